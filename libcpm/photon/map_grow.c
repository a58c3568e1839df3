/* photon/map_grow.c: subtrees, each grown by one thread: order the keys, move the photons, make the nodes. */
#include "map_grow.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/gather.h"

#define AHEAD 48 /* photons that are on their way from memory while a leaf is made */

static void widen(float *low, float *high, const float *position) {
    for (int a = 0; a < 3; a++) {
        low[a] = position[a] < low[a] ? position[a] : low[a];
        high[a] = position[a] > high[a] ? position[a] : high[a];
    }
}

void cpm_keys_box(const cpm_photon *photons, const uint64_t *keys, size_t count, int index_bits, float *low,
                  float *high) {
    const uint64_t index = (UINT64_C(1) << index_bits) - 1;
    for (int a = 0; a < 3; a++) low[a] = FLT_MAX, high[a] = -FLT_MAX;
    for (size_t i = 0; i < count; i++) widen(low, high, photons[keys[i] & index].position);
}

cpm_child cpm_node_join(cpm_node *node, const cpm_child *children, int n, uint32_t number) {
    memset(node->padding, 0, sizeof node->padding);
    cpm_child sum = children[0];
    sum.first = number, sum.count = 0;
    for (int i = 0; i < n; i++) {
        const cpm_child *c = &children[i];
        node->first[i] = c->first, node->count[i] = c->count;
        for (int a = 0; a < 3; a++) {
            node->low[a][i] = c->low[a], node->high[a][i] = c->high[a];
            node->facing_low[i][a] = c->facing_low[a], node->facing_high[i][a] = c->facing_high[a];
            sum.low[a] = c->low[a] < sum.low[a] ? c->low[a] : sum.low[a];
            sum.high[a] = c->high[a] > sum.high[a] ? c->high[a] : sum.high[a];
            sum.facing_low[a] = c->facing_low[a] < sum.facing_low[a] ? c->facing_low[a] : sum.facing_low[a];
            sum.facing_high[a] = c->facing_high[a] > sum.facing_high[a] ? c->facing_high[a] : sum.facing_high[a];
        }
        sum.depth = c->depth > sum.depth ? c->depth : sum.depth;
    }
    for (int i = n; i < CPM_WIDE; i++) {
        node->first[i] = node->count[i] = 0;
        for (int a = 0; a < 3; a++) {
            node->low[a][i] = node->high[a][i] = INFINITY; /* infinitely far from every point */
            node->facing_low[i][a] = node->facing_high[i][a] = 0;
        }
    }
    sum.depth++;
    return sum;
}

