/* shared/exact_oscillator.h: the fibre and the Luneburg lens: n^2 falls with the square of a distance.
 *
 * n^2 = M - w^2 |y|^2, y = r - c, or its part across the axis; so y'' = -w^2 y in sigma, and along the axis p is
 * constant: an ellipse about c, sinusoids along the fibre.
 *
 * With K = |p_y|^2, E = w^2 y^2 at the start (K + E stays), semi-axes A >= B of the ellipse
 *   w^2 A^2 = (K + E)/2 + sqrt((K - E)^2/4 + w^2 (y . p)^2),   A B w = |y x p|                                      (1)
 *   n^2 = p_axis^2 + w^2 B^2 + w^2 (A^2 - B^2) sin^2 u,  u = 0 at the far end of the long axis                     (2)
 * which gives the arc length (exact_ellipse.h) and the optical path int n^2 dsigma. */
#ifndef CPM_SHARED_EXACT_OSCILLATOR_H
#define CPM_SHARED_EXACT_OSCILLATOR_H
#include "../types/medium.h"
#include "exact_ellipse.h"

#define CPM_OSCILLATOR_PIECE 0.04 /* radians of a piece: the quintic is off by x^6/46080 = 9e-14 of the amplitude */

/* |a x b|^2 */
CPM_INLINE double cpm_cross_square(const double a[3], const double b[3]) {
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    return x * x + y * y + z * z;
}

/* The path from (r, p); w2 > 0. A null axis: none (the lens). */
CPM_INLINE void cpm_oscillator_start(const double center[3], const double axis[3], double w2, const double r[3],
                                     const double p[3], cpm_ellipse *e) {
    double y[3], py[3], along = 0.0, along_p = 0.0, largest = 0.0;
    e->kind = CPM_ELLIPSE_OSCILLATOR;
    e->on_sphere = 0;
    e->end = CPM_EXACT_INFINITE;
    e->rate = cpm_sqrt(w2);
    for (int k = 0; k < 3; k++) y[k] = r[k] - center[k], py[k] = p[k], e->r[k] = r[k];
    if (axis) along = cpm_dot(y, axis), along_p = cpm_dot(p, axis);
    for (int k = 0; k < 3; k++) {
        e->drift[k] = axis ? along_p * axis[k] : 0.0;
        if (axis) y[k] -= along * axis[k], py[k] -= e->drift[k];
        e->v[k] = py[k];
        e->a[k] = -w2 * y[k];
        y[k] *= e->rate; /* now of the size of p */
        largest = fmax(largest, fmax(fabs(y[k]), fabs(py[k])));
    }
    double K = cpm_dot(py, py), E = cpm_dot(y, y), cross = cpm_dot(y, py);
    double wave = cpm_sqrt(0.25 * (K - E) * (K - E) + cross * cross), long2 = 0.5 * (K + E) + wave;
    e->q2 = along_p * along_p + (long2 > 0.0 ? cpm_cross_square(y, py) / long2 : 0.0);
    e->k2 = 2.0 * wave;
    e->phase = -0.5 * cpm_atan2(2.0 * cross, E - K);
    e->scale = 1.0 / e->rate;
}

/* x at which |y|^2 = radius^2 first (the lens); `on`: the start is there. */
CPM_INLINE double cpm_oscillator_reaches(const cpm_ellipse *e, const double center[3], double radius, int on) {
    double y[3];
    for (int k = 0; k < 3; k++) y[k] = e->r[k] - center[k];
    double d = cpm_sqrt(cpm_dot(y, y));
    return cpm_ellipse_root((d - radius) * (d + radius), 2.0 * cpm_dot(y, e->v),
                            2.0 * (cpm_dot(e->v, e->v) + cpm_dot(y, e->a)), 2.0 * e->rate, on);
}

/* x at which n falls to `least`; infinite: never. */
CPM_INLINE double cpm_oscillator_cutoff(const cpm_ellipse *e, double least) {
    double room = least * least - e->q2;
    if (!(room > 0.0)) return CPM_EXACT_INFINITE;
    if (!(room < e->k2)) return 0.0;
    double s = cpm_sqrt(room / e->k2), near = cpm_atan2(s, cpm_sqrt(1.0 - s * s));
    double u = e->phase - CPM_PI * floor(e->phase / CPM_PI); /* in [0, pi]: n is least at both ends */
    double ahead = CPM_PI - near - u;
    if (u < near) ahead = 0.0;
    return ahead > 0.0 ? ahead / e->rate : 0.0;
}

/* int n^2 dsigma by (2). */
CPM_INLINE double cpm_oscillator_path(const cpm_ellipse *e, double x) {
    double c, g = cpm_half_sine(e->rate, x, &c), s, ignored;
    cpm_half_turns(e->phase + 0.5 * e->rate * x, &s, &ignored);
    return e->q2 * x + 0.5 * e->k2 * (x - (1.0 - 2.0 * s * s) * 2.0 * g * c);
}

/* x of a piece: shorter where |p| passes near 0, so that the arc length is a quintic too. Its slope, the square root of
 * q^2 + k^2 sin^2 u, has branch points at the distance d = sqrt(sin^2 u + q^2/k^2): off by (x/d)^6/3000. */
CPM_INLINE double cpm_oscillator_piece(const cpm_ellipse *e) {
    double s, c, narrow = 1.0;
    cpm_half_turns(e->phase, &s, &c);
    if (e->k2 > 0.0) narrow = fmin(1.0, 0.45 * cpm_sqrt(fmax(s * s + e->q2 / e->k2, 1e-12)));
    return CPM_OSCILLATOR_PIECE * narrow / e->rate;
}
#endif
