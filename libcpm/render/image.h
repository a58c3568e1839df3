/* render/image.h: the spectral film. Internal. */
#ifndef CPM_RENDER_IMAGE_H
#define CPM_RENDER_IMAGE_H
#include <stdatomic.h>

#include "api/context.h"

struct cpm_image {
    atomic_int references;
    int32_t width, height;
    size_t bins;
    double *wavelengths; /* bins; nm, bin centres, strictly increasing */
    float *data;         /* height x width x bins; actual radiance at the pinhole, W/m2/sr/nm */
    cpm_stats stats;
};

/* A black image. Checks the size (1..65536 each) and the wavelengths (1..CPM_MAX_BINS; finite, > 0, strictly
 * increasing) and says which is wrong. On failure *image is NULL. */
cpm_status cpm_image_new(cpm_context *context, int32_t width, int32_t height, const double *wavelengths, size_t bins,
                         cpm_image **image);

static inline size_t cpm_image_pixels(const cpm_image *image) { return (size_t)image->width * (size_t)image->height; }
#endif
