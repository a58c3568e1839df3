/* shared/exact_parabola.h: the path where n^2 is linear: r = r0 + p0 x + g x^2/2, p = p0 + g x for x = sigma, of any
 * length, and its arc length. Straight paths are the case g = 0.
 *
 * With gamma = |g|, s = p . g/gamma the part of p along g and q the rest, which stays: e = |p| = sqrt(q^2 + s^2) and
 * over [s0, s1 = s0 + d]
 *
 *   int ds/e = asinh(s1/q) - asinh(s0/q) = asinh y,   int e ds = (s1 e1 - s0 e0 + q^2 int ds/e)/2                  (1)
 *   y = d (s0 + s1)/(s1 e0 + s0 e1)                     s0, s1 of one sign                                         (2)
 *     = d (e0 - s0 (s0 + s1)/(e0 + e1))/q^2             else
 *   s1 e1 - s0 e0 = d (e1 + s0 (s0 + s1)/(e0 + e1))                                                                (3)
 *
 * Nothing cancels when d is small, and gamma divides out (d = gamma x): the arc length l = int e dx is good to rounding
 * for any gamma, 0 included. (The textbook difference of s e + q^2 asinh(s/q) loses 9 digits where gamma l << n^2.) */
#ifndef CPM_SHARED_EXACT_PARABOLA_H
#define CPM_SHARED_EXACT_PARABOLA_H
#include "elementary.h"
#include "piece.h"

#define CPM_EXACT_INFINITE 1e300

/* asinh(y)/y; up to 0.15 by its series, whose next term is below 1e-18: gentle bends need no logarithm. */
CPM_INLINE double cpm_asinh_ratio(double y) {
    double a = fabs(y), z = y * y;
    if (a < 0.15) {
        double p = -46189.0 / 5505024.0 * z + 12155.0 / 1245184.0;
        p = p * z - 6435.0 / 557056.0;
        p = p * z + 143.0 / 10240.0;
        p = p * z - 231.0 / 13312.0;
        p = p * z + 63.0 / 2816.0;
        p = p * z - 35.0 / 1152.0;
        p = p * z + 5.0 / 112.0;
        p = p * z - 3.0 / 40.0;
        p = p * z + 1.0 / 6.0;
        return 1.0 - p * z;
    }
    return cpm_log1p(a + a * a / (1.0 + cpm_sqrt(1.0 + a * a))) / a;
}

/* p split along the direction of g: s, and the rest (vector and square). Where g = 0, s = 0 and the rest is all. */
typedef struct cpm_split {
    double gamma, s, q2, e; /* |g|, p . g/|g|, |rest|^2, |p| */
    double axis[3], rest[3];
} cpm_split;
CPM_INLINE cpm_split cpm_split_along(const double p[3], const double g[3]) {
    cpm_split a;
    double largest = fmax(fabs(g[0]), fmax(fabs(g[1]), fabs(g[2])));
    double h[3] = {0.0, 0.0, 0.0}; /* scaled: |g|^2 must not underflow */
    for (int k = 0; k < 3 && largest > 0.0; k++) h[k] = g[k] / largest;
    double size = cpm_sqrt(cpm_dot(h, h));
    a.gamma = largest * size;
    for (int k = 0; k < 3; k++) a.axis[k] = size > 0.0 ? h[k] / size : 0.0;
    a.s = cpm_dot(p, a.axis);
    for (int k = 0; k < 3; k++) a.rest[k] = p[k] - a.s * a.axis[k];
    a.q2 = cpm_dot(a.rest, a.rest);
    a.e = cpm_sqrt(a.q2 + a.s * a.s);
    return a;
}

/* int ds/e divided by gamma, equations (1), (2); d = gamma x. 0 where q vanishes and p turns through 0 (not
 * integrable). */
