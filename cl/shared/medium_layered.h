/* shared/medium_layered.h: a table of height h = up . (r - origin); below the first and above the last height constant.
 *
 * A layer's record is a cubic in t = h - its start: N (cubic, step: n = 1 + s N, g = n s N' up) or S (linear-squared:
 * n^2 = 1 + s S, g = s S'/2 up). The layer is found by a guide of equal buckets, then by halving within the bucket's
 * layers: for evenly spaced heights one halving. */
#ifndef CPM_SHARED_MEDIUM_LAYERED_H
#define CPM_SHARED_MEDIUM_LAYERED_H
#include "medium_linear.h"

/* The layer of each height, 0..count. The guide gives a layer at or before it; then powers of two are tried from the
 * largest that a bucket may need (m->size[2] of them) down to 1. */
CPM_INLINE mask cpm_layer_of(const cpm_medium_data *m, CPM_GLOBAL const double *table, real height) {
    real bucket = (height - R(m->low)) * R(m->bucket);
    bucket = larger(smaller(bucket, splat(m->size[1] - 1)), splat(0.0)); /* NaN: the last */
    cpm_rows rows = rows_at(table, to_integers(floor_lanes(bucket)) + splat_mask(m->guide));
    mask layer = to_integers(fetch(&rows, 0)), last = splat_mask(m->size[0]);
    for (int i = m->size[2] - 1; i >= 0; i--) {
        mask next = layer + splat_mask((integer)1 << i), there = at_most(next, last);
        rows = rows_at(table, pick_mask(there, next, last) + splat_mask(m->heights - 1));
        layer = pick_mask(there & at_most(fetch(&rows, 0), height), next, layer);
    }
    return layer;
}

CPM_INLINE real3 cpm_field_layered(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                   real *n) {
    real height = cpm_along_axis(m, r), c[4];
    mask layer = cpm_layer_of(m, table, height);
    cpm_rows rows = rows_at(table, layer * splat_mask(CPM_RECORD) + splat_mask(m->records));
    real t = height - fetch(&rows, 4);
    fetch4(&rows, 0, c);
    real value = scale * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
    real slope = scale * (c[1] + t * (R(2.0) * c[2] + R(3.0) * t * c[3]));
    if (m->interpolation == CPM_FIELD_LINEAR_SQUARED) {
        *n = root(R(1.0) + value);
        return cpm_times_axis(m, R(0.5) * slope);
    }
    *n = R(1.0) + value;
    return cpm_times_axis(m, *n * slope);
}
#endif
