/* shared/exact_shells.h: exact paths through spherical layers whose n^2 is linear in rho^2, or n constant.
 *
 * With D = r - centre the force is linear: D'' = c D, n^2 = P + c (rho^2 - rho0^2), P = |p0|^2. For phase w x, w = sqrt|c|,
 * x = sigma, C = cos or cosh, S = sin/w or sinh/w (C^2 = 1 + c S^2):
 *
 *   r = r0 + (C - 1) D0 + S p0,   p = p0 + (C - 1) p0 + c S D0,   C - 1 = 2 c S(x/2)^2                             (1)
 *   rho^2 - rho0^2 = (P + c rho0^2) S^2 + 2 E C S,   E = p0 . D0                                                   (2)
 *
 * and with T = S/C = tan(w x)/w (tanh): S^2 = T^2/(1 - c T^2), C S = T/(1 - c T^2), so that a sphere is met where
 *
 *   (P + c rho_f^2) T^2 + 2 E T - (rho_f^2 - rho0^2) = 0                                                           (3)
 *
 * and, with t = tan(w x/2)/w, f the offset of r0 from it, a = D0 . normal, b = p0 . normal, a plane where
 *
 *   c (2 a - f) t^2 + 2 b t + f = 0.                                                                               (4)
 *
 * Differences of rho^2 come from heights, (h_f - h0)(2 R + h_f + h0): nothing cancels. c = 0: straight. Optical path
 * int |p|^2 dx = P x + (c rho0^2 + P)(C S - x)/2 + c E S^2; arc length int |p| dx is elliptic: Gauss-Legendre, panels halved
 * until both halves agree. */
#ifndef CPM_SHARED_EXACT_SHELLS_H
#define CPM_SHARED_EXACT_SHELLS_H
#include "elementary_more.h"
#include "exact_layers.h"

#define CPM_HARMONIC_PIECE 0.02 /* phase of a piece: the quintic's error is 2.2e-5 x 0.02^6 = 1.4e-15 of rho */
#define CPM_PI 3.14159265358979324

typedef struct cpm_harmonic {
    double c, w;            /* D'' = c D; w = sqrt |c| */
    double out[3], rho2;    /* D0 and its square */
    double square, e;       /* P = |p0|^2, E = p0 . D0 */
} cpm_harmonic;

/* Place of a point: height, D, and how far rounding may have moved the height. */
CPM_INLINE double cpm_shell_height(const cpm_medium_data *m, const double r[3], double out[3], double *rounding) {
    double d[3], v = 0.0, x2 = 0.0, size = 0.0;
    for (int k = 0; k < 3; k++) {
        d[k] = r[k] - m->origin[k];
        v += d[k] * m->axis[k];
        size += fabs(r[k]) + fabs(m->origin[k]);
    }
    for (int k = 0; k < 3; k++) {
        double across = d[k] - v * m->axis[k];
        x2 += across * across;
        out[k] = across + (m->radius + v) * m->axis[k];
    }
    double rho = cpm_sqrt((m->radius + v) * (m->radius + v) + x2);
    *rounding = 2e-15 * size;
    return (v * (2.0 * m->radius + v) + x2) / (m->radius + rho);
}
/* rho_b^2 - rho_a^2 of two heights. */
CPM_INLINE double cpm_shell_rise(const cpm_medium_data *m, double a, double b) {
    return (b - a) * (2.0 * m->radius + a + b);
}
CPM_INLINE double cpm_shell_pull(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale, int layer) {
    return m->interpolation == CPM_FIELD_STEP ? 0.0 : scale * cpm_layer_record(m, table, layer, 1);
}

CPM_INLINE cpm_harmonic cpm_harmonic_from(double c, const double out[3], const double p[3]) {
    cpm_harmonic h;
    h.c = c;
    h.w = cpm_sqrt(fabs(c));
    for (int k = 0; k < 3; k++) h.out[k] = out[k];
    h.rho2 = cpm_dot(out, out);
    h.square = cpm_dot(p, p);
    h.e = cpm_dot(p, out);
    return h;
}

