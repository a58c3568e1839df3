/* shared/path.h: photons' paths on a device: what each work-item of the photon pass has, and how it keeps it.
 *
 * An item has a segment of flights now, and one next in which what goes on is put together: survivors of diffuse
 * surfaces, then of specular ones, then fresh paths. Nothing of one item touches another's, and what becomes of a path
 * depends on (seed, path, surface, bin) alone: so results do not depend on how many items there are, or how long their
 * segments. */
#ifndef CPM_SHARED_PATH_H
#define CPM_SHARED_PATH_H
#include "../types/flight.h"
#include "../types/path.h"
#include "bins.h"
#include "settle.h"

/* One item's segment. */
typedef struct cpm_paths {
    CPM_GLOBAL cpm_flight *flights;
    CPM_GLOBAL cpm_walker *walkers;
    CPM_GLOBAL float *powers; /* bins each; those of one bin use the first */
    cpm_i32 count, bins;
} cpm_paths;

/* One more path that goes on: where its powers belong. */
CPM_INLINE CPM_GLOBAL float *cpm_paths_add(cpm_paths *to, const cpm_walker *w, const cpm_flight *flight) {
    const cpm_i32 at = to->count++;
    to->walkers[at] = *w;
    to->flights[at] = *flight;
    return to->powers + (size_t)at * (size_t)to->bins;
}

/* Energies of an item. */
CPM_INLINE cpm_roulette_rows cpm_rows_of(CPM_GLOBAL double *energy, cpm_i32 bins) {
    cpm_roulette_rows rows;
    rows.absorbed = energy + CPM_ROW_ABSORBED * bins, rows.gain = energy + CPM_ROW_GAIN * bins;
    rows.loss = energy + CPM_ROW_LOSS * bins, rows.variance = energy + CPM_ROW_VARIANCE * bins;
    return rows;
}

/* Adds what a flight carries to a row of an item's energies. */
CPM_INLINE void cpm_account(CPM_GLOBAL double *energy, cpm_i32 row, cpm_i32 bins, cpm_i32 bin,
                            CPM_GLOBAL const float *powers) {
    CPM_GLOBAL double *to = energy + row * bins + cpm_bins_first(bin);
    const cpm_i32 count = cpm_bins_count(bin, bins);
    for (cpm_i32 b = 0; b < count; b++) to[b] += (double)powers[b];
}

/* Roulette at a surface of `material`, with the random number `chance`. */
CPM_INLINE void cpm_play(const cpm_surface_tables *s, cpm_i32 bins, cpm_i32 bin, cpm_i32 material,
                         CPM_GLOBAL const float *powers, double chance, CPM_GLOBAL float *after, cpm_powers *p) {
    const cpm_i32 first = cpm_bins_first(bin), at = material * bins + first;
    p->before = powers;
    p->reflectance = s->reflectance + at;
    p->share = bin < 0 ? s->share + at : s->one;
    p->after = after;
    p->spectrum = 0;
    p->first = (cpm_u32)first, p->bins = (cpm_u32)cpm_bins_count(bin, bins);
    p->alive = chance < (double)(bin < 0 ? s->largest[material] : *p->reflectance);
}

/* A fresh path with all its bins. */
CPM_INLINE void cpm_paths_start(cpm_paths *to, cpm_u32 path, cpm_flight *flight, float weight,
                                CPM_GLOBAL const float *spectrum, CPM_GLOBAL double *energy) {
    CPM_GLOBAL double *emitted = energy + CPM_ROW_EMITTED * to->bins;
    cpm_walker w;
    CPM_CLEAR(w);
    w.path = path, w.direct = 1;
    flight->bin = -1;
    CPM_GLOBAL float *powers = cpm_paths_add(to, &w, flight);
    for (cpm_i32 b = 0; b < to->bins; b++) {
        powers[b] = weight * spectrum[b];
        emitted[b] += (double)powers[b];
    }
}

/* One bin of a fresh path that starts in a medium that disperses: each wavelength its own way. */
CPM_INLINE void cpm_paths_start_bin(cpm_paths *to, cpm_u32 path, cpm_flight *flight, cpm_i32 bin, float power,
                                    CPM_GLOBAL double *energy) {
    cpm_walker w;
    energy[CPM_ROW_EMITTED * to->bins + bin] += (double)power;
    if (!(power > 0.0f)) return;
    CPM_CLEAR(w);
    w.path = path, w.direct = 1;
    flight->bin = bin;
    *cpm_paths_add(to, &w, flight) = power;
}
#endif
