/* types/tree.h: an eight-wide bounding volume hierarchy over primitives, built on the host by Embree's rtcBuildBVH,
 * walked by shared/walk.h on both sides.
 *
 * A curve asks for boxes, and triangles, that grow by how far it bends. All is float, in units of the scene: (position
 * - center) unit, so that neither a nanometre nor the Earth is a special case. */
#ifndef CPM_TYPES_TREE_H
#define CPM_TYPES_TREE_H
#include "../shared/vec.h"
#include "geometry.h"

#define CPM_TREE_WIDTH 8
#define CPM_TREE_DEPTH 64 /* Embree's limit is 32, and large leaves add a few */

/* Three affine functions of a point, slopes x, y, z and the value at 0: distance from the triangle's plane, barycentric
 * u and v. What is no triangle has functions that let everything pass. */
#define CPM_FACE_PLANE 0
#define CPM_FACE_U 4
#define CPM_FACE_V 8
#define CPM_FACE_ROWS 12

typedef struct cpm_tree_node {
    float box[6][CPM_TREE_WIDTH]; /* low x, y, z, high x, y, z of each child; an empty child's low is above its high */
    float face[CPM_FACE_ROWS][CPM_TREE_WIDTH];
    cpm_i32 child[CPM_TREE_WIDTH]; /* a node, or ~primitive */
    cpm_u32 leaves;                /* bits: which children are primitives */
    cpm_u32 unused[7];
} cpm_tree_node;
CPM_STATIC_ASSERT(sizeof(cpm_tree_node) == 640, cpm_tree_node_size);
CPM_ASSERT_OFFSET(cpm_tree_node, child, 576);

/* What the walk needs beside the nodes and primitives. Lengths in metres. */
typedef struct cpm_tree_frame {
    double center[3];                     /* of the tree's units */
    double unit;                          /* 1/scale */
    double scale;                         /* largest |coordinate - center| of the primitives' box */
    double sagitta;                       /* a chord that strays farther from its curve is cut */
    double low[3], high[3];               /* the primitives' box */
    cpm_i32 triangle_count, sphere_count; /* numbered triangles first */
    cpm_i64 padding;
} cpm_tree_frame;
CPM_STATIC_ASSERT(sizeof(cpm_tree_frame) == 112, cpm_tree_frame_size);

typedef struct cpm_tree {
    CPM_GLOBAL const cpm_tree_node *nodes; /* the root first; NULL: nothing to meet */
    CPM_GLOBAL const cpm_triangle *triangles;
    CPM_GLOBAL const cpm_sphere *spheres;
    cpm_tree_frame frame;
} cpm_tree;

typedef struct cpm_hit {
    cpm_i32 primitive; /* -1: none */
    cpm_i32 padding;
    double t;         /* straight: distance; curve: theta */
    double u, v;      /* barycentric */
    cpm_vec position; /* on the ray, metres */
} cpm_hit;
CPM_STATIC_ASSERT(sizeof(cpm_hit) == 56, cpm_hit_size);
#endif
