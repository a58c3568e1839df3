/* kernels/start_area.cl: fresh paths of an area light, until an item's segment holds `fresh` flights. The light's paths
 * are first..last - 1; power_factor: 1/mean n^2 over the light. */
#include "kernels/paths.h"
#include "kernels/world.h"
#include "shared/emit.h"
#include "shared/region_at.h"
#include "shared/world_index.h"

__kernel void cpm_start_area(CPM_WORLD_PARAMETERS, CPM_NEXT_PARAMETERS, __global const cpm_emitter_data *emitter,
                             __global const double *area, __global const float *spectrum, ulong first, ulong last,
                             int fresh, double power_factor) {
    const size_t item = get_global_id(0);
    CPM_WORLD(world);
    CPM_PATHS(to, next_flights, next_walkers, next_powers, next_counts[item]);
    CPM_ENERGY(energy);
    const cpm_emitter_data e = *emitter;
    cpm_tally tally = tallies[item];
    const ulong end = min(tally.end, last);
    if (tally.next < first) return;
    cpm_flight flight;
    CPM_CLEAR(flight);
    flight.exact = 1;
    while (tally.next < end && to.count < fresh) {
        double at[3][CPM_WIDTH], up[3][CPM_WIDTH], way[3][CPM_WIDTH];
        uint index[CPM_WIDTH];
        int primitive[CPM_WIDTH];
        real3 point, normal, direction;
        int now = (int)min((ulong)min(CPM_WIDTH, fresh - to.count), end - tally.next);
        for (int i = 0; i < CPM_WIDTH; i++) index[i] = (uint)(tally.next - first) + (uint)i;
        emit_area(&e, e.triangles ? triangles + e.primitive : triangles, area, load_words(index, 0), &point, &normal,
                  &direction, primitive);
        store_doubles(point.x, at[0], 0), store_doubles(point.y, at[1], 0), store_doubles(point.z, at[2], 0);
        store_doubles(normal.x, up[0], 0), store_doubles(normal.y, up[1], 0), store_doubles(normal.z, up[2], 0);
        store_doubles(direction.x, way[0], 0), store_doubles(direction.y, way[1], 0);
        store_doubles(direction.z, way[2], 0);
        for (int i = 0; i < now; i++) {
            flight.position = cpm_v(at[0][i], at[1][i], at[2][i]);
            flight.direction = cpm_v(way[0][i], way[1][i], way[2][i]);
            flight.region = world_region_at(&world, flight.position, cpm_v(up[0][i], up[1][i], up[2][i]));
            flight.left = primitive[i];
            const int medium = cpm_region_medium(&flight.region);
            const double middle = world_squared_index(&world, medium, -1, flight.position);
            const float carried = (float)(middle * power_factor);
            const uint path = (uint)(tally.next + (ulong)i);
            if (!(carried > 0.0f)) continue;
            if (!world.places[medium].disperses)
                cpm_paths_start(&to, path, &flight, carried, spectrum, energy);
            else /* a surface emits n^2 L, with each bin's own n */
                for (int b = 0; b < bins; b++)
                    cpm_paths_start_bin(&to, path, &flight, b,
                                        carried * emit_own(spectrum[b],
                                                           world_squared_index(&world, medium, b, flight.position),
                                                           middle),
                                        energy);
            tally.emitted++;
        }
        tally.next += (ulong)now;
    }
    next_counts[item] = to.count;
    tallies[item] = tally;
}
