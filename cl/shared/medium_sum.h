/* shared/medium_sum.h: n = 1 + sum (n_i - 1), g = n sum grad n_i = n sum g_i/n_i, over a flat list of terms, none of which is
 * a sum itself. Where a term has no n (n_i <= 0) the sum has none. */
#ifndef CPM_SHARED_MEDIUM_SUM_H
#define CPM_SHARED_MEDIUM_SUM_H
#include "../types/term.h"
#include "dispersion.h"
#include "medium_one.h"

/* A term, out of the table (which is doubles: no pointer to it may be a struct's). */
CPM_INLINE cpm_term cpm_term_at(const cpm_medium_data *m, CPM_GLOBAL const double *table, int i) {
    union {
        cpm_term term;
        double raw[CPM_TERM];
    } u;
    for (int k = 0; k < CPM_TERM; k++) u.raw[k] = table[m->records + CPM_TERM * i + k];
    return u.term;
}

CPM_INLINE real cpm_term_scale(const cpm_term *t, CPM_GLOBAL const double *table, real scale) {
    if (t->scaling == CPM_SCALE_NONE) return splat(1.0);
    if (t->scaling == CPM_SCALE_GIVEN) return scale;
    scalar factor[CPM_WIDTH];
    store_lanes(scale, factor, 0);
    for (int i = 0; i < CPM_WIDTH; i++) {
        double n = cpm_dispersion_n(t->dispersion, t->count, table + t->coefficients, (double)factor[i]);
        factor[i] = (scalar)((t->square ? (n - 1.0) * (n + 1.0) : n - 1.0) / t->reference);
    }
    return load_lanes(factor, 0);
}

CPM_OUTLINE real3 cpm_field_sum(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale, real *n) {
    const real zero = splat(0.0);
    real3 slope = triple(zero, zero, zero);
    real refractivity = zero;
    mask good = ~splat_mask(0);
    for (int i = 0; i < m->size[0]; i++) {
        const cpm_term t = cpm_term_at(m, table, i);
        real index;
        real3 g = cpm_field_one(&t.data, table + t.table, r, cpm_term_scale(&t, table, scale), &index);
        good &= less(zero, index);
        refractivity += index - R(1.0);
        slope = add3(slope, R(1.0) / index, g);
    }
    real index = R(1.0) + refractivity;
    good &= less(zero, index);
    *n = pick(good, index, zero);
    return pick3(good, scale3(index, slope), triple(zero, zero, zero));
}
#endif
