/* backend/native/cross.h: what a ray does at the boundary of a medium. */
#ifndef CPM_NATIVE_CROSS_H
#define CPM_NATIVE_CROSS_H
#include "follow.h"

#define CPM_EQUAL_INDEX 1e-9 /* a jump of n below this is none */

#define CPM_COINCIDE 1e-11 /* of the scene: surfaces closer than this along a ray are one */

typedef struct cpm_passage {
    int32_t jumps;      /* n jumps: Snell and Fresnel; else `transmitted` goes straight on */
    int32_t total;      /* total reflection: there is no `transmitted` */
    double reflectance; /* Fresnel, 0 without a jump */
    cpm_flight reflected, transmitted;
} cpm_passage;

/* Only bounds a medium, or is a dielectric. */
int cpm_is_boundary(const cpm_pass *pass, int32_t primitive);
/* Would passing this primitive in this direction change the region? Surfaces always count. */
int cpm_boundary_counts(const cpm_pass *pass, const cpm_region *region, int32_t primitive, cpm_vec position,
                        cpm_vec direction);
/* Fills arrival->behind: what contains the ray once it has passed the boundary that it met and all that coincide with
 * it. A surface that coincides stands before them (what lies on a floor does not let the ray into the floor): then it
 * is what was met. cpm_follow does this for every arrival. */
void cpm_look_behind(const cpm_pass *pass, const cpm_flight *flight, cpm_arrival *arrival);

/* Both ways on from a boundary. Returns 0 where more than CPM_MAX_NESTED media would overlap. */
int cpm_pass_boundary(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_passage *passage);

/* A flight thrown back into the medium where another has arrived. */
cpm_flight cpm_depart(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec direction);
#endif
