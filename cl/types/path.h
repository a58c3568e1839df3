/* types/path.h: what the photon pass keeps beside flights, the same memory on both sides. */
#ifndef CPM_TYPES_PATH_H
#define CPM_TYPES_PATH_H
#include "walker.h"

/* One work-item's account. */
typedef struct cpm_tally {
    cpm_u64 next, end; /* path numbers that it has yet to start */
    cpm_u64 segments, lost, emitted;
    double evaluations;
    cpm_i32 photons, halves; /* stored, and the bins of all of them */
} cpm_tally;
CPM_STATIC_ASSERT(sizeof(cpm_tally) == 56, cpm_tally_size);

/* A stored photon's `spectrum` until the host has it: its population in the two highest bits, and the place of its
 * first power among those of its item. */
#define CPM_STAGED_POPULATION 30

/* Materials, a row of bins each. */
typedef struct cpm_surface_tables {
    CPM_GLOBAL const float *reflectance;
    CPM_GLOBAL const float *share;   /* of the largest of its material */
    CPM_GLOBAL const float *largest; /* one a material */
    CPM_GLOBAL const float *one;     /* 1 */
} cpm_surface_tables;
#endif
