/* scene/sky.c: suns and environments at a pass's wavelengths. What a direction sees is cl/shared/sky.h. */
#include "cl/shared/sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pass.h"

/* Points and weights of Gauss and Legendre on [0, 1], of their upper half. */
#define GAUSS 8
static const double gauss_x[GAUSS] = {0.0950125098376374, 0.2816035507792589, 0.4580167776572274, 0.6178762444026438,
                                      0.7554044083550030, 0.8656312023878318, 0.9445750230732326, 0.9894009349916499};
static const double gauss_w[GAUSS] = {0.1894506104550685, 0.1826034150449236, 0.1691565193950025, 0.1495959888165767,
                                      0.1246289712555339, 0.0951585116824928, 0.0622535239386479, 0.0271524594117541};

/* Mean over the disc's solid angle: with s the sine of its radius, sin t = s sqrt(1 - mu^2), so that
 * sin t dt = -s^2 mu dmu / sqrt(1 - s^2 (1 - mu^2)). */
static double disc_mean(const double *a, double sine, double cosine) {
    double sum = 0.0;
    for (int i = 0; i < GAUSS; i++)
        for (int side = -1; side <= 1; side += 2) {
            double mu = 0.5 + 0.5 * side * gauss_x[i];
            sum += 0.5 * gauss_w[i] * cpm_sun_limb(a, mu) * mu / sqrt(1.0 - sine * sine * (1.0 - mu * mu));
        }
    return sum * (1.0 + cosine); /* s^2/(1 - cos) */
}

static void limb_at(const light *l, double wavelength, double *a) {
    const double *t = l->limb;
    size_t i = 0;
    if (!t) {
        memset(a, 0, CPM_LIMB * sizeof *a);
        a[0] = 1.0;
        return;
    }
    while (i + 1 < l->limb_count && t[(i + 1) * CPM_LIMB_ROW] < wavelength) i++;
    const double *low = &t[i * CPM_LIMB_ROW], *high = i + 1 < l->limb_count ? low + CPM_LIMB_ROW : low;
    double share = high > low ? (wavelength - low[0]) / (high[0] - low[0]) : 0.0;
    share = cpm_min(cpm_max(share, 0.0), 1.0);
    for (int k = 0; k < CPM_LIMB; k++) a[k] = low[1 + k] + share * (high[1 + k] - low[1 + k]);
}

static cpm_status prepare_sun(const cpm_pass *pass, const light *l, cpm_sky *s) {
    s->data.kind = CPM_SKY_SUN;
    s->data.sine = sin(l->cutoff);
    s->limb = malloc(pass->bins * CPM_LIMB * sizeof *s->limb);
    if (!s->limb) return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a sun");
    for (size_t b = 0; b < pass->bins; b++) {
        double *a = &s->limb[b * CPM_LIMB];
        limb_at(l, pass->wavelengths[b], a);
        double mean = disc_mean(a, s->data.sine, cos(l->cutoff));
        if (!(mean > 0.0))
            return cpm_fail(pass->context, CPM_ERROR_INVALID_ARGUMENT,
                            "sun: its limb darkening at %g nm has a mean of %g; allowed: above 0", pass->wavelengths[b],
                            mean);
        for (int k = 0; k < CPM_LIMB; k++) a[k] /= mean;
    }
    return CPM_OK;
}

/* The image at the pass's wavelengths: linear between its own, held beyond; and its mean over all directions, each row
 * weighing what it covers. */
