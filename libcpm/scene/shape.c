/* scene/shape.c: meshes, spheres and boxes: what is taken in, what is refused, and their normals. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/shade.h"
#include "scene.h"

cpm_status cpm_scene_fill_shape(cpm_scene *scene, cpm_medium *medium, int32_t shape);

static cpm_status no_memory(cpm_scene *scene, const char *name) {
    return cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for shape '%s'", name);
}

cpm_status cpm_scene_add_material(cpm_scene *scene, const cpm_material *from, const char *name, int32_t *index) {
    *index = CPM_NO_MATERIAL;
    cpm_material m;
    CPM_TAKE(m, from);
    char what[128];
    if (m.kind < CPM_MATERIAL_BLACK || m.kind > CPM_MATERIAL_DIELECTRIC)
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT,
                        "shape '%s': material kind is %d; allowed: black 0, diffuse 1, mirror 2, dielectric 3", name,
                        m.kind);
    if (m.kind == CPM_MATERIAL_DIELECTRIC && !m.interior)
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "shape '%s': a dielectric needs an interior medium",
                        name);
    if (m.kind == CPM_MATERIAL_DIELECTRIC && scene->options.method == CPM_METHOD_EXACT &&
        !cpm_medium_has_exact(m.interior))
        return cpm_fail(scene->context, CPM_ERROR_UNSUPPORTED,
                        "method exact: the interior of shape '%s' has no closed form of the path", name);
    material taken = {.kind = m.kind};
    snprintf(what, sizeof what, "shape '%s': reflectance", name);
    if (m.kind == CPM_MATERIAL_DIFFUSE || m.kind == CPM_MATERIAL_MIRROR) {
        cpm_status status = cpm_spectrum_copy(scene->context, &m.reflectance, what, 0.0, 1.0, &taken.reflectance);
        if (status) return status;
    }
    if (!cpm_grow((void **)&scene->materials, &scene->material_capacity, scene->material_count, 1, sizeof taken)) {
        cpm_spectrum_free(&taken.reflectance);
        return no_memory(scene, name);
    }
    *index = (int32_t)scene->material_count;
    scene->materials[scene->material_count++] = taken;
    return CPM_OK;
}

static cpm_status push_shape(cpm_scene *scene, const shape *s, int32_t *index) {
    if (!cpm_grow((void **)&scene->shapes, &scene->shape_capacity, scene->shape_count, 1, sizeof *s))
        return no_memory(scene, s->name);
    *index = (int32_t)scene->shape_count;
    scene->shapes[scene->shape_count++] = *s;
    cpm_scene_changed(scene);
    return CPM_OK;
}

static shape new_shape(const char *name, size_t number) {
    shape s = {.material = CPM_NO_MATERIAL, .light = -1, .closed = -1};
    if (name && *name)
        snprintf(s.name, sizeof s.name, "%s", name);
    else
        snprintf(s.name, sizeof s.name, "shape %zu", number);
    for (int k = 0; k < 3; k++) s.box.low[k] = INFINITY, s.box.high[k] = -INFINITY;
    return s;
}

/* A shape is taken back as if it had never been added. */
static void pop_shape(cpm_scene *scene, const shape *s) {
    scene->shape_count--;
    if (s->is_sphere)
        scene->sphere_count -= s->count;
    else
        scene->triangle_count -= s->count;
    if (s->material != CPM_NO_MATERIAL) cpm_spectrum_free(&scene->materials[--scene->material_count].reflectance);
}

static cpm_status finish_shape(cpm_scene *scene, const shape *s, const cpm_material *given, int32_t *index) {
    cpm_status status = push_shape(scene, s, index);
    if (status || s->material == CPM_NO_MATERIAL || scene->materials[s->material].kind != CPM_MATERIAL_DIELECTRIC)
        return status;
    cpm_material m;
    CPM_TAKE(m, given);
    status = cpm_scene_fill_shape(scene, m.interior, *index);
    if (status) pop_shape(scene, s);
    return status;
}

static int reserve_triangles(cpm_scene *scene, size_t more) {
    size_t capacity = scene->triangle_capacity, shape_capacity = capacity;
    if (!cpm_grow((void **)&scene->triangles, &capacity, scene->triangle_count, more, sizeof(cpm_triangle))) return 0;
    if (!cpm_grow((void **)&scene->triangle_shape, &shape_capacity, scene->triangle_count, more, sizeof(int32_t)))
        return 0;
    if (scene->normals) {
        float *grown = realloc(scene->normals, capacity * 9 * sizeof(float));
        if (!grown) return 0;
        scene->normals = grown;
    }
    scene->triangle_capacity = capacity;
    return 1;
}

