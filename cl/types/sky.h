/* types/sky.h: what is seen beyond a scene's extent, the same memory on both sides: a sun's disc, or an environment.
 *
 * Beside it, of a sun six doubles a bin: the coefficients a0 ... a5 of its radiance over the mean of its disc,
 * sum a_i mu^i; of an environment that is an image, floats, height x width x bins. */
#ifndef CPM_TYPES_SKY_H
#define CPM_TYPES_SKY_H
#include "../dialect.h"

#define CPM_SKY_NONE 0
#define CPM_SKY_SUN 1
#define CPM_SKY_EVEN 2  /* the same from everywhere */
#define CPM_SKY_IMAGE 3 /* equal steps of angle: row 0 about `axis`, the middle column about `north` */
#define CPM_LIMB 6

typedef struct cpm_sky_data {
    double axis[3];              /*  0  unit: towards the sun's centre; of an image: up */
    double north[3];             /* 24  unit, across `axis` */
    double east[3];              /* 48  unit, across both: columns grow towards it */
    double sine;                 /* 72  of the sun's angular radius */
    cpm_i32 kind;                /* 80 */
    cpm_i32 width, height, bins; /* 84 */
} cpm_sky_data;
CPM_ASSERT_OFFSET(cpm_sky_data, sine, 72);
CPM_STATIC_ASSERT(sizeof(cpm_sky_data) == 96, cpm_sky_data_size);
#endif
