/* types/walker.h: what a photon's path has been through; the same memory on both sides. */
#ifndef CPM_TYPES_WALKER_H
#define CPM_TYPES_WALKER_H
#include "../dialect.h"

#define CPM_MAX_BOUNCES 4096 /* a closed room of albedo 1 would keep its photons for ever: beyond, they are lost */
#define CPM_MAX_CROSSINGS 65535

/* Populations that are searched apart. */
#define CPM_POPULATION_DIRECT 0
#define CPM_POPULATION_LATER 1
#define CPM_POPULATION_CAUSTIC 2

/* Rows of the energy table, W/nm a bin. */
#define CPM_ROW_EMITTED 0
#define CPM_ROW_GAIN 1
#define CPM_ROW_ABSORBED 2
#define CPM_ROW_ESCAPED 3
#define CPM_ROW_LOSS 4
#define CPM_ROW_VARIANCE 5
#define CPM_ROWS 6

typedef struct cpm_walker {
    cpm_u32 path;
    unsigned short bounce;    /* surfaces met; also which block of random numbers comes next */
    unsigned short crossings; /* boundaries passed unbroken since: they use blocks too */
    unsigned char specular;   /* only specular surfaces so far, one at least */
    unsigned char direct;     /* nothing met so far */
    unsigned short padding;
} cpm_walker;
CPM_STATIC_ASSERT(sizeof(cpm_walker) == 12, cpm_walker_size);

CPM_INLINE int cpm_population(const cpm_walker *w) {
    return w->direct ? CPM_POPULATION_DIRECT : w->specular ? CPM_POPULATION_CAUSTIC : CPM_POPULATION_LATER;
}

/* Something specular was met. */
CPM_INLINE void cpm_walker_reflects(cpm_walker *w) {
    w->specular = w->direct || w->specular;
    w->direct = 0;
    w->bounce++;
    w->crossings = 0;
}
#endif
