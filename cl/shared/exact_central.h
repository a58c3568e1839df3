/* shared/exact_central.h: the elliptic paths of fibre, Luneburg lens, fish-eye and Eaton lens behind one set of calls.
 */
#ifndef CPM_SHARED_EXACT_CENTRAL_H
#define CPM_SHARED_EXACT_CENTRAL_H
#include "exact_circle.h"
#include "exact_kepler.h"
#include "exact_oscillator.h"

CPM_INLINE int cpm_is_central(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_PARABOLIC) || CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) ||
           CPM_IS_KIND(m, CPM_MEDIUM_FISHEYE) || CPM_IS_KIND(m, CPM_MEDIUM_EATON);
}
/* Lenses that are 1 outside their sphere. */
CPM_INLINE int cpm_is_ball(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON);
}

/* n at r of the media above: the same bits as cpm_field. */
CPM_INLINE double cpm_central_index(const cpm_medium_data *m, double scale, const double r[3]) {
    double y[3], u[3], along = 0.0, per = 1.0 / m->high;
    for (int k = 0; k < 3; k++) y[k] = r[k] - m->origin[k], u[k] = y[k] * per;
    if (m->kind == CPM_MEDIUM_PARABOLIC) {
        along = cpm_dot(y, m->axis);
        for (int k = 0; k < 3; k++) y[k] -= along * m->axis[k];
        return cpm_sqrt(1.0 + (scale * m->value - scale * m->high * cpm_dot(y, y)));
    }
    double uu = cpm_dot(u, u);
    if (m->kind == CPM_MEDIUM_FISHEYE) return (1.0 + scale * m->value) * (1.0 / (1.0 + uu));
    if (m->kind == CPM_MEDIUM_LUNEBURG) return cpm_sqrt(1.0 + scale * (uu < 1.0 ? 1.0 - uu : 0.0));
    uu = uu > 1e-60 ? uu : 1e-60;
    return cpm_sqrt(1.0 + 2.0 * scale * (uu < 1.0 ? 1.0 / cpm_sqrt(uu) - 1.0 : 0.0));
}

/* Is (r, p) inside the lens's sphere, or about to be? *on: r is on it, to rounding. */
CPM_INLINE int cpm_ball_holds(const cpm_medium_data *m, const double r[3], const double p[3], int *on) {
    double y[3], size = 0.0;
    for (int k = 0; k < 3; k++) {
        y[k] = r[k] - m->origin[k];
        size += fabs(r[k]) + fabs(m->origin[k]);
    }
    double off = cpm_sqrt(cpm_dot(y, y)) - m->high;
    *on = fabs(off) <= 1e-15 * (size + m->high);
    return *on ? cpm_dot(y, p) < 0.0 : off < 0.0;
}

/* Sigma at which a straight ray outside meets the sphere; infinite: it does not. */
CPM_INLINE double cpm_ball_entry(const cpm_medium_data *m, const double r[3], const double p[3], int on) {
    double y[3], rest[3], pp = cpm_dot(p, p);
    if (on) return CPM_EXACT_INFINITE; /* on its way out */
    for (int k = 0; k < 3; k++) y[k] = r[k] - m->origin[k];
    double along = cpm_dot(y, p);
    for (int k = 0; k < 3; k++) rest[k] = y[k] - along / pp * p[k];
    double chord2 = m->high * m->high - cpm_dot(rest, rest);
    return along < 0.0 && chord2 > 0.0 ? (-along - cpm_sqrt(chord2 * pp)) / pp : CPM_EXACT_INFINITE;
}

/* The path from (r, p) inside; |p| becomes n(r) where the path depends on it. */
CPM_INLINE void cpm_central_start(const cpm_medium_data *m, double scale, const double r[3], double p[3], int on,
                                  cpm_ellipse *e) {
    if (m->kind == CPM_MEDIUM_FISHEYE || m->kind == CPM_MEDIUM_EATON) {
        double n = cpm_central_index(m, scale, r), factor = n / cpm_sqrt(cpm_dot(p, p));
        for (int k = 0; k < 3; k++) p[k] *= factor;
    }
    if (m->kind == CPM_MEDIUM_PARABOLIC)
        cpm_oscillator_start(m->origin, m->axis, scale * m->high, r, p, e);
    else if (m->kind == CPM_MEDIUM_LUNEBURG) {
        cpm_oscillator_start(m->origin, (const double *)0, scale / m->high / m->high, r, p, e);
        e->end = cpm_oscillator_reaches(e, m->origin, m->high, on);
        e->on_sphere = 1;
    } else if (m->kind == CPM_MEDIUM_FISHEYE)
        cpm_circle_start(m->origin, m->high, 1.0 + scale * m->value, r, p, e);
    else
        cpm_kepler_start(m->origin, m->high, scale, r, p, on, e);
}

