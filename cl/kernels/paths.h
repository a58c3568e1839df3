/* kernels/paths.h: the buffers of the photon pass as its kernels take them, and an item's part of them. An item's
 * segments hold `share` flights. */
#ifndef CPM_KERNELS_PATHS_H
#define CPM_KERNELS_PATHS_H
#include "../shared/path.h"

#define CPM_NEXT_PARAMETERS                                                                                            \
    __global cpm_flight *next_flights, __global cpm_walker *next_walkers, __global float *next_powers,                 \
        __global int *next_counts, __global cpm_tally *tallies, __global double *energies, int share, int bins

#define CPM_NOW_PARAMETERS                                                                                             \
    __global cpm_flight *flights, __global cpm_walker *walkers, __global float *powers, __global const int *counts,    \
        __global const cpm_arrival *arrivals

#define CPM_PATHS(which, f, w, p, n)                                                                                   \
    cpm_paths which;                                                                                                   \
    which.flights = (f) + get_global_id(0) * share, which.walkers = (w) + get_global_id(0) * share;                    \
    which.powers = (p) + get_global_id(0) * share * bins;                                                              \
    which.count = n, which.bins = bins
#define CPM_ENERGY(name) __global double *name = energies + get_global_id(0) * CPM_ROWS * bins
#endif
