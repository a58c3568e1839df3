/* types/eye.h: what eye rays need beside the world (types/world.h): the camera, and how surfaces look. */
#ifndef CPM_TYPES_EYE_H
#define CPM_TYPES_EYE_H
#include "world.h"

#define CPM_EYE_DEPTH 64          /* specular surfaces along one branch */
#define CPM_EYE_LEAST 1e-4f       /* of an eye ray: branches that carry less end */
#define CPM_EYE_SAMPLES_AT_ONCE 4 /* of each pixel: so many branches live together, however many are asked for */

typedef struct cpm_eye_frame {
    double origin[3], forward[3], right[3], up[3]; /* right and up scaled to half the picture */
    cpm_u64 seed;
    cpm_i32 width, height, samples;
    cpm_i32 splits; /* the medium at the camera disperses: one ray a bin */
    cpm_i32 bins;
    cpm_i32 corrected; /* discs that overhang an edge are measured */
    cpm_region region; /* what contains the camera */
    unsigned short padding[7];
} cpm_eye_frame;
CPM_STATIC_ASSERT(sizeof(cpm_eye_frame) == 160, cpm_eye_frame_size);

typedef struct cpm_eye {
    cpm_eye_frame is;
    CPM_GLOBAL const cpm_i32 *shape_light;   /* of each shape: the area light that it is, -1: none */
    CPM_GLOBAL const float *reflectance;     /* materials x bins */
    CPM_GLOBAL const float *reflectance_max; /* materials */
    CPM_GLOBAL const double *emission;       /* lights x bins */
    CPM_GLOBAL const double *squared_index;  /* bins: n_c^2 */
} cpm_eye;

/* What a branch has met. */
#define CPM_SEEN_NOTHING 0
#define CPM_SEEN_DARK 1    /* a surface that reflects nothing, perhaps a light */
#define CPM_SEEN_DIFFUSE 2 /* gathers */
#define CPM_SEEN_MIRROR 3
#define CPM_SEEN_BOUNDARY 4
#endif
