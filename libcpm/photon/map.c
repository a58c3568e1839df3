/* photon/map.c: a photon map's tree: what is asked of it. */
#include "map.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "cl/shared/gather.h"
#include "tree.h"

void cpm_tree_free(cpm_tree *tree) {
    if (!tree) return;
    free(tree->photons);
    if (tree->spectra) tree->release_spectra(tree->spectra);
    free(tree->points);
    free(tree->nodes);
    free(tree);
}

size_t cpm_tree_count(const cpm_tree *tree) { return tree->count; }

size_t cpm_tree_bytes(const cpm_tree *tree) {
    if (tree->count == 0) return 0;
    return tree->count * (sizeof *tree->photons + 3 * sizeof *tree->points) +
           tree->spectra_count * sizeof *tree->spectra + tree->node_count * sizeof *tree->nodes;
}

const cpm_photon *cpm_tree_photons(const cpm_tree *tree) { return tree->photons; }
const uint16_t *cpm_tree_spectra(const cpm_tree *tree) { return tree->spectra; }
double cpm_tree_scale(const cpm_tree *tree) { return tree->scale; }

extern const cpm_search cpm_search_baseline;
#if CPM_ISA_COUNT > 1
extern const cpm_search cpm_search_v3, cpm_search_v4;
#endif

const cpm_search *cpm_search_for(cpm_isa isa) {
#if CPM_ISA_COUNT > 1
    if (isa == CPM_ISA_V4) return &cpm_search_v4;
    if (isa == CPM_ISA_V3) return &cpm_search_v3;
#endif
    (void)isa;
    return &cpm_search_baseline;
}

/* --- queries --------------------------------------------------------------------------------------------------- */

#define NEAREST_USUAL 1024u /* room for so many is made at once: later queries then cannot run out of memory */

int32_t cpm_query_room(cpm_query *query, uint32_t k) {
    const size_t nearest = k < query->tree->count ? k : query->tree->count;
    const size_t capacity = 3 * nearest + 1024; /* so that buffers are seldom pruned to k */
    if (capacity <= query->capacity) return 1;
    float *distance = malloc((capacity + CPM_PAD) * sizeof *distance);
    uint32_t *id = malloc((capacity + CPM_PAD) * sizeof *id);
    uint64_t *order = malloc(capacity * sizeof *order);
    if (!distance || !id || !order) {
        free(distance);
        free(id);
        free(order);
        return 0;
    }
    free(query->distance);
    free(query->id);
    free(query->order);
    query->distance = distance, query->id = id, query->order = order, query->capacity = capacity;
    return 1;
}

cpm_query *cpm_query_create(const cpm_tree *tree) {
    cpm_query *query = calloc(1, sizeof *query);
    if (!query) return NULL;
    query->tree = tree;
    query->search = cpm_search_for(cpm_isa_chosen());
    query->stack = malloc((size_t)(tree->depth + 1) * sizeof *query->stack);
    query->sum = malloc((tree->bins + CPM_PAD) * sizeof *query->sum);
    if (query->stack && query->sum && cpm_query_room(query, NEAREST_USUAL)) return query;
    cpm_query_free(query);
    return NULL;
}

void cpm_query_free(cpm_query *query) {
    if (!query) return;
    free(query->distance);
    free(query->id);
    free(query->order);
    free(query->stack);
    free(query->sum);
    free(query);
}

/* Finds the k nearest; *radius2 is in m^2. 0: nothing can be found, or no memory for so large a k. */
static int32_t find(const cpm_tree *tree, cpm_query *query, const float *point, const float *normal, int32_t k,
                    double max_radius, cpm_found *found, double *radius2) {
    if (tree->count == 0 || !(max_radius > 0.0)) return 0;
    const double unit = (double)tree->unit, limit = max_radius * unit;
    const uint32_t nearest = k < 1 ? 1 : (uint32_t)k;
    if (!cpm_query_room(query, nearest)) return 0;
    float scaled[3], largest = 0.0f;
    for (int a = 0; a < 3; a++) {
        scaled[a] = point[a] * tree->unit;
        largest = fmaxf(largest, fabsf(scaled[a]));
    }
    *found = (cpm_found){0};
    if (largest <= FLT_MAX) /* else infinitely far from all */
        *found = query->search->nearest(query, scaled, normal, nearest, (float)fmin(limit * limit, (double)FLT_MAX));
    *radius2 = found->enough ? (double)found->radius2 / (unit * unit) : max_radius * max_radius;
    /* k photons in one single point, or a vanishing max_radius: no density is finite. The spacing of floats there is
     * the least radius that means anything. */
    const double least = 0x1p-24 * fmax((double)largest, 0x1p-24) / unit;
    *radius2 = fmax(*radius2, least * least);
    return 1;
}

double cpm_tree_irradiance(const cpm_tree *tree, cpm_query *query, const float *point, const float *normal, int32_t k,
                           double max_radius, double *irradiance) {
    cpm_found found;
    double radius2;
    if (!find(tree, query, point, normal, k, max_radius, &found, &radius2)) return 0.0;
    if (found.count > 0) {
        query->search->sum(query, found.count);
        const double factor = cpm_gather_factor(tree->scale, radius2);
        for (size_t b = 0; b < tree->bins; b++) irradiance[b] += factor * query->sum[b];
    }
    return found.enough ? sqrt(radius2) : max_radius;
}

double cpm_tree_radius(const cpm_tree *tree, cpm_query *query, const float *point, const float *normal, int32_t k,
                       double max_radius) {
    cpm_found found;
    double radius2;
    if (!find(tree, query, point, normal, k, max_radius, &found, &radius2)) return 0.0;
    return found.enough ? sqrt((double)found.radius2) / (double)tree->unit : max_radius;
}
