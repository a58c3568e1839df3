/* geometry/wide.h: eight floats at once, for the children of a tree's node. */
#ifndef CPM_GEOMETRY_WIDE_H
#define CPM_GEOMETRY_WIDE_H
#include <stdint.h>
#include <string.h>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

typedef float wide __attribute__((vector_size(32)));
typedef int32_t wide_mask __attribute__((vector_size(32)));

static inline wide wide_load(const float *from) { /* 32-byte aligned */
    wide v;
    memcpy(&v, __builtin_assume_aligned(from, 32), sizeof v);
    return v;
}
static inline wide wide_all(float x) { return (wide){x, x, x, x, x, x, x, x}; }

/* b where a or b is NaN, as x86 has it. */
static inline wide wide_min(wide a, wide b) {
#if defined(__AVX2__)
    return (wide)_mm256_min_ps((__m256)a, (__m256)b);
#else
    const wide_mask less = a < b;
    return (wide)((less & (wide_mask)a) | (~less & (wide_mask)b));
#endif
}
static inline wide wide_max(wide a, wide b) {
#if defined(__AVX2__)
    return (wide)_mm256_max_ps((__m256)a, (__m256)b);
#else
    const wide_mask more = a > b;
    return (wide)((more & (wide_mask)a) | (~more & (wide_mask)b));
#endif
}
static inline wide wide_abs(wide a) {
    const wide_mask sign = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    return (wide)((wide_mask)a & ~sign);
}

/* a b + c; fused where the machine can: for bounds with room for rounding, not for results */
static inline wide wide_along(wide a, float b, wide c) {
#if defined(__FMA__)
    return (wide)_mm256_fmadd_ps((__m256)a, _mm256_set1_ps(b), (__m256)c);
#else
    return a * b + c;
#endif
}
static inline wide wide_fused(wide a, wide b, wide c) {
#if defined(__FMA__)
    return (wide)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
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
