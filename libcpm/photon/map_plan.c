/* photon/map_plan.c: who grows what: keys, the upper part of the tree, runs for the threads, their subtrees joined. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "map_build.h"

#define UPPER_BITS 12 /* of a key, by which the photons are partitioned */
#define UPPER_LOW (64 - UPPER_BITS)
#define DIGITS (1 << UPPER_BITS)
#define RUN_SMALL 8192  /* photons that are one thread's work without further ado */
#define RUN_LARGE 65536 /* a single cell up to this size too */

/* --- keys and runs --------------------------------------------------------------------------------------------- */

/* Keys in `grid` of the photons of keys[first .. first + count) (`fresh`: of all), ordered by their upper bits.
 * 0: out of memory or cancelled. */
static int32_t partition(cpm_builder *b, size_t first, size_t count, const cpm_cells *grid, int fresh) {
    const uint64_t index = (UINT64_C(1) << b->index_bits) - 1;
    uint64_t *keys = b->keys + first, *scratch = (uint64_t *)(void *)b->tree->photons;
    const size_t chunks = cpm_builder_chunks(b);
    uint32_t *starts = calloc(chunks * DIGITS, sizeof *starts); /* [chunk][digit] */
    if (!starts) return 0;
#pragma omp parallel num_threads(b->threads)
    {
#pragma omp for schedule(dynamic, 1)
        for (size_t c = 0; c < chunks; c++) {
            if (cpm_poll(b->context)) continue;
            for (size_t i = count * c / chunks; i < count * (c + 1) / chunks; i++) {
                const uint64_t at = fresh ? i : keys[i] & index;
                scratch[i] = cpm_cells_key(grid, &b->given[at], at);
                starts[c * DIGITS + (scratch[i] >> UPPER_LOW)]++;
            }
        }
#pragma omp single
        for (uint32_t digit = 0, sum = 0; digit < DIGITS; digit++)
            for (size_t c = 0; c < chunks; c++) {
                const uint32_t n = starts[c * DIGITS + digit];
                starts[c * DIGITS + digit] = sum;
                sum += n;
            }
#pragma omp for schedule(dynamic, 1)
        for (size_t c = 0; c < chunks; c++) {
            if (cpm_poll(b->context)) continue; /* all chunks were counted, or none is moved */
            for (size_t i = count * c / chunks; i < count * (c + 1) / chunks; i++)
                keys[starts[c * DIGITS + (scratch[i] >> UPPER_LOW)]++] = scratch[i];
        }
    }
    free(starts);
    return !cpm_poll(b->context); /* where a chunk was left out, the keys mean nothing */
}

/* Plans the tree over [first, first + count) down to runs; returns its number, -1 out of memory. */
static int plan_tree(cpm_builder *b, size_t first, size_t count) {
    const uint64_t *keys = b->keys + first;
    int is_run = count <= RUN_SMALL;
    if (!is_run && cpm_keys_agree(keys, count, UPPER_LOW)) {
        is_run = count <= RUN_LARGE || count <= b->tree->count / (size_t)(16 * b->threads);
        if (!is_run) {
            float low[3], high[3];
            cpm_keys_box(b->given, keys, count, b->index_bits, low, high);
            const cpm_cells grid = cpm_cells_make(low, high, b->tree->unit, b->index_bits);
            if (grid.cells == 0.0)
                is_run = 1; /* a single point */
            else if (!partition(b, first, count, &grid, 0))
                return -1;
        }
    }
    if (b->plan_count == b->plan_capacity) {
        const size_t capacity = b->plan_capacity ? 2 * b->plan_capacity : 256;
        cpm_plan *plans = realloc(b->plans, capacity * sizeof *plans);
        if (!plans) return -1;
        b->plans = plans, b->plan_capacity = capacity;
    }
    const size_t number = b->plan_count++;
    b->plans[number] = (cpm_plan){.first = first, .count = count};
    if (is_run) return (int)number;
    size_t starts[CPM_WIDE + 1];
    const int n = cpm_keys_parts(keys, count, UPPER_LOW, cpm_part_target(count), starts);
    for (int i = 0; i < n; i++) {
        const int child = plan_tree(b, first + starts[i], starts[i + 1] - starts[i]);
        if (child < 0) return -1;
        b->plans[number].children[i] = child;
    }
    b->plans[number].n = n;
    return (int)number;
}

