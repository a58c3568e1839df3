/* kernels/meet.cl: paths that have arrived: those that met something diffuse or black are stored and scattered,
 * CPM_WIDTH abreast, those that met nothing end. Mirrors and boundaries are left to kernels/specular.cl. An item's
 * stored photons are appended to its `stage` places. `origin` is what positions are stored from; `scale`: the largest
 * coordinate of the scene. */
#include "kernels/paths.h"
#include "kernels/world.h"
#include "shared/path_meet.h"

__kernel void cpm_meet(CPM_WORLD_PARAMETERS, CPM_NEXT_PARAMETERS, CPM_NOW_PARAMETERS, __global const float *reflectance,
                       __global const float *shares, __global const float *largest, __global const float *one,
                       __global const uint *multiply, __global const uint *add, __global cpm_photon *photons,
                       __global ushort *spectra, int stage, int halves, ulong seed, double origin_x, double origin_y,
                       double origin_z) {
    const size_t item = get_global_id(0);
    CPM_WORLD(world);
    CPM_PATHS(from, flights, walkers, powers, counts[item]);
    CPM_PATHS(to, next_flights, next_walkers, next_powers, 0);
    cpm_meeting m;
    cpm_tally tally = tallies[item];
    m.world = &world, m.from = &from, m.to = &to, m.tally = &tally;
    m.arrivals = arrivals + item * share;
    m.energy = energies + item * CPM_ROWS * bins;
    m.surfaces.reflectance = reflectance, m.surfaces.share = shares, m.surfaces.largest = largest, m.surfaces.one = one;
    m.steps.multiply = multiply, m.steps.add = add;
    m.photons = photons + item * stage, m.spectra = spectra + item * halves;
    m.origin = cpm_v(origin_x, origin_y, origin_z);
    m.seed = seed;
    path_meet(&m);
    next_counts[item] = to.count;
    tallies[item] = tally;
}