static cpm_triangle triangle_of(const double *a, const double *b, const double *c) {
    cpm_triangle t = {0};
    for (int k = 0; k < 3; k++) t.corner[k] = a[k], t.edge1[k] = b[k] - a[k], t.edge2[k] = c[k] - a[k];
    return t;
}

/* Appends; returns 0 for a degenerate triangle, which is dropped. */
static int append_triangle(cpm_scene *scene, shape *s, const double *a, const double *b, const double *c, double size) {
    cpm_triangle t = triangle_of(a, b, c);
    if (!cpm_triangle_complete(&t, size)) return 0;
    scene->triangles[scene->triangle_count] = t;
    scene->triangle_shape[scene->triangle_count] = (int32_t)scene->shape_count;
    scene->triangle_count++;
    s->count++;
    s->area += 0.5 / sqrt(t.inverse_area2);
    for (int k = 0; k < 3; k++) {
        s->box.low[k] = fmin(s->box.low[k], fmin(a[k], fmin(b[k], c[k])));
        s->box.high[k] = fmax(s->box.high[k], fmax(a[k], fmax(b[k], c[k])));
    }
    return 1;
}

static cpm_status check_mesh(cpm_scene *scene, const cpm_mesh_desc *d, const char *name, double *size) {
    cpm_context *context = scene->context;
    if (!d->vertices || !d->faces || !d->vertex_count || !d->face_count)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "mesh '%s': %zu vertices and %zu faces; at least 3 and 1 are needed", name, d->vertex_count,
                        d->face_count);
    for (size_t i = 0; i < d->vertex_count; i++) {
        const double *v = (const double *)(const void *)((const char *)d->vertices + (ptrdiff_t)i * d->vertex_stride);
        for (int k = 0; k < 3; k++) {
            if (!cpm_in_range(v[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                                "mesh '%s': vertex %zu has coordinate %g; all must "
                                "be finite, at most 1e15 m",
                                name, i, v[k]);
            *size = fmax(*size, fabs(v[k]));
        }
    }
    for (size_t i = 0; i < d->face_count; i++) {
        const uint32_t *f = (const uint32_t *)(const void *)((const char *)d->faces + (ptrdiff_t)i * d->face_stride);
        for (int k = 0; k < 3; k++)
            if (f[k] >= d->vertex_count)
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                                "mesh '%s': face %zu names vertex %u; there are %zu", name, i, f[k], d->vertex_count);
    }
    for (size_t i = 0; d->normals && i < 3 * d->vertex_count; i++)
        if (!isfinite(d->normals[i]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "mesh '%s': normal %zu has coordinate %g; all must be "
                            "finite",
                            name, i / 3, d->normals[i]);
    if (scene->triangle_count + d->face_count > 0x7FFFFFFF)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "mesh '%s': more than 2^31 triangles in all", name);
    return CPM_OK;
}

cpm_status cpm_scene_add_mesh(cpm_scene *scene, const cpm_mesh_desc *desc, int32_t *index) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    if (!desc || !desc->material)
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "mesh and its material must not be NULL");
    cpm_mesh_desc d;
    CPM_TAKE(d, desc);
    if (!d.vertex_stride) d.vertex_stride = 24;
    if (!d.face_stride) d.face_stride = 12;
    shape s = new_shape(d.name, scene->shape_count);
    double size = 0.0;
    cpm_status status = check_mesh(scene, &d, s.name, &size);
    if (status) return status;
    s.first = scene->triangle_count;
    if (d.normals && !scene->normals) {
        scene->normals = calloc(scene->triangle_capacity + 1, 9 * sizeof(float));
        if (!scene->normals) return no_memory(scene, s.name);
    }
    if (!reserve_triangles(scene, d.face_count)) return no_memory(scene, s.name);
    s.has_normals = d.normals != NULL;
    for (size_t i = 0; i < d.face_count; i++) {
        const uint32_t *f = (const uint32_t *)(const void *)((const char *)d.faces + (ptrdiff_t)i * d.face_stride);
        const double *v[3];
        for (int k = 0; k < 3; k++)
            v[k] = (const double *)(const void *)((const char *)d.vertices + (ptrdiff_t)f[k] * d.vertex_stride);
        if (append_triangle(scene, &s, v[0], v[1], v[2], size) && d.normals)
            for (size_t k = 0; k < 9; k++)
                scene->normals[9 * (scene->triangle_count - 1) + k] = (float)d.normals[3 * f[k / 3] + k % 3];
    }
    if (!s.count)
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "mesh '%s': all %zu triangles have area 0", s.name,
                        d.face_count);
    status = cpm_scene_add_material(scene, d.material, s.name, &s.material);
    if (!status) status = finish_shape(scene, &s, d.material, index ? index : &(int32_t){0});
    if (status && scene->triangle_count > s.first) scene->triangle_count = s.first;
    return status;
}

