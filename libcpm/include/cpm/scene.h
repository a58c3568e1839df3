/* cpm/scene.h: shapes, materials, bounded media, lights and a camera in a medium that fills space.
 *
 * A scene is built by add and set calls from one thread, then used by any number of them. Spectra are functions of
 * wavelength: linear between samples, held beyond, taken at the bin centres of a render. */
#ifndef CPM_SCENE_H
#define CPM_SCENE_H
#include "medium.h"
#include "ray.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cpm_scene cpm_scene;

typedef struct cpm_spectrum {
    const double *wavelengths; /* nm, strictly increasing; NULL: flat, values[0] */
    const double *values;      /* NULL: flat 0 */
    size_t count;
} cpm_spectrum;

typedef struct cpm_box {
    double low[3], high[3];
} cpm_box;

typedef struct cpm_scene_options {
    size_t struct_size;
    cpm_medium *medium;    /* fills everything; NULL: homogeneous, n = 1 */
    const cpm_box *extent; /* a ray that crosses it outward has LEFT; NULL: shapes, lights and camera grown on each side
                              by their diagonal, infinite where everything is homogeneous */
    int32_t method;        /* cpm_method of curved paths; CPM_METHOD_AUTO */
    uint32_t exclude;      /* bit 1 << method: keeps AUTO from it */
    double rtol, atol;     /* 0, 0: the method's default */
    double max_step;       /* metres; 0: none */
    double step;           /* metres, fixed steps; 0: adaptive */
} cpm_scene_options;

CPM_API cpm_status cpm_scene_create(cpm_context *context, const cpm_scene_options *options, cpm_scene **scene);
CPM_API void cpm_scene_retain(cpm_scene *scene);
CPM_API void cpm_scene_release(cpm_scene *scene);

typedef enum cpm_material_kind {
    CPM_MATERIAL_BLACK = 0,
    CPM_MATERIAL_DIFFUSE = 1,
    CPM_MATERIAL_MIRROR = 2,
    CPM_MATERIAL_DIELECTRIC = 3
} cpm_material_kind;

typedef struct cpm_material {
    size_t struct_size;
    int32_t kind; /* cpm_material_kind */
    int32_t reserved;
    cpm_spectrum reflectance; /* diffuse, mirror: in [0, 1] */
    cpm_medium *interior;     /* dielectric: what the closed shape is filled with */
} cpm_material;

typedef struct cpm_mesh_desc {
    size_t struct_size;
    const double *vertices; /* vertex_count x 3, metres */
    size_t vertex_count;
    ptrdiff_t vertex_stride; /* bytes; 0: 24 */
    const uint32_t *faces;   /* face_count x 3 */
    size_t face_count;
    ptrdiff_t face_stride;   /* bytes; 0: 12 */
    const double *normals;   /* vertex_count x 3 shading normals, or NULL; contiguous */
    const cpm_material *material;
    const char *name;        /* used in messages; may be NULL */
} cpm_mesh_desc;

/* Degenerate triangles (area 0) are dropped; NaN or infinite vertices and indices out of range are refused. A
 * dielectric mesh must be closed and consistently oriented. */
CPM_API cpm_status cpm_scene_add_mesh(cpm_scene *scene, const cpm_mesh_desc *desc, int32_t *shape);
CPM_API cpm_status cpm_scene_add_sphere(cpm_scene *scene, const double *center, double radius,
                                        const cpm_material *material, const char *name, int32_t *shape);

typedef enum cpm_bounds_kind {
    CPM_BOUNDS_BOX = 1,
    CPM_BOUNDS_SPHERE = 2,
    CPM_BOUNDS_SHAPE = 3
} cpm_bounds_kind;

typedef struct cpm_bounds {
    size_t struct_size;
    int32_t kind;  /* cpm_bounds_kind */
    int32_t shape; /* kind SHAPE: a closed shape of this scene */
    cpm_box box;
    double center[3];
    double radius;
} cpm_bounds;

/* Where several media contain a point the last one added wins. `index` (may be NULL) counts from 1. */
CPM_API cpm_status cpm_scene_add_medium(cpm_scene *scene, cpm_medium *medium, const cpm_bounds *bounds,
                                        int32_t *index);

