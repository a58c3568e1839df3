/* scene/pass.c: inspects a scene once; its features decide what is built and what runs. */
#include "pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "medium/method.h"
#include "world.h"

#define NUDGE 1e-9 /* of the scene's size */
#define MOST_TOLERANCE 100.0 /* of bundles, in pixels */

cpm_status cpm_check_wavelengths(cpm_context *context, const double *wavelengths, size_t count) {
    if (!wavelengths || !count || count > CPM_MAX_BINS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%zu wavelengths; allowed: 1 to %d",
                        wavelengths ? count : 0, CPM_MAX_BINS);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(wavelengths[i]) || !(wavelengths[i] > 0.0) || (i && !(wavelengths[i] > wavelengths[i - 1])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "wavelength %zu is %g nm; allowed: positive, increasing", i, wavelengths[i]);
    return CPM_OK;
}

static void grow_box(cpm_box *box, const double *point) {
    for (int k = 0; k < 3; k++) box->low[k] = fmin(box->low[k], point[k]), box->high[k] = fmax(box->high[k], point[k]);
}

/* The scene's own extent, or the box of everything in it grown on each side by its diagonal. */
static void find_extent(cpm_pass *pass) {
    const cpm_scene *scene = pass->scene;
    cpm_box box = pass->box = cpm_geometry_box(scene->geometry);
    double diagonal2 = 0.0;
    for (int k = 0; k < 3; k++)
        if (box.high[k] > box.low[k]) diagonal2 += (box.high[k] - box.low[k]) * (box.high[k] - box.low[k]);
    pass->reach = diagonal2 > 0.0 ? sqrt(diagonal2) : 1.0;
    if (diagonal2 > 0.0)
        pass->center =
            cpm_v(0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1]), 0.5 * (box.low[2] + box.high[2]));
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].shape < 0 && !cpm_light_is_far(&scene->lights[i])) {
            cpm_vec p = scene->lights[i].position;
            grow_box(&box, (const double[3]){p.x, p.y, p.z});
        }
    if (scene->has_camera) grow_box(&box, scene->camera.origin);
    double all2 = 0.0;
    for (int k = 0; k < 3; k++)
        if (box.high[k] > box.low[k]) all2 += (box.high[k] - box.low[k]) * (box.high[k] - box.low[k]);
    double diagonal = all2 > 0.0 ? sqrt(all2) : 1.0;
    pass->nudge = NUDGE * pass->reach;
    pass->bounded = 1;
    if (scene->has_extent) {
        pass->extent = scene->extent;
        return;
    }
    for (int k = 0; k < 3; k++) {
        if (box.low[k] > box.high[k]) box.low[k] = box.high[k] = 0.0;
        pass->extent.low[k] = box.low[k] - diagonal;
        pass->extent.high[k] = box.high[k] + diagonal;
    }
    if (pass->features & CPM_FEATURE_CURVED) return;
    pass->bounded = 0;
    for (int k = 0; k < 3; k++) pass->extent.low[k] = -INFINITY, pass->extent.high[k] = INFINITY;
}

static int32_t method_of(const cpm_scene_options *o, const cpm_medium *medium) {
    return cpm_medium_needs_exact(medium) ? CPM_METHOD_EXACT
                                          : cpm_method_in(medium, o->method, o->exclude, o->step);
}

static cpm_way way_of(int32_t method, const cpm_medium *medium) {
    if (cpm_medium_is_uniform(medium)) return CPM_WAY_STRAIGHT;
    return method == CPM_METHOD_EXACT ? CPM_WAY_EXACT : CPM_WAY_INTEGRATED;
}

