/* kernels/start_delta.cl: fresh paths of a point or spot light, until an item's segment holds `fresh` flights. The
 * light's paths are first..last - 1; `apart`: each wavelength goes its own way. */
#include "kernels/paths.h"
#include "shared/emit.h"

__kernel void cpm_start_delta(CPM_NEXT_PARAMETERS, __global const cpm_emitter_data *emitter,
                              __global const double *cumulative, __global const int *guide,
                              __global const float *weight, __global const float *spectrum,
                              __global const cpm_region *region, ulong first, ulong last, int fresh, int apart) {
    const size_t item = get_global_id(0);
    CPM_PATHS(to, next_flights, next_walkers, next_powers, next_counts[item]);
    CPM_ENERGY(energy);
    const cpm_emitter_data e = *emitter;
    cpm_tally tally = tallies[item];
    const ulong end = min(tally.end, last);
    if (tally.next < first) return;
    cpm_flight flight;
    CPM_CLEAR(flight);
    flight.position = cpm_v(e.position[0], e.position[1], e.position[2]);
    flight.region = *region;
    flight.left = -1;
    while (tally.next < end && to.count < fresh) {
        double way[3][CPM_WIDTH], power[CPM_WIDTH];
        uint index[CPM_WIDTH];
        real3 direction;
        int now = (int)min((ulong)min(CPM_WIDTH, fresh - to.count), end - tally.next);
        for (int i = 0; i < CPM_WIDTH; i++) index[i] = (uint)(tally.next - first) + (uint)i;
        store_doubles(emit_delta(&e, cumulative, guide, weight, load_words(index, 0), &direction), power, 0);
        store_doubles(direction.x, way[0], 0), store_doubles(direction.y, way[1], 0);
        store_doubles(direction.z, way[2], 0);
        for (int i = 0; i < now; i++) {
            const float carried = (float)power[i];
            if (!(carried > 0.0f)) continue;
            flight.direction = cpm_v(way[0][i], way[1][i], way[2][i]);
            const uint path = (uint)(tally.next + (ulong)i);
            if (!apart) cpm_paths_start(&to, path, &flight, carried, spectrum, energy);
            for (int b = 0; apart && b < bins; b++)
                cpm_paths_start_bin(&to, path, &flight, b, carried * spectrum[b], energy);
            tally.emitted++;
        }
        tally.next += (ulong)now;
    }
    next_counts[item] = to.count;
    tallies[item] = tally;
}
