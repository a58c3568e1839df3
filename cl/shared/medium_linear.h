/* shared/medium_linear.h: n^2 or n linear in position, and the constant.
 *
 *   linear-squared  n^2 = 1 + s (S0 + G . d),  d = r - origin,  g = s G/2
 *   linear          n = 1 + s (N0 + G . d),                     g = n s G */
#ifndef CPM_SHARED_MEDIUM_LINEAR_H
#define CPM_SHARED_MEDIUM_LINEAR_H
#include "../types/medium.h"

/* G . (r - origin) */
CPM_INLINE real cpm_along_axis(const cpm_medium_data *m, real3 r) {
    return (r.x - R(m->origin[0])) * R(m->axis[0]) + (r.y - R(m->origin[1])) * R(m->axis[1]) +
           (r.z - R(m->origin[2])) * R(m->axis[2]);
}
CPM_INLINE real3 cpm_times_axis(const cpm_medium_data *m, real s) {
    return triple(s * R(m->axis[0]), s * R(m->axis[1]), s * R(m->axis[2]));
}

CPM_INLINE real3 cpm_field_linear_squared(const cpm_medium_data *m, real3 r, real scale, real *n) {
    *n = root(R(1.0) + scale * (R(m->value) + cpm_along_axis(m, r)));
    return cpm_times_axis(m, R(0.5) * scale);
}

CPM_INLINE real3 cpm_field_linear(const cpm_medium_data *m, real3 r, real scale, real *n) {
    *n = R(1.0) + scale * (R(m->value) + cpm_along_axis(m, r));
    return cpm_times_axis(m, *n * scale);
}

CPM_INLINE real3 cpm_field_homogeneous(const cpm_medium_data *m, real scale, real *n) {
    *n = R(1.0) + scale * R(m->value);
    return triple(splat(0.0), splat(0.0), splat(0.0));
}
#endif
