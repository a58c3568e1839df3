/* kernels/eye_gather.cl: one population's irradiance where eye rays have met diffuse surfaces. */
#include "kernels/eye.h"
#include "shared/coverage.h"
#include "shared/eye.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE /* what it calls is of single rays in double */
/* Query q is of branch list[q]. irradiance: count x bins, added to. whole: count, see world_gather. The map and scratch
 * are as in kernels/gather.cl. */
__kernel void cpm_eye_gather(CPM_WORLD_PARAMETERS, CPM_EYE_PARAMETERS, __global const cpm_map_node *map_nodes,
                             __global const float *points, __global const cpm_photon *photons,
                             __global const ushort *spectra, __global const cpm_map_numbers *numbers,
                             __global const double *map_origin, __global const cpm_arrival *arrivals,
                             __global const int *list, __global double *irradiance, __global double *whole,
                             __global float *distance, __global uint *id, __global ulong *order, __global ulong *stack,
                             __global double *sum, ulong capacity, double max_radius, uint nearest, int count,
                             int share) {
    CPM_WORLD(w);
    CPM_EYE(eye);
    CPM_EYE_SEGMENT(first, last);
    const size_t item = get_global_id(0);
    const cpm_vec origin = cpm_v(map_origin[0], map_origin[1], map_origin[2]);
    cpm_map_search s;
    s.map.nodes = map_nodes, s.map.points = points, s.map.photons = photons, s.map.spectra = spectra;
    s.map.is = *numbers;
    s.distance = distance + item * (capacity + CPM_PAD), s.id = id + item * (capacity + CPM_PAD);
    s.order = order + item * capacity, s.stack = stack + item * (size_t)(s.map.is.depth + 1);
    s.sum = sum + item * (s.map.is.bins + CPM_PAD);
    s.capacity = capacity, s.guess = 0.0f;
    for (int q = first; q < last; q++) {
        cpm_arrival a = arrivals[list[q]];
        double widest = whole[q];
        const cpm_vec normal = world_shading_normal(&w, &a.hit, eye_facing(&w, &a));
        world_gather(&w, eye.is.corrected, &s, nearest, max_radius, &a.hit, cpm_sub(a.hit.position, origin), normal,
                     &widest, irradiance + (size_t)q * s.map.is.bins);
        whole[q] = widest;
    }
}
#endif
