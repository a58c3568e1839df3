/* shared/world_index.h: n of a scene's media at single points, in double, whatever the lanes. */
#ifndef CPM_SHARED_WORLD_INDEX_H
#define CPM_SHARED_WORLD_INDEX_H
#include "exact.h"
#include "medium.h"
#include "piece_end.h"

/* NaN where n^2 <= 0. Float lanes give it in float. */
CPM_INLINE double cpm_index_at(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                               const double r[3]) {
    double of[CPM_LANES];
    real n;
    cpm_field(m, table, triple(splat(r[0]), splat(r[1]), splat(r[2])), splat(scale), &n);
    store_doubles(n, of, 0);
    return of[0] > 0.0 ? of[0] : NAN;
}

/* Discrete layers have no gradient to integrate. */
CPM_INLINE int cpm_is_discrete(const cpm_medium_data *m) {
    return !m->uniform && (m->kind == CPM_MEDIUM_LAYERED || m->kind == CPM_MEDIUM_SHELLS) &&
           m->interpolation == CPM_FIELD_STEP;
}

/* The same on the side that `direction` enters, where r lies on an interface of discrete layers. */
CPM_INLINE double cpm_index_toward(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                                   const double r[3], const double direction[3]) {
    if (!cpm_is_discrete(m)) return cpm_index_at(m, table, scale, r);
    double n = cpm_exact_index(m, table, scale, r, direction);
    return n > 0.0 ? n : NAN;
}

/* n at a point of a medium of the scene, for a bin (-1: the bundle). */
CPM_APART double world_index(const cpm_world *w, cpm_i32 medium, cpm_i32 bin, cpm_vec point) {
    const cpm_i32 at = medium * w->frame.bins + cpm_bins_middle(bin, w->frame.bins);
    if (w->places[medium].way == CPM_STRAIGHT_WAY) return w->index[at];
    const cpm_medium_data m = w->media[medium];
    const double r[3] = {point.x, point.y, point.z};
    return cpm_index_at(&m, cpm_table_of(w->tables, medium), w->scale[at], r);
}

/* Its square; 0 where there is none. */
CPM_INLINE double world_squared_index(const cpm_world *w, cpm_i32 medium, cpm_i32 bin, cpm_vec point) {
    const double n = world_index(w, medium, bin, point);
    return n > 0.0 ? n * n : 0.0;
}
#endif
