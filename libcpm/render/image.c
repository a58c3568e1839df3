/* render/image.c: making, sharing and reading the spectral film. */
#include "render/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SIDE 65536

static cpm_status check_wavelengths(cpm_context *context, const double *wavelengths, size_t bins) {
    if (!wavelengths) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelengths is NULL");
    if (bins < 1 || bins > CPM_MAX_BINS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelength_count is %zu; 1 to %d are allowed", bins,
                        CPM_MAX_BINS);
    for (size_t i = 0; i < bins; i++) {
        if (!isfinite(wavelengths[i]) || wavelengths[i] <= 0.0)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelengths[%zu] is %g nm; it must be finite and > 0",
                            i, wavelengths[i]);
        if (i > 0 && wavelengths[i] <= wavelengths[i - 1])
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "wavelengths[%zu] is %.17g nm after %.17g nm; they must increase strictly", i,
                            wavelengths[i], wavelengths[i - 1]);
    }
    return CPM_OK;
}

cpm_status cpm_image_new(cpm_context *context, int32_t width, int32_t height, const double *wavelengths, size_t bins,
                         cpm_image **image) {
    *image = NULL;
    if (width < 1 || width > MAX_SIDE || height < 1 || height > MAX_SIDE)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "size is %d x %d pixels; width and height must be 1 to %d",
                        (int)width, (int)height, MAX_SIDE);
    const cpm_status status = check_wavelengths(context, wavelengths, bins);
    if (status != CPM_OK) return status;

    cpm_image *made = calloc(1, sizeof *made);
    if (made) {
        atomic_init(&made->references, 1);
        made->width = width;
        made->height = height;
        made->bins = bins;
        made->stats.struct_size = sizeof made->stats;
        made->wavelengths = malloc(bins * sizeof *made->wavelengths);
        /* calloc checks pixels x (bins x 4); the factors themselves fit: 2^32 pixels need a 64-bit size_t. */
        if (cpm_image_pixels(made) / (size_t)width == (size_t)height)
            made->data = calloc(cpm_image_pixels(made), bins * sizeof *made->data);
    }
    if (!made || !made->wavelengths || !made->data) {
        cpm_image_release(made);
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an image of %d x %d pixels of %zu bins",
                        (int)width, (int)height, bins);
    }
    memcpy(made->wavelengths, wavelengths, bins * sizeof *wavelengths);
    *image = made;
    return CPM_OK;
}

cpm_status cpm_image_create(cpm_context *context, int32_t width, int32_t height, const double *wavelengths,
                            size_t wavelength_count, const float *values, cpm_image **image) {
    if (image) *image = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!image) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "image is NULL");
    if (!values) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "values is NULL");
    const cpm_status status = cpm_image_new(context, width, height, wavelengths, wavelength_count, image);
    if (status != CPM_OK) return status;
    memcpy((*image)->data, values, cpm_image_pixels(*image) * wavelength_count * sizeof *values);
    return CPM_OK;
}

void cpm_image_retain(cpm_image *image) {
    if (image) atomic_fetch_add(&image->references, 1);
}

void cpm_image_release(cpm_image *image) {
    if (!image || atomic_fetch_sub(&image->references, 1) != 1) return;
    free(image->wavelengths);
    free(image->data);
    free(image);
}

cpm_status cpm_image_size(const cpm_image *image, int32_t *width, int32_t *height, size_t *bins) {
    if (width) *width = image ? image->width : 0;
    if (height) *height = image ? image->height : 0;
    if (bins) *bins = image ? image->bins : 0;
    return image ? CPM_OK : CPM_ERROR_INVALID_ARGUMENT;
}

const float *cpm_image_data(const cpm_image *image) { return image ? image->data : NULL; }

const double *cpm_image_wavelengths(const cpm_image *image) { return image ? image->wavelengths : NULL; }

cpm_status cpm_image_stats(const cpm_image *image, cpm_stats *stats) {
    if (!image || !stats || stats->struct_size < sizeof stats->struct_size) return CPM_ERROR_INVALID_ARGUMENT;
    /* An older caller's struct is shorter: it gets the fields that it knows. struct_size stays its own. */
    const size_t theirs = stats->struct_size;
    const size_t known = theirs < sizeof image->stats ? theirs : sizeof image->stats;
    memcpy(stats, &image->stats, known);
    stats->struct_size = theirs;
    return CPM_OK;
}
