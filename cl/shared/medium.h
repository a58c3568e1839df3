/* shared/medium.h: n and g = (1/2) grad n^2 of any medium. n is not above 0 (or NaN) where n^2 <= 0: check less(0, n). */
#ifndef CPM_SHARED_MEDIUM_H
#define CPM_SHARED_MEDIUM_H
#include "medium_one.h"
#include "medium_sum.h"

CPM_ALWAYS_INLINE real3 cpm_field(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                  real *n) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_field_sum(m, table, r, scale, n);
    return cpm_field_one(m, table, r, scale, n);
}
#endif
