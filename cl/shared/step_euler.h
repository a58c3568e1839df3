/* shared/step_euler.h: Euler with Richardson extrapolation, the paper's method: one full step against two half steps;
 * the extrapolated value 2 (two halves) - (one full) is kept, second order. 2 evaluations a step: at the half step and
 * at the end, where the next one starts.
 *
 *   halves   r + h p + h^2 g/4,  p + h (g + g_half)/2      full   r + h p,  p + h g
 *   kept     r + h p + h^2 g/2,  p + h g_half              difference   h^2 g/4,  h (g_half - g)/2                  (1)
 *
 * with g_half at r + h p/2. Arc length and optical path likewise: the half step's n and n^2.
 * Gutierrez et al., Curved photon mapping: the difference is the error that chooses the step. */
#ifndef CPM_SHARED_STEP_EULER_H
#define CPM_SHARED_STEP_EULER_H
#include "step_trial.h"

CPM_INLINE cpm_trial cpm_step_euler(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_point *a,
                                    real h) {
    cpm_trial t;
    real n, quarter = R(0.25) * h * h;
    real3 g = cpm_field(m, table, add3(a->r, R(0.5) * h, a->p), a->scale, &n);
    real3 change = sub3(g, a->g);
    t.good = less(splat(0.0), n);
    t.end.r = add3(add3(a->r, h, a->p), R(2.0) * quarter, a->g);
    t.end.p = add3(a->p, h, g);
    if (CPM_SINGLE) t.bend = scale3(R(2.0) * quarter, a->g), t.push = scale3(h, g);
    t.end.g = cpm_field(m, table, t.end.r, a->scale, &t.end.n);
    t.end.scale = a->scale;
    t.good &= less(splat(0.0), t.end.n);
    t.way = h * n;
    t.path = h * (n * n);
    t.error_position2 = quarter * quarter * dot3(a->g, a->g);
    t.error_way = R(0.5) * h * (n - a->n);
    t.error_momentum2 = quarter * dot3(change, change);
    t.dense = t.curve = splat(0.0);
    return t;
}
#endif