int32_t cpm_builder_plan(cpm_builder *b) {
    const cpm_cells grid = cpm_cells_make(b->low, b->high, b->tree->unit, b->index_bits);
    return partition(b, 0, b->tree->count, &grid, 1) && plan_tree(b, 0, b->tree->count) >= 0;
}

/* --- subtrees -------------------------------------------------------------------------------------------------- */

/* Copies the nodes of all runs into one array, in the runs' order, so that the array does not depend on threads. */
static int32_t gather_nodes(cpm_builder *b, const cpm_grove *groves) {
    cpm_map_tree *tree = b->tree;
    size_t node_count = 0;
    for (size_t i = 0; i < b->plan_count; i++) node_count += b->plans[i].n ? 1 : b->plans[i].node_count;
    node_count = node_count ? node_count : 1; /* a single leaf still gets a node above it */
    tree->nodes = aligned_alloc(64, (node_count * sizeof *tree->nodes + 63) / 64 * 64);
    if (!tree->nodes) return 0;

    size_t at = 0;
    for (size_t i = 0; i < b->plan_count; i++) {
        cpm_plan *p = &b->plans[i];
        if (p->n || !p->node_count) continue;
        const uint32_t shift = (uint32_t)(at - p->node_first);
        memcpy(&tree->nodes[at], &groves[p->thread].nodes[p->node_first], p->node_count * sizeof *tree->nodes);
        for (size_t j = at; j < at + p->node_count; j++)
            for (int c = 0; c < CPM_WIDE; c++)
                if (!tree->nodes[j].count[c] && tree->nodes[j].low[0][c] < INFINITY) tree->nodes[j].first[c] += shift;
        p->made.first += shift;
        at += p->node_count;
    }
    for (size_t i = b->plan_count; i-- > 0;) { /* children before parents */
        cpm_plan *p = &b->plans[i];
        cpm_child children[CPM_WIDE];
        for (int c = 0; c < p->n; c++) children[c] = b->plans[p->children[c]].made;
        if (p->n) p->made = cpm_node_join(&tree->nodes[at], children, p->n, (uint32_t)at), at++;
    }
    cpm_child top = b->plans[0].made;
    if (top.count) top = cpm_node_join(&tree->nodes[at], &b->plans[0].made, 1, (uint32_t)at), at++;
    tree->node_count = at, tree->top = top.first, tree->depth = top.depth;
    return 1;
}

int32_t cpm_builder_grow(cpm_builder *b) {
    cpm_map_tree *tree = b->tree;
    size_t longest = 0;
    int32_t failed = 0;
    for (size_t i = 0; i < b->plan_count; i++)
        if (!b->plans[i].n && b->plans[i].count > longest) longest = b->plans[i].count;
    cpm_grove *groves = calloc((size_t)b->threads, sizeof *groves);
    if (!groves) return 0;
#pragma omp parallel num_threads(b->threads) reduction(| : failed)
    {
        cpm_grove *grove = &groves[omp_get_thread_num()];
        *grove = (cpm_grove){.given = b->given,
                             .photons = tree->photons,
                             .points = tree->points,
                             .keys = b->keys,
                             .scratch = malloc(longest * sizeof(uint64_t)),
                             .index_bits = b->index_bits,
                             .unit = tree->unit};
        if (!grove->scratch) failed = 1;
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < b->plan_count; i++) {
            cpm_plan *p = &b->plans[i];
            if (p->n || failed || cpm_poll(b->context)) continue;
            p->thread = omp_get_thread_num();
            p->node_first = grove->node_count;
            p->made = cpm_grove_grow(grove, p->first, p->count);
            p->node_count = grove->node_count - p->node_first;
            failed |= grove->out_of_memory;
        }
        free(grove->scratch);
    }
    if (!failed) failed = cpm_poll(b->context) || !gather_nodes(b, groves);
    for (int t = 0; t < b->threads; t++) free(groves[t].nodes);
    free(groves);
    return !failed;
}
