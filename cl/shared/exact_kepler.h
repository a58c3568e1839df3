/* shared/exact_kepler.h: the Eaton lens: Kepler's ellipse about the centre.
 *
 * n^2 = 2 mu/r - alpha, mu = s R, alpha = 2 s - 1 (s: the dispersion's scale, 1 at the d line), so y'' = -mu y/r^3 in
 * sigma: a planet's orbit whose time is sigma. Semi-axis a = mu/alpha, eccentricity e, eccentric anomaly E = 0 at the
 * periapsis, q^2 = 1 - e^2 = |y x p|^2/(mu a):
 *
 *   y = P (cos E - e) + Q sin E,  r = a (1 - e cos E),  p = sqrt(alpha)/r (-P sin E + Q cos E) (1) e cos E0 = 1 - r0/a,
 * e sin E0 = y . p sqrt(alpha)/mu, P/a = y cos E0/r0 - p sin E0/sqrt(alpha),  Q/a = y sin E0/r0 + p (cos E0 -
 * e)/sqrt(alpha)                        (2) dl = a sqrt(q^2 + e^2 sin^2 E) dE,  dsigma = a (1 - e cos E)
 * dE/sqrt(alpha),  n^2 dsigma = 2 mu dE/sqrt(alpha) - alpha dsigma (3)
 *
 * A ray straight at the centre (e = 1) turns back there: that is where its neighbours go, every one of which leaves
 * antiparallel, and (1) to (3) have no gap at E = 0. */
#ifndef CPM_SHARED_EXACT_KEPLER_H
#define CPM_SHARED_EXACT_KEPLER_H
#include "../types/medium.h"
#include "exact_oscillator.h"

#define CPM_KEPLER_PIECE 0.014 /* of r: the quintic is off by at most 1e-13 of it */
#define CPM_KEPLER_POINT 2e-13 /* of a: closer to the centre a piece leaps over the periapsis */

CPM_INLINE double cpm_kepler_radius(const cpm_ellipse *e, double E) { /* in semi-axes, by (1) without cancellation */
    double s, c;
    cpm_half_turns(0.5 * E, &s, &c);
    return e->size[1] + 2.0 * (1.0 - e->size[1]) * s * s;
}

/* The path from (r, p) inside; `on`: r is on the sphere. */
CPM_INLINE void cpm_kepler_start(const double center[3], double radius, double scale, const double r[3],
                                 const double p[3], int on, cpm_ellipse *e) {
    double mu = scale * radius, alpha = 2.0 * scale - 1.0, root_alpha = cpm_sqrt(alpha), a = mu / alpha, y[3];
    for (int k = 0; k < 3; k++) y[k] = r[k] - center[k], e->r[k] = r[k], e->drift[k] = 0.0;
    double r0 = cpm_sqrt(cpm_dot(y, y)), speed = cpm_sqrt(cpm_dot(p, p));
    double x = 1.0 - r0 / a, z = cpm_dot(y, p) * root_alpha / mu, E0 = cpm_atan2(z, x);
    e->kind = CPM_ELLIPSE_KEPLER;
    e->on_sphere = 1;
    e->rate = 1.0;
    e->q2 = fmin(cpm_cross_square(y, p) / (mu * a), 1.0);
    double e2 = 1.0 - e->q2, s, c;
    if (e->q2 > 0.5) e2 = fmin(x * x + z * z, 1.0), e->q2 = 1.0 - e2; /* whichever of the two is not a difference */
    double eccentricity = cpm_sqrt(e2);
    cpm_sine_cosine(E0, &s, &c);
    for (int k = 0; k < 3; k++) {
        e->along[k] = r0 > 0.0 ? a * (y[k] * c / r0 - p[k] * s / root_alpha) : -a * p[k] / speed;
        e->across[k] = r0 > 0.0 ? a * (y[k] * s / r0 + p[k] * (c - eccentricity) / root_alpha) : 0.0;
        e->v[k] = -e->along[k] * s + e->across[k] * c;
        e->a[k] = -e->along[k] * c - e->across[k] * s;
    }
    e->k2 = e2, e->phase = E0, e->scale = a;
    e->size[0] = a, e->size[1] = e->q2 / (1.0 + eccentricity), e->size[2] = root_alpha, e->size[3] = 0.0;
    e->end = cpm_ellipse_root(r0 - radius, a * z, a * x, 1.0, on); /* r = R */
}

/* (1): position from the centre and momentum. */
CPM_INLINE void cpm_kepler_at(const cpm_ellipse *e, double x, double y[3], double p[3]) {
    double E = e->phase + x, s, c, sine, ignored, radius = cpm_kepler_radius(e, E);
    if (!(radius > 1e-30)) E = 1e-14, radius = fmax(cpm_kepler_radius(e, E), 1e-30); /* the centre itself: p infinite */
    cpm_sine_cosine(E, &s, &c);
    cpm_half_turns(0.5 * E, &sine, &ignored);
    double near = e->size[1] - 2.0 * sine * sine; /* cos E - e */
    double rate = e->size[2] / (e->size[0] * radius);
    for (int k = 0; k < 3; k++) {
        y[k] = e->along[k] * near + e->across[k] * s;
        p[k] = rate * (e->across[k] * c - e->along[k] * s);
    }
}

/* Sigma from the start to x, by (3): (a/sqrt(alpha)) (x - 2 e cos Em sin(x/2)), Em in the middle. */
CPM_INLINE double cpm_kepler_sigma(const cpm_ellipse *e, double x) {
    double h = 0.5 * x, z = h * h, s, c, rest; /* rest = x - 2 sin(x/2) */
    cpm_sine_cosine(h, &s, &c);
    rest = 2.0 * (h - s);
    if (z < 0.25)
        rest = h * z / 3.0 *
               (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0 * (1.0 - z / 156.0)))));
    return e->size[0] / e->size[2] * (2.0 * s * cpm_kepler_radius(e, e->phase + h) + rest);
}
CPM_INLINE double cpm_kepler_path(const cpm_ellipse *e, double x) {
    double alpha = e->size[2] * e->size[2];
    return 2.0 * e->size[0] * e->size[2] * x - alpha * cpm_kepler_sigma(e, x);
}

CPM_INLINE double cpm_kepler_piece(const cpm_ellipse *e) {
    double E = e->phase, r = cpm_kepler_radius(e, E), s, c;
    if (r < CPM_KEPLER_POINT && E < 0.0) return -2.0 * E; /* mirrored: the whole of it lies within that of the centre */
    cpm_half_turns(E, &s, &c);
    return CPM_KEPLER_PIECE * r / cpm_sqrt(fmax(e->q2 + e->k2 * s * s, 1e-30));
}
#endif
