/* render/gather.c: the radiance estimate's irradiance, direct, later and caustic photons searched apart. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/host.h"
#include "eye.h"
#include "photon/search_host.h"
/* Embree's tree of floats, instead of ours */
#define CPM_BETWEEN(w, a, b) cpm_geometry_between((w)->geometry, a, b)
/* after the host's */
#include "cl/shared/coverage.h"
#include "cl/shared/eye.h"

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
    const cpm_map_tree *tree = photons->trees[CPM_DIRECT];
    const cpm_photon *all = cpm_tree_photons(tree);
    size_t count = cpm_tree_count(tree), probes = 0, found = 0;
    if (count < 2 * (size_t)nearest) return CPM_OK; /* nothing to learn from */
    uint32_t apart = 1;
    while (count / PROBES >= 2 * (size_t)apart) apart *= 2;
    for (size_t i = 0; i < count; i++) probes += all[i].path % apart == 0;
    double *radii = malloc((probes + 1) * sizeof *radii);
    cpm_map_query *query = cpm_query_create(tree);
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

int cpm_gather_queries(const cpm_gather *gather, cpm_map_query *queries[CPM_POPULATIONS]) {
    int ready = 1;
    for (int t = 0; t < CPM_POPULATIONS; t++) {
        const cpm_map_tree *tree = gather->photons->trees[t];
        queries[t] = cpm_tree_count(tree) ? cpm_query_create(tree) : NULL;
        ready &= queries[t] || !cpm_tree_count(tree);
    }
    return ready;
}

void cpm_gather_queries_free(cpm_map_query *queries[CPM_POPULATIONS]) {
    for (int t = 0; t < CPM_POPULATIONS; t++)
        if (queries[t]) cpm_query_free(queries[t]);
}

const int cpm_gather_order[CPM_POPULATIONS] = {CPM_LATER, CPM_DIRECT, CPM_CAUSTIC};

void cpm_gather_seen(const cpm_gather *gather, const cpm_world *world, cpm_map_query *queries[CPM_POPULATIONS],
                     const cpm_arrival *arrival, double *irradiance) {
    const cpm_hit *hit = &arrival->hit;
    const cpm_vec normal = world_shading_normal(world, hit, eye_facing(world, arrival));
    const cpm_vec placed = cpm_sub(hit->position, gather->photons->origin);
    const uint32_t nearest = (uint32_t)gather->nearest;
    double whole = 0.0;
    memset(irradiance, 0, gather->photons->bins * sizeof *irradiance);
    for (int i = 0; i < CPM_POPULATIONS; i++) {
        const int t = cpm_gather_order[i];
        if (queries[t] && cpm_query_room(queries[t], nearest))
            world_gather(world, gather->geometry != NULL, &queries[t]->state, nearest, gather->max_radius[t], hit,
                         placed, normal, &whole, irradiance);
    }
}
