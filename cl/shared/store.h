/* shared/store.h: a photon as it is stored: 32 bytes, and one 16-bit float a bin beside them (types/photon.h). */
#ifndef CPM_SHARED_STORE_H
#define CPM_SHARED_STORE_H
#include "../types/photon.h"
#include "bins.h"
#include "half.h"
#include "octahedral.h"

/* `at`: from the map's origin; `spectrum`: index of its first power. */
CPM_INLINE void cpm_photon_pack(CPM_GLOBAL cpm_photon *photon, cpm_vec at, cpm_u32 direction, cpm_u32 normal,
                                cpm_u32 spectrum, cpm_u32 path, cpm_u32 bounce, cpm_i32 bin) {
    photon->position[0] = (float)at.x, photon->position[1] = (float)at.y, photon->position[2] = (float)at.z;
    photon->direction = direction, photon->normal = normal;
    photon->spectrum = spectrum;
    photon->path = path;
    photon->bin = (unsigned short)cpm_bins_stored(bin);
    photon->bounce = (unsigned short)bounce;
}

/* Halves are rounded up or down at random, by what is cut off, so that sums of many keep their mean: all photons of a
 * light may have one power, and rounding it the same way each time would never average out. The random bits are a
 * congruential sequence of each photon's own, one step a bin. */
#define CPM_DITHER_STEP 747796405u
#define CPM_DITHER_ADD 2891336453u
CPM_INLINE cpm_u32 cpm_dither_start(cpm_u32 path, cpm_u32 bounce, cpm_u32 bin) {
    cpm_u32 state = (path * 0x9E3779B9u) ^ (bounce << 16 ^ bin) * 0x85EBCA6Bu;
    state ^= state >> 15;
    return state * 0x2C1B3C6Du;
}
CPM_INLINE cpm_u32 cpm_dither_next(cpm_u32 state) { return state * CPM_DITHER_STEP + CPM_DITHER_ADD; }

/* Of the bits of a float from 2^-14 to 2^15, where 13 of them are cut off. */
CPM_INLINE int cpm_half_dithers(cpm_u32 bits) { return bits - 0x38800000u <= 0x47000000u - 0x38800000u; }
CPM_INLINE unsigned short cpm_half_bits_dithered(cpm_u32 bits, cpm_u32 state) {
    return (unsigned short)((bits + (state >> 19) - (112u << 23)) >> 13);
}
/* Elsewhere to nearest. */
CPM_INLINE unsigned short cpm_half_dithered(float power, cpm_u32 state) {
    cpm_float_bits x;
    x.value = power;
    return cpm_half_dithers(x.bits) ? cpm_half_bits_dithered(x.bits, state) : cpm_half_from_float(power);
}
#endif