/* S, and C - 1, of equation (1). */
CPM_INLINE double cpm_harmonic_sine(const cpm_harmonic *h, double x) {
    double z = h->c * x * x;
    if (z < 0.05 && z > -0.05) {
        double p = z * (1.0 / 39916800.0) + 1.0 / 362880.0;
        p = p * z + 1.0 / 5040.0;
        p = p * z + 1.0 / 120.0;
        p = p * z + 1.0 / 6.0;
        return x + x * (z * p);
    }
    if (h->c > 0.0) return cpm_sinh(h->w * x) / h->w;
    double turns = h->w * x * (0.5 / CPM_PI);
    return cpm_sin((turns - floor(turns)) * (2.0 * CPM_PI)) / h->w;
}
CPM_INLINE double cpm_harmonic_lag(const cpm_harmonic *h, double x) {
    double sine = cpm_harmonic_sine(h, 0.5 * x);
    return 2.0 * h->c * sine * sine;
}
CPM_INLINE void cpm_harmonic_at(const cpm_harmonic *h, const double r0[3], const double p0[3], double x, double r[3],
                                double p[3]) {
    double lag = cpm_harmonic_lag(h, x), sine = cpm_harmonic_sine(h, x);
    for (int k = 0; k < 3; k++) {
        r[k] = r0[k] + (lag * h->out[k] + sine * p0[k]);
        p[k] = p0[k] + (lag * p0[k] + h->c * sine * h->out[k]);
    }
}
/* |p| after x, by (2). */
CPM_INLINE double cpm_harmonic_index(const cpm_harmonic *h, double x) {
    double lag = cpm_harmonic_lag(h, x), sine = cpm_harmonic_sine(h, x);
    double rise = sine * ((h->square + h->c * h->rho2) * sine + 2.0 * h->e * (1.0 + lag));
    double square = h->square + h->c * rise;
    return square > 0.0 ? cpm_sqrt(square) : 0.0;
}
CPM_INLINE double cpm_harmonic_path(const cpm_harmonic *h, double x) {
    double lag = cpm_harmonic_lag(h, x), sine = cpm_harmonic_sine(h, x);
    return h->square * x + 0.5 * (h->square + h->c * h->rho2) * (sine + lag * sine - x) + h->c * h->e * sine * sine;
}

/* int |p| dx over [a, b]: Gauss-Legendre of 8 points. */
CPM_INLINE double cpm_harmonic_panel(const cpm_harmonic *h, double a, double b) {
    const double node[4] = {0.1834346424956498049, 0.5255324099163289858, 0.7966664774136267396, 0.9602898564975362317};
    const double weight[4] = {0.3626837833783619830, 0.3137066458778872873, 0.2223810344533744705,
                              0.1012285362903762592};
    double middle = 0.5 * (a + b), reach = 0.5 * (b - a), sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += weight[i] *
               (cpm_harmonic_index(h, middle - reach * node[i]) + cpm_harmonic_index(h, middle + reach * node[i]));
    return reach * sum;
}
CPM_INLINE double cpm_harmonic_between(const cpm_harmonic *h, double a, double b) {
    if (h->c == 0.0) return cpm_sqrt(h->square) * (b - a);
    double sum = 0.0, widest = 0.25 / h->w, width = widest, least = 1e-7 * fmin(b - a, widest), at = a;
    for (int i = 0; i < 100000 && at < b; i++) {
        double end = at + width < b ? at + width : b, middle = 0.5 * (at + end);
        double whole = cpm_harmonic_panel(h, at, end);
        double halves = cpm_harmonic_panel(h, at, middle) + cpm_harmonic_panel(h, middle, end);
        /* of order 16: the halves' own error is 2^-16 of the difference */
        if (fabs(whole - halves) > 1e-13 * halves && end - at > least && middle > at && middle < end) {
            width = 0.5 * (end - at);
            continue;
        }
        sum += halves;
        at = end;
        width = fmin(2.0 * width, widest);
    }
    return sum;
}
/* Arc length of x. |p| has the period pi/w where c < 0: whole periods are counted. */
CPM_INLINE double cpm_harmonic_length(const cpm_harmonic *h, double x) {
    if (!(x > 0.0)) return 0.0;
    if (!(h->c < 0.0) || h->w * x < CPM_PI) return cpm_harmonic_between(h, 0.0, x);
    double period = CPM_PI / h->w, count = floor(x / period);
    return count * cpm_harmonic_between(h, 0.0, period) + cpm_harmonic_between(h, 0.0, fmax(x - count * period, 0.0));
}
/* The x at which the arc length is `wanted`: Newton, each step's length by quadrature over that step alone. */
CPM_INLINE double cpm_harmonic_inverse(const cpm_harmonic *h, double wanted, double most) {
    double x = 0.0, length = 0.0, turned = 0.0;
    if (h->c < 0.0 && wanted * h->w > cpm_sqrt(h->square)) { /* it may be more than a period */
        double period = CPM_PI / h->w, around = cpm_harmonic_between(h, 0.0, period), count = floor(wanted / around);
        turned = count * period;
        wanted = fmax(wanted - count * around, 0.0), most -= turned;
    }
    for (int i = 0; i < 2000; i++) {
        double n = cpm_harmonic_index(h, x), next = x + (wanted - length) / (n > 0.0 ? n : 1e-300);
        if (h->w > 0.0) next = fmin(fmax(next, x - 0.5 / h->w), x + 0.5 / h->w); /* a turn of phase at the most */
        next = fmin(fmax(next, 0.0), most);
        if (next == x) break;
        double step = next > x ? cpm_harmonic_between(h, x, next) : -cpm_harmonic_between(h, next, x);
        double moved = fabs(next - x);
        x = next;
        length += step;
        if (moved <= 1e-8 * x + 4e-16 * turned) { /* quadratic: the next one is at rounding */
            n = cpm_harmonic_index(h, x);
            return turned + (n > 0.0 ? fmin(fmax(x + (wanted - length) / n, 0.0), most) : x);
        }
    }
    return turned + x;
}

