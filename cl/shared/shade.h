/* shared/shade.h: eye rays, and what a surface that they meet looks like.
 *
 * L/n^2 is constant along a ray (basic radiance), so a pixel is sum weight (n_c/n_s)^2 L_s, L_s = rho/pi E at a diffuse
 * surface in index n_s, and n_s^2 times the basic radiance of an area light. */
#ifndef CPM_SHARED_SHADE_H
#define CPM_SHARED_SHADE_H
#include "philox.h"
#include "sampling.h"
#include "sobol.h"

/* Number of a Sobol point, alone, in (0, 1). */
CPM_INLINE double sobol_uniform(cpm_u32 index, int dimension, cpm_u32 seed) {
    cpm_u32 bits[CPM_WIDTH];
    store_words(sobol_lanes(splat_word(index), dimension, seed), bits, 0);
    return cpm_uniform(bits[0]);
}

/* Where in its pixel a sample lies, in (0, 1)^2: points of a Sobol sequence scrambled by the pixel's own random numbers,
 * so that they cover the square evenly however many they are. One alone is in the middle
 * (docs/decisions/0010-one-eye-ray.md). */
CPM_INLINE void cpm_eye_place(cpm_u64 seed, cpm_u32 pixel, cpm_i32 sample, cpm_i32 samples, double *x, double *y) {
    *x = *y = 0.5;
    if (samples == 1) return;
    cpm_random scramble = cpm_philox(seed, pixel, 0, CPM_STREAM_EYE, 0);
    *x = sobol_uniform((cpm_u32)sample, 0, scramble.v[0]);
    *y = sobol_uniform((cpm_u32)sample, 1, scramble.v[1]);
}

/* Unit direction through a point of the picture, (column + x, row + y) from the upper left; `right` and `up` are scaled
 * to half the picture. */
CPM_INLINE real3 eye_direction(real3 forward, real3 right, real3 up, real across, real down, cpm_i32 width,
                               cpm_i32 height) {
    real a = R(2.0) * across / R(width) - R(1.0), b = R(1.0) - R(2.0) * down / R(height);
    return unit3(add3(add3(forward, a, right), b, up));
}

/* Normal interpolated between those at a triangle's corners, at barycentric (u, v), on the side of the unit geometric
 * normal; that one where they cancel. */
CPM_INLINE real3 shade_normal(real3 corner0, real3 corner1, real3 corner2, real u, real v, real3 geometric) {
    real w = R(1.0) - u - v;
    real3 s = add3(add3(scale3(w, corner0), u, corner1), v, corner2);
    real length = root(dot3(s, s));
    mask known = less(splat(1e-9), length); /* not for NaN */
    s = scale3(R(1.0) / pick(known, length, splat(1.0)), s);
    s = pick3(less(splat(0.0), dot3(s, geometric)), s, scale3(splat(-1.0), s));
    return pick3(known, s, geometric);
}

/* What a ray of weight `weight` sees, of an area light: basic radiance as given, in the camera's index n_c. */
CPM_INLINE double cpm_shade_light(float weight, double radiance, double squared_index) {
    return (double)weight * radiance * squared_index;
}

/* And of a diffuse surface in index n under irradiance E. */
CPM_INLINE double cpm_shade_diffuse(float weight, float reflectance, double irradiance, double squared_index,
                                    double n) {
    return (double)weight * (double)reflectance * irradiance * squared_index / (CPM_PI * n * n);
}

/* Weight of a branch behind a specular surface. */
CPM_INLINE float cpm_shade_branch(float weight, float factor, float reflectance) {
    return weight * factor * reflectance;
}
#endif