/* Position and momentum at x; optical path up to there; sigma up to there. */
CPM_INLINE void cpm_central_at(const cpm_medium_data *m, double scale, const cpm_ellipse *e, double x, double r[3],
                               double p[3]) {
    double factor = 1.0;
    if (e->kind == CPM_ELLIPSE_KEPLER) {
        cpm_kepler_at(e, x, r, p);
        for (int k = 0; k < 3; k++) r[k] += m->origin[k];
    } else {
        cpm_ellipse_curve(e, x, r, p);
        if (e->kind == CPM_ELLIPSE_CIRCLE) factor = cpm_central_index(m, scale, r) / cpm_sqrt(cpm_dot(p, p));
    }
    for (int k = 0; k < 3; k++) p[k] *= factor;
}
CPM_INLINE double cpm_central_path(const cpm_medium_data *m, const cpm_ellipse *e, double x) {
    if (e->kind == CPM_ELLIPSE_OSCILLATOR) return cpm_oscillator_path(e, x);
    return e->kind == CPM_ELLIPSE_CIRCLE ? cpm_circle_path(e, m->high, x) : cpm_kepler_path(e, x);
}
CPM_INLINE double cpm_central_sigma(const cpm_medium_data *m, const cpm_ellipse *e, double x) {
    if (e->kind == CPM_ELLIPSE_OSCILLATOR) return x;
    return e->kind == CPM_ELLIPSE_CIRCLE ? cpm_circle_sigma(e, m->high, x) : cpm_kepler_sigma(e, x);
}
/* x at which n falls to `least`; infinite: never (nowhere in Eaton's lens is n below 1). */
CPM_INLINE double cpm_central_cutoff(const cpm_medium_data *m, const cpm_ellipse *e, double least) {
    if (e->kind == CPM_ELLIPSE_OSCILLATOR) return cpm_oscillator_cutoff(e, least);
    return e->kind == CPM_ELLIPSE_CIRCLE ? cpm_circle_cutoff(e, m->high, least) : CPM_EXACT_INFINITE;
}
/* x over which a quintic stands for the path. */
CPM_INLINE double cpm_central_piece(const cpm_ellipse *e) {
    if (e->kind == CPM_ELLIPSE_OSCILLATOR) return cpm_oscillator_piece(e);
    return e->kind == CPM_ELLIPSE_CIRCLE ? cpm_circle_piece(e) : cpm_kepler_piece(e);
}
/* Half grad n^2 at r, for the ends of pieces. */
CPM_INLINE void cpm_central_pull(const cpm_medium_data *m, double scale, const double r[3], double g[3]) {
    double y[3], along = 0.0, rr, n;
    for (int k = 0; k < 3; k++) y[k] = r[k] - m->origin[k];
    if (m->kind == CPM_MEDIUM_PARABOLIC) along = cpm_dot(y, m->axis);
    rr = cpm_dot(y, y);
    double R = m->high, factor = -scale * R;
    if (m->kind == CPM_MEDIUM_LUNEBURG) factor = -scale / R / R;
    if (m->kind == CPM_MEDIUM_FISHEYE) n = cpm_central_index(m, scale, r), factor = -2.0 * n * n / (R * R + rr);
    if (m->kind == CPM_MEDIUM_EATON) factor = -scale * R / fmax(rr * cpm_sqrt(rr), 1e-290);
    for (int k = 0; k < 3; k++) g[k] = factor * (m->kind == CPM_MEDIUM_PARABOLIC ? y[k] - along * m->axis[k] : y[k]);
}
/* The end of a piece of a path inside that does not go beyond x, sigma; returns its x. `least`: |p| to end at. */
CPM_INLINE double cpm_central_reach(const cpm_medium_data *m, const cpm_ellipse *e, double sigma, double least) {
    double x = cpm_central_piece(e), cutoff = least > 0.0 ? cpm_central_cutoff(m, e, least) : CPM_EXACT_INFINITE;
    double whole = cpm_central_sigma(m, e, x);
    if (whole > sigma) x *= sigma / whole;
    x = fmin(x, e->end);
    return cutoff > 0.0 ? fmin(x, cutoff) : x;
}
/* Onto the sphere, to rounding. */
CPM_INLINE void cpm_ball_snap(const cpm_medium_data *m, double r[3]) {
    double y[3];
    for (int k = 0; k < 3; k++) y[k] = r[k] - m->origin[k];
    double factor = m->high / cpm_sqrt(cpm_dot(y, y));
    for (int k = 0; k < 3; k++) r[k] = m->origin[k] + factor * y[k];
}
#endif