/* The first x > 0 with tan(w x/times)/w = T (tanh). */
CPM_INLINE double cpm_harmonic_when(const cpm_harmonic *h, double t, double times) {
    double z = h->w * t, x = t;
    if (h->c > 0.0) { /* atanh */
        if (!(z < 1.0 && z > 0.0)) return CPM_EXACT_INFINITE;
        if (z > 1e-6) x = 0.5 * cpm_log1p(2.0 * z / (1.0 - z)) / h->w;
        return x * times;
    }
    if (h->c == 0.0) return t > 0.0 ? t * times : CPM_EXACT_INFINITE;
    if (z > 1e-6 || z < -1e-6) x = cpm_atan(z) / h->w;
    if (!(t > 0.0)) x += CPM_PI / h->w;
    return x * times;
}
/* The smaller of two roots of f0 + f1 T + f2 T^2 by the time they come; a root at 0 is divided out by f0 = 0 given. */
CPM_INLINE double cpm_harmonic_first(const cpm_harmonic *h, double f0, double f1, double f2, int leaving, double times) {
    double root[2], first = CPM_EXACT_INFINITE;
    int count = 0;
    if (leaving) {
        if (f2 != 0.0) root[count++] = -f1 / f2;
    } else if (f2 == 0.0) {
        if (f1 != 0.0) root[count++] = -f0 / f1;
    } else {
        double d = f1 * f1 - 4.0 * f2 * f0;
        if (!(d >= 0.0)) return CPM_EXACT_INFINITE;
        double q = -0.5 * (f1 + (f1 < 0.0 ? -cpm_sqrt(d) : cpm_sqrt(d)));
        root[count++] = q / f2;
        if (q != 0.0) root[count++] = f0 / q;
    }
    for (int i = 0; i < count; i++) {
        if (root[i] == 0.0) continue;
        double x = cpm_harmonic_when(h, root[i], times);
        if (x < first) first = x;
    }
    return first;
}
/* x at which rho^2 has grown by `rise` for the first time, equation (3). leaving: it starts there (rise = 0). */
CPM_INLINE double cpm_harmonic_reach(const cpm_harmonic *h, double rise, int leaving) {
    return cpm_harmonic_first(h, -rise, 2.0 * h->e, h->square + h->c * (h->rho2 + rise), leaving, 1.0);
}
/* x of the first crossing of a plane, equation (4); infinite: none. */
CPM_INLINE double cpm_harmonic_plane(const cpm_harmonic *h, const double r0[3], const double p0[3],
                                     const double point[3], const double normal[3]) {
    double rounding, f = cpm_plane_offset(r0, point, normal, &rounding);
    double a = cpm_dot(h->out, normal), b = cpm_dot(p0, normal);
    int leaving = fabs(f) <= rounding;
    double x = cpm_harmonic_first(h, f, 2.0 * b, h->c * (2.0 * a - f), leaving, 2.0);
    if (leaving && h->c < 0.0 && b != 0.0) x = fmin(x, 2.0 * CPM_PI / h->w); /* once round */
    return x;
}

