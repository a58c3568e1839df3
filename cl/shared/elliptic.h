/* shared/elliptic.h: arc lengths of ellipses, int sqrt(q^2 + k^2 sin^2 u) du, in scalar double on both sides.
 *
 * From 0 to u, |u| <= pi/2, with s = sin u, c = cos u, D = q^2 + k^2 s^2 (Carlson's forms; all terms positive)
 *
 *   I(u) = q^2 s R_F(q^2 c^2, D, q^2) + k^2 q^2 s^3/3 R_D(q^2 c^2, D, q^2)                                          (1)
 *
 * and I(u + m pi) = I(u) + 2 m I(pi/2). R_F and R_D by duplication until the arguments agree to 0.8 %, then by their
 * series to the seventh order, whose remainder is below 1e-17 (DLMF 19.36.1, 19.36.2; Carlson, Numer. Algorithms 10,
 * 1995). Over a short interval a difference of (1) would cancel: there Gauss-Legendre with 8 points, exact to rounding
 * where the branch points sin u = +- i q/k are 8 half widths away; where they are nearer both ends are near u = 0, and
 * (1) loses nothing. */
#ifndef CPM_SHARED_ELLIPTIC_H
#define CPM_SHARED_ELLIPTIC_H
#include "arctangent.h"
#include "elementary.h"

#define CPM_LEAST_RATIO 1e-34 /* of q^2 to k^2: below it q is taken for 0, which moves I by 1e-32 of k */

/* Half turns k and the sine and cosine of what they leave, t = k pi + rest, |rest| <= pi/2, for |t| up to 1e15; the
 * sign (-1)^k is left out. */
CPM_INLINE double cpm_half_turns(double t, double *sine, double *cosine) {
    double k = (t * (1.0 / CPM_PI) + 6755399441055744.0) - 6755399441055744.0;
    /* pi in three parts of 26, 26 and 53 bits: k times the first two is exact for k < 2^27 */
    double rest = ((t - k * 3.1415926218032837) - k * 3.1786509424591713e-08) - k * 1.2246467991473532e-16;
    *sine = cpm_sin(rest);
    *cosine = cpm_cos(rest);
    return k;
}

/* Sine and cosine of any angle up to 1e15. */
CPM_INLINE void cpm_sine_cosine(double t, double *sine, double *cosine) {
    double pairs = 0.5 * cpm_half_turns(t, sine, cosine);
    if (pairs != floor(pairs)) *sine = -*sine, *cosine = -*cosine;
}

CPM_INLINE void cpm_carlson(double x, double y, double z, double *rf, double *rd) {
    double sum = 0.0, power = 1.0, f, d;
    for (int i = 0; i < 100; i++) {
        f = (x + y + z) / 3.0, d = (x + y + 3.0 * z) * 0.2;
        double spread = fmax(fmax(fabs(f - x), fabs(f - y)), fabs(f - z));
        if (spread < 0.008 * f) break;
        double a = cpm_sqrt(x), b = cpm_sqrt(y), c = cpm_sqrt(z), lambda = a * b + a * c + b * c;
        sum += power / (c * (z + lambda));
        power *= 0.25;
        x = 0.25 * (x + lambda), y = 0.25 * (y + lambda), z = 0.25 * (z + lambda);
    }
    double X = (f - x) / f, Y = (f - y) / f, Z = -(X + Y), e2 = X * Y - Z * Z, e3 = X * Y * Z;
    double series = 1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 / 44.0 * e2 * e3 - 5.0 / 208.0 * e2 * e2 * e2 +
                    3.0 / 104.0 * e3 * e3 + e2 * e2 * e3 / 16.0;
    *rf = series / cpm_sqrt(f);
    X = (d - x) / d, Y = (d - y) / d, Z = -(X + Y) / 3.0;
    double xy = X * Y, zz = Z * Z, e4 = 3.0 * (xy - zz) * zz, e5 = xy * zz * Z;
    e2 = xy - 6.0 * zz, e3 = (3.0 * xy - 8.0 * zz) * Z;
    series = 1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2 - 3.0 / 22.0 * e4 - 9.0 / 52.0 * e2 * e3 +
             3.0 / 26.0 * e5 - e2 * e2 * e2 / 16.0 + 3.0 / 40.0 * e3 * e3 + 3.0 / 20.0 * e2 * e4 +
             45.0 / 272.0 * e2 * e2 * e3 - 9.0 / 68.0 * (e3 * e4 + e2 * e5);
    *rd = power * series / (d * cpm_sqrt(d)) + 3.0 * sum;
}

