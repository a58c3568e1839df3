/* render/gather.c: the radiance estimate's irradiance, direct, later and caustic photons searched apart. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/octahedral.h"
#include "eye.h"

#define PROBES 512     /* photons whose own k-th neighbour is looked up to find the direct cap */
#define QUANTILE 0.9   /* nine in ten photons lie where the estimate reaches k within ... */
#define CAP_FACTOR 1.2 /* ... this many times that radius */

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The radius that direct photons ask for where they are. In the shade there are none: a search without a cap would
 * reach the lit area and blur it outward. A cap leaves the estimate unbiased where fewer than k are found, only
 * noisier. Probes are chosen by path, a power of two apart: a photon more or less somewhere moves no other probe. */
static cpm_status direct_cap(cpm_context *context, const cpm_photons *photons, int32_t nearest, double *cap) {
    const cpm_tree *tree = photons->trees[CPM_DIRECT];
    const cpm_photon *all = cpm_tree_photons(tree);
    size_t count = cpm_tree_count(tree), probes = 0, found = 0;
    if (count < 2 * (size_t)nearest) return CPM_OK; /* nothing to learn from */
    uint32_t apart = 1;
    while (count / PROBES >= 2 * (size_t)apart) apart *= 2;
    for (size_t i = 0; i < count; i++) probes += all[i].path % apart == 0;
    double *radii = malloc((probes + 1) * sizeof *radii);
    cpm_query *query = cpm_query_create(tree);
    if (radii && query) {
        for (size_t i = 0; i < count; i++) {
            if (all[i].path % apart) continue;
            cpm_vec n = cpm_octahedral_decode(all[i].normal);
            const float normal[3] = {(float)n.x, (float)n.y, (float)n.z};
            radii[found++] = cpm_tree_radius(tree, query, all[i].position, normal, nearest, *cap);
        }
        qsort(radii, found, sizeof *radii, compare_doubles);
        if (found) *cap = fmin(*cap, CAP_FACTOR * radii[(size_t)(QUANTILE * (double)(found - 1))]);
    }
    int failed = !radii || !query;
    free(radii);
    if (query) cpm_query_free(query);
    return failed ? cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to search the photon map") : CPM_OK;
}

cpm_status cpm_gather_begin(cpm_context *context, const cpm_photons *photons, const cpm_geometry *geometry,
                            int32_t nearest, double max_radius, cpm_gather *gather) {
    gather->photons = photons;
    gather->geometry = geometry;
    gather->nearest = nearest;
    for (int t = 0; t < CPM_POPULATIONS; t++) gather->max_radius[t] = max_radius > 0.0 ? max_radius : photons->diagonal;
    if (max_radius > 0.0) return CPM_OK;
    return direct_cap(context, photons, nearest, &gather->max_radius[CPM_DIRECT]);
}

int cpm_gather_queries(const cpm_gather *gather, cpm_query *queries[CPM_POPULATIONS]) {
    int ready = 1;
    for (int t = 0; t < CPM_POPULATIONS; t++) {
        const cpm_tree *tree = gather->photons->trees[t];
        queries[t] = cpm_tree_count(tree) ? cpm_query_create(tree) : NULL;
        ready &= queries[t] || !cpm_tree_count(tree);
    }
    return ready;
}

void cpm_gather_queries_free(cpm_query *queries[CPM_POPULATIONS]) {
    for (int t = 0; t < CPM_POPULATIONS; t++)
        if (queries[t]) cpm_query_free(queries[t]);
}

void cpm_gather_irradiance(const cpm_gather *gather, cpm_query *queries[CPM_POPULATIONS], cpm_vec point, cpm_vec normal,
                           double *irradiance, double *scratch) {
    const cpm_photons *photons = gather->photons;
    const size_t bins = photons->bins;
    cpm_vec local = cpm_sub(point, photons->origin);
    const float at[3] = {(float)local.x, (float)local.y, (float)local.z};
    const float n[3] = {(float)normal.x, (float)normal.y, (float)normal.z};
    static const int by_radius[CPM_POPULATIONS] = {CPM_LATER, CPM_DIRECT, CPM_CAUSTIC}; /* the widest first, mostly */
    double whole = 0.0; /* a disc known to lie wholly on its surface: so do all that are smaller */
    memset(irradiance, 0, bins * sizeof *irradiance);
    for (int i = 0; i < CPM_POPULATIONS; i++) {
        const int t = by_radius[i];
        if (!queries[t]) continue;
        memset(scratch, 0, bins * sizeof *scratch);
        double radius =
            cpm_tree_irradiance(photons->trees[t], queries[t], at, n, gather->nearest, gather->max_radius[t], scratch);
        double sum = 0.0, larger = 1.0;
        for (size_t b = 0; b < bins; b++) sum += scratch[b];
        if (!(sum > 0.0)) continue;
        if (gather->geometry && radius > whole) {
            larger = 1.0 / cpm_disc_coverage(gather->geometry, point, normal, radius);
            if (larger == 1.0) whole = radius;
        }
        for (size_t b = 0; b < bins; b++) irradiance[b] += larger * scratch[b];
    }
}
