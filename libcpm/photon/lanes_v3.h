/* photon/lanes_v3.h: boxes and sums of the search in AVX2 and F16C, as cl/shared/map_lanes.h has them. */
#ifndef CPM_PHOTON_LANES_V3_H
#define CPM_PHOTON_LANES_V3_H
#include <immintrin.h>

#include "tree.h"

#define CPM_LANES_BOXES
#define CPM_LANES_SUM

static inline __m256 outside(__m256 q, const float *low, const float *high) {
    const __m256 below = _mm256_sub_ps(_mm256_loadu_ps(low), q), above = _mm256_sub_ps(q, _mm256_loadu_ps(high));
    return _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
}

static inline uint32_t lanes_boxes(const cpm_node *node, const float *q, float radius2) {
    const __m256 x = outside(_mm256_set1_ps(q[0]), node->low[0], node->high[0]);
    const __m256 y = outside(_mm256_set1_ps(q[1]), node->low[1], node->high[1]);
    const __m256 z = outside(_mm256_set1_ps(q[2]), node->low[2], node->high[2]);
    const __m256 d = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(d, _mm256_set1_ps(radius2), _CMP_LE_OQ));
}

static inline void add8(const uint16_t *halves, __m256d *sum) {
    const __m256 f = _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(const void *)halves));
    sum[0] = _mm256_add_pd(sum[0], _mm256_cvtps_pd(_mm256_castps256_ps128(f)));
    sum[1] = _mm256_add_pd(sum[1], _mm256_cvtps_pd(_mm256_extractf128_ps(f, 1)));
}

static inline void lanes_sum(const uint16_t *halves, size_t stride, const uint32_t *id, uint32_t count, double *sum) {
    __m256d even[4], odd[4];
    for (int c = 0; c < 4; c++) even[c] = odd[c] = _mm256_setzero_pd();
    uint32_t i = 0;
    for (; i + 1 < count; i += 2) {
        const uint16_t *a = halves + id[i] * stride, *b = halves + id[i + 1] * stride;
        add8(a, even), add8(a + 8, even + 2);
        add8(b, odd), add8(b + 8, odd + 2);
    }
    if (i < count) add8(halves + id[i] * stride, even), add8(halves + id[i] * stride + 8, even + 2);
    for (int c = 0; c < 4; c++) _mm256_storeu_pd(sum + 4 * c, _mm256_add_pd(even[c], odd[c]));
}
#endif
