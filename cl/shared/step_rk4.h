/* shared/step_rk4.h: the classical Runge-Kutta method, fixed steps; 3 evaluations within and 1 at the end. As r'' =
 * g(r) (see step_dopri5.h), with g1 at the start:
 *
 *   r2 = r + h p/2,  r3 = r2 + h^2 g1/4,  r4 = r + h p + h^2 g2/2
 *   r + h p + h^2 (g1 + g2 + g3)/6,  p + h (g1 + 2 g2 + 2 g3 + g4)/6                                               (1)
 *
 * No embedded error; the caller counts the drift of |p| from n. */
#ifndef CPM_SHARED_STEP_RK4_H
#define CPM_SHARED_STEP_RK4_H
#include "step_trial.h"

CPM_INLINE cpm_trial cpm_step_rk4(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_point *a,
                                  real h) {
    cpm_trial t;
    real hh = h * h, n2, n3, n4;
    real3 r2 = add3(a->r, R(0.5) * h, a->p);
    real3 g2 = cpm_field(m, table, r2, a->scale, &n2);
    real3 g3 = cpm_field(m, table, add3(r2, R(0.25) * hh, a->g), a->scale, &n3);
    real3 g4 = cpm_field(m, table, add3(add3(a->r, h, a->p), R(0.5) * hh, g2), a->scale, &n4);
    real3 middle = add3(g2, splat(1.0), g3);
    real sixth = R(1.0 / 6.0) * h;
    t.end.r = add3(add3(a->r, h, a->p), sixth * h, add3(middle, splat(1.0), a->g));
    real3 weighed = add3(add3(a->g, splat(2.0), middle), splat(1.0), g4);
    t.end.p = add3(a->p, sixth, weighed);
    if (CPM_SINGLE) {
        t.bend = scale3(sixth * h, add3(middle, splat(1.0), a->g));
        t.push = scale3(sixth, weighed);
    }
    t.end.g = cpm_field(m, table, t.end.r, a->scale, &t.end.n);
    t.end.scale = a->scale;
    t.good = less(splat(0.0), n2) & less(splat(0.0), n3) & less(splat(0.0), n4) & less(splat(0.0), t.end.n);
    t.way = sixth * (a->n + R(2.0) * (n2 + n3) + n4);
    t.path = sixth * (a->n * a->n + R(2.0) * (n2 * n2 + n3 * n3) + n4 * n4);
    t.error_position2 = t.error_way = t.error_momentum2 = splat(0.0);
    t.dense = t.curve = splat(0.0);
    return t;
}
#endif
