/* shared/sky.h: what a ray that leaves a scene sees: a sun's disc with its limb darkening, or an image all around.
 *
 * A sphere of angular radius a, seen at an angle t from its centre, shows its surface under an angle m from the normal
 * with sin m = sin t / sin a (the law of sines in the triangle of eye, centre and point), so mu = cos m needs no small
 * angles. */
#ifndef CPM_SHARED_SKY_H
#define CPM_SHARED_SKY_H
#include "../types/sky.h"
#include "arctangent.h"
#include "vec.h"

/* mu on the sun's disc in a unit direction; negative: beside it. The sine is that of the cross product: it keeps its
 * digits where the cosine has none. */
CPM_INLINE double cpm_sun_mu(const cpm_sky_data *s, double x, double y, double z) {
    double cx = y * s->axis[2] - z * s->axis[1], cy = z * s->axis[0] - x * s->axis[2],
           cz = x * s->axis[1] - y * s->axis[0];
    double square = (cx * cx + cy * cy + cz * cz) / (s->sine * s->sine);
    double cosine = x * s->axis[0] + y * s->axis[1] + z * s->axis[2];
    return cosine > 0.0 && square <= 1.0 ? cpm_sqrt(1.0 - square) : -1.0;
}

/* Radiance over the disc's mean: sum a_i mu^i. */
CPM_INLINE double cpm_sun_limb(CPM_GLOBAL const double *a, double mu) {
    return a[0] + mu * (a[1] + mu * (a[2] + mu * (a[3] + mu * (a[4] + mu * a[5]))));
}

/* Where a unit direction lies in the image: bilinear between the centres of pixels, whose offsets (of bin 0) and
 * weights are at[4], share[4]. Columns go around; above the first row's centre and below the last's the row is held. */
CPM_INLINE void cpm_sky_place(const cpm_sky_data *s, double x, double y, double z, cpm_i64 at[4], double share[4]) {
    double up = x * s->axis[0] + y * s->axis[1] + z * s->axis[2];
    double north = x * s->north[0] + y * s->north[1] + z * s->north[2];
    double east = x * s->east[0] + y * s->east[1] + z * s->east[2];
    double level = cpm_sqrt(north * north + east * east);
    double row = cpm_atan2(level, up) * ((double)s->height / CPM_PI) - 0.5;
    double column = (cpm_atan2(east, north) + CPM_PI) * ((double)s->width / (2.0 * CPM_PI)) - 0.5;
    row = cpm_min(cpm_max(row, 0.0), (double)(s->height - 1));
    cpm_i32 r0 = (cpm_i32)row, c0 = (cpm_i32)(column + 1.0) - 1; /* from -1 on */
    cpm_i32 r1 = r0 + 1 < s->height ? r0 + 1 : r0;
    double dr = row - (double)r0, dc = column - (double)c0;
    cpm_i32 left = (c0 + s->width) % s->width, right = (c0 + 1 + s->width) % s->width;
    cpm_i64 line0 = (cpm_i64)r0 * s->width, line1 = (cpm_i64)r1 * s->width;
    at[0] = (line0 + left) * s->bins, at[1] = (line0 + right) * s->bins;
    at[2] = (line1 + left) * s->bins, at[3] = (line1 + right) * s->bins;
    share[0] = (1.0 - dr) * (1.0 - dc), share[1] = (1.0 - dr) * dc;
    share[2] = dr * (1.0 - dc), share[3] = dr * dc;
}
CPM_INLINE double cpm_sky_pixel(CPM_GLOBAL const float *pixels, const cpm_i64 at[4], const double share[4],
                                cpm_i32 bin) {
    return share[0] * (double)pixels[at[0] + bin] + share[1] * (double)pixels[at[1] + bin] +
           share[2] * (double)pixels[at[2] + bin] + share[3] * (double)pixels[at[3] + bin];
}
#endif
