/* scene/scene.c: a scene's life, its media, lights and camera. Shapes are in shape.c. */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "medium/method.h"

#define RADIANS (3.14159265358979323846 / 180.0)

int cpm_grow(void **array, size_t *capacity, size_t count, size_t more, size_t element) {
    if (count + more <= *capacity) return 1;
    size_t wanted = *capacity ? 2 * *capacity : 8;
    if (wanted < count + more) wanted = count + more;
    if (wanted > SIZE_MAX / element) return 0;
    void *grown = realloc(*array, wanted * element);
    if (!grown) return 0;
    *array = grown;
    *capacity = wanted;
    return 1;
}

static int finite3(const double *v) { return cpm_in_range(v[0]) && cpm_in_range(v[1]) && cpm_in_range(v[2]); }

static cpm_status take_extent(cpm_context *context, const cpm_box *box) {
    for (int k = 0; k < 3; k++)
        if (!(box->low[k] < box->high[k]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "extent: low[%d] is %g and high[%d] is %g; low must be "
                            "less than high", k, box->low[k], k, box->high[k]);
    return CPM_OK;
}

cpm_status cpm_scene_create(cpm_context *context, const cpm_scene_options *options, cpm_scene **scene) {
    if (scene) *scene = NULL;
    if (!context || !scene)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "context and scene must not be NULL");
    cpm_scene_options o = {.struct_size = sizeof o};
    if (options) CPM_TAKE(o, options);
    if (o.extent) {
        cpm_status status = take_extent(context, o.extent);
        if (status) return status;
    }
    if (o.method < CPM_METHOD_AUTO || o.method > CPM_METHOD_LAST)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "method is %d; allowed: %d to %d (cpm_method)", o.method,
                        CPM_METHOD_AUTO, CPM_METHOD_LAST);
    if (o.rtol != 0.0 && !(o.rtol >= 1e-14 && o.rtol <= 1.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "rtol is %g; allowed: 1e-14 to 1", o.rtol);
    if (!(o.atol >= 0.0) || !(o.max_step >= 0.0) || !(o.step >= 0.0) || isinf(o.step) || !isfinite(o.atol))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "atol %g, step %g, max_step %g: none may be negative or NaN, "
                        "nor atol or step infinite",
                        o.atol, o.step, o.max_step);
    if (cpm_method_needs_step(o.method) && !(o.step > 0.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "method %s has fixed steps: step must be positive, metres",
                        cpm_method_text(o.method));
    cpm_scene *s = calloc(1, sizeof *s);
    if (!s) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a scene");
    atomic_init(&s->references, 1);
    pthread_mutex_init(&s->lock, NULL);
    s->context = context;
    cpm_context_retain(context);
    s->options = o;
    if (o.extent) s->extent = *o.extent, s->has_extent = 1;
    s->options.extent = NULL;
    cpm_medium *medium = o.medium;
    cpm_status status = CPM_OK;
    if (medium) cpm_medium_retain(medium);
    else status = cpm_medium_create_homogeneous(context, 1.0, NULL, &medium);
    if (!status && !cpm_grow((void **)&s->media, &s->medium_capacity, 0, 1, sizeof *s->media)) {
        cpm_medium_release(medium);
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a scene");
    }
    if (status) {
        cpm_scene_release(s);
        return status;
    }
    s->media[0].medium = medium;
    s->media[0].shape = -1;
    s->media[0].also = 0;
    s->medium_count = 1;
    if (o.method == CPM_METHOD_EXACT && !cpm_medium_has_exact(medium)) {
        cpm_scene_release(s);
        return cpm_fail(context, CPM_ERROR_UNSUPPORTED, "method exact: the scene's medium has no closed form of the path");
    }
    *scene = s;
    return CPM_OK;
}

void cpm_scene_retain(cpm_scene *scene) {
    if (scene) atomic_fetch_add(&scene->references, 1);
}

void cpm_scene_release(cpm_scene *scene) {
    if (!scene || atomic_fetch_sub(&scene->references, 1) != 1) return;
    cpm_geometry_free(scene->geometry);
    for (size_t i = 0; i < scene->material_count; i++) cpm_spectrum_free(&scene->materials[i].reflectance);
    for (size_t i = 0; i < scene->medium_count; i++) cpm_medium_release(scene->media[i].medium);
    for (size_t i = 0; i < scene->light_count; i++) cpm_light_free(&scene->lights[i]);
    free(scene->triangles), free(scene->spheres), free(scene->normals);
    free(scene->triangle_shape), free(scene->sphere_shape);
    free(scene->shapes), free(scene->materials), free(scene->media), free(scene->lights);
    pthread_mutex_destroy(&scene->lock);
    cpm_context_release(scene->context);
    free(scene);
}

