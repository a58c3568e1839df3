/* dialect.h: every difference between C11 (gcc, clang) and OpenCL C 1.2, and nothing else.
 *
 * A `real` is CPM_WIDTH rays, one a lane; a `mask` is as many signed integers of the same size, 0 or -1 where it stands
 * for a truth. With CPM_WIDTH 1 (the default) both are plain scalars, so that one source serves packets and single
 * rays. CPM_SINGLE 1 makes lanes of float. Both sides give the same results to the last bit, provided that C is
 * compiled with -ffp-contract=off and no fast-math, and OpenCL with -cl-fp32-correctly-rounded-divide-sqrt where it is
 * single.
 *
 * Where lanes need what a vector cannot do (a look-up by a per-lane index), the loop over lanes is here. */
#ifndef CPM_DIALECT_H
#define CPM_DIALECT_H
#ifndef CPM_WIDTH
#define CPM_WIDTH 1
#endif
#ifndef CPM_SINGLE
#define CPM_SINGLE 0
#endif
#define CPM_GLUE2(a, b) a##b
#define CPM_GLUE(a, b) CPM_GLUE2(a, b)
#if CPM_SINGLE
#define CPM_SCALAR float
#else
#define CPM_SCALAR double
#endif

#ifdef __OPENCL_VERSION__ /* ---------------------------------------------------------------------------- OpenCL C */
#pragma OPENCL FP_CONTRACT OFF
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define CPM_GLOBAL __global
#define CPM_CONSTANT_TABLE __constant
typedef uint cpm_u32;
typedef ulong cpm_u64;
typedef int cpm_i32;
typedef long cpm_i64;
#define CPM_U64(x) x##UL
#if CPM_SINGLE
#define CPM_INTEGER int
#else
#define CPM_INTEGER long
#endif
#define CPM_STATIC_ASSERT(condition, name) typedef char name[(condition) ? 1 : -1]
#ifdef __clang__
#define CPM_ASSERT_OFFSET(type, member, value)                                                                         \
    CPM_STATIC_ASSERT(__builtin_offsetof(type, member) == (value), type##_##member)
#else /* no constant offset in OpenCL C itself: sizes are checked, offsets by the host */
#define CPM_ASSERT_OFFSET(type, member, value)
#endif
#define cpm_bits_of(x) as_ulong(x) /* double <-> its 64 bits */
#define cpm_double_of(x) as_double(x)
#define cpm_sqrt(x) sqrt((double)(x)) /* of one double */
#define CPM_CLEAR(x)                                                                                                   \
    for (size_t clear_ = 0; clear_ < sizeof(x); clear_++) ((uchar *)&(x))[clear_] = 0
/* Tables of several media: one buffer, and where each begins. */
typedef struct {
    __global const double *all;
    __global const long *first;
} cpm_tables;
#define cpm_table_of(tables, i) ((tables).all + (tables).first[i])

#else /* ------------------------------------------------------------------------------------------------------ C11 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#if defined(__SSE2__) && CPM_WIDTH > 1
#include <immintrin.h>
#endif
#define CPM_GLOBAL
#define CPM_CONSTANT_TABLE static const
typedef uint32_t cpm_u32;
typedef uint64_t cpm_u64;
typedef int32_t cpm_i32;
typedef int64_t cpm_i64;
#define CPM_U64(x) UINT64_C(x)
#if CPM_SINGLE
#define CPM_INTEGER int32_t
#else
#define CPM_INTEGER int64_t
#endif
#define CPM_STATIC_ASSERT(condition, name) _Static_assert(condition, #name)
#define CPM_ASSERT_OFFSET(type, member, value) _Static_assert(offsetof(type, member) == (value), #member)
static inline cpm_u64 cpm_bits_of(double x) {
    cpm_u64 bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static inline double cpm_double_of(cpm_u64 bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
#define cpm_sqrt(x) sqrt((double)(x))
#define CPM_CLEAR(x) memset(&(x), 0, sizeof(x))
typedef struct {
    const double *const *of;
} cpm_tables;
#define cpm_table_of(tables, i) ((tables).of[i])
#endif /* ------------------------------------------------------------------------------------------------ both sides  \
        */

#define CPM_INLINE static inline
#define CPM_ALWAYS_INLINE                                                                                              \
    static inline __attribute__((always_inline)) /* where a call would cost more than it saves                         \
                                                  */
/* A function that is not worth room in its caller's registers and code. */
#if defined(__GNUC__) || defined(__clang__)
#define CPM_APART static __attribute__((noinline, unused))
#else
#define CPM_APART static
#endif
typedef CPM_SCALAR scalar;
typedef CPM_INTEGER integer;
#define R(x) ((scalar)(x)) /* every literal of lane arithmetic: no silent double */

#if CPM_WIDTH ==                                                                                                       \
    1 /* ------------------------------------------------------------------------- one ray: plain scalars */
typedef scalar real;
typedef integer mask;
#define CPM_BOOL(c) (-(mask)(c)) /* scalars compare to 0 or 1, vectors to 0 or -1 */
#define pick(m, a, b) ((m) ? (a) : (b))
#define any_lane(m) ((m) != 0)
#define splat(s) ((real)(s))
#define splat_mask(i) ((mask)(i))
#define root(x) CPM_ROOT(x)
#define to_integers(x) ((mask)(x))
#define to_reals(m) ((real)(m))
#define load_lanes(p, i) ((p)[i])
#define store_lanes(v, p, i) ((p)[i] = (v))
#define lane_of(v, i) (v)
#ifdef __OPENCL_VERSION__
#define CPM_ROOT(x) sqrt((scalar)(x))
#else
#define CPM_ROOT(x) ((scalar)(CPM_SINGLE ? (scalar)sqrtf((float)(x)) : (scalar)sqrt((double)(x))))
#endif

#elif defined(                                                                                                         \
    __OPENCL_VERSION__) /* ----------------------------------------------------------- OpenCL C vector types */
typedef CPM_GLUE(CPM_SCALAR, CPM_WIDTH) real;
typedef CPM_GLUE(CPM_INTEGER, CPM_WIDTH) mask;
#define CPM_BOOL(c) (c)
#define pick(m, a, b) select(b, a, m) /* top bit set: a */
#define any_lane(m) any(m)
#define splat(s) ((real)((scalar)(s)))
#define splat_mask(i) ((mask)((integer)(i)))
#define root(x) sqrt(x)
#define to_integers(x) CPM_GLUE(convert_, CPM_GLUE(CPM_INTEGER, CPM_WIDTH))(x)
#define to_reals(m) CPM_GLUE(convert_, CPM_GLUE(CPM_SCALAR, CPM_WIDTH))(m)
#define load_lanes(p, i) CPM_GLUE(vload, CPM_WIDTH)(i, p)
#define store_lanes(v, p, i) CPM_GLUE(vstore, CPM_WIDTH)(v, i, p)

#else /* ----------------------------------------------------------------------------------------------- GNU vectors   \
       */
typedef scalar real __attribute__((vector_size(CPM_WIDTH * sizeof(scalar))));
typedef integer mask __attribute__((vector_size(CPM_WIDTH * sizeof(scalar))));
#define CPM_BOOL(c) (c)
#define splat(s) ((scalar)(s) - (real){0}) /* "-": keeps -0.0 */
#define splat_mask(i) ((integer)(i) + (mask){0})
#define pick(m, a, b) ((real)(((mask)(a) & (m)) | ((mask)(b) & ~(m))))
#define to_integers(x) __builtin_convertvector(x, mask)
#define to_reals(m) __builtin_convertvector(m, real)
#define lane_of(v, i) ((v)[i])
static inline int any_lane(mask m) {
    integer any = 0;
    for (int i = 0; i < CPM_WIDTH; i++) any |= m[i];
    return any != 0;
}
CPM_ALWAYS_INLINE real root(real x) { /* -fno-math-errno makes it one vector instruction */
    for (int i = 0; i < CPM_WIDTH; i++) x[i] = CPM_SINGLE ? (scalar)sqrtf((float)x[i]) : (scalar)sqrt((double)x[i]);
    return x;
}
static inline real load_lanes(const scalar *p, size_t i) {
    real v;
    memcpy(&v, p + i * CPM_WIDTH, sizeof v);
    return v;
}
static inline void store_lanes(real v, scalar *p, size_t i) { memcpy(p + i * CPM_WIDTH, &v, sizeof v); }
#endif /* ------------------------------------------------------------------------------------------------ both sides  \
        */

/* A `word` is CPM_WIDTH unsigned integers of 64 bits, for random bits: products of 32 bits fit. In memory they are 32.
 * word_product takes words below 2^32, and a number below 2^32. */
#if CPM_WIDTH == 1
typedef cpm_u64 word;
#define splat_word(s) ((word)(s))
#define to_words(m) ((word)(cpm_i64)(m))
#define load_words(p, part) ((word)(p)[part])
#define store_words(w, p, part) ((p)[part] = (cpm_u32)(w))
#define word_reals(w) ((real)(w))
#define word_product(a, b) ((word)(a) * (b))
#elif defined(__OPENCL_VERSION__)
typedef CPM_GLUE(ulong, CPM_WIDTH) word;
#define splat_word(s) ((word)((ulong)(s)))
#define to_words(m) CPM_GLUE(convert_ulong, CPM_WIDTH)(CPM_GLUE(convert_long, CPM_WIDTH)(m))
#define load_words(p, part) CPM_GLUE(convert_ulong, CPM_WIDTH)(CPM_GLUE(vload, CPM_WIDTH)(part, p))
#define store_words(w, p, part) CPM_GLUE(vstore, CPM_WIDTH)(CPM_GLUE(convert_uint, CPM_WIDTH)(w), part, p)
#define word_reals(w) CPM_GLUE(convert_, CPM_GLUE(CPM_SCALAR, CPM_WIDTH))(w)
#define word_product(a, b) ((a) * (b))
#else
typedef cpm_u64 word __attribute__((vector_size(CPM_WIDTH * 8)));
typedef cpm_i64 cpm_word_signs __attribute__((vector_size(CPM_WIDTH * 8)));
typedef cpm_u32 cpm_half_words __attribute__((vector_size(CPM_WIDTH * 4)));
#define splat_word(s) ((cpm_u64)(s) + (word){0})
#if defined(__AVX512F__) && CPM_WIDTH == 8 /* gcc does not see that 32 x 32 bits is all that is asked */
#define word_product(a, b) ((word)_mm512_mul_epu32((__m512i)(a), (__m512i)splat_word(b)))
#elif defined(__AVX2__) && CPM_WIDTH == 4
#define word_product(a, b) ((word)_mm256_mul_epu32((__m256i)(a), (__m256i)splat_word(b)))
#elif defined(__SSE2__) && CPM_WIDTH == 2
#define word_product(a, b) ((word)_mm_mul_epu32((__m128i)(a), (__m128i)splat_word(b)))
#else
#define word_product(a, b) ((a) * (cpm_u64)(b))
#endif
#define to_words(m) ((word) __builtin_convertvector(m, cpm_word_signs))
static inline word load_words(const cpm_u32 *p, int part) {
    cpm_half_words v;
    memcpy(&v, p + part * CPM_WIDTH, sizeof v);
    return __builtin_convertvector(v, word);
}
static inline void store_words(word w, cpm_u32 *p, int part) {
    cpm_half_words v = __builtin_convertvector(w, cpm_half_words);
    memcpy(p + part * CPM_WIDTH, &v, sizeof v);
}
#if CPM_SINGLE
#define word_reals(w) __builtin_convertvector(w, real)
#else /* below 2^32: the mantissa of 2^52 + w, as few machines convert 64 bits */
#define word_reals(w) ((real)((w) | CPM_U64(0x4330000000000000)) - 4503599627370496.0)
#endif
#endif

/* The bits of a real as integers, and back. */
#if CPM_WIDTH == 1 && defined(__OPENCL_VERSION__)
#define bits_of(x) CPM_GLUE(as_, CPM_INTEGER)(x)
#define real_of(m) CPM_GLUE(as_, CPM_SCALAR)(m)
#elif CPM_WIDTH == 1
static inline mask bits_of(real x) {
    mask bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static inline real real_of(mask bits) {
    real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
#elif defined(__OPENCL_VERSION__)
#define bits_of(x) CPM_GLUE(as_, CPM_GLUE(CPM_INTEGER, CPM_WIDTH))(x)
#define real_of(m) CPM_GLUE(as_, CPM_GLUE(CPM_SCALAR, CPM_WIDTH))(m)
#else
#define bits_of(x) ((mask)(x))
#define real_of(m) ((real)(m))
#endif

#define less(a, b) CPM_BOOL((a) < (b))
#define at_most(a, b) CPM_BOOL((a) <= (b))
#define equal(a, b) CPM_BOOL((a) == (b))
#define smaller(a, b) pick(less(a, b), a, b) /* b where either is NaN */
#define larger(a, b) pick(less(a, b), b, a)  /* a where either is NaN */
#define magnitude(x) larger(x, -(x))
#define pick_mask(m, a, b) (((a) & (m)) | ((b) & ~(m)))

/* Three lanes: a vector in space for each ray. */
typedef struct {
    real x, y, z;
} real3;
CPM_INLINE real3 triple(real x, real y, real z) {
    real3 v;
    v.x = x, v.y = y, v.z = z;
    return v;
}
CPM_INLINE real3 add3(real3 a, real s, real3 b) { /* a + s b */
    a.x += s * b.x, a.y += s * b.y, a.z += s * b.z;
    return a;
}
CPM_INLINE real3 sub3(real3 a, real3 b) {
    a.x -= b.x, a.y -= b.y, a.z -= b.z;
    return a;
}
CPM_INLINE real3 scale3(real s, real3 a) {
    a.x *= s, a.y *= s, a.z *= s;
    return a;
}
CPM_INLINE real dot3(real3 a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
CPM_INLINE real3 pick3(mask m, real3 a, real3 b) {
    return triple(pick(m, a.x, b.x), pick(m, a.y, b.y), pick(m, a.z, b.z));
}

#define CPM_MAGIC (CPM_SINGLE ? R(12582912.0) : R(6755399441055744.0)) /* 1.5 x 2^23, 1.5 x 2^52 */
/* floor of |x| < 2^51 (2^22 single) by the rounding of an addition: no library call at baseline x86-64. */
CPM_INLINE real floor_lanes(real x) {
    real nearest = (x + CPM_MAGIC) - CPM_MAGIC;
    return nearest - pick(less(x, nearest), splat(1.0), splat(0.0));
}

/* An integer in [0, 2^22) as a word, by the same addition. */
#define real_words(x) to_words(bits_of((x) + CPM_MAGIC) - bits_of(splat(CPM_MAGIC)))

/* log2 and 2^x to 6 %, for step sizes: the bits of a positive number are its logarithm, linear between powers of two.
 */
#define CPM_ROUGH_SHIFT                                                                                                \
    (CPM_SINGLE ? 9 : 13) /* so that exponent and mantissa fit where an addition of magic is exact */
#define CPM_ROUGH_ONE (CPM_SINGLE ? R(16384.0) : R(549755813888.0)) /* 2^14, 2^39: one power of two */
#define CPM_ROUGH_BIAS (CPM_SINGLE ? R(127.0) : R(1023.0))
CPM_INLINE real log2_rough(real x) {
    mask bits = (bits_of(x) >> CPM_ROUGH_SHIFT) + bits_of(splat(CPM_MAGIC));
    return (real_of(bits) - CPM_MAGIC) * (R(1.0) / CPM_ROUGH_ONE) - CPM_ROUGH_BIAS;
}
CPM_INLINE real exp2_rough(real y) { /* |y| <= 100 */
    real t = (y + CPM_ROUGH_BIAS) * CPM_ROUGH_ONE + CPM_MAGIC;
    return real_of((bits_of(t) - bits_of(splat(CPM_MAGIC))) << CPM_ROUGH_SHIFT);
}

/* Look-ups by a per-lane index. Tables are doubles always. `cpm_rows` are places in a table, one a lane, which offsets
 * that are the same for all lanes start from; fetch4 takes four neighbours. */
typedef struct {
    CPM_GLOBAL const double *at[CPM_WIDTH];
} cpm_rows;
#if CPM_WIDTH == 1
CPM_INLINE cpm_rows rows_at(CPM_GLOBAL const double *table, mask index) {
    cpm_rows rows;
    rows.at[0] = table + index;
    return rows;
}
CPM_INLINE real fetch(const cpm_rows *rows, integer offset) { return (real)rows->at[0][offset]; }
CPM_INLINE void fetch4(const cpm_rows *rows, integer offset, real *out) {
    for (int k = 0; k < 4; k++) out[k] = (real)rows->at[0][offset + k];
}
#elif defined(__OPENCL_VERSION__)
CPM_INLINE cpm_rows rows_at(CPM_GLOBAL const double *table, mask index) { /* vstore, loop: 4 x a lane by pointer */
    cpm_rows rows;
    integer at[CPM_WIDTH];
    CPM_GLUE(vstore, CPM_WIDTH)(index, 0, at);
#pragma unroll
    for (int i = 0; i < CPM_WIDTH; i++) rows.at[i] = table + at[i];
    return rows;
}
CPM_INLINE real fetch(const cpm_rows *rows, integer offset) {
    scalar value[CPM_WIDTH];
#pragma unroll
    for (int i = 0; i < CPM_WIDTH; i++) value[i] = (scalar)rows->at[i][offset];
    return CPM_GLUE(vload, CPM_WIDTH)(0, value);
}
CPM_INLINE void fetch4(const cpm_rows *rows, integer offset, real *out) {
    scalar value[4 * CPM_WIDTH];
#pragma unroll
    for (int i = 0; i < CPM_WIDTH; i++)
#pragma unroll
        for (int k = 0; k < 4; k++) value[k * CPM_WIDTH + i] = (scalar)rows->at[i][offset + k];
#pragma unroll
    for (int k = 0; k < 4; k++) out[k] = CPM_GLUE(vload, CPM_WIDTH)(k, value);
}
#else
CPM_INLINE cpm_rows rows_at(const double *table, mask index) {
    cpm_rows rows;
    for (int i = 0; i < CPM_WIDTH; i++) rows.at[i] = table + index[i];
    return rows;
}
CPM_INLINE real fetch(const cpm_rows *rows, integer offset) {
    real v = splat(0.0);
    for (int i = 0; i < CPM_WIDTH; i++) v[i] = (scalar)rows->at[i][offset];
    return v;
}
/* Rows of four by lane, transposed in registers: lanes 2k and 2k + 1, then pairs of pairs. */
typedef double cpm_row4 __attribute__((vector_size(32)));
CPM_INLINE cpm_row4 cpm_row_at(const double *p) {
    cpm_row4 row;
    memcpy(&row, p, sizeof row);
    return row;
}
#if CPM_WIDTH == 2
CPM_INLINE void fetch4(const cpm_rows *rows, integer offset, real *out) {
    cpm_row4 a = cpm_row_at(rows->at[0] + offset), b = cpm_row_at(rows->at[1] + offset);
    for (int k = 0; k < 4; k++) out[k] = (real){(scalar)a[k], (scalar)b[k]};
}
#else
CPM_INLINE void cpm_transpose4(const cpm_rows *rows, integer offset, int first, cpm_row4 out[4]) {
    cpm_row4 a = cpm_row_at(rows->at[first] + offset), b = cpm_row_at(rows->at[first + 1] + offset);
    cpm_row4 c = cpm_row_at(rows->at[first + 2] + offset), d = cpm_row_at(rows->at[first + 3] + offset);
    cpm_row4 even_ab = __builtin_shufflevector(a, b, 0, 4, 2, 6), odd_ab = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    cpm_row4 even_cd = __builtin_shufflevector(c, d, 0, 4, 2, 6), odd_cd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    out[0] = __builtin_shufflevector(even_ab, even_cd, 0, 1, 4, 5);
    out[1] = __builtin_shufflevector(odd_ab, odd_cd, 0, 1, 4, 5);
    out[2] = __builtin_shufflevector(even_ab, even_cd, 2, 3, 6, 7);
    out[3] = __builtin_shufflevector(odd_ab, odd_cd, 2, 3, 6, 7);
}
CPM_INLINE void fetch4(const cpm_rows *rows, integer offset, real *out) {
    cpm_row4 low[4];
    cpm_transpose4(rows, offset, 0, low);
#if CPM_WIDTH == 4
    for (int k = 0; k < 4; k++) out[k] = __builtin_convertvector(low[k], real);
#else
    cpm_row4 high[4];
    cpm_transpose4(rows, offset, 4, high);
    for (int k = 0; k < 4; k++)
        out[k] = __builtin_convertvector(__builtin_shufflevector(low[k], high[k], 0, 1, 2, 3, 4, 5, 6, 7), real);
#endif
}
#endif
#endif

/* Lanes in memory that is the same for every width and precision: doubles and 64-bit flags, part by part. */
#if CPM_WIDTH == 1
CPM_INLINE real load_doubles(const double *p, int part) { return (real)p[part]; }
CPM_INLINE void store_doubles(real v, double *p, int part) { p[part] = (double)v; }
CPM_INLINE mask load_flags(const cpm_i64 *p, int part) { return (mask)p[part]; }
CPM_INLINE void store_flags(mask v, cpm_i64 *p, int part) { p[part] = (cpm_i64)v; }
#elif defined(__OPENCL_VERSION__)
CPM_INLINE real load_doubles(const double *p, int part) {
    return CPM_GLUE(convert_, CPM_GLUE(CPM_SCALAR, CPM_WIDTH))(CPM_GLUE(vload, CPM_WIDTH)(part, p));
}
CPM_INLINE void store_doubles(real v, double *p, int part) {
    CPM_GLUE(vstore, CPM_WIDTH)(CPM_GLUE(convert_double, CPM_WIDTH)(v), part, p);
}
CPM_INLINE mask load_flags(const cpm_i64 *p, int part) {
    return CPM_GLUE(convert_, CPM_GLUE(CPM_INTEGER, CPM_WIDTH))(CPM_GLUE(vload, CPM_WIDTH)(part, p));
}
CPM_INLINE void store_flags(mask v, cpm_i64 *p, int part) {
    CPM_GLUE(vstore, CPM_WIDTH)(CPM_GLUE(convert_long, CPM_WIDTH)(v), part, p);
}
#else
typedef double cpm_doubles __attribute__((vector_size(CPM_WIDTH * 8)));
typedef cpm_i64 cpm_flags __attribute__((vector_size(CPM_WIDTH * 8)));
CPM_INLINE real load_doubles(const double *p, int part) {
    cpm_doubles v;
    memcpy(&v, p + part * CPM_WIDTH, sizeof v);
    return __builtin_convertvector(v, real);
}
CPM_INLINE void store_doubles(real v, double *p, int part) {
    cpm_doubles d = __builtin_convertvector(v, cpm_doubles);
    memcpy(p + part * CPM_WIDTH, &d, sizeof d);
}
CPM_INLINE mask load_flags(const cpm_i64 *p, int part) {
    cpm_flags v;
    memcpy(&v, p + part * CPM_WIDTH, sizeof v);
    return __builtin_convertvector(v, mask);
}
CPM_INLINE void store_flags(mask v, cpm_i64 *p, int part) {
    cpm_flags d = __builtin_convertvector(v, cpm_flags);
    memcpy(p + part * CPM_WIDTH, &d, sizeof d);
}
#endif
/* Lanes of double whatever the precision: what a ray's state is added up in, so that float steps lose nothing to it. */
#if CPM_WIDTH == 1
typedef double broad;
#define to_broad(v) ((double)(v))
#define load_broad(p, part) ((p)[part])
#define store_broad(v, p, part) ((p)[part] = (v))
#define root_broad(v) cpm_sqrt(v)
#elif defined(__OPENCL_VERSION__)
typedef CPM_GLUE(double, CPM_WIDTH) broad;
#define to_broad(v) CPM_GLUE(convert_double, CPM_WIDTH)(v)
#define load_broad(p, part) CPM_GLUE(vload, CPM_WIDTH)(part, p)
#define store_broad(v, p, part) CPM_GLUE(vstore, CPM_WIDTH)(v, part, p)
#define root_broad(v) sqrt(v)
#else
typedef cpm_doubles broad;
#define to_broad(v) __builtin_convertvector(v, broad)
CPM_INLINE broad load_broad(const double *p, int part) {
    broad v;
    memcpy(&v, p + part * CPM_WIDTH, sizeof v);
    return v;
}
CPM_INLINE void store_broad(broad v, double *p, int part) { memcpy(p + part * CPM_WIDTH, &v, sizeof v); }
CPM_INLINE broad root_broad(broad v) {
    for (int i = 0; i < CPM_WIDTH; i++) v[i] = sqrt(v[i]);
    return v;
}
#endif
#define load3_doubles(p, part)                                                                                         \
    triple(load_doubles((p)[0], part), load_doubles((p)[1], part), load_doubles((p)[2], part))
CPM_INLINE void store3_doubles(real3 v, double (*p)[8], int part) {
    store_doubles(v.x, p[0], part);
    store_doubles(v.y, p[1], part);
    store_doubles(v.z, p[2], part);
}

/* Eight floats at once, for the children of a tree's node: bounds with room for rounding, never results. wide_min and
 * wide_max give b where either is NaN. */
#ifdef __OPENCL_VERSION__
typedef float8 wide;
typedef int8 wide_mask;
#define wide_load(from) vload8(0, from)
#define wide_any(from) vload8(0, from)
#define wide_store(v, to) vstore8(v, 0, to)
#define wide_all(x) ((float8)(x))
#define wide_min(a, b) select(b, a, (a) < (b))
#define wide_max(a, b) select(b, a, (a) > (b))
#define wide_abs(a) fabs(a)
#define wide_along(a, b, c) ((a) * (b) + (c))
#if defined(__AVX__) && defined(__clang__) && __has_builtin(__builtin_ia32_movmskps256)
typedef float cpm_wide_register __attribute__((vector_size(32)));
CPM_INLINE cpm_u32 wide_bits(wide_mask mask) {
    return (cpm_u32)__builtin_ia32_movmskps256((cpm_wide_register)as_float8(mask));
}
#else
CPM_INLINE cpm_u32 wide_bits(wide_mask mask) {
    int8 bits = mask & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    int4 four = bits.lo | bits.hi;
    int2 two = four.lo | four.hi;
    return (cpm_u32)(two.x | two.y);
}
#endif
#define cpm_lowest_bit(bits) (31 - (int)clz((bits) & -(bits)))
typedef double8 wide_doubles;
#define wide_zeros() ((double8)(0.0))
#define wide_gathered(from) vload8(0, from)
#define wide_halves(from) convert_double8(vload_half8(0, (CPM_GLOBAL const half *)(from)))
#define wide_keep(v, to) vstore8(v, 0, to)
#define cpm_root_float(x) sqrt((float)(x))
#define cpm_count_bits(bits) popcount(bits)
#else
#if defined(__AVX2__)
#include <immintrin.h>
#endif
typedef float wide __attribute__((vector_size(32)));
typedef cpm_i32 wide_mask __attribute__((vector_size(32)));
static inline wide wide_load(const float *from) { /* 32-byte aligned */
    wide v;
    memcpy(&v, __builtin_assume_aligned(from, 32), sizeof v);
    return v;
}
static inline wide wide_any(const float *from) { /* aligned as floats are */
    wide v;
    memcpy(&v, from, sizeof v);
    return v;
}
static inline void wide_store(wide v, float *to) { memcpy(to, &v, sizeof v); }
static inline wide wide_all(float x) { return (wide){x, x, x, x, x, x, x, x}; }
static inline wide wide_min(wide a, wide b) {
#if defined(__AVX2__)
    return (wide)_mm256_min_ps((__m256)a, (__m256)b);
#else
    const wide_mask less_than = a < b;
    return (wide)((less_than & (wide_mask)a) | (~less_than & (wide_mask)b));
#endif
}
static inline wide wide_max(wide a, wide b) {
#if defined(__AVX2__)
    return (wide)_mm256_max_ps((__m256)a, (__m256)b);
#else
    const wide_mask more_than = a > b;
    return (wide)((more_than & (wide_mask)a) | (~more_than & (wide_mask)b));
#endif
}
static inline wide wide_abs(wide a) {
    const wide_mask sign = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    return (wide)((wide_mask)a & ~sign);
}
/* a b + c, fused where the machine can. */
static inline wide wide_along(wide a, wide b, wide c) {
#if defined(__FMA__)
    return (wide)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    return a * b + c;
#endif
}
static inline cpm_u32 wide_bits(wide_mask mask) {
#if defined(__AVX2__)
    return (cpm_u32)_mm256_movemask_ps((__m256)mask);
#else
    cpm_u32 bits = 0;
    for (int i = 0; i < 8; i++) bits |= (cpm_u32)(mask[i] & 1) << i;
    return bits;
#endif
}
#define cpm_lowest_bit(bits) __builtin_ctz(bits)
/* Eight doubles, and eight half floats as such: exact (shared/half.h). */
typedef double wide_doubles __attribute__((vector_size(64)));
#define wide_zeros() ((wide_doubles){0})
static inline wide_doubles wide_gathered(const double *from) {
    wide_doubles v;
    memcpy(&v, from, sizeof v);
    return v;
}
#define wide_halves(from) cpm_wide_halves(from)
static inline void wide_keep(wide_doubles v, double *to) { memcpy(to, &v, sizeof v); }
#define cpm_root_float(x) sqrtf(x)
#define cpm_count_bits(bits) ((cpm_u32)__builtin_popcount(bits))
#endif
#endif
