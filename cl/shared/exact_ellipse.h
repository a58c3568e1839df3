/* shared/exact_ellipse.h: paths that are ellipses: what fibre, Luneburg lens, fish-eye and Eaton lens share.
 *
 * With a parameter x of each medium's own (sigma, arc length, eccentric anomaly) and a rate w
 *
 *   r(x) = r0 + v S1(x) + a S2(x) + drift x,   S1 = sin(w x)/w,   S2 = (1 - cos w x)/w^2                            (1)
 *
 * v and a being dr/dx - drift and d2r/dx2 at the start; only the fibre drifts, along its axis. By the half angle,
 * S1 = 2 g c, S2 = 2 g^2 with g = sin(w x/2)/w, c = cos(w x/2): nothing cancels, and w = 0 is a parabola.
 *
 * Arc length dl = scale sqrt(q^2 + k^2 sin^2 u) du, u = phase + w x (elliptic.h), where u = 0 is the end of the axis at
 * which the path is slowest; on circles x is arc length itself.
 *
 * Roots of D + f1 S1 + f2 S2 (planes, spheres, a least index): with t = tan(w x/2)/w
 *   (2 f2 + w^2 D) t^2 + 2 f1 t + D = 0.                                                                            (2)
 */
#ifndef CPM_SHARED_EXACT_ELLIPSE_H
#define CPM_SHARED_EXACT_ELLIPSE_H
#include "elliptic.h"
#include "exact_parabola.h"

#define CPM_ELLIPSE_OSCILLATOR 0 /* x = sigma */
#define CPM_ELLIPSE_CIRCLE 1     /* x = arc length */
#define CPM_ELLIPSE_KEPLER 2     /* x = eccentric anomaly from the start */

typedef struct cpm_ellipse {
    int kind, on_sphere; /* CPM_ELLIPSE_; 1: it ends on the medium's sphere */
    double r[3], v[3], a[3], drift[3], rate;
    double q2, k2, phase, scale;
    double end;     /* x of its natural end; CPM_EXACT_INFINITE */
    double size[4]; /* circle: n0 a, a^2 + r0^2, r0 . d, d^2(r^2)/dl^2; Kepler: semi-axis, 1 - e, sqrt(alpha), - */
    double along[3], across[3]; /* Kepler: semi-axes, to the periapsis and across */
} cpm_ellipse;

/* g and c of (1). */
CPM_INLINE double cpm_half_sine(double rate, double x, double *c) {
    double h = 0.5 * rate * x, s;
    if (h < 0.1 && h > -0.1) {
        double z = h * h;
        *c = 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z * (1.0 / 40320.0 - z / 3628800.0))));
        return 0.5 * x * (1.0 - z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z / 362880.0))));
    }
    cpm_half_turns(h, &s, c); /* an odd number of half turns changes the sign of both: of no product */
    return s / rate;
}

/* Position and dr/dx by (1). */
CPM_INLINE void cpm_ellipse_curve(const cpm_ellipse *e, double x, double r[3], double slope[3]) {
    double c, g = cpm_half_sine(e->rate, x, &c), s1 = 2.0 * g * c, s2 = 2.0 * g * g,
              cosine = 1.0 - e->rate * e->rate * s2;
    for (int k = 0; k < 3; k++) {
        r[k] = e->r[k] + (e->v[k] * s1 + e->a[k] * s2 + e->drift[k] * x);
        slope[k] = e->v[k] * cosine + e->a[k] * s1 + e->drift[k];
    }
}

/* x > 0 for t = up/down of (2); negative: none. */
CPM_INLINE double cpm_ellipse_angle(double up, double down, double rate) {
    if (up == 0.0 && down == 0.0) return -1.0;
    if (rate == 0.0) return down != 0.0 ? 2.0 * up / down : -1.0;
    if (up < 0.0) up = -up, down = -down;
    return up == 0.0 ? 2.0 * CPM_PI / rate : 2.0 * cpm_atan2(rate * up, down) / rate;
}
/* The smallest x > 0 at which D + f1 S1 + f2 S2 = 0, by (2); CPM_EXACT_INFINITE: none. `on`: D counts as 0, and the
 * root at 0 does not. */
CPM_INLINE double cpm_ellipse_root(double D, double f1, double f2, double rate, int on) {
    double A = 2.0 * f2 + (on ? 0.0 : rate * rate * D), first, second = -1.0;
    if (on)
        first = cpm_ellipse_angle(-2.0 * f1, A, rate);
    else {
        double discriminant = f1 * f1 - A * D;
        if (!(discriminant >= 0.0)) return CPM_EXACT_INFINITE;
        double q = -(f1 + (f1 < 0.0 ? -cpm_sqrt(discriminant) : cpm_sqrt(discriminant)));
        first = cpm_ellipse_angle(q, A, rate);
        second = cpm_ellipse_angle(D, q, rate);
    }
    if (second > 0.0 && (second < first || !(first > 0.0))) first = second;
    return first > 0.0 ? first : CPM_EXACT_INFINITE;
}

