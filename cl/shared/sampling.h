/* shared/sampling.h: directions and points from uniform numbers in (0, 1). */
#ifndef CPM_SHARED_SAMPLING_H
#define CPM_SHARED_SAMPLING_H
#include "elementary.h"
#include "vec.h"

#define CPM_TWO_PI 6.283185307179586476925
#define CPM_PI 3.141592653589793238463

/* sin and cos of `turn` whole turns, turn in [0, 1], at once: the quarter turn nearest, and Taylor over +-1/8 of a turn
 * (to x^17 and x^16; error below 2e-16). */
CPM_INLINE void cpm_sincos_turns(double turn, double *sine, double *cosine) {
    double quarter = (turn * 4.0 + 6755399441055744.0) - 6755399441055744.0; /* 1.5 x 2^52 rounds to an integer */
    double f = (turn - 0.25 * quarter) * CPM_TWO_PI, z = f * f;
    double s = 1.0 / 6227020800.0 + z * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0));
    s = -1.0 / 5040.0 + z * (1.0 / 362880.0 + z * (-1.0 / 39916800.0 + z * s));
    s = f + f * (z * (-1.0 / 6.0 + z * (1.0 / 120.0 + z * s)));
    double c = 1.0 / 479001600.0 + z * (-1.0 / 87178291200.0 + z * (1.0 / 20922789888000.0));
    c = 1.0 / 24.0 + z * (-1.0 / 720.0 + z * (1.0 / 40320.0 + z * (-1.0 / 3628800.0 + z * c)));
    c = 1.0 - z * (0.5 - z * c);
    int q = (int)quarter;
    double a = q & 1 ? c : s, b = q & 1 ? s : c;
    *sine = q & 2 ? -a : a;
    *cosine = (q + 1) & 2 ? -b : b;
}

/* Unit vector at cos theta from the axis n, at azimuth `turn` (in turns). */
CPM_INLINE cpm_vec cpm_direction_about(cpm_vec n, double cos_theta, double turn) {
    cpm_vec s, t;
    double sine = sqrt((1.0 - cos_theta) * (1.0 + cos_theta)), c, w;
    cpm_frame(n, &s, &t);
    cpm_sincos_turns(turn, &w, &c);
    return cpm_unit(cpm_along(cpm_along(cpm_scaled(cos_theta, n), sine * c, s), sine * w, t));
}

/* Density cos theta / pi about n (Malley). */
CPM_INLINE cpm_vec cpm_sample_cosine(cpm_vec n, double u, double v) { return cpm_direction_about(n, sqrt(1.0 - u), v); }

/* Uniform in solid angle over 1 >= cos theta >= cos_cutoff. */
CPM_INLINE cpm_vec cpm_sample_cone(cpm_vec axis, double cos_cutoff, double u, double v) {
    return cpm_direction_about(axis, 1.0 - u * (1.0 - cos_cutoff), v);
}

/* Uniform over a triangle: barycentric coordinates of corners 1 and 2. */
CPM_INLINE void cpm_sample_triangle(double u, double v, double *b1, double *b2) {
    double root = sqrt(u);
    *b1 = root * (1.0 - v);
    *b2 = root * v;
}
#endif
