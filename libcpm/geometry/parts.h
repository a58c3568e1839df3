/* geometry/parts.h: what the files of this folder share. */
#ifndef CPM_GEOMETRY_PARTS_H
#define CPM_GEOMETRY_PARTS_H
#include "embree.h"
#include "geometry.h"

#define ULP 1.2e-7      /* of a float, relative */
#define START_ULPS 8.0  /* a straight float ray starts this many ulp of the scene away */

struct cpm_geometry {
    const cpm_triangle *triangles;
    const cpm_sphere *spheres;
    size_t triangle_count, sphere_count;
    cpm_box box;
    cpm_vec center;  /* subtracted before anything becomes float */
    double scale;    /* largest |coordinate - center| of the box */
    double sagitta;
    RTCDevice device;
    RTCScene straight, curved;
};

/* The box of a primitive, before any rounding. */
void cpm_primitive_box(const cpm_geometry *geometry, size_t primitive, double low[3], double high[3]);
/* straight.c */
cpm_status cpm_straight_build(cpm_context *context, cpm_geometry *geometry);
/* The part [enter, leave] of o + t d inside the box grown by `grow`; 0: none. */
int cpm_clip_to_box(const cpm_geometry *geometry, cpm_vec o, cpm_vec d, double grow, double *enter, double *leave);
#endif
