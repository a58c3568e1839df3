/* kernels/gather.cl: the k nearest photons of one map, and the irradiance that they carry. Each work-item takes `share`
 * of the queries, one after the other: a query's radius is the first guess of the next. */
#include "shared/map_search.h"

/* points (metres from the map's origin) and unit normals: count x 3. irradiance: count x bins, added to; radii: the
 * radius used; or, where k_th is 1, r_k itself, and irradiance is left alone. Scratch, each work-item's after the
 * other's: distance and id capacity + CPM_PAD, order capacity, stack depth + 1, sum bins + CPM_PAD. found: count, how
 * many photons were summed; ids: nearest each, or none where keep is 0. */
__kernel void cpm_gather(__global const cpm_map_node *nodes, __global const float *points_of_map,
                         __global const cpm_photon *photons, __global const ushort *spectra,
                         __global const cpm_map_numbers *numbers, __global const float *points,
                         __global const float *normals, __global double *irradiance, __global double *radii,
                         __global uint *found_counts, __global uint *ids, __global float *distance, __global uint *id,
                         __global ulong *order, __global ulong *stack, __global double *sum, ulong capacity,
                         double max_radius, uint nearest, int k_th, int keep, long count, long share) {
    const size_t item = get_global_id(0);
    const long first = (long)item * share, last = min(first + share, count);
    cpm_map_search s;
    s.map.nodes = nodes, s.map.points = points_of_map, s.map.photons = photons, s.map.spectra = spectra;
    s.map.is = *numbers;
    s.distance = distance + item * (capacity + CPM_PAD), s.id = id + item * (capacity + CPM_PAD);
    s.order = order + item * capacity, s.stack = stack + item * (size_t)(s.map.is.depth + 1);
    s.sum = sum + item * (s.map.is.bins + CPM_PAD);
    s.capacity = capacity, s.guess = 0.0f;
    for (long i = first; i < last; i++) {
        float point[3], normal[3];
        cpm_map_found found;
        for (int k = 0; k < 3; k++) point[k] = points[3 * i + k], normal[k] = normals[3 * i + k];
        if (k_th)
            radii[i] = cpm_map_kth_radius(&s, point, normal, nearest, max_radius, &found);
        else
            radii[i] = cpm_map_irradiance(&s, point, normal, nearest, max_radius, &found,
                                          irradiance + i * (long)s.map.is.bins);
        found_counts[i] = found.count;
        for (uint j = 0; keep && j < found.count && j < nearest; j++) ids[i * (long)nearest + j] = s.id[j];
    }
}
