/* kernels/follow_exact.cl: flights in medium `medium`, whose paths are closed forms. */
#include "kernels/world.h"
#include "shared/follow_exact.h"

__kernel void cpm_follow_exact(CPM_WORLD_PARAMETERS, __global const cpm_flight *flights, __global cpm_arrival *arrivals,
                               __global const int *counts, int share, int medium) {
    CPM_WORLD(w);
    const long first = (long)get_global_id(0) * share, last = first + counts[get_global_id(0)];
    const cpm_medium_data m = w.media[medium];
    for (long i = first; i < last; i++) {
        cpm_flight flight = flights[i];
        cpm_arrival arrival;
        if (cpm_region_medium(&flight.region) != medium) continue;
        world_follow_exact(&w, medium, &m, cpm_table_of(w.tables, medium), &flight, &arrival);
        arrivals[i] = arrival;
    }
}
