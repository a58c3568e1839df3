/* types/world.h: a scene at given wavelengths as its rays see it: what libcpm/scene/pass.c has looked up, as tables.
 *
 * On the host the pointers are the scene's own arrays; on a device they are buffers, and each kernel puts them together
 * (shared/world.h). */
#ifndef CPM_TYPES_WORLD_H
#define CPM_TYPES_WORLD_H
#include "flight.h"
#include "medium.h"

/* How rays run in a medium. */
#define CPM_STRAIGHT_WAY 0
#define CPM_EXACT_WAY 1
#define CPM_INTEGRATED_WAY 2

/* What a shape's surface is: cpm_material_kind, or nothing but the bounds of a medium. */
#define CPM_SURFACE_BLACK 0
#define CPM_SURFACE_DIFFUSE 1
#define CPM_SURFACE_MIRROR 2
#define CPM_SURFACE_DIELECTRIC 3
#define CPM_SURFACE_NONE 4

typedef struct cpm_place { /* a medium of the scene, beside its cpm_medium_data */
    cpm_i32 way;           /* CPM_..._WAY */
    cpm_i32 method;        /* CPM_STEP_ that runs */
    cpm_i32 also;          /* another medium that the same shape bounds, 0: none */
    cpm_i32 disperses;     /* n differs between the bins */
    /* what bounds it (not the one that fills space): a sphere, or `count` triangles, and their box */
    cpm_i32 is_sphere, first, count, padding;
    double low[3], high[3];
} cpm_place;
CPM_STATIC_ASSERT(sizeof(cpm_place) == 80, cpm_place_size);

typedef struct cpm_surface { /* of a shape */
    cpm_i32 kind;            /* CPM_SURFACE_ */
    cpm_i32 material;        /* row of the reflectances; -1: none */
    cpm_i32 medium;          /* the last medium that it bounds (cpm_place.also: the others), 0: none */
    cpm_i32 has_normals;     /* shading normals */
} cpm_surface;

typedef struct cpm_world_frame {
    double low[3], high[3];         /* the extent: a ray that crosses it outward has left */
    double box_low[3], box_high[3]; /* of the geometry */
    double center[3];               /* of the geometry: pieces that start far from it may be as long as that is far */
    double reach;                   /* a good length of one curved piece, metres: the geometry's diagonal */
    cpm_i32 bins, middle;           /* the bin that stands for a whole bundle where nothing disperses */
    cpm_i32 bounded;                /* the extent is finite */
    cpm_i32 coarse;                 /* float is too coarse for this geometry: straight rays are all asked exactly */
    double nudge;                   /* metres: far below the geometry, far above rounding */
    cpm_i32 media, padding;         /* how many */
} cpm_world_frame;
CPM_STATIC_ASSERT(sizeof(cpm_world_frame) == 160, cpm_world_frame_size);

struct cpm_geometry; /* the host's */

typedef struct cpm_world {
    cpm_tree tree;
    cpm_world_frame frame;
    CPM_GLOBAL const cpm_medium_data *media;
    cpm_tables tables; /* of the media */
    CPM_GLOBAL const cpm_place *places;
    CPM_GLOBAL const double *scale;           /* media x bins: dispersion factor */
    CPM_GLOBAL const double *index;           /* media x bins: n of uniform media */
    CPM_GLOBAL const cpm_i32 *triangle_shape; /* of each primitive */
    CPM_GLOBAL const cpm_i32 *sphere_shape;
    CPM_GLOBAL const cpm_surface *surfaces; /* of each shape */
    CPM_GLOBAL const float *normals;        /* 9 a triangle, where any shape has them */
    const struct cpm_geometry *geometry;    /* host only */
} cpm_world;

/* What a query asks of a primitive met at or about its start: would passing it change what contains the ray? */
typedef struct cpm_filter {
    const cpm_world *world;
    const cpm_region *region;
} cpm_filter;
#endif
