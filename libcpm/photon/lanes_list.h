/* photon/lanes_list.h: the search's lists in plain C, which compilers vectorise; lanes_v4.h compresses instead.
 *
 * `distance` may be read, and distance, id and `out` written, up to CPM_PAD beyond their ends. */
#ifndef CPM_PHOTON_LANES_LIST_H
#define CPM_PHOTON_LANES_LIST_H
#include "cl/shared/gather.h"
#include "tree.h"

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
