/* kernels/follow_integrated.cl: flights in medium `medium`, whose paths are integrated, eight abreast. */
#include "kernels/world.h"
#include "shared/follow_integrated.h"

__kernel void cpm_follow_integrated(CPM_WORLD_PARAMETERS, __global const cpm_flight *flights,
                                    __global cpm_arrival *arrivals, __global const int *counts, int share, int medium,
                                    __global const cpm_step_control *control) {
    CPM_WORLD(w);
    const long first = (long)get_global_id(0) * share, last = first + counts[get_global_id(0)];
    const cpm_medium_data m = w.media[medium];
    cpm_step_control c = *control;
    cpm_step_control_set(&c);
    if (first < last)
        world_follow_integrated(&w, medium, &m, cpm_table_of(w.tables, medium), &c, flights, arrivals, first, last);
}
