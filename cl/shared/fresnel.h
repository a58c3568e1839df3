/* shared/fresnel.h: a ray at a jump of the refractive index; lanes, of which one ray is a case. */
#ifndef CPM_SHARED_FRESNEL_H
#define CPM_SHARED_FRESNEL_H
#include "vec.h"

CPM_INLINE real3 reflect3(real3 d, real3 n) { return add3(d, R(-2.0) * dot3(d, n), n); }

/* Snell and Fresnel for unpolarised light. `d`: unit direction of travel, `n`: unit normal of either side, `n1`, `n2`:
 * index before and behind. Returns the reflectance R in [0, 1], 1 where reflection is total; `refracted` is the unit
 * direction behind (untouched where there is none). */
CPM_INLINE real fresnel_lanes(real3 d, real3 n, real n1, real n2, real3 *refracted) {
    real along = -dot3(d, n), c1 = magnitude(along);
    n = pick3(less(along, splat(0.0)), scale3(splat(-1.0), n), n);
    /* cos^2 behind = 1 - (n1/n2)^2 sin^2, written so that equal indices lose nothing */
    real ratio = n1 / n2;
    real s2 = R(1.0) - c1 * c1;
    real c2_squared = R(1.0) - ratio * ratio * pick(less(s2, splat(0.0)), splat(0.0), s2);
    mask passes = less(splat(0.0), c2_squared);
    real c2 = root(pick(passes, c2_squared, splat(1.0)));
    *refracted = pick3(passes, unit3(add3(scale3(ratio, d), ratio * c1 - c2, n)), *refracted);
    real s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
    real p = (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1);
    return pick(passes, R(0.5) * (s * s + p * p), splat(1.0));
}
#endif
