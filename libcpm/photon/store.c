/* photon/store.c: stored photons of one population; see store.h. */
#include "store.h"

#include <string.h>

#include "pages.h"

#define RUN 4096          /* photons that a thread claims at a time: 32 pages */
#define SPECTRA_RUN 65536 /* halves, likewise */
#define MOST 0xFFFFFFFFu  /* photons, and halves: their numbers are 32 bits */

int cpm_store_open(cpm_store *s, uint64_t bytes) {
    size_t photons = bytes, spectra = bytes;
    memset(s, 0, sizeof *s);
    if (photons > MOST * sizeof *s->photons) photons = MOST * sizeof *s->photons;
    if (spectra > MOST * sizeof *s->spectra) spectra = MOST * sizeof *s->spectra;
    s->photons = cpm_pages_reserve(&photons);
    s->spectra = cpm_pages_reserve(&spectra);
    if (!s->photons || !s->spectra) {
        cpm_store_free(s);
        return 0;
    }
    s->capacity = photons / sizeof *s->photons;
    s->spectra_capacity = spectra / sizeof *s->spectra;
    return 1;
}

/* A run of places in either array, [*next, *end). */
static int claim(size_t *count, size_t capacity, size_t run, size_t *next, size_t *end) {
    size_t first;
#pragma omp atomic capture
    {
        first = *count;
        *count += run;
    }
    *next = first, *end = first + run;
    return *end <= capacity;
}

cpm_photon *cpm_store_place(cpm_store_part *part, size_t bins, uint32_t *spectrum) {
    cpm_store *s = part->store;
    if (part->next == part->end) {
        if (!claim(&s->count, s->capacity, RUN, &part->next, &part->end)) {
            part->next = part->end;
            return NULL;
        }
        cpm_pages_expect(s->photons + part->next, RUN * sizeof *s->photons);
    }
    if (part->spectra_next + bins > part->spectra_end) {
        if (!claim(&s->spectra_count, s->spectra_capacity, SPECTRA_RUN, &part->spectra_next, &part->spectra_end)) {
            part->spectra_next = part->spectra_end;
            return NULL;
        }
        cpm_pages_expect(s->spectra + part->spectra_next, SPECTRA_RUN * sizeof *s->spectra);
    }
    *spectrum = (uint32_t)part->spectra_next;
    part->spectra_next += bins;
    return &s->photons[part->next++];
}

/* Is a place one that a part has left open? */
static int is_open(size_t place, const cpm_store_part *parts, size_t part_count) {
    for (size_t i = 0; i < part_count; i++)
        if (place >= parts[i].next && place < parts[i].end) return 1;
    return 0;
}

void cpm_store_close(cpm_store *s, const cpm_store_part *parts, size_t part_count) {
    size_t top = s->count, open = 0;
    for (size_t i = 0; i < part_count; i++) open += parts[i].end - parts[i].next;
    s->count -= open;
    for (size_t i = 0; i < part_count; i++)
        for (size_t place = parts[i].next; place < parts[i].end && place < s->count; place++) {
            do top--;
            while (is_open(top, parts, part_count));
            s->photons[place] = s->photons[top];
        }
}

void cpm_store_free(cpm_store *s) {
    cpm_pages_free(s->photons), cpm_pages_free(s->spectra);
    memset(s, 0, sizeof *s);
}
