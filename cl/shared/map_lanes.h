/* shared/map_lanes.h: what a search in a photon map does eight photons, or children, at a time. A host that has better
 * instructions for some of it defines those before, and CPM_LANES_ and their names; with the same results to the last
 * bit.
 *
 * `distance` may be read, and distance, id and `out` written, up to CPM_PAD beyond their ends. */
#ifndef CPM_SHARED_MAP_LANES_H
#define CPM_SHARED_MAP_LANES_H
#include "../types/map.h"
#include "gather.h"
#include "half.h"

#ifndef CPM_LANES_BOXES
CPM_INLINE wide cpm_wide_outside(float q, wide low, wide high) {
    const wide below = low - wide_all(q), above = wide_all(q) - high;
    return wide_max(wide_max(below, above), wide_all(0.0f));
}

/* A bit for each child whose box is within the squared radius: cpm_distance2 of three cpm_outside. */
CPM_INLINE cpm_u32 lanes_boxes(CPM_GLOBAL const cpm_map_node *node, const float *q, float radius2) {
    const wide x = cpm_wide_outside(q[0], wide_any(node->low[0]), wide_any(node->high[0]));
    const wide y = cpm_wide_outside(q[1], wide_any(node->low[1]), wide_any(node->high[1]));
    const wide z = cpm_wide_outside(q[2], wide_any(node->low[2]), wide_any(node->high[2]));
    return wide_bits(((x * x + y * y) + z * z) <= wide_all(radius2));
}
#endif

#ifndef CPM_LANES_LISTS
/* Appends a leaf's photons within the squared radius to the n listed; `count` <= CPM_LEAF. Returns the new n. */
CPM_INLINE size_t lanes_leaf(CPM_GLOBAL const float *points, cpm_u32 first, cpm_u32 count, const float *q,
                             float radius2, CPM_GLOBAL float *distance, CPM_GLOBAL cpm_u32 *id, size_t n) {
    for (cpm_u32 i = 0; i < count; i += 8) {
        const wide x = wide_any(points + i) - wide_all(q[0]), y = wide_any(points + count + i) - wide_all(q[1]);
        const wide z = wide_any(points + 2 * count + i) - wide_all(q[2]), d = (x * x + y * y) + z * z;
        const cpm_u32 here = count - i < 8 ? (1u << (count - i)) - 1u : 0xffu;
        cpm_u32 near = wide_bits(d <= wide_all(radius2)) & here;
        float each[8];
        if (!near) continue;
        wide_store(d, each);
        for (int j = 0; j < 8; j++) {
            distance[n] = each[j], id[n] = first + i + (cpm_u32)j;
            n += near >> j & 1u;
        }
    }
    return n;
}

/* How many are at most a, and at most b. Beyond n stand infinities. */
CPM_INLINE void lanes_count(CPM_GLOBAL const float *distance, size_t n, float a, float b, size_t *at_a, size_t *at_b) {
    cpm_u32 in_a = 0, in_b = 0;
    for (size_t i = 0; i < n; i += 8) {
        const wide d = wide_any(distance + i);
        in_a += cpm_count_bits(wide_bits(d <= wide_all(a))), in_b += cpm_count_bits(wide_bits(d <= wide_all(b)));
    }
    *at_a = in_a, *at_b = in_b;
}

/* Copies those in (low, high], in their order. Returns how many. */
CPM_INLINE size_t lanes_between(CPM_GLOBAL const float *distance, size_t n, float low, float high, float *out) {
    size_t m = 0;
    for (size_t i = 0; i < n; i += 8) {
        const wide d = wide_any(distance + i);
        for (cpm_u32 in = wide_bits((d > wide_all(low)) & (d <= wide_all(high))); in; in &= in - 1)
            out[m++] = distance[i + (size_t)cpm_lowest_bit(in)];
    }
    return m;
}

/* Keeps the ids of those below t, in their order. Returns how many. */
CPM_INLINE size_t lanes_below(CPM_GLOBAL const float *distance, CPM_GLOBAL cpm_u32 *id, size_t n, float t) {
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        id[m] = id[i];
        m += distance[i] < t;
    }
    return m;
}
#endif

#ifndef CPM_LANES_SUM
/* Sums 16 consecutive halves over photons: those at halves + id[i] stride. Even and odd i are summed apart, then
 * together, everywhere. */
CPM_INLINE void lanes_sum(CPM_GLOBAL const unsigned short *halves, size_t stride, CPM_GLOBAL const cpm_u32 *id,
                          cpm_u32 count, CPM_GLOBAL double *sum) {
    wide_doubles even0 = wide_zeros(), even1 = even0, odd0 = even0, odd1 = even0;
    cpm_u32 i = 0;
    for (; i + 1 < count; i += 2) {
        CPM_GLOBAL const unsigned short *a = halves + id[i] * stride, *b = halves + id[i + 1] * stride;
        even0 += wide_halves(a), even1 += wide_halves(a + 8);
        odd0 += wide_halves(b), odd1 += wide_halves(b + 8);
    }
    if (i < count) {
        CPM_GLOBAL const unsigned short *a = halves + id[i] * stride;
        even0 += wide_halves(a), even1 += wide_halves(a + 8);
    }
    wide_keep(even0 + odd0, sum), wide_keep(even1 + odd1, sum + 8);
}
#endif
#endif
