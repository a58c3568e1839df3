/* shared/bins.h: which bins a path stands for: one, all, or a run of neighbours, in one number.
 *
 *   b >= 0   bin b alone
 *   -1       all bins of the film (the bundle)
 *   -2 - c   a run of two or more, c = first + 256 (count - 1)
 *
 * A run goes the way of its middle bin. A stored photon (types/photon.h) has b or c in 16 bits, and CPM_ALL_BINS for
 * the bundle: no run of at most 256 bins has that number. */
#ifndef CPM_SHARED_BINS_H
#define CPM_SHARED_BINS_H
#include "../dialect.h"
#include "../types/photon.h"

CPM_INLINE cpm_i32 cpm_bins_run(cpm_i32 first, cpm_i32 count, cpm_i32 all) {
    if (count == 1) return first;
    return count == all ? -1 : -2 - (first + ((count - 1) << 8));
}
CPM_INLINE cpm_i32 cpm_bins_first(cpm_i32 bins) { return bins >= 0 ? bins : bins == -1 ? 0 : (-2 - bins) & 255; }
CPM_INLINE cpm_i32 cpm_bins_count(cpm_i32 bins, cpm_i32 all) {
    return bins >= 0 ? 1 : bins == -1 ? all : ((-2 - bins) >> 8) + 1;
}
/* The bin whose way the run goes. */
CPM_INLINE cpm_i32 cpm_bins_middle(cpm_i32 bins, cpm_i32 all) {
    return bins >= 0 ? bins : cpm_bins_first(bins) + cpm_bins_count(bins, all) / 2;
}

/* Of a stored photon. */
CPM_INLINE cpm_u32 cpm_bins_stored(cpm_i32 bins) {
    return bins >= 0 ? (cpm_u32)bins : bins == -1 ? CPM_ALL_BINS : (cpm_u32)(-2 - bins);
}
CPM_INLINE cpm_u32 cpm_photon_first(cpm_u32 bin) { return bin == CPM_ALL_BINS ? 0u : bin & 255u; }
CPM_INLINE cpm_u32 cpm_photon_count(cpm_u32 bin, cpm_u32 all) { return bin == CPM_ALL_BINS ? all : (bin >> 8) + 1u; }
#endif
