/* kernels/follow_parabolas.cl: flights in medium `medium`, whose n^2 is linear, CPM_WIDTH abreast. */
#include "kernels/world.h"
#include "shared/follow_parabolas.h"

__kernel void cpm_follow_parabolas(CPM_WORLD_PARAMETERS, __global const cpm_flight *flights,
                                   __global cpm_arrival *arrivals, __global const int *counts, int share, int medium) {
    CPM_WORLD(w);
    const long first = (long)get_global_id(0) * share, last = first + counts[get_global_id(0)];
    const cpm_medium_data m = w.media[medium];
    world_follow_parabolas(&w, medium, &m, cpm_table_of(w.tables, medium), flights, arrivals, first, last);
}