/* A plane's distance along a drifting path: f = D + C x + f1 S1 + f2 S2. */
typedef struct cpm_ripple {
    double D, C, f1, f2, rate;
} cpm_ripple;
CPM_INLINE double cpm_ripple_at(const cpm_ripple *f, double x, double *slope) {
    double c, g = cpm_half_sine(f->rate, x, &c), s1 = 2.0 * g * c, s2 = 2.0 * g * g;
    *slope = f->C + f->f1 * (1.0 - f->rate * f->rate * s2) + f->f2 * s1;
    return f->D + f->C * x + f->f1 * s1 + f->f2 * s2;
}
/* The root in (low, high), between which f is monotone and changes sign. */
CPM_INLINE double cpm_ripple_polish(const cpm_ripple *f, double low, double high, int positive_at_low) {
    double x = 0.5 * (low + high), slope;
    for (int i = 0; i < 200; i++) {
        double value = cpm_ripple_at(f, x, &slope);
        if (value == 0.0) return x;
        if ((value > 0.0) == positive_at_low)
            low = x;
        else
            high = x;
        double next = x - value / slope;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (fabs(next - x) <= 2e-16 * x) return next;
        x = next;
    }
    return x;
}
/* The first root after 0, else infinite. f is a line plus a wave of mean m(x) = D + f2/rate^2 + C x and height H: it
 * vanishes only while |m| <= H, and, come in from outside, within a period of that. */
CPM_INLINE double cpm_ripple_root(const cpm_ripple *f, int on) {
    double w = f->rate, H1 = cpm_sqrt(f->f1 * f->f1 + f->f2 * f->f2 / (w * w)), H = H1 / w, slope;
    double mean = f->D + f->f2 / (w * w), start = 0.0;
    if (fabs(mean) > H) {
        if (mean * f->C >= 0.0) return CPM_EXACT_INFINITE;
        start = (fabs(mean) - H) / fabs(f->C) - 2.0 * CPM_PI / w;
        if (!(w * start < 1e14)) return CPM_EXACT_INFINITE; /* beyond any angle that has digits left */
        if (start < 0.0) start = 0.0;
    }
    double low = start, value = cpm_ripple_at(f, start, &slope);
    if (start == 0.0 && on) value = slope != 0.0 ? slope : f->f2; /* the sign on the way out */
    int positive = value > 0.0;
    double turn = -1.0, middle = 0.0;
    if (fabs(f->C) < H1) { /* f' = C + H1 cos(w x - middle) = 0 at w x = middle +- turn */
        turn = cpm_atan2(cpm_sqrt((H1 - f->C) * (H1 + f->C)), -f->C);
        middle = cpm_atan2(f->f2 / w, f->f1);
    }
    double period = floor((w * start - middle) / (2.0 * CPM_PI)) - 1.0;
    for (int i = 0; i < 16; i++) {
        double high = start + (H + fabs(mean)) / fabs(f->C) + 4.0 * CPM_PI / w; /* monotone: beyond any root */
        if (turn >= 0.0) {
            high = (middle + (i & 1 ? turn : -turn) + 2.0 * CPM_PI * (period + (double)(i >> 1))) / w;
            if (!(high > low)) continue;
        }
        if (!(high < CPM_EXACT_INFINITE)) return CPM_EXACT_INFINITE;
        if ((cpm_ripple_at(f, high, &slope) > 0.0) != positive) return cpm_ripple_polish(f, low, high, positive);
        if (turn < 0.0) return CPM_EXACT_INFINITE;
        low = high;
    }
    return CPM_EXACT_INFINITE;
}

/* x of the first crossing of a plane after the start; infinite: none. */
CPM_INLINE double cpm_ellipse_plane(const cpm_ellipse *e, const double point[3], const double normal[3]) {
    double rounding;
    cpm_ripple f;
    f.D = cpm_plane_offset(e->r, point, normal, &rounding);
    f.C = cpm_dot(e->drift, normal), f.f1 = cpm_dot(e->v, normal), f.f2 = cpm_dot(e->a, normal), f.rate = e->rate;
    int on = fabs(f.D) <= rounding;
    if (fabs(f.C) <= 4e-16 * cpm_sqrt(cpm_dot(e->drift, e->drift)))
        return cpm_ellipse_root(f.D, f.f1, f.f2, f.rate, on);
    return cpm_ripple_root(&f, on);
}

/* Arc length from the start to x, and x of an arc length. */
CPM_INLINE double cpm_ellipse_arc(const cpm_ellipse *e, double x) {
    if (e->kind == CPM_ELLIPSE_CIRCLE) return x;
    return e->scale * cpm_elliptic_arc(e->q2, e->k2, e->phase, e->rate * x);
}
CPM_INLINE double cpm_ellipse_of_arc(const cpm_ellipse *e, double length) {
    if (e->kind == CPM_ELLIPSE_CIRCLE) return length;
    return cpm_elliptic_inverse(e->q2, e->k2, e->phase, length / e->scale) / e->rate;
}
#endif
