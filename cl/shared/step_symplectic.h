/* shared/step_symplectic.h: leapfrog and Yoshida's sixth-order composition of it, fixed steps in sigma, for very long
 * paths: H = (|p|^2 - n^2)/2 stays bounded however far a ray goes.
 *
 *   kick, drift, kick:  p + w h g/2,  r + w h p,  p + w h g/2                                                      (1)
 *
 * with w = 1 (leapfrog, 1 evaluation) or w3 w2 w1 w0 w1 w2 w3 (7). l' = n(r) and L' = n^2(r) are kicked like p.
 * Additions are compensated (Kahan): after 10^8 steps rounding would else have walked away with the ninth digit. What an
 * addition lost is carried in the lanes' `low`.
 * Yoshida, Construction of higher order symplectic integrators, Phys. Lett. A 150 (1990): solution A. */
#ifndef CPM_SHARED_STEP_SYMPLECTIC_H
#define CPM_SHARED_STEP_SYMPLECTIC_H
#include "../types/lanes.h"
#include "step_trial.h"

CPM_CONSTANT_TABLE double cpm_yoshida6_w[7] = {0.78451361047755726382,  0.23557321335935813368, -1.17767998417887100695,
                                               1.31518632068391121889,  -1.17767998417887100695, 0.23557321335935813368,
                                               0.78451361047755726382};

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
    t.good = at_most(splat(0.0), h);
    t.way = t.path = splat(0.0);
    for (int i = 0; i < (yoshida ? 7 : 1); i++) {
        const scalar w = yoshida ? R(cpm_yoshida6_w[i]) : R(1.0);
        const real n = t.end.n;
        t.end.p = cpm_compensated3(t.end.p, w * h2, t.end.g, &p_low);
        t.end.r = cpm_compensated3(t.end.r, w * h, t.end.p, &r_low);
        t.end.g = cpm_field(m, table, t.end.r, a->scale, &t.end.n);
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
