/* scene/sky_light.c: suns and environments as the user gives them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

#define SUN_RADIUS 0.2666 /* degrees, at the mean distance: 959.63 arc seconds (Allen's Astrophysical Quantities) */
#define MOST_PIXELS (1u << 28)
#define RADIANS (3.14159265358979323846 / 180.0)

static int direction_of(const double *v, cpm_vec *to) {
    for (int k = 0; k < 3; k++)
        if (!isfinite(v[k])) return 0;
    const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0.0)) return 0;
    *to = cpm_unit(cpm_v(v[0] / largest, v[1] / largest, v[2] / largest));
    return 1;
}

static cpm_status take_limb(cpm_context *context, const cpm_light_desc *d, light *to) {
    if (!d->limb) return CPM_OK;
    if (!d->limb_count || d->limb_count > 100000)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "sun: limb_count is %zu; allowed: 1 to 100000",
                        d->limb_count);
    for (size_t i = 0; i < d->limb_count; i++) {
        const double *row = &d->limb[CPM_LIMB_ROW * i];
        for (int k = 0; k < CPM_LIMB_ROW; k++)
            if (!isfinite(row[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "sun: limb[%zu][%d] is %g; it must be finite", i,
                                k, row[k]);
        if (!(row[0] > 0.0) || (i && !(row[0] > row[-CPM_LIMB_ROW])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "sun: limb[%zu] is for %g nm; allowed: positive, increasing", i, row[0]);
    }
    to->limb = malloc(d->limb_count * CPM_LIMB_ROW * sizeof *to->limb);
    if (!to->limb) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a sun");
    memcpy(to->limb, d->limb, d->limb_count * CPM_LIMB_ROW * sizeof *to->limb);
    to->limb_count = d->limb_count;
    return CPM_OK;
}

static cpm_status take_sun(cpm_context *context, const cpm_light_desc *d, light *to) {
    if (!direction_of(d->target, &to->axis))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "sun: target is (%g, %g, %g); the direction towards it is needed, finite and not zero",
                        d->target[0], d->target[1], d->target[2]);
    const double radius = d->cutoff == 0.0 ? SUN_RADIUS : d->cutoff;
    if (!(radius > 0.0 && radius < 90.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "sun: angular radius is %g degrees; allowed: above 0, below 90", d->cutoff);
    to->cutoff = radius * RADIANS;
    return take_limb(context, d, to);
}

static cpm_status take_pixels(cpm_context *context, const cpm_light_desc *d, light *to) {
    const size_t bins = d->emission.count;
    const double *w = d->emission.wavelengths;
    if (d->width < 1 || d->height < 1 || (uint64_t)d->width * (uint64_t)d->height > MOST_PIXELS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "environment: %d x %d pixels; allowed: 1 x 1 to %u pixels",
                        d->width, d->height, MOST_PIXELS);
    if (!w || !bins || bins > 10000)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "environment: an image of %zu wavelengths; allowed: 1 to 10000", w ? bins : 0);
    for (size_t i = 0; i < bins; i++)
        if (!isfinite(w[i]) || !(w[i] > 0.0) || (i && !(w[i] > w[i - 1])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "environment: wavelength %zu is %g nm; allowed: positive, increasing", i, w[i]);
    const size_t count = (size_t)d->width * (size_t)d->height;
    for (size_t i = 0; i < count * bins; i++)
        if (!(d->pixels[i] >= 0.0f) || !isfinite(d->pixels[i]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "environment: row %zu, column %zu is %g at %g nm; allowed: finite, not negative",
                            i / bins / (size_t)d->width, i / bins % (size_t)d->width, (double)d->pixels[i],
                            w[i % bins]);
    if (!direction_of(d->up, &to->axis) || !direction_of(d->target, &to->north))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "environment: up and target, directions of the image, must be finite and not zero");
    cpm_vec across = cpm_along(to->north, -cpm_vdot(to->north, to->axis), to->axis);
    if (!(cpm_norm(across) > 1e-9))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "environment: target (%g, %g, %g) lies along up",
                        d->target[0], d->target[1], d->target[2]);
    to->north = cpm_unit(across);
    to->emission.values = calloc(2 * bins, sizeof(double));
    to->pixels = malloc(count * bins * sizeof *to->pixels);
    if (!to->emission.values || !to->pixels)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an environment of %d x %d pixels", d->width,
                        d->height);
    memcpy(to->pixels, d->pixels, count * bins * sizeof *to->pixels);
    to->emission.wavelengths = to->emission.values + bins;
    to->emission.count = bins;
    memcpy(to->emission.wavelengths, w, bins * sizeof *w);
    to->width = d->width, to->height = d->height;
    return CPM_OK;
}

cpm_status cpm_light_take_far(cpm_context *context, const cpm_light_desc *d, light *to) {
    if (d->aim) {
        for (int k = 0; k < 3; k++)
            if (!(d->aim->low[k] < d->aim->high[k]) || !cpm_in_range(d->aim->low[k]) || !cpm_in_range(d->aim->high[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                                "light: aim.low[%d] is %g and aim.high[%d] is %g; both finite, low less than high", k,
                                d->aim->low[k], k, d->aim->high[k]);
        to->aim = *d->aim;
        to->has_aim = 1;
    }
    cpm_status status = CPM_OK;
    to->axis = cpm_v(0.0, 1.0, 0.0), to->north = cpm_v(0.0, 0.0, -1.0);
    if (d->kind == CPM_LIGHT_SUN)
        status = take_sun(context, d, to);
    else if (d->pixels)
        status = take_pixels(context, d, to);
    if (status) cpm_light_free(to);
    return status;
}

void cpm_light_free(light *l) {
    cpm_spectrum_free(&l->emission);
    free(l->pixels), free(l->limb);
    l->pixels = NULL, l->limb = NULL;
}
