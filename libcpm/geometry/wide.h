/* geometry/wide.h: eight floats at once, for the children of a tree's node. */
#ifndef CPM_GEOMETRY_WIDE_H
#define CPM_GEOMETRY_WIDE_H
#include <stdint.h>
#include <string.h>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

typedef float wide_float __attribute__((vector_size(32)));
typedef int32_t wide_mask __attribute__((vector_size(32)));

static inline wide_float wide_load(const float *from) { /* 32-byte aligned */
    wide_float v;
    memcpy(&v, __builtin_assume_aligned(from, 32), sizeof v);
    return v;
}
static inline wide_float wide_all(float x) { return (wide_float){x, x, x, x, x, x, x, x}; }

/* b where a or b is NaN, as x86 has it. */
static inline wide_float wide_min(wide_float a, wide_float b) {
#if defined(__AVX2__)
    return (wide_float)_mm256_min_ps((__m256)a, (__m256)b);
#else
    const wide_mask less = a < b;
    return (wide_float)((less & (wide_mask)a) | (~less & (wide_mask)b));
#endif
}
static inline wide_float wide_max(wide_float a, wide_float b) {
#if defined(__AVX2__)
    return (wide_float)_mm256_max_ps((__m256)a, (__m256)b);
#else
    const wide_mask more = a > b;
    return (wide_float)((more & (wide_mask)a) | (~more & (wide_mask)b));
#endif
}
static inline wide_float wide_abs(wide_float a) {
    const wide_mask sign = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    return (wide_float)((wide_mask)a & ~sign);
}

/* a b + c; fused where the machine can: for bounds with room for rounding, not for results */
static inline wide_float wide_along(wide_float a, float b, wide_float c) {
#if defined(__FMA__)
    return (wide_float)_mm256_fmadd_ps((__m256)a, _mm256_set1_ps(b), (__m256)c);
#else
    return a * b + c;
#endif
}
static inline wide_float wide_fused(wide_float a, wide_float b, wide_float c) {
#if defined(__FMA__)
    return (wide_float)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    return a * b + c;
#endif
}
static inline unsigned wide_bits(wide_mask mask) {
#if defined(__AVX2__)
    return (unsigned)_mm256_movemask_ps((__m256)mask);
#else
    unsigned bits = 0;
    for (int i = 0; i < 8; i++) bits |= (unsigned)(mask[i] & 1) << i;
    return bits;
#endif
}
#endif