void cpm_scene_changed(cpm_scene *scene) {
    cpm_geometry_free(scene->geometry);
    scene->geometry = NULL;
}

cpm_status cpm_scene_prepare(cpm_context *context, cpm_scene *scene, int straight, int curved) {
    cpm_status status = CPM_OK;
    pthread_mutex_lock(&scene->lock);
    if (!scene->geometry)
        status = cpm_geometry_create(context, scene->triangles, scene->triangle_count, scene->spheres,
                                     scene->sphere_count, &scene->geometry);
    if (!status) status = cpm_geometry_prepare(context, scene->geometry, straight, curved);
    pthread_mutex_unlock(&scene->lock);
    return status;
}

/* Makes a shape the bounds of a medium, last in the list. Takes a reference. */
static cpm_status push_medium(cpm_scene *s, cpm_medium *medium, int32_t shape_index) {
    if (s->medium_count >= 65535)
        return cpm_fail(s->context, CPM_ERROR_INVALID_ARGUMENT, "a scene holds at most 65534 bounded media");
    if (!cpm_grow((void **)&s->media, &s->medium_capacity, s->medium_count, 1, sizeof *s->media))
        return cpm_fail(s->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a medium");
    cpm_medium_retain(medium);
    s->media[s->medium_count].medium = medium;
    s->media[s->medium_count].shape = shape_index;
    s->media[s->medium_count].also = s->shapes[shape_index].medium;
    s->shapes[shape_index].medium = (int32_t)s->medium_count++;
    return CPM_OK;
}

cpm_status cpm_scene_fill_shape(cpm_scene *scene, cpm_medium *medium, int32_t shape);
cpm_status cpm_scene_fill_shape(cpm_scene *scene, cpm_medium *medium, int32_t shape) {
    cpm_status status = cpm_shape_require_closed(scene, shape);
    return status ? status : push_medium(scene, medium, shape);
}

cpm_status cpm_scene_add_medium(cpm_scene *scene, cpm_medium *medium, const cpm_bounds *bounds, int32_t *index) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_context *context = scene->context;
    if (!medium || !bounds)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium and bounds must not be NULL");
    if (scene->options.method == CPM_METHOD_EXACT && !cpm_medium_has_exact(medium))
        return cpm_fail(context, CPM_ERROR_UNSUPPORTED, "method exact: a bounded medium has no closed form of the path");
    cpm_bounds b;
    CPM_TAKE(b, bounds);
    int32_t shape_index = -1;
    cpm_status status;
    char name[64];
    snprintf(name, sizeof name, "bounds of medium %zu", scene->medium_count);
    if (b.kind == CPM_BOUNDS_BOX) {
        for (int k = 0; k < 3; k++)
            if (!(b.box.low[k] < b.box.high[k]) || !cpm_in_range(b.box.low[k]) || !cpm_in_range(b.box.high[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                                "bounds: low[%d] is %g and high[%d] is %g; both finite, low less than high", k,
                                b.box.low[k], k, b.box.high[k]);
        status = cpm_scene_add_box(scene, &b.box, name, &shape_index);
    } else if (b.kind == CPM_BOUNDS_SPHERE) {
        status = cpm_scene_add_sphere(scene, b.center, b.radius, NULL, name, &shape_index);
    } else if (b.kind == CPM_BOUNDS_SHAPE) {
        if (b.shape < 0 || (size_t)b.shape >= scene->shape_count)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "bounds: shape is %d; the scene has %zu shapes", b.shape,
                            scene->shape_count);
        shape_index = b.shape;
        status = cpm_shape_require_closed(scene, shape_index);
    } else {
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "bounds: kind is %d; allowed: box 1, sphere 2, shape 3", b.kind);
    }
    if (!status) status = push_medium(scene, medium, shape_index);
    if (!status && index) *index = (int32_t)scene->medium_count - 1;
    if (!status) cpm_scene_changed(scene);
    return status;
}

