/* kernels/behind.cl: what flights that met a boundary enter. */
#include "kernels/world.h"
#include "shared/behind.h"

__kernel void cpm_behind(CPM_WORLD_PARAMETERS, __global const cpm_flight *flights, __global cpm_arrival *arrivals,
                         __global const int *counts, int share) {
    CPM_WORLD(w);
    const long first = (long)get_global_id(0) * share, last = first + counts[get_global_id(0)];
    for (long i = first; i < last; i++) {
        cpm_flight flight = flights[i];
        cpm_arrival arrival = arrivals[i];
        world_look_behind(&w, &flight, &arrival);
        arrivals[i] = arrival;
    }
}
