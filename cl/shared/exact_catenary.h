/* shared/exact_catenary.h: the path where n is linear, G = grad n: p = p0 + G l, explicit in arc length l.
 *
 * With s, q, e of exact_parabola.h (now d = gamma l, gamma = |G|; e = n):
 *   r = r0 + axis (e1 - e0)/gamma + rest sigma,   sigma = int dl/e,   optical path = int e dl                      (1)
 *   (e1 - e0)/gamma = l (s0 + s1)/(e0 + e1)
 * and in sigma: e1 = e0 cosh x + s0 sinh x, s1 = s0 cosh x + e0 sinh x, x = gamma sigma.                           (2)
 *
 * f(sigma) = (r - point) . normal has f'' = n (G . normal): of one sign, so at most two crossings, on either side of
 * the extremum, which is at s = -(rest . normal)/(axis . normal). (3) */
#ifndef CPM_SHARED_EXACT_CATENARY_H
#define CPM_SHARED_EXACT_CATENARY_H
#include "exact_parabola.h"

#define CPM_CATENARY_PIECE                                                                                             \
    0.02 /* gamma sigma of a piece: the quintic's error is 2.2e-5 x 0.02^5 = 7e-14 of its length */
#define CPM_EXACT_FAR 1e100

CPM_INLINE void cpm_catenary_at(const cpm_split *a, const double r0[3], double length, double r[3], double p[3]) {
    double s1 = a->s + a->gamma * length, e1 = cpm_sqrt(a->q2 + s1 * s1);
    double along = a->e + e1 > 0.0 ? length * (a->s + s1) / (a->e + e1) : 0.0, across = cpm_inverse_integral(a, length);
    for (int k = 0; k < 3; k++) {
        r[k] = r0[k] + (a->gamma > 0.0 ? a->axis[k] * along + a->rest[k] * across : a->rest[k] * across);
        p[k] = a->rest[k] + a->axis[k] * s1;
    }
}

CPM_INLINE double cpm_catenary_offset(const cpm_split *a, const double r0[3], const double point[3],
                                      const double normal[3], double length) {
    double r[3], p[3], rounding;
    cpm_catenary_at(a, r0, length, r, p);
    return cpm_plane_offset(r, point, normal, &rounding);
}
/* The root in (low, high), where the offset changes sign: Newton (slope normal . p/e) kept in the bracket. */
CPM_INLINE double cpm_catenary_polish(const cpm_split *a, const double r0[3], const double point[3],
                                      const double normal[3], double low, double high, int positive_at_low) {
    double l = 0.5 * (low + high);
    for (int i = 0; i < 200; i++) {
        double r[3], p[3], rounding;
        cpm_catenary_at(a, r0, l, r, p);
        double f = cpm_plane_offset(r, point, normal, &rounding), slope = cpm_dot(p, normal) / cpm_sqrt(cpm_dot(p, p));
        if (f == 0.0) return l;
        if ((f > 0.0) == positive_at_low)
            low = l;
        else
            high = l;
        double next = l - f / slope;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (fabs(next - l) <= 2e-16 * l) return next;
        l = next;
    }
    return l;
}
/* Arc length of the first crossing of the plane in (0, most], else -1, by (3). */
CPM_INLINE double cpm_catenary_plane(const cpm_split *a, const double r0[3], const double p0[3], const double point[3],
                                     const double normal[3], double most) {
    double rounding, f0 = cpm_plane_offset(r0, point, normal, &rounding);
    double slope = cpm_dot(p0, normal), bend = cpm_dot(a->axis, normal) * a->gamma;
    int on_plane = fabs(f0) <= rounding;
    if (on_plane) f0 = slope; /* the sign on the way out */
    double start = 0.0;
    if (slope * bend < 0.0) { /* there is an extremum ahead */
        double turn = (-cpm_dot(a->rest, normal) / cpm_dot(a->axis, normal) - a->s) / a->gamma;
        if (turn > 0.0 && turn < most) {
            double there = cpm_catenary_offset(a, r0, point, normal, turn);
            if (!on_plane && (there > 0.0) != (f0 > 0.0))
                return cpm_catenary_polish(a, r0, point, normal, 0.0, turn, f0 > 0.0);
            start = turn;
        } else if (turn >= most)
            start = -1.0;
    } else if (on_plane)
        return -1.0;
    if (start > 0.0 && (f0 > 0.0) == (bend > 0.0)) return -1.0; /* turned away from the plane for good */
    /* From here on the offset is monotone: look where it changes sign. */
    double low = start > 0.0 ? start : 0.0,
           high = low + fabs(f0) + fabs(cpm_catenary_offset(a, r0, point, normal, low));
    int positive = f0 > 0.0;
    if (!(high > low)) high = low + a->e / (a->gamma + 1e-30);
    for (int i = 0; i < 400; i++) {
        if (high > most) high = most;
        if ((cpm_catenary_offset(a, r0, point, normal, high) > 0.0) != positive)
            return cpm_catenary_polish(a, r0, point, normal, low, high, positive);
        if (high >= most || high > CPM_EXACT_FAR) return -1.0;
        low = high;
        high = 2.0 * high;
    }
    return -1.0;
}

/* Point, momentum and arc length after sigma <= CPM_CATENARY_PIECE/gamma, by the series of (2). */
CPM_INLINE double cpm_catenary_after(const cpm_split *a, const double r0[3], double sigma, double r[3], double p[3]) {
    double x = a->gamma * sigma, xx = x * x;
    double sinh_x = 1.0 + xx / 6.0 * (1.0 + xx / 20.0 * (1.0 + xx / 42.0));          /* sinh x/x */
    double cosh_x = 0.5 * (1.0 + xx / 12.0 * (1.0 + xx / 30.0 * (1.0 + xx / 56.0))); /* (cosh x - 1)/x^2 */
    double length = sigma * (a->e * sinh_x + a->s * cosh_x * x), along = sigma * (a->s * sinh_x + a->e * cosh_x * x);
    for (int k = 0; k < 3; k++) {
        r[k] = r0[k] + a->axis[k] * along + a->rest[k] * sigma;
        p[k] = a->rest[k] + a->axis[k] * (a->s + a->gamma * length);
    }
    return length;
}
#endif
