/* cpm/image.h: rendering, the spectral film, and spectral OpenEXR. */
#ifndef CPM_IMAGE_H
#define CPM_IMAGE_H
#include "photons.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cpm_image cpm_image;

typedef struct cpm_render_options {
    size_t struct_size;
    int32_t width, height; /* 1..65536 */
    uint64_t photons;
    uint64_t seed;
    const double *wavelengths; /* bin centres, nm, strictly increasing */
    size_t wavelength_count;
    int32_t nearest;      /* k, >= 2 */
    int32_t samples;      /* eye rays a pixel, >= 1 */
    int32_t no_projection;
    int32_t batch;        /* 0: chosen */
    int32_t no_edge_correction; /* 1: discs that overhang a surface's edge keep their whole area (dark edges) */
    int32_t reserved;
    double max_radius;    /* metres; <= 0: direct light capped by what its own photons ask for, the rest at the diagonal */
    double bundle_tolerance; /* where a medium disperses: wavelengths whose eye rays meet a surface (or leave) within so
                                many pixels of each other share one ray; of photons, see cpm_photons_options, with
                                `nearest` for 150. 0: each goes its own way. At most 100 */
} cpm_render_options;

CPM_API cpm_status cpm_image_render(cpm_context *context, cpm_scene *scene, const cpm_render_options *options,
                                    cpm_image **image);
/* Same, with photons traced before (their wavelengths are the image's; options->photons, seed and wavelengths are
 * ignored, seed apart for the eye rays). */
CPM_API cpm_status cpm_image_gather(cpm_context *context, cpm_scene *scene, cpm_photons *photons,
                                    const cpm_render_options *options, cpm_image **image);

/* An image from values (height x width x bins, C order), for writing. */
CPM_API cpm_status cpm_image_create(cpm_context *context, int32_t width, int32_t height, const double *wavelengths,
                                    size_t wavelength_count, const float *values, cpm_image **image);
CPM_API void cpm_image_retain(cpm_image *image);
CPM_API void cpm_image_release(cpm_image *image);

CPM_API cpm_status cpm_image_size(const cpm_image *image, int32_t *width, int32_t *height, size_t *bins);
/* height x width x bins; actual radiance at the pinhole, W/m2/sr/nm. Owned by the image. */
CPM_API const float *cpm_image_data(const cpm_image *image);
CPM_API const double *cpm_image_wavelengths(const cpm_image *image);
CPM_API cpm_status cpm_image_stats(const cpm_image *image, cpm_stats *stats);

/* Spectral EXR in the layout of Fichet et al. 2021: channels S0.550,000nm (float), spectralLayoutVersion,
 * emissiveUnits, and R, G, B. `rgb` is height x width x 3 linear sRGB, or NULL: made from CIE 1931 by the fit of Wyman
 * et al. 2013. Written beside `path`, then renamed: never a half file. */
CPM_API cpm_status cpm_image_write_exr(cpm_context *context, const cpm_image *image, const char *path,
                                       const float *rgb);

#ifdef __cplusplus
}
#endif
#endif
