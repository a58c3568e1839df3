/* geometry/parts.h: what the files of this folder share. */
#ifndef CPM_GEOMETRY_PARTS_H
#define CPM_GEOMETRY_PARTS_H
#include "backend/native/isa.h"
#include "bvh.h"
#include "geometry.h"

#define ULP 1.2e-7     /* of a float, relative */
#define START_ULPS 8.0 /* a straight float ray starts this many ulp of the scene away */

#define CPM_FEW 64 /* primitives: up to so many, asking all of them is faster than a tree */

struct RTCDeviceTy;
struct RTCSceneTy;

/* curve.c: cpm_geometry_curve and cpm_geometry_curves, for an instruction set. */
typedef struct cpm_curve_code {
    void (*first_hit)(const cpm_tree *tree, const cpm_curve *curve, double theta_end, int32_t left, double slack,
                      const cpm_filter *filter, cpm_hit *hit);
    /* `few`: what each primitive gave to the tree, where they are at most CPM_FEW; else NULL */
    void (*first_hits)(const cpm_tree *tree, const cpm_bvh_leaf *few, const cpm_curve *curves, const double *from,
                       const int32_t *left, size_t count, cpm_hit *hits);
} cpm_curve_code;

struct cpm_geometry {
    size_t triangle_count, sphere_count;
    cpm_box box;
    cpm_vec center; /* subtracted before anything becomes float */
    cpm_tree tree;  /* for curves; no nodes until prepared */
    size_t node_count;
    cpm_bvh_leaf *few; /* see cpm_curve_code */
    struct RTCDeviceTy *device;
    struct RTCSceneTy *straight; /* Embree's, NULL until prepared */
    const cpm_curve_code *curve_code;
};

/* The box of a primitive, before any rounding. */
void cpm_primitive_box(const cpm_geometry *geometry, size_t primitive, double low[3], double high[3]);
/* straight.c */
cpm_status cpm_straight_build(cpm_context *context, cpm_geometry *geometry);
#endif
