/* shared/medium_central.h: fibre, Luneburg lens, fish-eye, Eaton lens. y = r - centre, u = |y|/R, s the dispersion's
 * scale.
 *
 *   parabolic  n^2 = 1 + s (S0 - k rho^2), k = (n0 alpha)^2, S0 = n0^2 - 1      g = -s k (y - (y . axis) axis)
 *   luneburg   n^2 = 1 + s (1 - u^2) inside, 1 outside                          g = -s y/R^2
 *   fisheye    n = (1 + s N0)/(1 + u^2), N0 = n0 - 1                            g = -2 n^2 y/(R^2 (1 + u^2))
 *   eaton      n^2 = 1 + 2 s (1/u - 1) inside, 1 outside                        g = -s y/(R^2 u^3)
 *
 * The fish-eye's own index scales, not n - 1 everywhere: it stays a fish-eye, and its circles stay exact. At Eaton's
 * centre u is kept above 1e-30 (1e-15 in single precision): nothing becomes infinite. */
#ifndef CPM_SHARED_MEDIUM_CENTRAL_H
#define CPM_SHARED_MEDIUM_CENTRAL_H
#include "medium_linear.h"

#define CPM_LEAST_U2 (CPM_SINGLE ? 1e-30 : 1e-60)

CPM_INLINE real3 cpm_field_parabolic(const cpm_medium_data *m, real3 r, real scale, real *n) {
    real3 y = triple(r.x - R(m->origin[0]), r.y - R(m->origin[1]), r.z - R(m->origin[2]));
    real along = cpm_along_axis(m, r), pull = scale * R(m->high);
    y = triple(y.x - along * R(m->axis[0]), y.y - along * R(m->axis[1]), y.z - along * R(m->axis[2]));
    *n = root(R(1.0) + (scale * R(m->value) - pull * dot3(y, y)));
    return scale3(-pull, y);
}

/* y/R */
CPM_INLINE real3 cpm_from_center(const cpm_medium_data *m, real3 r) {
    const scalar per = R(1.0 / m->high);
    return triple((r.x - R(m->origin[0])) * per, (r.y - R(m->origin[1])) * per, (r.z - R(m->origin[2])) * per);
}

CPM_INLINE real3 cpm_field_luneburg(const cpm_medium_data *m, real3 r, real scale, real *n) {
    real3 u = cpm_from_center(m, r);
    real left = R(1.0) - dot3(u, u), zero = splat(0.0);
    mask inside = less(zero, left);
    *n = root(R(1.0) + scale * pick(inside, left, zero));
    return scale3(pick(inside, scale * R(-1.0 / m->high), zero), u);
}

CPM_INLINE real3 cpm_field_fisheye(const cpm_medium_data *m, real3 r, real scale, real *n) {
    real3 u = cpm_from_center(m, r);
    real per = R(1.0) / (R(1.0) + dot3(u, u)), index = (R(1.0) + scale * R(m->value)) * per;
    *n = index;
    return scale3(R(-2.0 / m->high) * (index * index * per), u);
}

CPM_INLINE real3 cpm_field_eaton(const cpm_medium_data *m, real3 r, real scale, real *n) {
    real3 u = cpm_from_center(m, r);
    real uu = larger(dot3(u, u), splat(CPM_LEAST_U2)), per = R(1.0) / root(uu), zero = splat(0.0);
    mask inside = less(uu, splat(1.0));
    *n = root(R(1.0) + R(2.0) * scale * pick(inside, per - R(1.0), zero));
    return scale3(pick(inside, scale * R(-1.0 / m->high) * (per * per * per), zero), u);
}

/* The field inside Luneburg's or Eaton's lens, continued beyond its sphere. */
CPM_INLINE real3 cpm_field_lens_within(const cpm_medium_data *m, real3 r, real scale, real *n) {
    const real3 u = cpm_from_center(m, r);
    const real uu = larger(dot3(u, u), splat(CPM_LEAST_U2)), one = splat(1.0);
    if (m->kind == CPM_MEDIUM_LUNEBURG) {
        *n = root(one + scale * (one - uu));
        return scale3(scale * R(-1.0 / m->high), u);
    }
    const real per = one / root(uu);
    *n = root(one + R(2.0) * scale * (per - one));
    return scale3(scale * R(-1.0 / m->high) * (per * per * per), u);
}
#endif
