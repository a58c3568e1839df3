/* shared/piece.h: what can be asked of a piece of a curved ray (cl/types/ray.h), in scalar double on both sides.
 *
 * A function with value f, slope f' and second derivative f'' at both ends of [0, h] is, with theta = sigma/h,
 *
 *   f(theta) = f0 + f0' h theta + f0'' h^2/2 theta^2 + theta^3 (c3 + c4 theta + c5 theta^2)                        (1)
 *   D = f1 - f0 - f0' h - f0'' h^2/2,  V = (f1' - f0' - f0'' h) h,  A = (f1'' - f0'') h^2
 *   c3 = 10 D - 4 V + A/2,  c4 = -15 D + 7 V - A,  c5 = 6 D - 3 V + A/2                                            (2)
 *
 * Position: f' = p, f'' = g. Arc length: l' = n, l'' = dn/dsigma = g . p/n. The error is f^(6) h^6 theta^3 (1 -
 * theta)^3 /720: near an end (within 5 % on either side, so also just beyond it) 1/100 of its middle's. */
#ifndef CPM_SHARED_PIECE_H
#define CPM_SHARED_PIECE_H
#include "../dialect.h"
#include "../types/ray.h"
#include "roots.h"

#define CPM_ON_PLANE 1e-15 /* of the coordinates' size: what rounding leaves */
#define CPM_NO_ROOT 2.0    /* theta returned where there is none */

/* Coefficients c[0..5] of f(theta), equations (1) and (2). */
CPM_INLINE void cpm_quintic(double h, double f0, double d0, double s0, double f1, double d1, double s1, double c[6]) {
    double first = d0 * h, second = 0.5 * s0 * h * h;
    double rise = ((f1 - f0) - first) - second, turn = (d1 - d0 - s0 * h) * h, bend = (s1 - s0) * h * h;
    c[0] = f0;
    c[1] = first;
    c[2] = second;
    c[3] = 10.0 * rise - 4.0 * turn + 0.5 * bend;
    c[4] = -15.0 * rise + 7.0 * turn - bend;
    c[5] = 6.0 * rise - 3.0 * turn + 0.5 * bend;
}
CPM_INLINE double cpm_quintic_at(const double c[6], double t) {
    return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
}
CPM_INLINE double cpm_quintic_slope(const double c[6], double t) { /* df/dtheta */
    return c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])));
}

CPM_INLINE void cpm_piece_axis(const cpm_piece *piece, int k, double c[6]) {
    cpm_quintic(piece->h, piece->r0[k], piece->p0[k], piece->g0[k], piece->r1[k], piece->p1[k], piece->g1[k], c);
}
/* Position, metres, at theta in [0, 1] (a little beyond is fine). */
CPM_INLINE void cpm_piece_position(const cpm_piece *piece, double theta, double r[3]) {
    for (int k = 0; k < 3; k++) {
        double c[6];
        cpm_piece_axis(piece, k, c);
        r[k] = cpm_quintic_at(c, theta);
    }
}
/* Momentum p = dr/dsigma; |p| = n up to the integrator's drift. */
CPM_INLINE void cpm_piece_momentum(const cpm_piece *piece, double theta, double p[3]) {
    double per_sigma = piece->h != 0.0 ? 1.0 / piece->h : 0.0;
    for (int k = 0; k < 3; k++) {
        double c[6];
        cpm_piece_axis(piece, k, c);
        p[k] = piece->h != 0.0 ? cpm_quintic_slope(c, theta) * per_sigma : piece->p0[k];
    }
}

CPM_INLINE double cpm_dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Arc length (metres from the ray's start) as a quintic in theta. */
CPM_INLINE void cpm_piece_length_quintic(const cpm_piece *piece, double c[6]) {
    double s0 = piece->n0 > 0.0 ? cpm_dot(piece->g0, piece->p0) / piece->n0 : 0.0;
    double s1 = piece->n1 > 0.0 ? cpm_dot(piece->g1, piece->p1) / piece->n1 : 0.0;
    cpm_quintic(piece->h, 0.0, piece->n0, s0, piece->length1 - piece->length0, piece->n1, s1, c);
}
CPM_INLINE double cpm_piece_length(const cpm_piece *piece, double theta) {
    double c[6];
    cpm_piece_length_quintic(piece, c);
    return piece->length0 + cpm_quintic_at(c, theta);
}
/* theta of an arc length in [length0, length1] or a little beyond: Newton kept inside a bracket. */
CPM_INLINE double cpm_piece_theta(const cpm_piece *piece, double length) {
    double c[6], whole = piece->length1 - piece->length0, wanted = length - piece->length0;
    cpm_piece_length_quintic(piece, c);
    if (!(whole > 0.0)) return 0.0;
    double low = wanted < 0.0 ? -0.25 : 0.0, high = wanted > whole ? 1.25 : 1.0, t = wanted / whole;
    for (int i = 0; i < 60; i++) {
        double miss = cpm_quintic_at(c, t) - wanted, slope = cpm_quintic_slope(c, t);
        if (miss > 0.0)
            high = t;
        else
            low = t;
        double next = slope > 0.0 ? t - miss / slope : 0.5 * (low + high);
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        double moved = next - t;
        t = next;
        if (moved < 4e-16 && moved > -4e-16) break;
    }
    return t;
}

/* theta of the first crossing of a plane (any normal) after the piece's start, up to `last`; CPM_NO_ROOT: none. A start
 * on the plane (to rounding) is not a crossing. */
CPM_INLINE double cpm_piece_plane(const cpm_piece *piece, const double point[3], const double normal[3], double last) {
    double f0 = 0.0, f1 = 0.0, size = 0.0, c[6];
    for (int k = 0; k < 3; k++) {
        f0 += (piece->r0[k] - point[k]) * normal[k];
        f1 += (piece->r1[k] - point[k]) * normal[k];
        size += (fabs(piece->r0[k]) + fabs(point[k])) * fabs(normal[k]);
    }
    cpm_quintic(piece->h, f0, cpm_dot(piece->p0, normal), cpm_dot(piece->g0, normal), f1, cpm_dot(piece->p1, normal),
                cpm_dot(piece->g1, normal), c);
    double roots[5];
    int leaving = c[0] <= CPM_ON_PLANE * size && c[0] >= -CPM_ON_PLANE * size; /* divide the root at 0 out */
    int count = leaving ? cpm_roots(c + 1, 4, 0.0, last, roots) : cpm_roots(c, 5, 0.0, last, roots);
    return count ? roots[0] : CPM_NO_ROOT;
}
#endif