/* Equation (1) for sin u and cos u of |u| <= pi/2. */
CPM_INLINE double cpm_elliptic_part(double q2, double k2, double s, double c) {
    double rf, rd, ss = s * s;
    cpm_carlson(q2 * c * c, q2 + k2 * ss, q2, &rf, &rd);
    return q2 * s * (rf + k2 * ss * rd / 3.0);
}
CPM_INLINE double cpm_elliptic_from_zero(double q2, double k2, double u) {
    double s, c, turns = cpm_half_turns(u, &s, &c);
    double part = cpm_elliptic_part(q2, k2, s, c);
    return turns != 0.0 ? part + 2.0 * turns * cpm_elliptic_part(q2, k2, 1.0, 0.0) : part;
}

CPM_CONSTANT_TABLE double cpm_gauss8_x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                             0.9602898564975363};
CPM_CONSTANT_TABLE double cpm_gauss8_w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                             0.1012285362903763};
CPM_INLINE double cpm_elliptic_speed(double q2, double k2, double u) { /* sqrt(q2 + k2 sin^2 u) */
    double s, c;
    cpm_half_turns(u, &s, &c);
    return cpm_sqrt(q2 + k2 * s * s);
}

/* int from u to u + du, du >= 0; q2, k2 >= 0, not both 0. */
CPM_INLINE double cpm_elliptic_arc(double q2, double k2, double u, double du) {
    if (q2 < CPM_LEAST_RATIO * k2) q2 = CPM_LEAST_RATIO * k2;
    double h = 0.5 * du, middle = u + h, near = middle;
    near -= CPM_PI * ((near * (1.0 / CPM_PI) + 6755399441055744.0) - 6755399441055744.0);
    if (du > 0.25 || near * near * k2 + q2 < 64.0 * h * h * k2)
        return cpm_elliptic_from_zero(q2, k2, u + du) - cpm_elliptic_from_zero(q2, k2, u);
    double sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += cpm_gauss8_w[i] * (cpm_elliptic_speed(q2, k2, middle - h * cpm_gauss8_x[i]) +
                                  cpm_elliptic_speed(q2, k2, middle + h * cpm_gauss8_x[i]));
    return h * sum;
}

/* The du >= 0 after which the integral from u is `wanted`: whole half turns, then Newton kept in a bracket. */
CPM_INLINE double cpm_elliptic_inverse(double q2, double k2, double u, double wanted) {
    if (!(wanted > 0.0)) return 0.0;
    if (q2 < CPM_LEAST_RATIO * k2) q2 = CPM_LEAST_RATIO * k2;
    double turns = 0.0;
    if (wanted > 2.0 * cpm_sqrt(q2 + k2)) { /* a half turn is longer than that */
        double turn = 2.0 * cpm_elliptic_part(q2, k2, 1.0, 0.0);
        turns = floor(wanted / turn);
        wanted -= turns * turn;
    }
    double low = 0.0, high = 1.0000001 * CPM_PI, x = wanted / cpm_elliptic_speed(q2, k2, u);
    if (!(x < high)) x = 0.5 * high;
    for (int i = 0; i < 100; i++) {
        double miss = cpm_elliptic_arc(q2, k2, u, x) - wanted;
        if (miss > 0.0)
            high = x;
        else
            low = x;
        double next = x - miss / cpm_elliptic_speed(q2, k2, u + x), moved = fabs(next - x);
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
            moved = next - x;
            if (next == low || next == high) break;
        }
        x = next;
        if (fabs(moved) <= 4e-16 * x) break;
    }
    return turns * CPM_PI + x;
}
#endif