static cpm_status look_at_media(cpm_pass *pass) {
    const cpm_scene *scene = pass->scene;
    for (size_t m = 0; m < scene->medium_count; m++) {
        const cpm_medium *medium = scene->media[m].medium;
        double *scale = &pass->scale[m * pass->bins];
        pass->method[m] = (uint8_t)method_of(&pass->options, medium);
        if (pass->method[m] == CPM_METHOD_AUTO)
            return cpm_fail(pass->context, CPM_ERROR_INVALID_ARGUMENT,
                            "exclude is 0x%x; no method is left for medium %zu", (unsigned)pass->options.exclude, m);
        pass->way[m] = (uint8_t)way_of(pass->method[m], medium);
        for (size_t b = 0; b < pass->bins; b++) {
            cpm_status status = cpm_medium_scale(pass->context, medium, pass->wavelengths[b], &scale[b]);
            if (status) return status;
            if (scale[b] != scale[0]) pass->disperses[m] = 1;
            if (pass->way[m] == CPM_WAY_STRAIGHT)
                pass->index[m * pass->bins + b] = cpm_medium_n(medium, scale[b], (const double[3]){0.0, 0.0, 0.0});
        }
        if (pass->way[m] != CPM_WAY_STRAIGHT) pass->features |= CPM_FEATURE_CURVED;
        if (pass->way[m] == CPM_WAY_EXACT) pass->features |= CPM_FEATURE_EXACT;
        if (pass->way[m] == CPM_WAY_INTEGRATED) pass->features |= CPM_FEATURE_INTEGRATOR;
        if (pass->disperses[m]) pass->features |= CPM_FEATURE_DISPERSION;
    }
    for (size_t m = 0; m < scene->medium_count; m++)
        if (scene->media[m].medium->extinction) pass->features |= CPM_FEATURE_EXTINCTION;
    if (pass->features & CPM_FEATURE_EXTINCTION) {
        pass->extinction = calloc(scene->medium_count * pass->bins, sizeof *pass->extinction);
        if (!pass->extinction) return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for extinctions");
        for (size_t i = 0; i < scene->medium_count * pass->bins; i++)
            pass->extinction[i] =
                cpm_medium_extinction(scene->media[i / pass->bins].medium, pass->wavelengths[i % pass->bins]);
    }
    if (scene->medium_count > 1) pass->features |= CPM_FEATURE_BOUNDARIES | CPM_FEATURE_SPECULAR;
    return CPM_OK;
}

static void look_at_surfaces(cpm_pass *pass) {
    const cpm_scene *scene = pass->scene;
    for (size_t m = 0; m < scene->material_count; m++) {
        const material *from = &scene->materials[m];
        if (from->kind == CPM_MATERIAL_MIRROR) pass->features |= CPM_FEATURE_SPECULAR;
        for (size_t b = 0; b < pass->bins; b++) {
            float r = (float)cpm_spectrum_at(&from->reflectance, pass->wavelengths[b]);
            pass->reflectance[m * pass->bins + b] = r;
            pass->reflectance_max[m] = fmaxf(pass->reflectance_max[m], r);
        }
    }
    for (size_t l = 0; l < scene->light_count; l++) {
        const int area = scene->lights[l].kind == CPM_LIGHT_AREA, far = cpm_light_is_far(&scene->lights[l]);
        pass->features |= far    ? CPM_FEATURE_SKY
                          : area ? CPM_FEATURE_AREA_LIGHTS
                                 : CPM_FEATURE_DELTA_LIGHTS | CPM_FEATURE_PROJECTION;
        for (size_t b = 0; b < pass->bins; b++)
            pass->emission[l * pass->bins + b] = cpm_spectrum_at(&scene->lights[l].emission, pass->wavelengths[b]);
    }
    if (scene->sphere_count) pass->features |= CPM_FEATURE_SPHERES;
    if (scene->triangle_count) pass->features |= CPM_FEATURE_MESHES;
    if (scene->normals) pass->features |= CPM_FEATURE_SHADING_NORMALS;
}

cpm_status cpm_pass_begin(cpm_context *context, cpm_scene *scene, const double *wavelengths, size_t bins,
                          cpm_pass *pass) {
    return cpm_pass_begin_with(context, scene, &scene->options, wavelengths, bins, pass);
}

