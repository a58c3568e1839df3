/* shared/medium.h: n and g = (1/2) grad n^2 of any medium. n is not above 0 (or NaN) where n^2 <= 0: check less(0, n).
 */
#ifndef CPM_SHARED_MEDIUM_H
#define CPM_SHARED_MEDIUM_H
#include "medium_one.h"
#include "medium_sum.h"

CPM_ALWAYS_INLINE real3 cpm_field(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                  real *n) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_field_sum(m, table, r, scale, n);
    return cpm_field_one(m, table, r, scale, n);
}

/* n grows without bound at some place: rays may end there, captured. A sum's size[1] says it of its terms. */
CPM_INLINE int cpm_is_singular(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_EATON) | CPM_IS_KIND(m, CPM_MEDIUM_SOURCES) |
           (CPM_IS_KIND(m, CPM_MEDIUM_SUM) && m->size[1]);
}
CPM_INLINE real cpm_singular_distance_of(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SOURCES)) return cpm_nearest_source(m, table, r);
    real3 u = cpm_from_center(m, r);
    return R(m->high) * root(dot3(u, u));
}
CPM_APART real cpm_singular_distance_of_sum(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r) {
    real nearest = splat(CPM_SINGLE ? 1e37 : 1e299);
    for (int i = 0; i < m->size[0]; i++) {
        const cpm_term t = cpm_term_at(m, table, i);
        if (cpm_is_singular(&t.data)) nearest = smaller(nearest, cpm_singular_distance_of(&t.data, table + t.table, r));
    }
    return nearest;
}
/* How far it is to the nearest such place, metres: a longer step could leap over it. */
CPM_INLINE real cpm_singular_distance(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_singular_distance_of_sum(m, table, r);
    return cpm_singular_distance_of(m, table, r);
}

/* A table of samples: between them n is a polynomial, at each a higher derivative jumps. A sum's size[2] says it of its
 * terms. */
CPM_INLINE int cpm_is_table(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_LAYERED) | CPM_IS_KIND(m, CPM_MEDIUM_SHELLS) | CPM_IS_KIND(m, CPM_MEDIUM_GRID) |
           (CPM_IS_KIND(m, CPM_MEDIUM_SUM) && m->size[2]);
}
#endif
