/* photon/tree.h: the inside of a photon map's tree: what its builder makes and its search reads. Internal.
 *
 * A bounding-volume hierarchy, eight children a node, over photons in Morton order. A leaf is a run of at most CPM_LEAF
 * photons, or of any number in one single point. Beside the photons themselves a leaf keeps the three coordinates,
 * scaled by a power of two, as x[count] y[count] z[count]: all that a search reads of a photon that is too far.
 * Bytes a photon: 32 record + 2 a bin + 12 coordinates + about 2.5 of nodes. */
#ifndef CPM_PHOTON_TREE_H
#define CPM_PHOTON_TREE_H
#include "backend/native/isa.h"
#include "map.h"

#define CPM_WIDE 8  /* children of a node */
#define CPM_LEAF 32 /* photons of a leaf */
#define CPM_PAD 16  /* floats, and halves, that a vector may touch beyond the last */

typedef struct cpm_node {
    float low[3][CPM_WIDE], high[3][CPM_WIDE]; /* tight boxes, scaled; infinite where there is no child */
    uint32_t first[CPM_WIDE];                  /* a leaf's first photon, or the child's number among the nodes */
    uint32_t count[CPM_WIDE];                  /* photons of a leaf; 0: the child is a node */
    int8_t facing_low[CPM_WIDE][3], facing_high[CPM_WIDE][3]; /* bounds of the photons' unit normals in 1/CPM_FACING */
    uint8_t padding[16];
} cpm_node; /* five lines of 64 bytes */

#define CPM_FACING 126

struct cpm_tree {
    cpm_photon *photons; /* leaf after leaf; within a leaf by (path, bounce, bin) */
    uint16_t *spectra;
    void (*release_spectra)(void *); /* how they are freed */
    float *points;                   /* of a leaf with first photon f: from points + 3 f */
    cpm_node *nodes;
    size_t count, spectra_count, node_count, bins;
    uint32_t top;    /* number of the uppermost node */
    int32_t depth;   /* nodes on the longest way down */
    int32_t unsplit; /* 1: every photon carries all bins, photon i's at spectra + i bins */
    float unit;      /* power of two: coordinates are stored times this, so that they are below 1 */
    float extent;    /* longest side of the box of all, scaled */
    double scale;    /* W/nm of a half-float 1 */
};

/* Scratch of one thread. Where `distance` and `id` have n entries, room for CPM_PAD more follows. */
struct cpm_query {
    const cpm_tree *tree;
    const struct cpm_search *search;
    size_t capacity;
    float *distance; /* squared, scaled */
    uint32_t *id;
    uint64_t *order; /* of ties */
    uint64_t *stack;
    double *sum;
    float guess; /* squared radius per photon of the last query; 0: none yet */
};

typedef struct cpm_found {
    float radius2;  /* squared distance of the k-th photon, scaled; the largest allowed where there are fewer */
    uint32_t count; /* photons to be summed, in query->id, in the tree's order */
    int32_t enough; /* 1: k photons were found */
} cpm_found;

/* One for each instruction set, all with the same results to the last bit. */
typedef struct cpm_search {
    /* Finds the k nearest within the squared radius `limit`; `point` scaled and finite, 1 <= k. The query's buffers
     * have room for it (cpm_query_room). */
    cpm_found (*nearest)(cpm_query *query, const float *point, const float *normal, uint32_t k, float limit);
    /* Half-float powers of photons query->id[0..count), summed over photons, to query->sum[bins]. */
    void (*sum)(cpm_query *query, uint32_t count);
} cpm_search;
const cpm_search *cpm_search_for(cpm_isa isa);
/* Makes room for k nearest; 0 out of memory. */
int32_t cpm_query_room(cpm_query *query, uint32_t k);
#endif
