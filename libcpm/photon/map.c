/* photon/map.c: a photon map's tree: what is asked of it. */
#include "map.h"

#include <math.h>
#include <stdlib.h>

#include "search_host.h"
/* after the host's */
#include "cl/shared/map_search.h"

void cpm_tree_free(cpm_map_tree *tree) {
    if (!tree) return;
    free(tree->photons);
    if (tree->spectra) tree->release_spectra(tree->spectra);
    free(tree->points);
    free(tree->nodes);
    free(tree);
}

size_t cpm_tree_count(const cpm_map_tree *tree) { return tree->count; }

size_t cpm_tree_bytes(const cpm_map_tree *tree) {
    if (tree->count == 0) return 0;
    return tree->count * (sizeof *tree->photons + 3 * sizeof *tree->points) +
           tree->spectra_count * sizeof *tree->spectra + tree->node_count * sizeof *tree->nodes;
}

const cpm_photon *cpm_tree_photons(const cpm_map_tree *tree) { return tree->photons; }
const uint16_t *cpm_tree_spectra(const cpm_map_tree *tree) { return tree->spectra; }
double cpm_tree_scale(const cpm_map_tree *tree) { return tree->scale; }

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

cpm_map_view cpm_tree_view(const cpm_map_tree *tree) {
    const cpm_map_view view = {.nodes = tree->nodes,
                               .points = tree->points,
                               .photons = tree->photons,
                               .spectra = tree->spectra,
                               .is = {.scale = tree->scale,
                                      .count = tree->count,
                                      .unit = tree->unit,
                                      .extent = tree->extent,
                                      .top = tree->top,
                                      .depth = tree->depth,
                                      .unsplit = tree->unsplit,
                                      .bins = (cpm_u32)tree->bins}};
    return view;
}

int32_t cpm_query_room(cpm_map_query *query, uint32_t k) {
    cpm_map_search *s = &query->state;
    const size_t capacity = (size_t)CPM_MAP_CAPACITY(k, query->tree->count);
    if (capacity <= s->capacity) return 1;
    float *distance = malloc((capacity + CPM_PAD) * sizeof *distance);
    uint32_t *id = malloc((capacity + CPM_PAD) * sizeof *id);
    uint64_t *order = malloc(capacity * sizeof *order);
    if (!distance || !id || !order) {
        free(distance);
        free(id);
        free(order);
        return 0;
    }
    free(s->distance);
    free(s->id);
    free(s->order);
    s->distance = distance, s->id = id, s->order = order, s->capacity = capacity;
    return 1;
}

cpm_map_query *cpm_query_create(const cpm_map_tree *tree) {
    cpm_map_query *query = calloc(1, sizeof *query);
    if (!query) return NULL;
    query->tree = tree;
    query->search = cpm_search_for(cpm_isa_chosen());
    query->state.map = cpm_tree_view(tree);
    query->state.stack = malloc((size_t)(tree->depth + 1) * sizeof *query->state.stack);
    query->state.sum = malloc((tree->bins + CPM_PAD) * sizeof *query->state.sum);
    if (query->state.stack && query->state.sum && cpm_query_room(query, NEAREST_USUAL)) return query;
    cpm_query_free(query);
    return NULL;
}

void cpm_query_free(cpm_map_query *query) {
    if (!query) return;
    free(query->state.distance);
    free(query->state.id);
    free(query->state.order);
    free(query->state.stack);
    free(query->state.sum);
    free(query);
}

double cpm_tree_irradiance(const cpm_map_tree *tree, cpm_map_query *query, const float *point, const float *normal,
                           int32_t k, double max_radius, double *irradiance) {
    const uint32_t nearest = k < 1 ? 1 : (uint32_t)k;
    cpm_map_found found;
    (void)tree;
    if (!cpm_query_room(query, nearest)) return 0.0;
    return cpm_map_irradiance(&query->state, point, normal, nearest, max_radius, &found, irradiance);
}

double cpm_tree_radius(const cpm_map_tree *tree, cpm_map_query *query, const float *point, const float *normal,
                       int32_t k, double max_radius) {
    const uint32_t nearest = k < 1 ? 1 : (uint32_t)k;
    cpm_map_found found;
    (void)tree;
    if (!cpm_query_room(query, nearest)) return 0.0;
    return cpm_map_kth_radius(&query->state, point, normal, nearest, max_radius, &found);
}
