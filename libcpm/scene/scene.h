/* scene/scene.h: a scene's inside: what was added, and what a pass makes of it. */
#ifndef CPM_SCENE_SCENE_H
#define CPM_SCENE_SCENE_H
#include <pthread.h>
#include <stdatomic.h>

#include "api/context.h"
#include "cl/types/flight.h"
#include "geometry/geometry.h"
#include "medium/medium.h"

#define CPM_NO_MATERIAL (-1)
#define CPM_LARGEST 1e15 /* metres; beyond, squares leave the range of float, in which Embree works */

/* A sampled function of wavelength, owned. */
typedef struct spectrum {
    double *wavelengths, *values; /* one block; wavelengths NULL: flat */
    size_t count;
} spectrum;
cpm_status cpm_spectrum_copy(cpm_context *context, const cpm_spectrum *from, const char *what, double low, double high,
                             spectrum *to);
double cpm_spectrum_at(const spectrum *s, double wavelength);
void cpm_spectrum_free(spectrum *s);

typedef struct material {
    int32_t kind; /* cpm_material_kind */
    spectrum reflectance;
} material;

typedef struct shape {
    char name[64];
    int32_t material; /* index, or CPM_NO_MATERIAL: only the bounds of a medium */
    int32_t medium;   /* index in media of the last that it bounds (media[].also: the others), 0: none */
    int32_t light;    /* index of the area light that it is, -1: none */
    int32_t is_sphere;
    size_t first, count; /* triangles, or the one sphere */
    int32_t has_normals;
    int32_t closed; /* -1: not looked at yet */
    double area;
    cpm_box box;
} shape;

typedef struct bounded_medium {
    cpm_medium *medium;
    int32_t shape; /* what bounds it; -1 for the medium that fills space (index 0) */
    int32_t also;  /* another medium that the same shape bounds, 0: none */
} bounded_medium;

typedef struct light {
    int32_t kind; /* cpm_light_kind */
    int32_t shape;
    cpm_vec position, axis; /* axis of a sun: towards it; of an environment: up */
    double cutoff;          /* radians; of a sun: its angular radius */
    spectrum emission;
    cpm_vec north; /* environment: the middle of its image */
    float *pixels; /* height x width x emission.count, NULL: none */
    int32_t width, height;
    double *limb; /* limb_count x CPM_LIMB_ROW, NULL: none */
    size_t limb_count;
    cpm_box aim;
    int32_t has_aim;
} light;

static inline int cpm_light_is_far(const light *l) {
    return l->kind == CPM_LIGHT_SUN || l->kind == CPM_LIGHT_ENVIRONMENT;
}
/* sky_light.c: takes what a sun or an environment brings, checked. */
#define CPM_LIMB_ROW 7 /* wavelength, a0 ... a5 */
cpm_status cpm_light_take_far(cpm_context *context, const cpm_light_desc *desc, light *to);
void cpm_light_free(light *l);

struct cpm_scene {
    atomic_int references;
    cpm_context *context;
    cpm_scene_options options;
    int32_t has_extent;
    cpm_box extent;
    cpm_triangle *triangles;
    cpm_sphere *spheres;
    float *normals; /* 9 a triangle, allocated when a mesh brings some */
    int32_t *triangle_shape;
    int32_t *sphere_shape;
    size_t triangle_count, triangle_capacity, sphere_count, sphere_capacity;
    shape *shapes;
    size_t shape_count, shape_capacity;
    material *materials;
    size_t material_count, material_capacity;
    bounded_medium *media; /* [0] fills space */
    size_t medium_count, medium_capacity;
    light *lights;
    size_t light_count, light_capacity;
    cpm_camera camera;
    int32_t has_camera;

    pthread_mutex_t lock; /* guards what follows, made when first needed, dropped when something is added */
    cpm_geometry *geometry;
};

/* Finite, and not beyond CPM_LARGEST. */
static inline int cpm_in_range(double coordinate) { return coordinate >= -CPM_LARGEST && coordinate <= CPM_LARGEST; }

/* Grows an array by one element, doubling; 0 on failure. */
int cpm_grow(void **array, size_t *capacity, size_t count, size_t more, size_t element);

/* Something was added: what was built is stale. */
void cpm_scene_changed(cpm_scene *scene);
/* The geometry, built for straight and curved queries as asked. */
cpm_status cpm_scene_prepare(cpm_context *context, cpm_scene *scene, int straight, int curved);

/* Adds a material; fails with the shape's name in the message. */
cpm_status cpm_scene_add_material(cpm_scene *scene, const cpm_material *from, const char *name, int32_t *index);
/* A box's 12 triangles, normals outward, without material. */
cpm_status cpm_scene_add_box(cpm_scene *scene, const cpm_box *box, const char *name, int32_t *shape);
/* Checks that a mesh is closed and oriented outward; the message names it. */
cpm_status cpm_shape_require_closed(cpm_scene *scene, int32_t shape);

static inline int32_t cpm_primitive_shape(const cpm_scene *scene, int32_t primitive) {
    return (size_t)primitive < scene->triangle_count ? scene->triangle_shape[primitive]
                                                     : scene->sphere_shape[(size_t)primitive - scene->triangle_count];
}
/* Unit geometric normal, (b - a) x (c - a) for triangles, outward for spheres. */
cpm_vec cpm_geometric_normal(const cpm_scene *scene, const cpm_hit *hit);
/* Interpolated shading normal where the mesh has them, else the geometric one; on the geometric normal's side. */
cpm_vec cpm_shading_normal(const cpm_scene *scene, const cpm_hit *hit, cpm_vec geometric);
#endif
