/* photon/store.c: growing arrays of stored photons, one set a thread. */
#include <stdlib.h>
#include <string.h>

#include "cl/shared/half.h"
#include "photons.h"
#include "scene/scene.h"

/* Rounded up or down at random, by what is cut off, so that sums of many keep their mean: all photons of a light may
 * have one power, and rounding it the same way each time would never average out. Below 2^-14 to nearest. */
static uint16_t dithered(float power, uint32_t *state) {
    union {
        float value;
        uint32_t bits;
    } x = {power};
    *state = *state * 747796405u + 2891336453u;
    if (x.bits < 0x38800000u || x.bits > 0x47000000u) return cpm_half_from_float(power);
    x.bits += *state >> 19; /* 13 bits are cut off */
    x.bits &= 0xFFFFE000u;
    return cpm_half_from_float(x.value);
}

int cpm_store_photon(cpm_store *s, const cpm_photon *photon, const float *powers, size_t count) {
    if (!cpm_grow((void **)&s->photons, &s->capacity, s->count, 1, sizeof *s->photons) ||
        !cpm_grow((void **)&s->spectra, &s->spectra_capacity, s->spectra_count, count, sizeof *s->spectra))
        return 0;
    cpm_photon *to = &s->photons[s->count++];
    *to = *photon;
    to->spectrum = (unsigned)s->spectra_count;
    uint32_t state = (photon->path * 0x9E3779B9u) ^ ((uint32_t)photon->bounce << 16 ^ photon->bin) * 0x85EBCA6Bu;
    state ^= state >> 15;
    state *= 0x2C1B3C6Du;
    for (size_t i = 0; i < count; i++) s->spectra[s->spectra_count + i] = dithered(powers[i], &state);
    s->spectra_count += count;
    return s->spectra_count <= 0xFFFFFFFFu;
}

int cpm_store_append(cpm_store *s, cpm_store *from) {
    if (!s->count) {
        cpm_store_free(s);
        *s = *from;
        memset(from, 0, sizeof *from);
        return 1;
    }
    if (!from->count) {
        cpm_store_free(from);
        return 1;
    }
    if (!cpm_grow((void **)&s->photons, &s->capacity, s->count, from->count, sizeof *s->photons) ||
        !cpm_grow((void **)&s->spectra, &s->spectra_capacity, s->spectra_count, from->spectra_count,
                  sizeof *s->spectra) || s->spectra_count + from->spectra_count > 0xFFFFFFFFu)
        return 0;
    for (size_t i = 0; i < from->count; i++) from->photons[i].spectrum += (unsigned)s->spectra_count;
    memcpy(s->photons + s->count, from->photons, from->count * sizeof *s->photons);
    memcpy(s->spectra + s->spectra_count, from->spectra, from->spectra_count * sizeof *s->spectra);
    s->count += from->count;
    s->spectra_count += from->spectra_count;
    cpm_store_free(from);
    return 1;
}

void cpm_store_free(cpm_store *s) {
    free(s->photons), free(s->spectra);
    memset(s, 0, sizeof *s);
}
