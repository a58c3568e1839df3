/* kernels/follow_straight.cl: flights in media of one n. */
#include "kernels/world.h"
#include "shared/follow_straight.h"

__kernel void cpm_follow_straight(CPM_WORLD_PARAMETERS, __global const cpm_flight *flights,
                                  __global cpm_arrival *arrivals, __global const int *counts, int share) {
    CPM_WORLD(w);
    const long first = (long)get_global_id(0) * share, last = first + counts[get_global_id(0)];
    for (long i = first; i < last; i++) {
        cpm_flight flight = flights[i];
        cpm_arrival arrival;
        if (w.places[cpm_region_medium(&flight.region)].way != CPM_STRAIGHT_WAY) continue;
        cpm_arrival_begin(&flight, &arrival);
        world_follow_straight(&w, &flight, &arrival);
        arrivals[i] = arrival;
    }
}
