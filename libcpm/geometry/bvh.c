/* geometry/bvh.c: Embree's builder, and its tree laid out depth first in one array. */
#include "bvh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "embree.h"

/* What the builder makes: Embree allocates, and frees all of it with the RTCBVH. */
typedef struct tree_node {
    int32_t primitive; /* a leaf's; -1: inner */
    uint32_t count;
    struct tree_node *child[CPM_BVH_WIDTH];
    struct RTCBounds bounds[CPM_BVH_WIDTH];
} tree_node;

static void *create_node(RTCThreadLocalAllocator allocator, unsigned count, void *user) {
    (void)user;
    tree_node *node = rtcThreadLocalAlloc(allocator, sizeof *node, 16);
    node->primitive = -1;
    node->count = count;
    return node;
}

static void set_children(void *to, void **children, unsigned count, void *user) {
    (void)user;
    for (unsigned i = 0; i < count; i++) ((tree_node *)to)->child[i] = children[i];
}

static void set_bounds(void *to, const struct RTCBounds **bounds, unsigned count, void *user) {
    (void)user;
    for (unsigned i = 0; i < count; i++) ((tree_node *)to)->bounds[i] = *bounds[i];
}

/* One primitive a leaf: its box is then tested beside its siblings' before it is. */
static void *create_leaf(RTCThreadLocalAllocator allocator, const struct RTCBuildPrimitive *primitives, size_t count,
                         void *user) {
    (void)user, (void)count;
    tree_node *leaf = rtcThreadLocalAlloc(allocator, offsetof(tree_node, child), 16);
    leaf->primitive = (int32_t)primitives[0].primID;
    leaf->count = 0;
    return leaf;
}

static size_t inner_nodes(const tree_node *node, int depth, int *deepest) {
    size_t count = 1;
    if (node->primitive >= 0) return 0;
    if (depth > *deepest) *deepest = depth;
    for (uint32_t i = 0; i < node->count; i++) count += inner_nodes(node->child[i], depth + 1, deepest);
    return count;
}

static void clear(cpm_bvh_node *node) {
    for (int i = 0; i < CPM_BVH_WIDTH; i++) {
        for (int k = 0; k < 3; k++) node->box[k][i] = INFINITY, node->box[3 + k][i] = -INFINITY;
        for (int k = 0; k < CPM_FACE_ROWS; k++) node->face[k][i] = 0.0f;
        node->child[i] = 0;
    }
    node->leaves = 0;
}

static void set_box(cpm_bvh_node *node, uint32_t i, const struct RTCBounds *b) {
    node->box[0][i] = b->lower_x, node->box[1][i] = b->lower_y, node->box[2][i] = b->lower_z;
    node->box[3][i] = b->upper_x, node->box[4][i] = b->upper_y, node->box[5][i] = b->upper_z;
}

static void set_leaf(cpm_bvh_node *node, uint32_t i, int32_t primitive, const cpm_bvh_leaf *leaf) {
    node->child[i] = ~primitive;
    node->leaves |= 1u << i;
    for (int k = 0; k < CPM_FACE_ROWS; k++) node->face[k][i] = leaf->face[k];
}

static int32_t flatten(cpm_bvh *bvh, const tree_node *from, const cpm_bvh_leaf *leaves) {
    size_t at = bvh->count++;
    clear(&bvh->nodes[at]);
    for (uint32_t i = 0; i < from->count; i++) {
        const tree_node *child = from->child[i];
        set_box(&bvh->nodes[at], i, &from->bounds[i]);
        if (child->primitive >= 0) {
            set_leaf(&bvh->nodes[at], i, child->primitive, &leaves[child->primitive]);
        } else {
            const int32_t inner = flatten(bvh, child, leaves);
            bvh->nodes[at].child[i] = inner;
        }
    }
    return (int32_t)at;
}

static int allocate(cpm_bvh *bvh, size_t nodes, const char **why) {
    bvh->nodes = aligned_alloc(64, nodes * sizeof *bvh->nodes);
    if (!bvh->nodes) *why = "no memory for the tree of the scene's primitives";
    return bvh->nodes != NULL;
}

int cpm_bvh_build(void *embree_device, const cpm_bvh_leaf *leaves, size_t count, cpm_bvh *bvh, const char **why) {
    bvh->nodes = NULL, bvh->count = 0;
    if (!count) return 1;
    struct RTCBuildPrimitive *primitives = aligned_alloc(32, count * sizeof *primitives);
    if (!primitives) {
        *why = "no memory to build the tree of the scene's primitives";
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        const float *b = leaves[i].box;
        primitives[i] = (struct RTCBuildPrimitive){b[0], b[1], b[2], 0, b[3], b[4], b[5], (unsigned)i};
    }
    RTCBVH tree = rtcNewBVH(embree_device);
    struct RTCBuildArguments a = rtcDefaultBuildArguments();
    a.maxBranchingFactor = CPM_BVH_WIDTH;
    a.maxLeafSize = 1;
    a.bvh = tree;
    a.primitives = primitives;
    a.primitiveCount = a.primitiveArrayCapacity = count;
    a.createNode = create_node;
    a.setNodeChildren = set_children;
    a.setNodeBounds = set_bounds;
    a.createLeaf = create_leaf;
    const tree_node *root = rtcBuildBVH(&a);
    int done = 0;
    if (!root)
        *why = "Embree could not build the tree of the scene's primitives";
    else if (root->primitive >= 0) { /* one primitive: a node about it */
        const float *b = leaves[root->primitive].box;
        const struct RTCBounds bounds = {b[0], b[1], b[2], 0.0f, b[3], b[4], b[5], 0.0f};
        done = allocate(bvh, 1, why);
        if (done) {
            clear(&bvh->nodes[0]);
            set_box(&bvh->nodes[0], 0, &bounds);
            set_leaf(&bvh->nodes[0], 0, root->primitive, &leaves[root->primitive]);
            bvh->count = 1;
        }
    } else {
        int deepest = 0;
        size_t nodes = inner_nodes(root, 1, &deepest);
        if (deepest > CPM_BVH_DEPTH)
            *why = "the tree of the scene's primitives is too deep";
        else
            done = allocate(bvh, nodes, why);
        if (done) flatten(bvh, root, leaves);
    }
    rtcReleaseBVH(tree);
    free(primitives);
    return done;
}

void cpm_bvh_free(cpm_bvh *bvh) {
    free(bvh->nodes);
    bvh->nodes = NULL, bvh->count = 0;
}
