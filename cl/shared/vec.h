/* shared/vec.h: three doubles, one ray's, and what more lanes know of vectors in space than dialect.h does. Where a
 * lane is one double both are one type, so that functions of lanes take a single ray too. */
#ifndef CPM_SHARED_VEC_H
#define CPM_SHARED_VEC_H
#include "../dialect.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE
typedef real3 cpm_vec;
#else
typedef struct cpm_vec {
    double x, y, z;
} cpm_vec;
#endif

CPM_INLINE cpm_vec cpm_v(double x, double y, double z) {
    cpm_vec v;
    v.x = x, v.y = y, v.z = z;
    return v;
}
/* As fmin and fmax but for NaN (b then), and without a call. */
CPM_INLINE double cpm_min(double a, double b) { return a < b ? a : b; }
CPM_INLINE double cpm_max(double a, double b) { return a > b ? a : b; }

CPM_INLINE double cpm_vdot(cpm_vec a, cpm_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
CPM_INLINE cpm_vec cpm_cross(cpm_vec a, cpm_vec b) {
    return cpm_v(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
CPM_INLINE cpm_vec cpm_add(cpm_vec a, cpm_vec b) { return cpm_v(a.x + b.x, a.y + b.y, a.z + b.z); }
CPM_INLINE cpm_vec cpm_sub(cpm_vec a, cpm_vec b) { return cpm_v(a.x - b.x, a.y - b.y, a.z - b.z); }
CPM_INLINE cpm_vec cpm_scaled(double s, cpm_vec a) { return cpm_v(s * a.x, s * a.y, s * a.z); }
CPM_INLINE cpm_vec cpm_along(cpm_vec a, double s, cpm_vec b) { /* a + s b */
    return cpm_v(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
CPM_INLINE double cpm_norm(cpm_vec a) { return sqrt(cpm_vdot(a, a)); }
CPM_INLINE cpm_vec cpm_unit(cpm_vec a) { return cpm_scaled(1.0 / cpm_norm(a), a); }

/* The same of lanes. */
CPM_INLINE real3 splat3(cpm_vec a) { return triple(splat(a.x), splat(a.y), splat(a.z)); }
CPM_INLINE real3 unit3(real3 a) { return scale3(R(1.0) / root(dot3(a, a)), a); }

/* Two unit vectors that make a right-handed frame with the unit vector n (Duff et al., Building an Orthonormal Basis,
 * Revisited. JCGT 6(1), 2017). */
CPM_INLINE void frame3(real3 n, real3 *s, real3 *t) {
    real sign = pick(less(n.z, splat(0.0)), splat(-1.0), splat(1.0));
    real a = R(-1.0) / (sign + n.z), b = n.x * n.y * a;
    *s = triple(R(1.0) + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *t = triple(b, sign + n.y * n.y * a, -n.y);
}
#endif
