/* geometry/bvh.h: an eight-wide bounding volume hierarchy, built by Embree, walked by curve_walk.h.
 *
 * Embree's own scenes know straight rays only; a curve asks for boxes, and triangles, that grow by how far it bends.
 * All is float, in units of the scene: (position - center) unit, so that neither a nanometre nor the Earth is a special
 * case. */
#ifndef CPM_GEOMETRY_BVH_H
#define CPM_GEOMETRY_BVH_H
#include <stddef.h>
#include <stdint.h>

#define CPM_BVH_WIDTH 8
#define CPM_BVH_DEPTH 64 /* Embree's limit is 32, and large leaves add a few */

/* Three affine functions of a point, slopes x, y, z and the value at 0: distance from the triangle's plane, barycentric
 * u and v. What is no triangle has functions that let everything pass. */
enum { CPM_FACE_PLANE = 0, CPM_FACE_U = 4, CPM_FACE_V = 8, CPM_FACE_ROWS = 12 };

typedef struct cpm_bvh_node {
    float box[6][CPM_BVH_WIDTH]; /* low x, y, z, high x, y, z of each child; an empty child's low is above its high */
    float face[CPM_FACE_ROWS][CPM_BVH_WIDTH];
    int32_t child[CPM_BVH_WIDTH]; /* a node, or ~primitive */
    uint32_t leaves;              /* bits: which children are primitives */
    uint32_t unused[7];
} cpm_bvh_node;

typedef struct cpm_bvh {
    cpm_bvh_node *nodes; /* the root first; 64-byte aligned */
    size_t count;
} cpm_bvh;

/* What a primitive gives to the tree. */
typedef struct cpm_bvh_leaf {
    float box[6]; /* low x, y, z, high x, y, z */
    float face[CPM_FACE_ROWS];
} cpm_bvh_leaf;

/* Returns 0 with `why` set (a text that lasts) where there is no memory or Embree fails. */
int cpm_bvh_build(void *embree_device, const cpm_bvh_leaf *leaves, size_t count, cpm_bvh *bvh, const char **why);
void cpm_bvh_free(cpm_bvh *bvh);
#endif
