/* photon/tree.h: the inside of a photon map's tree (cl/types/map.h): what its builder makes and its search reads.
 * Internal. */
#ifndef CPM_PHOTON_TREE_H
#define CPM_PHOTON_TREE_H
#include "backend/native/isa.h"
#include "cl/types/map.h"
#include "map.h"

typedef cpm_map_node cpm_node;

struct cpm_map_tree {
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

/* What a search reads. */
cpm_map_view cpm_tree_view(const cpm_map_tree *tree);

/* Scratch of one thread. */
struct cpm_map_query {
    const cpm_map_tree *tree;
    const struct cpm_search *search;
    cpm_map_search state;
};

/* One for each instruction set, all with the same results to the last bit. */
typedef struct cpm_search {
    /* Finds the k nearest within the squared radius `limit`; `point` scaled and finite, 1 <= k. The query's buffers
     * have room for it (cpm_query_room). */
    cpm_map_found (*nearest)(cpm_map_search *search, const float *point, const float *normal, uint32_t k, float limit);
    /* Half-float powers of photons id[0..count), summed over photons, to sum[bins]. */
    void (*sum)(const cpm_map_search *search, uint32_t count);
} cpm_search;
const cpm_search *cpm_search_for(cpm_isa isa);
/* Makes room for k nearest; 0 out of memory. */
int32_t cpm_query_room(cpm_map_query *query, uint32_t k);
#endif
