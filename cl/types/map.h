/* types/map.h: a photon map as a search reads it: built by libcpm/photon/map_build.c, the same on both sides.
 *
 * A bounding-volume hierarchy, eight children a node, over photons in Morton order. A leaf is a run of at most CPM_LEAF
 * photons, or of any number in one single point. Beside the photons themselves a leaf keeps the three coordinates,
 * scaled by a power of two, as x[count] y[count] z[count]: all that a search reads of a photon that is too far.
 * Bytes a photon: 32 record + 2 a bin + 12 coordinates + about 2.5 of nodes. */
#ifndef CPM_TYPES_MAP_H
#define CPM_TYPES_MAP_H
#include "../dialect.h"
#include "photon.h"

#define CPM_WIDE 8  /* children of a node */
#define CPM_LEAF 32 /* photons of a leaf */
#define CPM_PAD 16  /* floats, and halves, that a vector may touch beyond the last */
#define CPM_FACING 126

typedef struct cpm_map_node {
    float low[3][CPM_WIDE], high[3][CPM_WIDE]; /* tight boxes, scaled; infinite where there is no child */
    cpm_u32 first[CPM_WIDE];                   /* a leaf's first photon, or the child's number among the nodes */
    cpm_u32 count[CPM_WIDE];                   /* photons of a leaf; 0: the child is a node */
    signed char facing_low[CPM_WIDE][3], facing_high[CPM_WIDE][3]; /* bounds of their unit normals in 1/CPM_FACING */
    unsigned char padding[16];
} cpm_map_node; /* five lines of 64 bytes */
CPM_STATIC_ASSERT(sizeof(cpm_map_node) == 320, cpm_map_node_size);
CPM_ASSERT_OFFSET(cpm_map_node, first, 192);
CPM_ASSERT_OFFSET(cpm_map_node, facing_low, 256);

/* The numbers of one population's map; count 0: there are no arrays. */
typedef struct cpm_map_numbers {
    double scale;    /* W/nm of a half-float 1 */
    cpm_u64 count;   /* photons */
    float unit;      /* power of two: coordinates are stored times this, so that they are below 1 */
    float extent;    /* longest side of the box of all, scaled */
    cpm_u32 top;     /* number of the uppermost node */
    cpm_i32 depth;   /* nodes on the longest way down */
    cpm_i32 unsplit; /* 1: every photon carries all bins, photon i's at spectra + i bins */
    cpm_u32 bins;
} cpm_map_numbers;
CPM_STATIC_ASSERT(sizeof(cpm_map_numbers) == 40, cpm_map_numbers_size);

typedef struct cpm_map_view {
    CPM_GLOBAL const cpm_map_node *nodes;
    CPM_GLOBAL const float *points;           /* of a leaf with first photon f: from points + 3 f */
    CPM_GLOBAL const cpm_photon *photons;     /* leaf after leaf; within a leaf by (path, bounce, bin) */
    CPM_GLOBAL const unsigned short *spectra; /* half floats */
    cpm_map_numbers is;
} cpm_map_view;

/* One search at a time: where it lists. `distance` and `id` have room for `capacity` and CPM_PAD more, `order` for
 * `capacity`, `stack` for depth + 1, `sum` for bins + CPM_PAD. */
typedef struct cpm_map_search {
    cpm_map_view map;
    CPM_GLOBAL float *distance; /* squared, scaled */
    CPM_GLOBAL cpm_u32 *id;
    CPM_GLOBAL cpm_u64 *order; /* of ties */
    CPM_GLOBAL cpm_u64 *stack;
    CPM_GLOBAL double *sum;
    cpm_u64 capacity;
    float guess; /* squared radius per photon of the last query; 0: none yet. It changes the cost, never the result */
} cpm_map_search;

typedef struct cpm_map_found {
    float radius2;  /* squared distance of the k-th photon, scaled; the largest allowed where there are fewer */
    cpm_u32 count;  /* photons to be summed, in the search's `id`, in the map's order */
    cpm_i32 enough; /* 1: k photons were found */
} cpm_map_found;

/* Entries for k nearest of so many photons: so many that lists are seldom cut. */
#define CPM_MAP_CAPACITY(k, count) (3 * (cpm_u64)((k) < (count) ? (k) : (count)) + 1024)
#endif
