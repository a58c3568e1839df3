/* backend/native/cross.h: what a ray does at the boundary of a medium: cl/shared/boundary.h and behind.h for a pass. */
#ifndef CPM_NATIVE_CROSS_H
#define CPM_NATIVE_CROSS_H
#include "follow.h"

/* Fills arrival->behind. cpm_follow does this for every arrival. */
void cpm_look_behind(const cpm_pass *pass, const cpm_flight *flight, cpm_arrival *arrival);

/* Both ways on from a boundary. Returns 0 where more than CPM_MAX_NESTED media would overlap. */
int cpm_pass_boundary(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_passage *passage);

/* A flight thrown back into the medium where another has arrived. */
cpm_flight cpm_depart(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec direction);
#endif
