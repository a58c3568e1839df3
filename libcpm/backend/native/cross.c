/* backend/native/cross.c: cl/shared/boundary.h and behind.h for a pass. */
#include "cross.h"

#include "host.h"
/* after the host's */
#include "cl/shared/boundary.h"

cpm_flight cpm_depart(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec direction) {
    return world_depart(&pass->world, flight, arrival, direction);
}

void cpm_look_behind(const cpm_pass *pass, const cpm_flight *flight, cpm_arrival *arrival) {
    world_look_behind(&pass->world, flight, arrival);
}

int cpm_pass_boundary(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival,
                      cpm_passage *passage) {
    return world_pass_boundary(&pass->world, flight, arrival, passage);
}
