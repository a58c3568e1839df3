/* photon/lanes_v4.h: the search in AVX-512: what cl/shared/map_lanes.h does, to the last bit. */
#ifndef CPM_PHOTON_LANES_V4_H
#define CPM_PHOTON_LANES_V4_H
#include <immintrin.h>

#include "tree.h"

#define CPM_LANES_BOXES
#define CPM_LANES_LISTS
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
    return _mm256_cmp_ps_mask(d, _mm256_set1_ps(radius2), _CMP_LE_OQ);
}

static inline size_t lanes_leaf(const float *points, uint32_t first, uint32_t count, const float *q, float radius2,
                                float *distance, uint32_t *id, size_t n) {
    const __m512 qx = _mm512_set1_ps(q[0]), qy = _mm512_set1_ps(q[1]), qz = _mm512_set1_ps(q[2]);
    const __m512 limit = _mm512_set1_ps(radius2);
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (uint32_t i = 0; i < count; i += 16) {
        const __m512 x = _mm512_sub_ps(_mm512_loadu_ps(points + i), qx);
        const __m512 y = _mm512_sub_ps(_mm512_loadu_ps(points + count + i), qy);
        const __m512 z = _mm512_sub_ps(_mm512_loadu_ps(points + 2 * count + i), qz);
        const __m512 d = _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(x, x), _mm512_mul_ps(y, y)), _mm512_mul_ps(z, z));
        const uint32_t here = count - i < 16 ? (1u << (count - i)) - 1u : 0xffffu;
        const __mmask16 near = _mm512_mask_cmp_ps_mask((__mmask16)here, d, limit, _CMP_LE_OQ);
        const __m512i ids = _mm512_add_epi32(_mm512_set1_epi32((int)(first + i)), lane);
        /* compressed in a register: to memory it is slow on some machines */
        _mm512_storeu_ps(distance + n, _mm512_maskz_compress_ps(near, d));
        _mm512_storeu_si512(id + n, _mm512_maskz_compress_epi32(near, ids));
        n += (size_t)__builtin_popcount(near);
    }
    return n;
}

static inline void lanes_count(const float *distance, size_t n, float a, float b, size_t *at_a, size_t *at_b) {
    const __m512 va = _mm512_set1_ps(a), vb = _mm512_set1_ps(b);
    size_t na = 0, nb = 0;
    for (size_t i = 0; i < n; i += 16) {
        const __m512 d = _mm512_loadu_ps(distance + i);
        na += (size_t)__builtin_popcount(_mm512_cmp_ps_mask(d, va, _CMP_LE_OQ));
        nb += (size_t)__builtin_popcount(_mm512_cmp_ps_mask(d, vb, _CMP_LE_OQ));
    }
    *at_a = na, *at_b = nb;
}

static inline size_t lanes_between(const float *distance, size_t n, float low, float high, float *out) {
    const __m512 vl = _mm512_set1_ps(low), vh = _mm512_set1_ps(high);
    size_t m = 0;
    for (size_t i = 0; i < n; i += 16) {
        const __m512 d = _mm512_loadu_ps(distance + i);
        const __mmask16 between = _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(d, vl, _CMP_GT_OQ), d, vh, _CMP_LE_OQ);
        _mm512_storeu_ps(out + m, _mm512_maskz_compress_ps(between, d));
        m += (size_t)__builtin_popcount(between);
    }
    return m;
}

static inline size_t lanes_below(const float *distance, uint32_t *id, size_t n, float t) {
    const __m512 vt = _mm512_set1_ps(t);
    size_t m = 0;
    for (size_t i = 0; i < n; i += 16) {
        const __mmask16 below = _mm512_cmp_ps_mask(_mm512_loadu_ps(distance + i), vt, _CMP_LT_OQ);
        _mm512_storeu_si512(id + m, _mm512_maskz_compress_epi32(below, _mm512_loadu_si512(id + i)));
        m += (size_t)__builtin_popcount(below);
    }
    return m;
}

static inline void add16(const uint16_t *halves, __m512d *low, __m512d *high) {
    const __m512 f = _mm512_cvtph_ps(_mm256_loadu_si256((const __m256i *)(const void *)halves));
    *low = _mm512_add_pd(*low, _mm512_cvtps_pd(_mm512_castps512_ps256(f)));
    *high = _mm512_add_pd(*high, _mm512_cvtps_pd(_mm512_extractf32x8_ps(f, 1)));
}

static inline void lanes_sum(const uint16_t *halves, size_t stride, const uint32_t *id, uint32_t count, double *sum) {
    __m512d e0 = _mm512_setzero_pd(), e1 = e0, o0 = e0, o1 = e0;
    uint32_t i = 0;
    for (; i + 1 < count; i += 2) {
        add16(halves + id[i] * stride, &e0, &e1);
        add16(halves + id[i + 1] * stride, &o0, &o1);
    }
    if (i < count) add16(halves + id[i] * stride, &e0, &e1);
    _mm512_storeu_pd(sum, _mm512_add_pd(e0, o0));
    _mm512_storeu_pd(sum + 8, _mm512_add_pd(e1, o1));
}
#endif
