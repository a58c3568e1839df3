/* photon/lanes_any.h: what cl/shared/map_lanes.h does, to the last bit, in loops that compilers make the most of where
 * eight floats are more than a register. */
#ifndef CPM_PHOTON_LANES_ANY_H
#define CPM_PHOTON_LANES_ANY_H
#include "cl/shared/gather.h"
#include "cl/shared/half.h"
#include "tree.h"

#define CPM_LANES_BOXES
#define CPM_LANES_LISTS
#define CPM_LANES_SUM

/* A bit for each child whose box is within the squared radius. */
static inline uint32_t lanes_boxes(const cpm_node *node, const float *q, float radius2) {
    float d[CPM_WIDE];
    uint32_t mask = 0;
    for (int i = 0; i < CPM_WIDE; i++)
        d[i] = cpm_distance2(cpm_outside(q[0], node->low[0][i], node->high[0][i]),
                             cpm_outside(q[1], node->low[1][i], node->high[1][i]),
                             cpm_outside(q[2], node->low[2][i], node->high[2][i]));
    for (int i = 0; i < CPM_WIDE; i++) mask |= (uint32_t)(d[i] <= radius2) << i;
    return mask;
}

/* Sums 16 consecutive halves over photons: those at halves + id[i] stride. Even and odd i are summed apart, then
 * together, on every ISA. */
static inline void lanes_sum(const uint16_t *halves, size_t stride, const uint32_t *id, uint32_t count, double *sum) {
    double even[16] = {0}, odd[16] = {0};
    uint32_t i = 0;
    for (; i + 1 < count; i += 2) {
        const uint16_t *a = halves + id[i] * stride, *b = halves + id[i + 1] * stride;
        for (int c = 0; c < 16; c++) even[c] += (double)cpm_half_to_float(a[c]);
        for (int c = 0; c < 16; c++) odd[c] += (double)cpm_half_to_float(b[c]);
    }
    if (i < count)
        for (int c = 0; c < 16; c++) even[c] += (double)cpm_half_to_float(halves[id[i] * stride + (size_t)c]);
    for (int c = 0; c < 16; c++) sum[c] = even[c] + odd[c];
}

/* Appends a leaf's photons within the squared radius to the n listed; `count` <= CPM_LEAF. Returns the new n. */
static inline size_t lanes_leaf(const float *points, uint32_t first, uint32_t count, const float *q, float radius2,
                                float *distance, uint32_t *id, size_t n) {
    float d[CPM_LEAF];
    const float *x = points, *y = points + count, *z = y + count;
    for (uint32_t i = 0; i < count; i++) d[i] = cpm_distance2(x[i] - q[0], y[i] - q[1], z[i] - q[2]);
    for (uint32_t i = 0; i < count; i++) {
        distance[n] = d[i], id[n] = first + i;
        n += d[i] <= radius2;
    }
    return n;
}

/* How many are at most a, and at most b. Beyond n stand infinities. */
static inline void lanes_count(const float *distance, size_t n, float a, float b, size_t *at_a, size_t *at_b) {
    uint32_t na = 0, nb = 0;
    for (size_t i = 0; i < n; i++) na += distance[i] <= a, nb += distance[i] <= b;
    *at_a = na, *at_b = nb;
}

/* Copies those in (low, high], in their order. Returns how many. */
static inline size_t lanes_between(const float *distance, size_t n, float low, float high, float *out) {
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        out[m] = distance[i];
        m += (size_t)((distance[i] > low) & (distance[i] <= high));
    }
    return m;
}

/* Keeps the ids of those below t, in their order. Returns how many. */
static inline size_t lanes_below(const float *distance, uint32_t *id, size_t n, float t) {
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        id[m] = id[i];
        m += distance[i] < t;
    }
    return m;
}
#endif