static cpm_status prepare_image(cpm_pass *pass, size_t number, cpm_sky *s) {
    const light *l = &pass->scene->lights[number];
    const size_t bins = pass->bins, from = l->emission.count, width = (size_t)l->width, height = (size_t)l->height;
    double *mean = &pass->emission[number * bins];
    s->data.kind = CPM_SKY_IMAGE;
    s->data.width = l->width, s->data.height = l->height, s->data.bins = (int32_t)bins;
    s->pixels = malloc(width * height * bins * sizeof *s->pixels);
    if (!s->pixels)
        return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an environment of %d x %d pixels",
                        l->width, l->height);
    for (size_t b = 0; b < bins; b++) {
        const double *w = l->emission.wavelengths;
        size_t i = 0;
        while (i + 2 < from && w[i + 1] < pass->wavelengths[b]) i++;
        const size_t j = i + 1 < from ? i + 1 : i;
        double share = j > i ? (pass->wavelengths[b] - w[i]) / (w[j] - w[i]) : 0.0, whole = 0.0;
        share = cpm_min(cpm_max(share, 0.0), 1.0);
        for (size_t r = 0; r < height; r++) {
            double sum = 0.0, top = CPM_PI * (double)r / (double)height,
                   bottom = CPM_PI * (double)(r + 1) / (double)height;
            for (size_t c = 0; c < width; c++) {
                const float *pixel = &l->pixels[(r * width + c) * from];
                double value = (1.0 - share) * (double)pixel[i] + share * (double)pixel[j];
                s->pixels[(r * width + c) * bins + b] = (float)value;
                sum += value;
            }
            whole += sum / (double)width * 0.5 * (cos(top) - cos(bottom));
        }
        mean[b] = whole;
    }
    return CPM_OK;
}

cpm_status cpm_sky_begin(cpm_pass *pass) {
    const cpm_scene *scene = pass->scene;
    pass->sky = calloc(scene->light_count, sizeof *pass->sky);
    if (!pass->sky) return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a sky");
    cpm_status status = CPM_OK;
    for (size_t i = 0; i < scene->light_count && !status; i++) {
        const light *l = &scene->lights[i];
        cpm_sky *s = &pass->sky[i];
        if (!cpm_light_is_far(l)) continue;
        const cpm_vec east = cpm_cross(l->north, l->axis);
        memcpy(s->data.axis, (const double[3]){l->axis.x, l->axis.y, l->axis.z}, sizeof s->data.axis);
        memcpy(s->data.north, (const double[3]){l->north.x, l->north.y, l->north.z}, sizeof s->data.north);
        memcpy(s->data.east, (const double[3]){east.x, east.y, east.z}, sizeof s->data.east);
        s->data.kind = CPM_SKY_EVEN;
        if (l->kind == CPM_LIGHT_SUN)
            status = prepare_sun(pass, l, s);
        else if (l->pixels)
            status = prepare_image(pass, i, s);
    }
    return status;
}

void cpm_sky_end(cpm_pass *pass) {
    for (size_t i = 0; pass->sky && i < pass->scene->light_count; i++)
        free(pass->sky[i].limb), free(pass->sky[i].pixels);
    free(pass->sky);
    pass->sky = NULL;
}

int cpm_sky_radiance(const cpm_pass *pass, size_t number, cpm_vec d, size_t first, size_t count, double *radiance) {
    const cpm_sky *s = &pass->sky[number];
    const double *emission = &pass->emission[number * pass->bins + first];
    if (s->data.kind == CPM_SKY_SUN) {
        const double mu = cpm_sun_mu(&s->data, d.x, d.y, d.z);
        if (mu < 0.0) return 0;
        for (size_t b = 0; b < count; b++)
            radiance[b] = emission[b] * cpm_max(cpm_sun_limb(&s->limb[(first + b) * CPM_LIMB], mu), 0.0);
    } else if (s->data.kind == CPM_SKY_IMAGE) {
        cpm_i64 at[4];
        double share[4];
        cpm_sky_place(&s->data, d.x, d.y, d.z, at, share);
        for (size_t b = 0; b < count; b++) radiance[b] = cpm_sky_pixel(s->pixels, at, share, (cpm_i32)(first + b));
    } else if (s->data.kind == CPM_SKY_EVEN) {
        memcpy(radiance, emission, count * sizeof *radiance);
    } else {
        return 0;
    }
    return 1;
}
