/* shared/medium.h: n and g = (1/2) grad n^2 of any medium. n is not above 0 (or NaN) where n^2 <= 0: check less(0, n).
 *
 * CPM_MEDIA says which kinds are compiled in: bit 1 << CPM_MEDIUM_... (all by default). */
#ifndef CPM_SHARED_MEDIUM_H
#define CPM_SHARED_MEDIUM_H
#include "medium_grid.h"
#include "medium_layered.h"
#include "medium_linear.h"

#ifndef CPM_MEDIA
#define CPM_MEDIA 31
#endif
#define CPM_IS_KIND(m, k) (((CPM_MEDIA >> (k)) & 1) && (m)->kind == (k))

CPM_INLINE real3 cpm_field(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale, real *n) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR_SQUARED)) return cpm_field_linear_squared(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR)) return cpm_field_linear(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) return cpm_field_layered(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_GRID)) {
        if (m->interpolation == CPM_FIELD_CUBIC) return cpm_field_grid_cubic(m, table, r, scale, n);
        return cpm_field_grid_linear(m, table, r, scale, n);
    }
    return cpm_field_homogeneous(m, scale, n);
}
#endif
