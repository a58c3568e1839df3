/* photon/lanes_any.h: boxes and sums of the search in plain C. lanes_v3.h, lanes_v4.h: the same, to the last bit. */
#ifndef CPM_PHOTON_LANES_ANY_H
#define CPM_PHOTON_LANES_ANY_H
#include "cl/shared/gather.h"
#include "cl/shared/half.h"
#include "tree.h"

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
#endif
