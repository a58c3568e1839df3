/* shared/fresnel.h: a ray at a jump of the refractive index. */
#ifndef CPM_SHARED_FRESNEL_H
#define CPM_SHARED_FRESNEL_H
#include "vec.h"

CPM_INLINE cpm_vec cpm_reflect(cpm_vec d, cpm_vec n) { return cpm_along(d, -2.0 * cpm_vdot(d, n), n); }

/* Snell and Fresnel for unpolarised light. `d`: unit direction of travel, `n`: unit normal of either side, `n1`, `n2`:
 * index before and behind. Returns the reflectance R in [0, 1], 1 where reflection is total; `refracted` is the unit
 * direction behind (untouched where there is none). */
CPM_INLINE double cpm_fresnel(cpm_vec d, cpm_vec n, double n1, double n2, cpm_vec *refracted) {
    double c1 = -cpm_vdot(d, n);
    if (c1 < 0.0) {
        c1 = -c1;
        n = cpm_scaled(-1.0, n);
    }
    /* cos^2 behind = 1 - (n1/n2)^2 sin^2, written so that equal indices lose nothing */
    double ratio = n1 / n2;
    double s2 = 1.0 - c1 * c1;
    double c2_squared = 1.0 - ratio * ratio * (s2 < 0.0 ? 0.0 : s2);
    if (!(c2_squared > 0.0)) return 1.0;
    double c2 = sqrt(c2_squared);
    *refracted = cpm_unit(cpm_along(cpm_scaled(ratio, d), ratio * c1 - c2, n));
    double s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
    double p = (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1);
    return 0.5 * (s * s + p * p);
}
#endif