typedef enum cpm_light_kind {
    CPM_LIGHT_POINT = 1,
    CPM_LIGHT_SPOT = 2,
    CPM_LIGHT_AREA = 3,
    CPM_LIGHT_SUN = 4,
    CPM_LIGHT_ENVIRONMENT = 5
} cpm_light_kind;

/* Sun and environment are infinitely far away: a ray that crosses the scene's extent outward sees them by its direction
 * there, and their photons come in there. */

typedef struct cpm_light_desc {
    size_t struct_size;
    int32_t kind;  /* cpm_light_kind */
    int32_t shape; /* area: a shape of this scene, emitting on the side of its geometric normal */
    double position[3];
    double target[3];      /* spot: where it is aimed; sun: the direction in which its centre is seen; environment with
                              pixels: the direction of the image's middle column, across `up` */
    double cutoff;         /* spot: half-angle, degrees, in (0, 180], uniform inside; sun: angular radius, degrees, in
                              (0, 90), 0: 0.2666 */
    cpm_spectrum emission; /* point, spot: actual W/sr/nm; area, sun, environment: basic radiance W/m2/sr/nm, of the sun
                              the mean over its disc (irradiance over solid angle) */
    double up[3];          /* environment with pixels: the direction of row 0 */
    const float *pixels;   /* environment: basic radiance, height x width x emission.count (emission.wavelengths; its
                              values NULL); equal steps of angle, row 0 about `up`, columns clockwise seen from above;
                              NULL: `emission` from everywhere */
    int32_t width, height; /* of the pixels */
    const double *limb;    /* sun: limb_count x 7: wavelength (nm, increasing) and coefficients a0 ... a5 of the limb
                              darkening sum a_i mu^i; linear between, held beyond; NULL: none */
    size_t limb_count;
    const cpm_box *aim;    /* sun, environment: photons start only on paths that cross this box first; NULL: all shapes
                              (of a planet what is within 25 km of the camera) */
} cpm_light_desc;
CPM_API cpm_status cpm_scene_add_light(cpm_scene *scene, const cpm_light_desc *desc, int32_t *light);

typedef struct cpm_camera {
    size_t struct_size;
    double origin[3], target[3], up[3];
    double fov; /* horizontal, degrees, in (0, 180) */
} cpm_camera;
CPM_API cpm_status cpm_scene_set_camera(cpm_scene *scene, const cpm_camera *camera);

/* The extent: the scene's own, or what is chosen for what it holds now. Infinite where nothing bends. */
CPM_API cpm_status cpm_scene_extent(cpm_scene *scene, cpm_box *extent);

/* What the scene needs, found by inspection; what is not set is not built, not run and not stored. */
#define CPM_FEATURE_CURVED (1u << 0)        /* some medium bends rays */
#define CPM_FEATURE_EXACT (1u << 1)         /* some bent paths are closed forms */
#define CPM_FEATURE_INTEGRATOR (1u << 2)    /* some bent paths are integrated */
#define CPM_FEATURE_DISPERSION (1u << 3)    /* bundles split */
#define CPM_FEATURE_SPECULAR (1u << 4)      /* mirrors or index jumps: caustic map, its projection map */
#define CPM_FEATURE_BOUNDARIES (1u << 5)    /* bounded media or dielectrics */
#define CPM_FEATURE_SPHERES (1u << 6)
#define CPM_FEATURE_MESHES (1u << 7)
#define CPM_FEATURE_SHADING_NORMALS (1u << 8)
#define CPM_FEATURE_AREA_LIGHTS (1u << 9)
#define CPM_FEATURE_PROJECTION (1u << 10)   /* point or spot lights: projection maps over their directions */
#define CPM_FEATURE_DELTA_LIGHTS (1u << 11)
#define CPM_FEATURE_SKY (1u << 12)          /* a sun or an environment */
#define CPM_FEATURE_EXTINCTION (1u << 13)   /* some medium dims light */
CPM_API cpm_status cpm_scene_features(cpm_scene *scene, const double *wavelengths, size_t count, uint32_t *features);

#ifdef __cplusplus
}
#endif
#endif
