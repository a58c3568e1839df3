/* photon/store.c: growing arrays of stored photons, one set a thread. */
#include <stdlib.h>
#include <string.h>

#include "cl/shared/half.h"
#include "photons.h"
#include "scene/scene.h"

int cpm_store_photon(cpm_store *s, const cpm_photon *photon, const float *powers, size_t count) {
    if (!cpm_grow((void **)&s->photons, &s->capacity, s->count, 1, sizeof *s->photons) ||
        !cpm_grow((void **)&s->spectra, &s->spectra_capacity, s->spectra_count, count, sizeof *s->spectra))
        return 0;
    cpm_photon *to = &s->photons[s->count++];
    *to = *photon;
    to->spectrum = (unsigned)s->spectra_count;
    for (size_t i = 0; i < count; i++) s->spectra[s->spectra_count + i] = cpm_half_from_float(powers[i]);
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