/* Points, box and normals of the leaf whose photons stand at `first`. */
static cpm_child leaf_of(const cpm_grove *grove, size_t first, size_t count) {
    const cpm_photon *photons = grove->photons + first;
    float *points = grove->points + 3 * first;
    cpm_child leaf = {.first = (uint32_t)first, .count = (uint32_t)count};
    for (int a = 0; a < 3; a++, points += count) {
        float low = FLT_MAX, high = -FLT_MAX;
        for (size_t i = 0; i < count; i++) {
            float x = photons[i].position[a] * grove->unit;
            points[i] = x;
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        leaf.low[a] = low, leaf.high[a] = high;
    }
    double low[3] = {2.0, 2.0, 2.0}, high[3] = {-2.0, -2.0, -2.0};
    for (size_t i = 0; i < count; i++) {
        if (i > 0 && photons[i].normal == photons[i - 1].normal) continue; /* mostly: a leaf on one wall */
        cpm_vec n = cpm_octahedral_decode(photons[i].normal);
        const double c[3] = {n.x, n.y, n.z};
        for (int a = 0; a < 3; a++) low[a] = fmin(low[a], c[a]), high[a] = fmax(high[a], c[a]);
    }
    for (int a = 0; a < 3; a++) {
        leaf.facing_low[a] = (int8_t)floor(low[a] * CPM_FACING);
        leaf.facing_high[a] = (int8_t)ceil(high[a] * CPM_FACING);
    }
    return leaf;
}

/* Sends for the photons of the keys up to AHEAD beyond `end`. Both ends: a record may lie across two lines. */
static void send_ahead(cpm_grove *grove, size_t end, size_t run_end) {
    const uint64_t index = (UINT64_C(1) << grove->index_bits) - 1;
    size_t upto = end + AHEAD < run_end ? end + AHEAD : run_end;
    for (; grove->ahead < upto; grove->ahead++) {
        const char *photon = (const char *)&grove->given[grove->keys[grove->ahead] & index];
        __builtin_prefetch(photon);
        __builtin_prefetch(photon + sizeof(cpm_photon) - 1);
    }
}

static uint64_t order_of(const cpm_photon *p) { return cpm_photon_order(p->path, p->bounce, p->bin); }

static cpm_child leaf(cpm_grove *grove, size_t first, size_t count, size_t run_end) {
    const uint64_t index = (UINT64_C(1) << grove->index_bits) - 1;
    send_ahead(grove, first + count, run_end);
    cpm_photon *out = grove->photons + first;
    for (size_t i = 0; i < count; i++) { /* insertion: photons mostly come in the order of their paths */
        const cpm_photon *p = &grove->given[grove->keys[first + i] & index];
        uint64_t order = order_of(p);
        size_t at = i;
        for (; at > 0 && order_of(&out[at - 1]) > order; at--) out[at] = out[at - 1];
        out[at] = *p;
    }
    return leaf_of(grove, first, count);
}

static int by_order(const void *a, const void *b) {
    uint64_t x = order_of(a), y = order_of(b);
    return (x > y) - (x < y);
}

/* A leaf of any number of photons in one point. */
static cpm_child point_leaf(cpm_grove *grove, size_t first, size_t count) {
    const uint64_t index = (UINT64_C(1) << grove->index_bits) - 1;
    int ordered = 1;
    for (size_t i = 0; i < count; i++) {
        grove->photons[first + i] = grove->given[grove->keys[first + i] & index];
        if (i > 0 && by_order(&grove->photons[first + i - 1], &grove->photons[first + i]) > 0) ordered = 0;
    }
    if (!ordered) qsort(grove->photons + first, count, sizeof(cpm_photon), by_order);
    return leaf_of(grove, first, count);
}

/* The number of a new node, its content still open. */
static size_t new_node(cpm_grove *grove) {
    if (grove->node_count == grove->node_capacity) {
        size_t capacity = grove->node_capacity ? 2 * grove->node_capacity : 64;
        cpm_node *nodes = realloc(grove->nodes, capacity * sizeof *nodes);
        if (!nodes) {
            grove->out_of_memory = 1;
            return 0;
        }
        grove->nodes = nodes, grove->node_capacity = capacity;
    }
    return grove->node_count++;
}

static cpm_child subtree(cpm_grove *grove, size_t first, size_t count, size_t run_end) {
    uint64_t *keys = grove->keys + first;
    if (count <= CPM_LEAF) return leaf(grove, first, count, run_end);
    if (cpm_keys_agree(keys, count, grove->index_bits)) { /* one cell: divide it anew, unless it is one point */
        float low[3], high[3];
        cpm_keys_box(grove->given, keys, count, grove->index_bits, low, high);
        if (low[0] == high[0] && low[1] == high[1] && low[2] == high[2]) return point_leaf(grove, first, count);
        const cpm_cells grid = cpm_cells_make(low, high, grove->unit, grove->index_bits);
        if (grid.cells == 0.0) return point_leaf(grove, first, count); /* scaled, they differ by less than a float */
        for (size_t i = 0; i < count; i++) {
            uint64_t at = keys[i] & ((UINT64_C(1) << grove->index_bits) - 1);
            keys[i] = cpm_cells_key(&grid, &grove->given[at], at);
        }
        cpm_keys_sort(keys, grove->scratch, count, grove->index_bits);
        grove->ahead = first;
    }
    size_t starts[CPM_WIDE + 1];
    int n = cpm_keys_parts(keys, count, grove->index_bits, cpm_part_target(count), starts);
    cpm_child children[CPM_WIDE];
    for (int i = 0; i < n && !grove->out_of_memory; i++)
        children[i] = subtree(grove, first + starts[i], starts[i + 1] - starts[i], run_end);
    size_t number = grove->out_of_memory ? 0 : new_node(grove);
    if (grove->out_of_memory) return (cpm_child){0};
    return cpm_node_join(&grove->nodes[number], children, n, (uint32_t)number);
}

cpm_child cpm_grove_grow(cpm_grove *grove, size_t first, size_t count) {
    cpm_keys_sort(grove->keys + first, grove->scratch, count, grove->index_bits);
    grove->ahead = first;
    return subtree(grove, first, count, first + count);
}
