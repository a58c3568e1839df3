/* geometry/parts.h: what the files of this folder share. */
#ifndef CPM_GEOMETRY_PARTS_H
#define CPM_GEOMETRY_PARTS_H
#include "backend/native/isa.h"
#include "bvh.h"
#include "geometry.h"

#define ULP 1.2e-7     /* of a float, relative */
#define START_ULPS 8.0 /* a straight float ray starts this many ulp of the scene away */

struct RTCDeviceTy;
struct RTCSceneTy;

/* curve.c: cpm_geometry_curve and cpm_geometry_curves, for an instruction set. */
typedef struct cpm_curve_code {
    void (*first_hit)(const cpm_geometry *geometry, const cpm_curve *curve, double theta_end, int32_t left,
                      double slack, const cpm_filter *filter, cpm_hit *hit);
    void (*first_hits)(const cpm_geometry *geometry, const cpm_curve *curves, const double *from, const int32_t *left,
                       size_t count, cpm_hit *hits);
} cpm_curve_code;

struct cpm_geometry {
    const cpm_triangle *triangles;
    const cpm_sphere *spheres;
    size_t triangle_count, sphere_count;
    cpm_box box;
    cpm_vec center; /* subtracted before anything becomes float */
    double scale;   /* largest |coordinate - center| of the box */
    double unit;    /* 1/scale: positions in the tree are (r - center) unit */
    double sagitta; /* a chord that strays farther from its curve is cut */
    struct RTCDeviceTy *device;
    struct RTCSceneTy *straight; /* Embree's, NULL until prepared */
    cpm_bvh curved;              /* no nodes until prepared */
    const cpm_curve_code *curve_code;
};

/* The box of a primitive, before any rounding. */
void cpm_primitive_box(const cpm_geometry *geometry, size_t primitive, double low[3], double high[3]);
/* straight.c */
cpm_status cpm_straight_build(cpm_context *context, cpm_geometry *geometry);
/* The part [enter, leave] of o + t d inside the box grown by `grow`; 0: none. */
int cpm_clip_to_box(const cpm_geometry *geometry, cpm_vec o, cpm_vec d, double grow, double *enter, double *leave);
#endif
