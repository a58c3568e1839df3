/* shared/medium_one.h: n and g = (1/2) grad n^2 of any medium that is not a sum.
 */
#ifndef CPM_SHARED_MEDIUM_ONE_H
#define CPM_SHARED_MEDIUM_ONE_H
#include "medium_central.h"
#include "medium_expression.h"
#include "medium_grid.h"
#include "medium_layered.h"
#include "medium_linear.h"
#include "medium_shells.h"
#include "medium_sources.h"

CPM_ALWAYS_INLINE real3 cpm_field_one(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                      real *n) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR_SQUARED)) return cpm_field_linear_squared(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR)) return cpm_field_linear(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) return cpm_field_layered(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_GRID)) {
        if (m->interpolation == CPM_FIELD_CUBIC) return cpm_field_grid_cubic(m, table, r, scale, n);
        return cpm_field_grid_linear(m, table, r, scale, n);
    }
    if (CPM_IS_KIND(m, CPM_MEDIUM_PARABOLIC)) return cpm_field_parabolic(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG)) return cpm_field_luneburg(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_FISHEYE)) return cpm_field_fisheye(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_EATON)) return cpm_field_eaton(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_SOURCES)) return cpm_field_sources(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_SHELLS)) return cpm_field_shells(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_EXPRESSION)) return cpm_field_expression(m, table, r, scale, n);
    return cpm_field_homogeneous(m, scale, n);
}
#endif