cpm_status cpm_scene_add_light(cpm_scene *scene, const cpm_light_desc *desc, int32_t *index) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_context *context = scene->context;
    if (!desc) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "light must not be NULL");
    cpm_light_desc d;
    CPM_TAKE(d, desc);
    light l = {.kind = d.kind, .shape = -1};
    l.position = cpm_v(d.position[0], d.position[1], d.position[2]);
    if (d.kind == CPM_LIGHT_AREA) {
        if (d.shape < 0 || (size_t)d.shape >= scene->shape_count)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "area light: shape is %d; the scene has %zu shapes",
                            d.shape, scene->shape_count);
        if (scene->shapes[d.shape].light >= 0)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "area light: shape '%s' is a light already",
                            scene->shapes[d.shape].name);
        if (scene->shapes[d.shape].material == CPM_NO_MATERIAL)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "area light: '%s' only bounds a medium",
                            scene->shapes[d.shape].name);
        l.shape = d.shape;
    } else if (d.kind == CPM_LIGHT_POINT || d.kind == CPM_LIGHT_SPOT) {
        if (!finite3(d.position))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "light: position is (%g, %g, %g); it must be finite",
                            d.position[0], d.position[1], d.position[2]);
    } else if (d.kind == CPM_LIGHT_SUN || d.kind == CPM_LIGHT_ENVIRONMENT) {
        cpm_status status = cpm_light_take_far(context, &d, &l);
        if (status) return status;
    } else {
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "light: kind is %d; allowed: point 1, spot 2, area 3, sun 4, environment 5", d.kind);
    }
    if (d.kind == CPM_LIGHT_SPOT) {
        cpm_vec axis = cpm_sub(cpm_v(d.target[0], d.target[1], d.target[2]), l.position);
        if (!finite3(d.target) || !(cpm_vdot(axis, axis) > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "spot: target is (%g, %g, %g); it must be finite and not the position", d.target[0],
                            d.target[1], d.target[2]);
        if (!(d.cutoff > 0.0 && d.cutoff <= 180.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "spot: cutoff is %g degrees; allowed: above 0, to 180",
                            d.cutoff);
        l.axis = cpm_unit(axis);
        l.cutoff = d.cutoff * RADIANS;
    } else if (!cpm_light_is_far(&l)) {
        l.axis = cpm_v(0.0, 0.0, 1.0);
        l.cutoff = 180.0 * RADIANS;
    }
    cpm_status status = CPM_OK;
    if (!l.pixels) status = cpm_spectrum_copy(context, &d.emission, "light: emission", 0.0, 1e300, &l.emission);
    if (status) {
        cpm_light_free(&l);
        return status;
    }
    if (!cpm_grow((void **)&scene->lights, &scene->light_capacity, scene->light_count, 1, sizeof l)) {
        cpm_light_free(&l);
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a light");
    }
    if (l.shape >= 0) scene->shapes[l.shape].light = (int32_t)scene->light_count;
    if (index) *index = (int32_t)scene->light_count;
    scene->lights[scene->light_count++] = l;
    return CPM_OK;
}

cpm_status cpm_scene_set_camera(cpm_scene *scene, const cpm_camera *camera) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_context *context = scene->context;
    if (!camera) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera must not be NULL");
    cpm_camera c;
    CPM_TAKE(c, camera);
    if (!finite3(c.origin) || !finite3(c.target) || !finite3(c.up))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera: origin, target and up must be finite");
    cpm_vec forward = cpm_v(c.target[0] - c.origin[0], c.target[1] - c.origin[1], c.target[2] - c.origin[2]);
    cpm_vec right = cpm_cross(forward, cpm_v(c.up[0], c.up[1], c.up[2]));
    double size = cpm_norm(forward) * cpm_norm(cpm_v(c.up[0], c.up[1], c.up[2]));
    if (!(size > 0.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera: target must differ from origin, and up from zero");
    if (!(cpm_norm(right) > 1e-9 * size))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera: up (%g, %g, %g) lies along the line of sight",
                        c.up[0], c.up[1], c.up[2]);
    if (!(c.fov > 0.0 && c.fov < 180.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera: fov is %g degrees; allowed: between 0 and 180", c.fov);
    scene->camera = c;
    scene->has_camera = 1;
    return CPM_OK;
}