CPM_INLINE double cpm_inverse_integral(const cpm_split *a, double x) {
    double s0 = a->s, s1 = s0 + a->gamma * x, e0 = a->e, e1 = cpm_sqrt(a->q2 + s1 * s1), y;
    if (s0 * s1 > 0.0)
        y = x * (s0 + s1) / (s1 * e0 + s0 * e1);
    else if (a->q2 > 1e-30 * (e0 * e0 + e1 * e1))
        y = x * (e0 - s0 * (s0 + s1) / (e0 + e1)) / a->q2;
    else
        return 0.0;
    return y * cpm_asinh_ratio(y * a->gamma);
}
/* int e dx, equations (1), (3). */
CPM_INLINE double cpm_momentum_integral(const cpm_split *a, double x) {
    double s0 = a->s, s1 = s0 + a->gamma * x, e0 = a->e, e1 = cpm_sqrt(a->q2 + s1 * s1);
    double sum = e0 + e1 > 0.0 ? s0 * (s0 + s1) / (e0 + e1) : 0.0;
    return 0.5 * (x * (e1 + sum) + a->q2 * cpm_inverse_integral(a, x));
}
/* The x > 0 at which int e dx is `wanted`: Halley's iteration (derivatives e, gamma s/e) kept in a bracket. */
CPM_INLINE double cpm_momentum_inverse(const cpm_split *a, double wanted) {
    if (!(wanted > 0.0)) return 0.0;
    double bent = a->e * a->e + 2.0 * a->gamma * a->s / (a->e > 0.0 ? a->e : 1.0) * wanted;
    double low = 0.0, high = CPM_EXACT_INFINITE, x = 2.0 * wanted / (a->e + cpm_sqrt(bent > 0.0 ? bent : 0.0));
    if (!(x < CPM_EXACT_INFINITE)) x = a->gamma > 0.0 ? cpm_sqrt(2.0 * wanted / a->gamma) : 0.0;
    for (int i = 0; i < 200; i++) {
        double s1 = a->s + a->gamma * x, e1 = cpm_sqrt(a->q2 + s1 * s1);
        double miss = cpm_momentum_integral(a, x) - wanted;
        if (miss > 0.0)
            high = x;
        else
            low = x;
        double newton = miss / e1, next = x - newton / (1.0 - 0.5 * newton * a->gamma * s1 / (e1 * e1));
        if (next == x) return x;
        if (!(next > low && next < high))
            next = high < CPM_EXACT_INFINITE ? 0.5 * (low + high) : 2.0 * low;
        else if (fabs(next - x) <= 1e-6 * fmin(x, e1 / (a->gamma + 1e-300)))
            return next; /* cubic: 1e-18 is left */
        if (next == x) return x;
        x = next;
    }
    return x;
}

CPM_INLINE void cpm_parabola_at(const double r0[3], const double p0[3], const double g[3], double x, double r[3],
                                double p[3]) {
    for (int k = 0; k < 3; k++) {
        r[k] = r0[k] + x * (p0[k] + 0.5 * x * g[k]);
        p[k] = p0[k] + x * g[k];
    }
}
/* Optical path: int |p|^2 dx. */
CPM_INLINE double cpm_parabola_path(const double p0[3], const double g[3], double x) {
    return x * (cpm_dot(p0, p0) + x * (cpm_dot(p0, g) + x * cpm_dot(g, g) * (1.0 / 3.0)));
}
/* Arc length from p along a parabola (see the head of this file). */
CPM_INLINE double cpm_exact_length(const double p[3], const double g[3], double sigma) {
    cpm_split a = cpm_split_along(p, g);
    return cpm_momentum_integral(&a, sigma);
}

/* What rounding may leave of a distance between points of this size. */
CPM_INLINE double cpm_plane_offset(const double r[3], const double point[3], const double normal[3], double *rounding) {
    double f = 0.0, size = 0.0;
    for (int k = 0; k < 3; k++) {
        f += (r[k] - point[k]) * normal[k];
        size += (fabs(r[k]) + fabs(point[k])) * fabs(normal[k]);
    }
    *rounding = CPM_ON_PLANE * size;
    return f;
}
/* First x in (0, most] on the plane, else -1. A start on the plane is not a crossing. */
CPM_INLINE double cpm_parabola_plane(const double r0[3], const double p0[3], const double g[3], const double point[3],
                                     const double normal[3], double most) {
    double rounding, roots[2], f = cpm_plane_offset(r0, point, normal, &rounding);
    double rise = cpm_dot(p0, normal), bend = 0.5 * cpm_dot(g, normal);
    int count = fabs(f) <= rounding ? cpm_roots_quadratic(rise, bend, 0.0, 0.0, most, roots)
                                    : cpm_roots_quadratic(f, rise, bend, 0.0, most, roots);
    return count ? roots[0] : -1.0;
}
#endif
