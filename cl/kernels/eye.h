/* kernels/eye.h: what eye rays need beside the world, as every kernel takes it, and put together. */
#ifndef CPM_KERNELS_EYE_H
#define CPM_KERNELS_EYE_H
#include "../types/eye.h"
#include "world.h"

#define CPM_EYE_PARAMETERS                                                                                             \
    __global const cpm_eye_frame *eye_frame, __global const int *shape_light, __global const float *reflectance,       \
        __global const float *reflectance_max, __global const double *emission, __global const double *squared_index

#define CPM_EYE(eye)                                                                                                   \
    cpm_eye eye;                                                                                                       \
    eye.is = *eye_frame;                                                                                               \
    eye.shape_light = shape_light, eye.reflectance = reflectance, eye.reflectance_max = reflectance_max;               \
    eye.emission = emission, eye.squared_index = squared_index

/* Where a kernel's branches are, in segments of `share` a work-item. */
#define CPM_EYE_SEGMENT(first, last) const int first = (int)get_global_id(0) * share, last = min(first + share, count)
#endif