cpm_status cpm_pass_begin_with(cpm_context *context, cpm_scene *scene, const cpm_scene_options *options,
                               const double *wavelengths, size_t bins, cpm_pass *pass) {
    memset(pass, 0, sizeof *pass);
    pass->options = *options;
    pass->context = context;
    pass->scene = scene;
    pass->bins = bins;
    pass->middle = (int32_t)(bins / 2);
    size_t media = scene->medium_count, materials = scene->material_count + 1, lights = scene->light_count + 1;
    pass->wavelengths = malloc(bins * sizeof(double));
    pass->reflectance = calloc(materials * bins, sizeof(float));
    pass->reflectance_max = calloc(materials, sizeof(float));
    pass->scale = calloc(media * bins, sizeof(double));
    pass->index = calloc(media * bins, sizeof(double));
    pass->disperses = calloc(media, 1);
    pass->way = calloc(media, 1);
    pass->method = calloc(media, 1);
    pass->emission = calloc(lights * bins, sizeof(double));
    cpm_status status = CPM_OK;
    if (!pass->wavelengths || !pass->reflectance || !pass->reflectance_max || !pass->scale || !pass->index ||
        !pass->disperses || !pass->way || !pass->method || !pass->emission)
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a pass over %zu wavelengths", bins);
    if (!status) {
        memcpy(pass->wavelengths, wavelengths, bins * sizeof(double));
        status = look_at_media(pass);
    }
    if (!status) {
        look_at_surfaces(pass);
        int curved = (pass->features & CPM_FEATURE_CURVED) != 0, straight = 0;
        for (size_t m = 0; m < media; m++) straight |= pass->way[m] == CPM_WAY_STRAIGHT;
        status = cpm_scene_prepare(context, scene, straight, curved);
    }
    if (!status && (pass->features & CPM_FEATURE_SKY)) status = cpm_sky_begin(pass);
    if (!status) {
        pass->geometry = scene->geometry;
        find_extent(pass);
        if (!cpm_world_begin(pass)) status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a pass");
    }
    if (status) cpm_pass_end(pass);
    return status;
}

cpm_status cpm_pass_take_bundles(cpm_pass *pass, double tolerance, int32_t nearest) {
    if (!(tolerance >= 0.0 && tolerance <= MOST_TOLERANCE))
        return cpm_fail(pass->context, CPM_ERROR_INVALID_ARGUMENT, "bundle_tolerance is %g; allowed: 0 to %g",
                        tolerance, MOST_TOLERANCE);
    pass->bundle_tolerance = pass->context->opencl ? 0.0 : tolerance; /* on a device each wavelength goes its own way */
    pass->nearest = nearest;
    return CPM_OK;
}

void cpm_pass_end(cpm_pass *pass) {
    cpm_sky_end(pass);
    free(pass->extinction);
    cpm_world_end(pass);
    free(pass->wavelengths), free(pass->reflectance), free(pass->reflectance_max), free(pass->scale);
    free(pass->index), free(pass->disperses), free(pass->way), free(pass->method), free(pass->emission);
    memset(pass, 0, sizeof *pass);
}

double cpm_pass_index(const cpm_pass *pass, int32_t medium, int32_t bin, cpm_vec point) {
    size_t at = (size_t)medium * pass->bins + cpm_pass_bin(pass, bin);
    if (pass->way[medium] == CPM_WAY_STRAIGHT) return pass->index[at];
    return cpm_medium_n(pass->scene->media[medium].medium, pass->scale[at],
                        (const double[3]){point.x, point.y, point.z});
}

cpm_status cpm_scene_features(cpm_scene *scene, const double *wavelengths, size_t count, uint32_t *features) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    if (!features) return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "features must not be NULL");
    cpm_status status = cpm_check_wavelengths(scene->context, wavelengths, count);
    cpm_pass pass;
    if (!status) status = cpm_pass_begin(scene->context, scene, wavelengths, count, &pass);
    if (status) return status;
    *features = pass.features;
    cpm_pass_end(&pass);
    return CPM_OK;
}

cpm_status cpm_scene_extent(cpm_scene *scene, cpm_box *extent) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    if (!extent) return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "extent must not be NULL");
    cpm_pass pass = {.scene = scene, .context = scene->context};
    for (size_t m = 0; m < scene->medium_count; m++)
        if (!cpm_medium_is_uniform(scene->media[m].medium)) pass.features |= CPM_FEATURE_CURVED;
    cpm_status status = cpm_scene_prepare(scene->context, scene, 0, 0);
    if (status) return status;
    find_extent(&pass);
    *extent = pass.extent;
    return CPM_OK;
}
