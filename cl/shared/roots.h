/* shared/roots.h: all real roots of a short polynomial in an interval, in order.
 *
 * A curve meets a plane or a sphere where a polynomial in theta vanishes. Degrees 1 and 2 are closed forms; above, the
 * polynomial is written in the Bernstein basis of the interval, where the number of sign changes of the coefficients
 * bounds the number of roots (variation diminishing): none proves that there is no root, one isolates a root, more
 * halves the interval (de Casteljau). Isolated roots are polished by Newton kept inside its bracket. */
#ifndef CPM_SHARED_ROOTS_H
#define CPM_SHARED_ROOTS_H
#include "../dialect.h"

#define CPM_ROOTS_MAX_DEGREE 10
#define CPM_ROOTS_MAX_DEPTH 40

CPM_INLINE double cpm_polynomial(const double *f, int degree, double t) {
    double v = f[degree];
    for (int i = degree - 1; i >= 0; i--) v = v * t + f[i];
    return v;
}

/* Roots of f0 + f1 t + f2 t^2 in (a, b], ascending; without cancellation (q = -(f1 + sign f1 sqrt D)/2). */
CPM_INLINE int cpm_roots_quadratic(double f0, double f1, double f2, double a, double b, double *roots) {
    double t0, t1;
    if (f2 == 0.0) {
        if (f1 == 0.0) return 0;
        t0 = -f0 / f1;
        if (!(t0 > a && t0 <= b)) return 0;
        roots[0] = t0;
        return 1;
    }
    double d = f1 * f1 - 4.0 * f2 * f0;
    if (!(d >= 0.0)) return 0;
    double q = -0.5 * (f1 + (f1 < 0.0 ? -sqrt(d) : sqrt(d)));
    t0 = q / f2;
    t1 = q == 0.0 ? t0 : f0 / q;
    if (t0 > t1) {
        double swap = t0;
        t0 = t1;
        t1 = swap;
    }
    int count = 0;
    if (t0 > a && t0 <= b) roots[count++] = t0;
    if (t1 > a && t1 <= b && t1 > t0) roots[count++] = t1;
    return count;
}

/* Sign changes of the coefficients, zeros passed over; `first` is the first sign, 0 where all vanish. */
CPM_INLINE int cpm_sign_changes(const double *b, int degree, int *first) {
    int changes = 0, sign = 0;
    *first = 0;
    for (int i = 0; i <= degree; i++) {
        int s = b[i] > 0.0 ? 1 : b[i] < 0.0 ? -1 : 0;
        if (s && sign && s != sign) changes++;
        if (s && !sign) *first = s;
        if (s) sign = s;
    }
    return changes;
}

/* The root of q in (lo, hi), where q goes from the sign `first` to the other: Newton from `guess` (a part of the
 * bracket), or halving where Newton would leave the bracket. */
CPM_INLINE double cpm_root_bracketed(const double *q, int degree, double lo, double hi, double guess, int first) {
    double t = lo + guess * (hi - lo);
    for (int i = 0; i < 100; i++) {
        double f = q[degree], df = 0.0;
        for (int k = degree - 1; k >= 0; k--) {
            df = df * t + f;
            f = f * t + q[k];
        }
        if (f == 0.0) return t;
        if ((f < 0.0) == (first < 0)) lo = t;
        else hi = t;
        double next = t - f / df;
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        if (fabs(next - t) <= 4e-16 * fabs(next) || next == t) return next;
        t = next;
    }
    return t;
}

/* Roots of sum f[i] t^i in (a, b], ascending; at most `degree` of them. */
CPM_INLINE int cpm_roots(const double *f, int degree, double a, double b, double *roots) {
    if (degree <= 2)
        return cpm_roots_quadratic(f[0], degree > 0 ? f[1] : 0.0, degree > 1 ? f[2] : 0.0, a, b, roots);

    double q[CPM_ROOTS_MAX_DEGREE + 1]; /* f(a + (b - a) u) by repeated synthetic division */
    for (int i = 0; i <= degree; i++) q[i] = f[i];
    if (a != 0.0)
        for (int i = 0; i < degree; i++)
            for (int k = degree - 1; k >= i; k--) q[k] += a * q[k + 1];
    double w = b - a, power = 1.0;
    for (int i = 1; i <= degree; i++) q[i] *= (power *= w);

    double bernstein[CPM_ROOTS_MAX_DEGREE + 1]; /* b_j = sum_i C(j,i)/C(n,i) q_i */
    {
        double binomial = 1.0;
        for (int i = 0; i <= degree; i++) {
            bernstein[i] = q[i] / binomial;
            binomial = binomial * (double)(degree - i) / (double)(i + 1);
        }
        for (int level = 1; level <= degree; level++)
            for (int i = degree; i >= level; i--) bernstein[i] += bernstein[i - 1];
    }
    int first;
    int changes = cpm_sign_changes(bernstein, degree, &first);
    if (changes == 0 && bernstein[degree] != 0.0) return 0;

    /* depth-first over halves, left first: each level keeps the right half that is still to come */
    double stack[CPM_ROOTS_MAX_DEGREE + 1][CPM_ROOTS_MAX_DEGREE + 1];
    double stack_lo[CPM_ROOTS_MAX_DEGREE + 1], stack_hi[CPM_ROOTS_MAX_DEGREE + 1];
    int height = 0, count = 0;
    double lo = 0.0, hi = 1.0;
    for (;;) {
        changes = cpm_sign_changes(bernstein, degree, &first);
        int ends_on_root = first != 0 && bernstein[degree] == 0.0;
        int split = changes + ends_on_root > 1 && hi - lo > 1e-12 && height < CPM_ROOTS_MAX_DEGREE;
        if (split) {
            double right[CPM_ROOTS_MAX_DEGREE + 1];
            for (int i = 0; i <= degree; i++) right[i] = bernstein[i];
            for (int level = 1; level <= degree; level++)
                for (int i = 0; i <= degree - level; i++) right[i] = 0.5 * (right[i] + right[i + 1]);
            for (int level = 1; level <= degree; level++)
                for (int i = degree; i >= level; i--) bernstein[i] = 0.5 * (bernstein[i] + bernstein[i - 1]);
            double middle = 0.5 * (lo + hi);
            int unused;
            if (cpm_sign_changes(right, degree, &unused) + (right[degree] == 0.0) > 0) {
                for (int i = 0; i <= degree; i++) stack[height][i] = right[i];
                stack_lo[height] = middle;
                stack_hi[height] = hi;
                height++;
            }
            hi = middle;
            continue;
        }
        if (changes > 0 && count < degree) {
            double u = changes > 1 ? 0.5 * (lo + hi) : cpm_root_bracketed(q, degree, lo, hi, 0.5, first);
            roots[count++] = a + w * u;
        }
        if (ends_on_root && count < degree) roots[count++] = a + w * hi;
        if (height == 0) return count;
        height--;
        for (int i = 0; i <= degree; i++) bernstein[i] = stack[height][i];
        lo = stack_lo[height];
        hi = stack_hi[height];
    }
}
#endif
