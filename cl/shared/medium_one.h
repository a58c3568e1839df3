/* shared/medium_one.h: n and g = (1/2) grad n^2 of any medium that is not a sum.
 *
 * CPM_MEDIA says which kinds are compiled in: bit 1 << CPM_MEDIUM_... (all by default). A sum needs its bit and its
 * terms'. */
#ifndef CPM_SHARED_MEDIUM_ONE_H
#define CPM_SHARED_MEDIUM_ONE_H
#include "medium_expression.h"
#include "medium_grid.h"
#include "medium_layered.h"
#include "medium_linear.h"
#include "medium_shells.h"

#ifndef CPM_MEDIA
#define CPM_MEDIA 0x1fff
#endif
#define CPM_HAS_KIND(k) ((CPM_MEDIA >> (k)) & 1)
#define CPM_IS_KIND(m, k) (CPM_HAS_KIND(k) && (m)->kind == (k))

CPM_ALWAYS_INLINE real3 cpm_field_one(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                      real *n) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR_SQUARED)) return cpm_field_linear_squared(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LINEAR)) return cpm_field_linear(m, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) return cpm_field_layered(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_GRID)) {
        if (m->interpolation == CPM_FIELD_CUBIC) return cpm_field_grid_cubic(m, table, r, scale, n);
        return cpm_field_grid_linear(m, table, r, scale, n);
    }
    if (CPM_IS_KIND(m, CPM_MEDIUM_SHELLS)) return cpm_field_shells(m, table, r, scale, n);
    if (CPM_IS_KIND(m, CPM_MEDIUM_EXPRESSION)) return cpm_field_expression(m, table, r, scale, n);
    return cpm_field_homogeneous(m, scale, n);
}
#endif