cpm_status cpm_scene_add_sphere(cpm_scene *scene, const double *center, double radius, const cpm_material *given,
                                const char *name, int32_t *index) {
    if (!scene) return CPM_ERROR_INVALID_ARGUMENT;
    if (!center) return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "sphere: center must not be NULL");
    shape s = new_shape(name, scene->shape_count);
    if (!cpm_in_range(center[0]) || !cpm_in_range(center[1]) || !cpm_in_range(center[2]))
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT,
                        "sphere '%s': center is (%g, %g, %g); it must be finite, at "
                        "most 1e15 m",
                        s.name, center[0], center[1], center[2]);
    if (!(radius > 0.0) || !cpm_in_range(radius))
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT,
                        "sphere '%s': radius is %g; it must be positive, at most 1e15 m", s.name, radius);
    size_t capacity = scene->sphere_capacity, shape_capacity = capacity;
    if (!cpm_grow((void **)&scene->spheres, &capacity, scene->sphere_count, 1, sizeof(cpm_sphere)) ||
        !cpm_grow((void **)&scene->sphere_shape, &shape_capacity, scene->sphere_count, 1, sizeof(int32_t)))
        return no_memory(scene, s.name);
    scene->sphere_capacity = capacity;
    if (given) {
        cpm_status status = cpm_scene_add_material(scene, given, s.name, &s.material);
        if (status) return status;
    }
    s.is_sphere = 1, s.closed = 1, s.first = scene->sphere_count, s.count = 1;
    s.area = 4.0 * 3.14159265358979323846 * radius * radius;
    for (int k = 0; k < 3; k++) s.box.low[k] = center[k] - radius, s.box.high[k] = center[k] + radius;
    cpm_sphere *ball = &scene->spheres[scene->sphere_count];
    memcpy(ball->center, center, sizeof ball->center);
    ball->radius = radius;
    scene->sphere_shape[scene->sphere_count++] = (int32_t)scene->shape_count;
    return finish_shape(scene, &s, given, index ? index : &(int32_t){0});
}

cpm_status cpm_scene_add_box(cpm_scene *scene, const cpm_box *box, const char *name, int32_t *index) {
    static const unsigned char faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                               {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    double corners[8][3], size = 0.0;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) {
            corners[i][k] = (i >> k) & 1 ? box->high[k] : box->low[k];
            size = fmax(size, fabs(corners[i][k]));
        }
    shape s = new_shape(name, scene->shape_count);
    s.first = scene->triangle_count;
    s.closed = 1;
    if (!reserve_triangles(scene, 12)) return no_memory(scene, name);
    for (int i = 0; i < 12; i++)
        append_triangle(scene, &s, corners[faces[i][0]], corners[faces[i][1]], corners[faces[i][2]], size);
    if (s.count != 12) {
        scene->triangle_count = s.first;
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT, "%s: the box is too flat to have faces", name);
    }
    return push_shape(scene, &s, index);
}

cpm_vec cpm_geometric_normal(const cpm_scene *scene, const cpm_hit *hit) {
    if ((size_t)hit->primitive < scene->triangle_count) {
        const cpm_triangle *t = &scene->triangles[hit->primitive];
        return cpm_scaled(sqrt(t->inverse_area2), cpm_v(t->normal[0], t->normal[1], t->normal[2]));
    }
    const double *c = scene->spheres[(size_t)hit->primitive - scene->triangle_count].center;
    return cpm_unit(cpm_sub(hit->position, cpm_v(c[0], c[1], c[2])));
}

cpm_vec cpm_shading_normal(const cpm_scene *scene, const cpm_hit *hit, cpm_vec geometric) {
    if (!scene->normals || (size_t)hit->primitive >= scene->triangle_count ||
        !scene->shapes[scene->triangle_shape[hit->primitive]].has_normals)
        return geometric;
    const float *n = &scene->normals[9 * (size_t)hit->primitive];
    cpm_vec corner[3];
    for (int k = 0; k < 3; k++) corner[k] = cpm_v((double)n[3 * k], (double)n[3 * k + 1], (double)n[3 * k + 2]);
    return shade_normal(corner[0], corner[1], corner[2], hit->u, hit->v, geometric);
}
