/* photon/store.h: stored photons of one population, filled by all threads at once.
 *
 * A thread claims a run of places at a time and fills it; nothing moves until the end, when the places that the
 * threads' last runs left open are filled from the top. Pages are touched once, by the thread that writes them. */
#ifndef CPM_PHOTON_STORE_H
#define CPM_PHOTON_STORE_H
#include <stddef.h>
#include <stdint.h>

#include "cl/types/photon.h"

typedef struct cpm_store {
    cpm_photon *photons; /* both from pages.h */
    uint16_t *spectra;   /* from photon.spectrum on: a 16-bit float for each bin that the photon carries */
    size_t count;        /* places claimed; photons once closed */
    size_t spectra_count;
    size_t capacity, spectra_capacity;
} cpm_store;

/* A thread's part of one store. */
typedef struct cpm_store_part {
    cpm_store *store;
    size_t next, end, spectra_next, spectra_end;
} cpm_store_part;

/* Room for `bytes` of photons and as much of spectra, or what the system grants. 0: out of memory. */
int cpm_store_open(cpm_store *store, uint64_t bytes);
/* Where a photon of so many bins goes, and the index of its spectrum. NULL: no room. */
cpm_photon *cpm_store_place(cpm_store_part *part, size_t bins, uint32_t *spectrum);
/* Joins the parts, so that photons are [0, count). */
void cpm_store_close(cpm_store *store, const cpm_store_part *parts, size_t part_count);
void cpm_store_free(cpm_store *store);
#endif
