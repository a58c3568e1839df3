/* Stores of photons (photon/store.h, pages.h): filled by threads at once, closed, nothing lost, nothing twice. */
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "photon/pages.h"
#include "photon/store.h"

#define THREADS 3

/* Photon i of a thread carries its own numbers, and as many bins as they say. */
static size_t bins_of(uint32_t thread, uint32_t i) { return 1 + (thread + i) % 5; }

static void fill(cpm_store_part *part, uint32_t thread, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t spectrum;
        const size_t bins = bins_of(thread, i);
        cpm_photon *photon = cpm_store_place(part, bins, &spectrum);
        assert_non_null(photon);
        *photon = (cpm_photon){.path = i, .bounce = (unsigned short)thread, .spectrum = spectrum};
        for (size_t b = 0; b < bins; b++) part->store->spectra[spectrum + b] = (uint16_t)(i + 7 * b + 1000 * thread);
    }
}

static void threads_fill_one_store(void **state) {
    (void)state;
    static const uint32_t counts[][THREADS] = {{0, 0, 0}, {1, 0, 0}, {5000, 1, 30000}, {4096, 8192, 0}, {0, 0, 12345}};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        cpm_store store;
        cpm_store_part parts[THREADS] = {{0}};
        assert_true(cpm_store_open(&store, (uint64_t)1 << 30));
        for (int t = 0; t < THREADS; t++) parts[t].store = &store;
#pragma omp parallel for num_threads(THREADS) schedule(static, 1)
        for (int t = 0; t < THREADS; t++) fill(&parts[t], (uint32_t)t, counts[c][t]);
        cpm_store_close(&store, parts, THREADS);
        assert_int_equal(store.count, counts[c][0] + counts[c][1] + counts[c][2]);
        uint8_t *seen[THREADS];
        for (int t = 0; t < THREADS; t++) seen[t] = calloc(counts[c][t] + 1, 1);
        for (size_t k = 0; k < store.count; k++) {
            const cpm_photon *p = &store.photons[k];
            assert_true(p->bounce < THREADS && p->path < counts[c][p->bounce]);
            assert_int_equal(seen[p->bounce][p->path]++, 0);
            for (size_t b = 0; b < bins_of(p->bounce, p->path); b++)
                assert_int_equal(store.spectra[p->spectrum + b], (uint16_t)(p->path + 7 * b + 1000u * p->bounce));
        }
        for (int t = 0; t < THREADS; t++) free(seen[t]);
        cpm_store_free(&store);
    }
}

static void a_full_store_says_so(void **state) {
    (void)state;
    cpm_store store;
    cpm_store_part part = {.store = &store};
    uint32_t spectrum;
    assert_true(cpm_store_open(&store, 1 << 18)); /* two runs of photons, two of spectra */
    size_t stored = 0;
    while (cpm_store_place(&part, 3, &spectrum)) stored++;
    assert_int_equal(stored, 8192);
    assert_null(cpm_store_place(&part, 3, &spectrum));
    cpm_store_free(&store);
}

static void pages_keep_what_they_hold(void **state) {
    (void)state;
    size_t bytes = (size_t)1 << 24;
    unsigned char *pages = cpm_pages_reserve(&bytes);
    assert_non_null(pages);
    assert_int_equal(bytes, (size_t)1 << 24);
    for (size_t i = 0; i < bytes; i += 4096) assert_int_equal(pages[i], 0);
    memset(pages, 0x5A, 100000);
    cpm_pages_trim(pages, 100000);
    for (size_t i = 0; i < 100000; i++) assert_int_equal(pages[i], 0x5A);
    cpm_pages_free(pages);
    cpm_pages_free(NULL);
    bytes = SIZE_MAX / 4; /* more than any address space */
    pages = cpm_pages_reserve(&bytes);
    assert_non_null(pages);
    assert_true(bytes > 0 && bytes < SIZE_MAX / 4);
    cpm_pages_free(pages);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_fill_one_store),
        cmocka_unit_test(a_full_store_says_so),
        cmocka_unit_test(pages_keep_what_they_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