/* Which layer the ray moves in, as cpm_layer_enter. *along_face: round with the face, held by the layers on both sides. */
CPM_INLINE int cpm_shell_enter(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale, double height,
                               double rounding, const double out[3], double p[3], int *along_face) {
    int layer = cpm_layer_at(m, table, height + rounding), below = layer - 1;
    *along_face = 0;
    if (layer == 0 || height - table[m->heights + layer - 1] > rounding) return layer;
    double rho2 = cpm_dot(out, out), rho = cpm_sqrt(rho2), u = cpm_dot(p, out) / rho, square = cpm_dot(p, p);
    if (m->interpolation != CPM_FIELD_STEP) {
        if (fabs(u) <= 1e-14 * cpm_sqrt(square)) {
            if (square + cpm_shell_pull(m, table, scale, layer) * rho2 > 0.0) return layer;
            if (square + cpm_shell_pull(m, table, scale, below) * rho2 < 0.0) return below;
            *along_face = 1;
            return layer;
        }
        return u > 0.0 ? layer : below;
    }
    int into = u >= 0.0 ? layer : below; /* a straight ray along a sphere leaves it outward */
    double n = 1.0 + scale * cpm_layer_record(m, table, into, 0), size = cpm_sqrt(square), rest[3];
    if (fabs(size - n) <= 1e-12 * n) return into;
    for (int k = 0; k < 3; k++) rest[k] = p[k] - u / rho * out[k];
    double left = n * n - cpm_dot(rest, rest);
    if (left < 0.0) { /* total reflection */
        for (int k = 0; k < 3; k++) p[k] = rest[k] - u / rho * out[k];
        return into == layer ? below : layer;
    }
    double v = u >= 0.0 ? cpm_sqrt(left) : -cpm_sqrt(left);
    for (int k = 0; k < 3; k++) p[k] = rest[k] + v / rho * out[k];
    return into;
}

/* The path from (r, p) in its layer and the sigma at which it leaves it (at most sigma_limit); p may be turned by Snell. */
CPM_INLINE cpm_harmonic cpm_shell_path(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                                       const double r[3], double p[3], double sigma_limit, double *sigma,
                                       double *face) {
    double rounding, out[3], height = cpm_shell_height(m, r, out, &rounding);
    int along, layer = cpm_shell_enter(m, table, scale, height, rounding, out, p, &along);
    double c = cpm_shell_pull(m, table, scale, layer);
    if (along) c = -cpm_dot(p, p) / cpm_dot(out, out);
    cpm_harmonic h = cpm_harmonic_from(c, out, p);
    *sigma = sigma_limit;
    *face = CPM_EXACT_INFINITE;
    for (int upper = 0; upper < 2 && !along; upper++) {
        int bound = layer - 1 + upper;
        if (bound < 0 || bound >= m->size[0]) continue;
        double to = table[m->heights + bound];
        int leaving = fabs(height - to) <= rounding;
        double x = cpm_harmonic_reach(&h, leaving ? 0.0 : cpm_shell_rise(m, height, to), leaving);
        if (x <= *sigma) *sigma = x, *face = to;
    }
    return h;
}
/* Moves a point onto a face, to rounding. */
CPM_INLINE void cpm_shell_snap(const cpm_medium_data *m, double face, double r[3]) {
    double rounding, out[3], off = face - cpm_shell_height(m, r, out, &rounding);
    double per = off / cpm_sqrt(cpm_dot(out, out));
    for (int k = 0; k < 3; k++) r[k] += per * out[k];
}
#endif
