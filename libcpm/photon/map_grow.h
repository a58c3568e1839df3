/* photon/map_grow.h: subtrees, each grown by one thread. Internal to the builder. */
#ifndef CPM_PHOTON_MAP_GROW_H
#define CPM_PHOTON_MAP_GROW_H
#include "map_keys.h"

typedef struct cpm_child { /* what a node keeps of a child */
    float low[3], high[3];
    uint32_t first, count;
    int8_t facing_low[3], facing_high[3];
    int32_t depth; /* 0: a leaf */
} cpm_child;

/* Fills a node with n children; slots from n on are emptied. Returns the child that stands for the node, whose number
 * is `number`. */
cpm_child cpm_node_join(cpm_node *node, const cpm_child *children, int n, uint32_t number);

typedef struct cpm_grove { /* one thread's */
    const cpm_photon *given;
    cpm_photon *photons; /* out, in the tree's order */
    float *points;       /* out */
    uint64_t *keys;      /* in the tree's order */
    uint64_t *scratch;   /* as many as the longest run */
    size_t ahead;        /* keys whose photons have been sent for */
    int index_bits;
    float unit;
    cpm_node *nodes; /* of all subtrees of this thread; children before parents */
    size_t node_count, node_capacity;
    int32_t out_of_memory;
} cpm_grove;

/* The subtree over keys[first .. first + count), whose order it completes: moves their photons, appends its nodes. */
cpm_child cpm_grove_grow(cpm_grove *grove, size_t first, size_t count);

/* Box of the photons that keys name. */
void cpm_keys_box(const cpm_photon *photons, const uint64_t *keys, size_t count, int index_bits, float *low,
                  float *high);
#endif
