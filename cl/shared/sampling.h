/* shared/sampling.h: directions and points from uniform numbers in (0, 1). */
#ifndef CPM_SHARED_SAMPLING_H
#define CPM_SHARED_SAMPLING_H
#include "elementary.h"
#include "vec.h"

#define CPM_TWO_PI 6.283185307179586476925
#define CPM_PI 3.141592653589793238463

/* Unit vector at cos theta from the axis n, at azimuth `turn` (in turns). */
CPM_INLINE cpm_vec cpm_direction_about(cpm_vec n, double cos_theta, double turn) {
    cpm_vec s, t;
    double sine = sqrt((1.0 - cos_theta) * (1.0 + cos_theta)), c, w;
    cpm_frame(n, &s, &t);
    w = cpm_sin(CPM_TWO_PI * turn);
    c = cpm_cos(CPM_TWO_PI * turn);
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
