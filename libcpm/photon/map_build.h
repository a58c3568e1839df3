/* photon/map_build.h: what the stages of building a tree hand on. Internal to the builder. */
#ifndef CPM_PHOTON_MAP_BUILD_H
#define CPM_PHOTON_MAP_BUILD_H
#include "map_grow.h"

typedef struct cpm_plan { /* a node of the upper tree, or a run */
    size_t first, count;
    int n, children[CPM_WIDE]; /* n = 0: a run, one thread's work */
    cpm_child made;
    int thread;
    size_t node_first, node_count; /* a run's nodes, in its thread's grove */
} cpm_plan;

typedef struct cpm_builder {
    cpm_context *context;
    cpm_map_tree *tree;
    cpm_photon *given;
    uint16_t *given_spectra;
    void (*release)(void *); /* of both */
    uint64_t *keys;
    cpm_plan *plans; /* parents before children */
    size_t plan_count, plan_capacity;
    float low[3], high[3]; /* box of all, metres */
    int index_bits, threads;
} cpm_builder;

/* Into how many chunks a loop over photons is cut: several a thread, as cores differ and are not ours alone. */
static inline size_t cpm_builder_chunks(const cpm_builder *builder) {
    return builder->threads > 1 ? 8 * (size_t)builder->threads : 1;
}

/* Keys, and the upper part of the tree down to runs that one thread can take. Until photons move there, the memory of
 * tree->photons is scratch. 0: out of memory, or cancelled. */
int32_t cpm_builder_plan(cpm_builder *builder);
/* The runs' subtrees, by all threads, and the nodes above them: fills photons, points, nodes. 0: as above. */
int32_t cpm_builder_grow(cpm_builder *builder);
#endif
