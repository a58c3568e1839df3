/* shared/medium_layered.h: a table of height h = up . (r - origin); below the first and above the last height constant.
 *
 * A layer's record is a cubic in t = h - its start: N (cubic, step: n = 1 + s N, g = n s N' up) or S (linear-squared:
 * n^2 = 1 + s S, g = s S'/2 up). The layer is found by a guide of equal buckets, then by halving within the bucket's
 * layers: for evenly spaced heights one halving or none. */
#ifndef CPM_SHARED_MEDIUM_LAYERED_H
#define CPM_SHARED_MEDIUM_LAYERED_H
#include "medium_linear.h"

/* The layer of each height, 0..count, exact integers. */
CPM_INLINE mask cpm_layer_of(const cpm_medium_data *m, CPM_GLOBAL const double *table, real height) {
    real bucket = (height - R(m->low)) * R(m->bucket);
    bucket = larger(smaller(bucket, splat(m->size[1] - 1)), splat(0.0)); /* NaN: the last */
    mask guide = to_integers(floor_lanes(bucket)) * splat_mask(2) + splat_mask(m->guide);
    mask low = to_integers(fetch(table, guide)), high = to_integers(fetch(table, guide + splat_mask(1)));
    const mask one = splat_mask(1);
    for (int i = 0; i < m->size[2]; i++) {
        mask middle = (low + high + one) >> 1, open = less(low, high); /* middle >= 1 where open */
        mask at = pick_mask(open, middle - one, splat_mask(0));
        mask above = at_most(fetch(table, at + splat_mask(m->heights)), height) | ~open;
        low = pick_mask(above & open, middle, low);
        high = pick_mask(above, high, middle - one);
    }
    return low;
}

CPM_INLINE real3 cpm_field_layered(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                   real *n) {
    real height = cpm_along_axis(m, r), c[4];
    mask layer = cpm_layer_of(m, table, height);
    mask start = pick_mask(equal(layer, splat_mask(0)), layer, layer - splat_mask(1));
    real t = height - fetch(table, start + splat_mask(m->heights));
    fetch4(table, layer * splat_mask(4) + splat_mask(m->records), c);
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
