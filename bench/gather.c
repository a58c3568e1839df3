/* bench/gather.c: builds a photon map's tree and asks it for the k nearest; bench/gather.py runs it beside its peers.
 *
 * gather PHOTONS QUERIES RADII [nearest] [threads] [bins] [repeats]
 *
 * PHOTONS, QUERIES: float32, six a row: position, unit normal. RADII: written, float64, r_k of each query.
 * Prints one JSON object: the fastest of `repeats` runs each for the build (records, spectra and all), for the queries
 * of irradiance (k nearest and the sum of their spectra) and of r_k alone; bytes; a checksum of the irradiances. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "backend/native/isa.h"
#include "cl/shared/half.h"
#include "cl/shared/octahedral.h"
#include "cl/shared/philox.h"
#include "photon/map.h"

#define CHUNK 256 /* queries that a thread takes at a time */

static void give_up(const char *what) {
    fprintf(stderr, "gather: %s\n", what);
    exit(1);
}

static float *read_rows(const char *name, size_t *count) {
    FILE *file = fopen(name, "rb");
    if (!file || fseek(file, 0, SEEK_END)) give_up(name);
    long bytes = ftell(file);
    if (bytes < 0 || fseek(file, 0, SEEK_SET)) give_up(name);
    *count = (size_t)bytes / (6 * sizeof(float));
    float *rows = malloc((size_t)bytes + 1);
    if (!rows || fread(rows, 6 * sizeof *rows, *count, file) != *count) give_up(name);
    fclose(file);
    return rows;
}

static cpm_map_tree *build(cpm_context *context, const float *rows, size_t count, size_t bins, double *seconds) {
    cpm_photon *photons = malloc(count * sizeof *photons);
    uint16_t *spectra = malloc(count * bins * sizeof *spectra);
    if (!photons || !spectra) give_up("out of memory");
    for (size_t i = 0; i < count; i++) {
        const float *r = rows + 6 * i;
        const uint32_t normal = cpm_octahedral_encode(cpm_v((double)r[3], (double)r[4], (double)r[5]));
        photons[i] = (cpm_photon){.position = {r[0], r[1], r[2]},
                                  .normal = normal,
                                  .spectrum = (uint32_t)(i * bins),
                                  .path = (uint32_t)i,
                                  .bin = CPM_ALL_BINS};
        const cpm_random random = cpm_philox(0, (uint32_t)i, 0, 0, 0);
        for (size_t b = 0; b < bins; b++)
            spectra[i * bins + b] = cpm_half_from_float(0.25f + (float)(random.v[b & 3] >> 8) * 0x1p-24f);
    }
    cpm_map_tree *tree = NULL;
    const double start = cpm_seconds();
    const cpm_status status =
        cpm_tree_build(context, photons, spectra, count, count * bins, free, bins, 1.0 / (double)count, &tree);
    *seconds = cpm_seconds() - start;
    if (status != CPM_OK) give_up(cpm_context_last_error(context));
    return tree;
}

/* Irradiance (or r_k alone, `irradiance` NULL) of every query; returns seconds. */
static double ask(const cpm_map_tree *tree, const float *rows, size_t count, int nearest, int threads, size_t bins,
                  double *radii, double *irradiance) {
    const double start = cpm_seconds();
#pragma omp parallel num_threads(threads)
    {
        cpm_map_query *query = cpm_query_create(tree);
        if (!query) give_up("out of memory");
#pragma omp for schedule(dynamic, CHUNK)
        for (size_t i = 0; i < count; i++) {
            const float *r = rows + 6 * i;
            if (irradiance)
                radii[i] = cpm_tree_irradiance(tree, query, r, r + 3, nearest, HUGE_VAL, irradiance + i * bins);
            else
                radii[i] = cpm_tree_radius(tree, query, r, r + 3, nearest, HUGE_VAL);
        }
        cpm_query_free(query);
    }
    return cpm_seconds() - start;
}

static unsigned long long checksum(const void *data, size_t bytes) { /* FNV-1a */
    const unsigned char *p = data;
    unsigned long long hash = 14695981039346656037ull;
    for (size_t i = 0; i < bytes; i++) hash = (hash ^ p[i]) * 1099511628211ull;
    return hash;
}

static int number(char **argv, int argc, int at, int otherwise) { return argc > at ? atoi(argv[at]) : otherwise; }

int main(int argc, char **argv) {
    if (argc < 4) give_up("usage: gather PHOTONS QUERIES RADII [nearest] [threads] [bins] [repeats]");
    const int nearest = number(argv, argc, 4, 150), threads = number(argv, argc, 5, 2);
    const size_t bins = (size_t)number(argv, argc, 6, 16);
    const int repeats = number(argv, argc, 7, 3);
    size_t count, query_count;
    float *rows = read_rows(argv[1], &count), *queries = read_rows(argv[2], &query_count);

    const cpm_context_options options = {.struct_size = sizeof options, .threads = threads};
    cpm_context *context = NULL;
    if (cpm_context_create(&options, &context) != CPM_OK) give_up("no context; threads must be 1 to 1024");
    double *radii = malloc(query_count * sizeof *radii);
    double *irradiance = malloc(query_count * bins * sizeof *irradiance);
    if (!radii || !irradiance) give_up("out of memory");

    double best_build = HUGE_VAL, best_irradiance = HUGE_VAL, best_radius = HUGE_VAL;
    cpm_map_tree *tree = NULL;
    for (int i = 0; i < repeats; i++) {
        double seconds;
        cpm_tree_free(tree);
        tree = build(context, rows, count, bins, &seconds);
        best_build = fmin(best_build, seconds);
        best_radius = fmin(best_radius, ask(tree, queries, query_count, nearest, threads, bins, radii, NULL));
        memset(irradiance, 0, query_count * bins * sizeof *irradiance);
        best_irradiance =
            fmin(best_irradiance, ask(tree, queries, query_count, nearest, threads, bins, radii, irradiance));
    }
    FILE *file = fopen(argv[3], "wb");
    if (!file || fwrite(radii, sizeof *radii, query_count, file) != query_count || fclose(file)) give_up(argv[3]);

    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("{\"photons\": %zu, \"queries\": %zu, \"nearest\": %d, \"threads\": %d, \"bins\": %zu, \"isa\": \"%s\", "
           "\"build_seconds\": %.6f, \"irradiance_seconds\": %.6f, \"radius_seconds\": %.6f, "
           "\"bytes\": %zu, \"peak_bytes\": %ld, \"checksum\": \"%016llx\"}\n",
           count, query_count, nearest, threads, bins, cpm_isa_text(cpm_isa_chosen()), best_build, best_irradiance,
           best_radius, cpm_tree_bytes(tree), usage.ru_maxrss * 1024,
           checksum(irradiance, query_count * bins * sizeof *irradiance));
    cpm_tree_free(tree);
    cpm_context_release(context);
    free(rows), free(queries), free(radii), free(irradiance);
    return 0;
}
