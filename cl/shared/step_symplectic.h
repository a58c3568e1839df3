/* shared/step_symplectic.h: leapfrog and Yoshida's sixth-order composition of it, fixed steps in sigma, for very long
 * paths: H = (|p|^2 - n^2)/2 stays bounded however far a ray goes.
 *
 *   kick, drift, kick:  p + w h g/2,  r + w h p,  p + w h g/2                                                      (1)
 *
 * with w = 1 (leapfrog, 1 evaluation) or w3 w2 w1 w0 w1 w2 w3 (7). l' = n(r) and L' = n^2(r) are kicked like p.
 * Additions are compensated (Kahan): after 10^8 steps rounding would else have walked away with the ninth digit. What
 * an addition lost is carried in the lanes' `low`. Yoshida, Construction of higher order symplectic integrators, Phys.
 * Lett. A 150 (1990): solution A. */
#ifndef CPM_SHARED_STEP_SYMPLECTIC_H
#define CPM_SHARED_STEP_SYMPLECTIC_H
#include "../types/lanes.h"
#include "step_trial.h"

CPM_CONSTANT_TABLE double cpm_yoshida6_w[7] = {0.78451361047755726382, 0.23557321335935813368,  -1.17767998417887100695,
                                               1.31518632068391121889, -1.17767998417887100695, 0.23557321335935813368,
                                               0.78451361047755726382};

/* Which rays spend the step in Luneburg's or Eaton's lens: its middle, along the parabola of the start, lies there.
 * Stages that step over the sphere (they go backwards too) see the field continued, or a step that starts or ends there
 * would be of first order. */
CPM_INLINE int cpm_has_within(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON);
}
CPM_INLINE mask cpm_is_within(const cpm_medium_data *m, const cpm_point *a, real h) {
    real n;
    const real3 g = cpm_field_lens_within(m, a->r, a->scale, &n);
    const real3 u = cpm_from_center(m, add3(add3(a->r, R(0.5) * h, a->p), R(0.125) * h * h, g));
    return less(dot3(u, u), splat(1.0));
}
CPM_INLINE real3 cpm_field_side(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                mask within, real *n) {
    real3 g = cpm_field(m, table, r, scale, n);
    if (!cpm_has_within(m)) return g;
    real n_within;
    const real3 g_within = cpm_field_lens_within(m, r, scale, &n_within);
    *n = pick(within, n_within, *n);
    return pick3(within, g_within, g);
}

/* sum + (more + low), what is lost into low. */
CPM_INLINE real cpm_compensated(real sum, real more, real *low) {
    real all = more + *low, total = sum + all;
    *low = all - (total - sum);
    return total;
}
CPM_INLINE real3 cpm_compensated3(real3 sum, real s, real3 more, real3 *low) {
    return triple(cpm_compensated(sum.x, s * more.x, &low->x), cpm_compensated(sum.y, s * more.y, &low->y),
                  cpm_compensated(sum.z, s * more.z, &low->z));
}

CPM_INLINE cpm_trial cpm_step_symplectic(const cpm_medium_data *m, CPM_GLOBAL const double *table, cpm_lane_rays *rays,
                                         int part, const cpm_point *a, real h, int yoshida) {
    real3 r_low = load3_doubles(rays->low, part), p_low = load3_doubles(rays->low + 3, part);
    const real h2 = R(0.5) * h;
    cpm_trial t;
    t.end = *a;
    mask within = splat_mask(0);
    if (cpm_has_within(m)) { /* also the start's g: rounding decides on which side of the sphere it was taken */
        within = cpm_is_within(m, a, h);
        real n;
        const real3 g = cpm_field_lens_within(m, a->r, a->scale, &n);
        t.end.g = pick3(within, g, a->g), t.end.n = pick(within, n, a->n);
    }
    t.good = at_most(splat(0.0), h);
    t.way = t.path = splat(0.0);
    for (int i = 0; i < (yoshida ? 7 : 1); i++) {
        const scalar w = yoshida ? R(cpm_yoshida6_w[i]) : R(1.0);
        const real n = t.end.n;
        t.end.p = cpm_compensated3(t.end.p, w * h2, t.end.g, &p_low);
        t.end.r = cpm_compensated3(t.end.r, w * h, t.end.p, &r_low);
        t.end.g = cpm_field_side(m, table, t.end.r, a->scale, within, &t.end.n);
        t.end.p = cpm_compensated3(t.end.p, w * h2, t.end.g, &p_low);
        t.good &= less(splat(0.0), t.end.n);
        t.way += w * h2 * (n + t.end.n);
        t.path += w * h2 * (n * n + t.end.n * t.end.n);
    }
    t.error_position2 = t.error_way = t.error_momentum2 = t.dense = t.curve = splat(0.0);
    store3_doubles(r_low, rays->low_next, part);
    store3_doubles(p_low, rays->low_next + 3, part);
    return t;
}
#endif
