/* geometry/bvh.h: the tree of cl/types/tree.h, built by Embree. */
#ifndef CPM_GEOMETRY_BVH_H
#define CPM_GEOMETRY_BVH_H
#include <stddef.h>

#include "cl/types/tree.h"

/* What a primitive gives to the tree. */
typedef struct cpm_bvh_leaf {
    float box[6]; /* low x, y, z, high x, y, z */
    float face[CPM_FACE_ROWS];
} cpm_bvh_leaf;

/* Nodes, the root first, 64-byte aligned, for free(). NULL with `why` set (a text that lasts): no memory, or Embree
 * fails. */
cpm_tree_node *cpm_bvh_build(void *embree_device, const cpm_bvh_leaf *leaves, size_t count, size_t *node_count,
                             const char **why);
#endif
