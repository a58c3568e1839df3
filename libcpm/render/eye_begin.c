/* render/eye_begin.c: the camera, and how surfaces look, as tables (cl/types/eye.h): for either backend. */
#include <math.h>
#include <stdlib.h>

#include "cl/shared/sampling.h"
#include "eye.h"

static void keep(double to[3], cpm_vec v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

static cpm_vec set_camera(const cpm_camera *c, const cpm_image *image, cpm_eye_frame *is) {
    const cpm_vec origin = cpm_v(c->origin[0], c->origin[1], c->origin[2]);
    const cpm_vec forward = cpm_unit(cpm_sub(cpm_v(c->target[0], c->target[1], c->target[2]), origin));
    const double half = tan(c->fov * (CPM_PI / 360.0));
    const cpm_vec right = cpm_unit(cpm_cross(forward, cpm_unit(cpm_v(c->up[0], c->up[1], c->up[2]))));
    keep(is->origin, origin), keep(is->forward, forward);
    keep(is->right, cpm_scaled(half, right));
    keep(is->up, cpm_scaled(half * image->height / image->width, cpm_cross(right, forward)));
    return forward;
}

cpm_status cpm_eye_begin(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                         const cpm_image *image, cpm_eye_tables *tables) {
    const cpm_scene *scene = pass->scene;
    cpm_eye *eye = &tables->eye;
    cpm_eye_frame *is = &eye->is;
    *is = (cpm_eye_frame){.seed = seed,
                          .width = image->width,
                          .height = image->height,
                          .samples = samples,
                          .bins = (int32_t)pass->bins,
                          .corrected = gather->geometry != NULL};
    const cpm_vec forward = set_camera(&scene->camera, image, is),
                  origin = cpm_v(is->origin[0], is->origin[1], is->origin[2]);
    is->region = cpm_region_at(pass, origin, forward);
    const int32_t medium = cpm_region_medium(&is->region);
    is->splits = pass->disperses[medium] && !cpm_pass_bundles(pass);
    tables->shape_light = NULL;
    for (size_t b = 0; b < pass->bins; b++) {
        const double n = cpm_pass_index(pass, medium, (int32_t)b, origin);
        if (!(n > 0.0))
            return cpm_fail(pass->context, CPM_ERROR_INVALID_ARGUMENT, "camera: n^2 is not positive at its origin");
        tables->squared_index[b] = n * n;
    }
    tables->shape_light = malloc((scene->shape_count + 1) * sizeof *tables->shape_light);
    if (!tables->shape_light) return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass");
    for (size_t i = 0; i < scene->shape_count; i++) tables->shape_light[i] = scene->shapes[i].light;
    eye->shape_light = tables->shape_light;
    eye->reflectance = pass->reflectance, eye->reflectance_max = pass->reflectance_max;
    eye->emission = pass->emission;
    eye->squared_index = tables->squared_index;
    return CPM_OK;
}

void cpm_eye_end(cpm_eye_tables *tables) { free(tables->shape_light); }
