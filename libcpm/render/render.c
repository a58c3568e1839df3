/* render/render.c: the paper's algorithm, in order:
 * inspect the scene -> project -> emit -> trace -> store -> build map -> eye rays -> gather -> film. */
#include <math.h>
#include <string.h>

#include "backend/backend.h"

static cpm_status check_options(cpm_context *context, const cpm_scene *scene, const cpm_render_options *o) {
    if (!scene->has_camera)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "the scene has no camera; set one before rendering");
    if (o->nearest < 2 || o->nearest > 1000000)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "nearest is %d; allowed: 2 to 1000000", o->nearest);
    if (o->samples < 1 || o->samples > 1 << 20)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "samples is %d; allowed: 1 to 1048576", o->samples);
    if (o->photons > 0xFFFFFFFFu)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "photons is %llu; allowed: 0 to 4294967295",
                        (unsigned long long)o->photons);
    if (isnan(o->max_radius)) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "max_radius is NaN");
    if (o->batch < 0 || o->batch > 1 << 20)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "batch is %d; allowed: 0 to 1048576", o->batch);
    return CPM_OK;
}

/* The second half: a picture from maps that exist. */
static cpm_status gather_picture(const cpm_pass *pass, const cpm_photons *photons, const cpm_render_options *o,
                                 cpm_image *image) {
    cpm_context *context = pass->context;
    cpm_gather gather;
    double start = cpm_seconds();
    image->stats = photons->stats;
    const cpm_geometry *geometry = o->no_edge_correction ? NULL : pass->geometry;
    cpm_status status = CPM_OK;
    if (geometry) status = cpm_scene_prepare(context, pass->scene, 1, 0);
    if (!status) status = cpm_gather_begin(context, photons, geometry, o->nearest, o->max_radius, &gather);
    if (!status) status = cpm_backend_of(context)->eye(pass, &gather, o->seed, o->samples, image);
    image->stats.seconds_gather = cpm_seconds() - start;
    return status;
}

cpm_status cpm_image_render(cpm_context *context, cpm_scene *scene, const cpm_render_options *options,
                            cpm_image **image) {
    if (image) *image = NULL;
    if (!context || !scene || !options || !image)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "context, scene, options and image must not be NULL");
    double start = cpm_seconds();
    cpm_render_options o;
    CPM_TAKE(o, options);
    cpm_image *film = NULL;
    cpm_photons *photons = NULL;
    cpm_pass pass;
    cpm_status status = cpm_check_wavelengths(context, o.wavelengths, o.wavelength_count);
    if (!status) status = check_options(context, scene, &o);
    if (!status) status = cpm_image_new(context, o.width, o.height, o.wavelengths, o.wavelength_count, &film);
    if (status) return status;

    cpm_progress_begin(context);
    status = cpm_pass_begin(context, scene, o.wavelengths, o.wavelength_count, &pass);
    double prepared = cpm_seconds() - start;
    if (!status) {
        status = cpm_pass_take_bundles(&pass, o.bundle_tolerance, o.nearest);
        const cpm_photons_options p = {.struct_size = sizeof p,
                                       .photons = o.photons,
                                       .seed = o.seed,
                                       .no_projection = o.no_projection,
                                       .batch = o.batch};
        if (!status) status = cpm_photons_run(&pass, &p, &photons);
        if (!status) status = gather_picture(&pass, photons, &o, film);
        cpm_pass_end(&pass);
    }
    cpm_photons_release(photons);
    film->stats.seconds_prepare = prepared;
    film->stats.seconds_total = cpm_seconds() - start;
    if (status)
        cpm_image_release(film);
    else
        *image = film;
    return status;
}

cpm_status cpm_image_gather(cpm_context *context, cpm_scene *scene, cpm_photons *photons,
                            const cpm_render_options *options, cpm_image **image) {
    if (image) *image = NULL;
    if (!context || !scene || !photons || !options || !image)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "context, scene, photons, options and image must not be NULL");
    double start = cpm_seconds();
    cpm_render_options o;
    CPM_TAKE(o, options);
    cpm_image *film = NULL;
    cpm_pass pass;
    cpm_status status = check_options(context, scene, &o);
    if (!status) status = cpm_image_new(context, o.width, o.height, photons->wavelengths, photons->bins, &film);
    if (status) return status;
    cpm_progress_begin(context);
    status = cpm_pass_begin(context, scene, photons->wavelengths, photons->bins, &pass);
    if (!status) {
        status = cpm_pass_take_bundles(&pass, o.bundle_tolerance, o.nearest);
        if (!status) status = gather_picture(&pass, photons, &o, film);
        cpm_pass_end(&pass);
    }
    film->stats.seconds_total += cpm_seconds() - start;
    if (status)
        cpm_image_release(film);
    else
        *image = film;
    return status;
}
