/* kernels/specular.cl: paths that have met a mirror or a boundary, one after the other; what goes on is appended to
 * what kernels/meet.cl has put together. */
#include "kernels/paths.h"
#include "kernels/world.h"
#include "shared/path_specular.h"
#if CPM_WIDTH == 1 && !CPM_SINGLE /* what it calls is of single rays in double */

__kernel void cpm_specular(CPM_WORLD_PARAMETERS, CPM_NEXT_PARAMETERS, CPM_NOW_PARAMETERS,
                           __global const float *reflectance, __global const float *shares,
                           __global const float *largest, __global const float *one, __global const uint *multiply,
                           __global const uint *add, ulong seed) {
    const size_t item = get_global_id(0);
    CPM_WORLD(world);
    CPM_PATHS(from, flights, walkers, powers, counts[item]);
    CPM_PATHS(to, next_flights, next_walkers, next_powers, next_counts[item]);
    cpm_meeting m;
    cpm_tally tally = tallies[item];
    CPM_CLEAR(m);
    m.world = &world, m.from = &from, m.to = &to, m.tally = &tally;
    m.arrivals = arrivals + item * share;
    m.energy = energies + item * CPM_ROWS * bins;
    m.surfaces.reflectance = reflectance, m.surfaces.share = shares, m.surfaces.largest = largest, m.surfaces.one = one;
    m.steps.multiply = multiply, m.steps.add = add;
    m.seed = seed;
    path_meet_specular(&m);
    next_counts[item] = to.count;
    tallies[item] = tally;
}
#endif
