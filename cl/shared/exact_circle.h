/* shared/exact_circle.h: Maxwell's fish-eye: circles, straight lines through the centre.
 *
 * n = n0/(1 + r^2/a^2). With unit direction d, b = y . d and y_t the rest of y = r - c across d, the curvature vector
 *   kappa N = (grad n/n)_t = -2 y_t/(a^2 + r^2)                                                                     (1)
 * is that of a circle for good. Along it, with A = a^2 + r0^2 and S1, S2, S3 = int S2 of the arc length l,
 *   a^2 + r^2 = A + 2 b S1 + B S2,  B = 2 (1 + kappa N . y),  sigma = int dl/n = (A l + 2 b S2 + B S3)/(n0 a^2)     (2)
 *   optical path = n0 a atan2(2 a g, A c + 2 b g),  one half turn more a full circle                               (3)
 * (g, c: half angles, exact_ellipse.h), the angle on the sphere whose stereographic projection the fish-eye is. */
#ifndef CPM_SHARED_EXACT_CIRCLE_H
#define CPM_SHARED_EXACT_CIRCLE_H
#include "../types/medium.h"
#include "exact_ellipse.h"

#define CPM_CIRCLE_PIECE 0.009 /* of sqrt(a^2 + r^2): the quintic is off by at most 2e-13 of that, mostly 1e-14 */

CPM_INLINE void cpm_circle_start(const double center[3], double radius, double n0, const double r[3], const double p[3],
                                 cpm_ellipse *e) {
    double y[3], d[3], size = cpm_sqrt(cpm_dot(p, p));
    for (int k = 0; k < 3; k++) y[k] = r[k] - center[k], d[k] = p[k] / size;
    double b = cpm_dot(y, d), rest2 = 0.0, A = radius * radius + cpm_dot(y, y);
    e->kind = CPM_ELLIPSE_CIRCLE;
    e->on_sphere = 0;
    e->end = CPM_EXACT_INFINITE;
    for (int k = 0; k < 3; k++) {
        double rest = y[k] - b * d[k];
        rest2 += rest * rest;
        e->r[k] = r[k], e->v[k] = d[k], e->drift[k] = 0.0;
        e->a[k] = -2.0 * rest / A;
    }
    e->rate = cpm_sqrt(cpm_dot(e->a, e->a));
    e->q2 = 1.0, e->k2 = e->phase = 0.0, e->scale = 1.0;
    e->size[0] = n0 * radius, e->size[1] = A, e->size[2] = b, e->size[3] = 2.0 * (1.0 - 2.0 * rest2 / A);
}

/* l at which n falls to `least`. */
CPM_INLINE double cpm_circle_cutoff(const cpm_ellipse *e, double radius, double least) {
    return cpm_ellipse_root(e->size[1] - e->size[0] * radius / least, 2.0 * e->size[2], e->size[3], e->rate, 0);
}

CPM_INLINE double cpm_circle_path(const cpm_ellipse *e, double radius, double l) {
    double turns = floor(0.5 * e->rate * l / CPM_PI), c, g, rest = l;
    if (turns > 0.0) rest = fmax(l - turns * (2.0 * CPM_PI / e->rate), 0.0);
    g = cpm_half_sine(e->rate, rest, &c); /* of an angle in [0, pi], but for the sign of both */
    if (g < 0.0)
        g = -g, c = -c;
    else if (e->rate * rest > 4.0) /* pi but for rounding */
        g = 0.0, c = -1.0;
    return e->size[0] * (turns * CPM_PI + cpm_atan2(2.0 * radius * g, e->size[1] * c + 2.0 * e->size[2] * g));
}

CPM_INLINE double cpm_circle_sigma(const cpm_ellipse *e, double radius, double l) {
    double c, g = cpm_half_sine(e->rate, l, &c), z = e->rate * l, s3;
    z *= z;
    if (z < 0.25)
        s3 = l * l * l / 6.0 *
             (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0 * (1.0 - z / 156.0)))));
    else
        s3 = (l - 2.0 * g * c) / (e->rate * e->rate);
    return (e->size[1] * l + 2.0 * e->size[2] * (2.0 * g * g) + e->size[3] * s3) / (e->size[0] * radius);
}

CPM_INLINE double cpm_circle_piece(const cpm_ellipse *e) { return CPM_CIRCLE_PIECE * cpm_sqrt(e->size[1]); }
#endif
