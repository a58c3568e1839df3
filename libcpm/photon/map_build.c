/* photon/map_build.c: from photons in any order to a tree: survey, keys, runs, subtrees, spectra.
 *
 * 1. One pass over the photons: their box, whether spectra are in range.
 * 2. Keys, partitioned by their upper bits (parallel, one pass).
 * 3. The upper part of the tree is planned down to runs that one thread can take; a run in a single cell that is too
 *    long for that is divided anew, by all threads.
 * 4. Each thread grows subtrees (map_grow.c): that is where the photons move.
 * 5. The upper nodes are filled in, the spectra follow the photons.
 *
 * Peak: the given arrays, and 32 + 12 + 8 + about 3 bytes a photon beside them; the result's spectra come after the given
 * photons have gone. */
#define _DEFAULT_SOURCE /* madvise */
#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "map_grow.h"

#define UPPER_BITS 12                /* of a key, by which the photons are partitioned */
#define UPPER_LOW (64 - UPPER_BITS)
#define DIGITS (1 << UPPER_BITS)
#define RUN_SMALL 8192               /* photons that are one thread's work without further ado */
#define RUN_LARGE 65536              /* a single cell up to this size too */
#define SPECTRA_AHEAD 24

typedef struct plan { /* a node of the upper tree, or a run */
    size_t first, count;
    int n, children[CPM_WIDE]; /* n = 0: a run, one thread's work */
    cpm_child made;
    int thread;
    size_t node_first, node_count; /* a run's nodes, in its thread's grove */
} plan;

typedef struct builder {
    cpm_context *context;
    cpm_tree *tree;
    cpm_photon *given;
    uint16_t *given_spectra;
    uint64_t *keys;
    plan *plans; /* parents before children */
    size_t plan_count, plan_capacity, run_large;
    float low[3], high[3];
    int index_bits, threads;
} builder;

/* Memory in huge pages where there are any: it is filled and read at random. free() releases it. */
static void *large_alloc(size_t bytes) {
    const size_t page = (size_t)2 << 20;
    if (bytes < 4 * page) return malloc(bytes ? bytes : 1);
    bytes = (bytes + page - 1) / page * page;
    void *memory = aligned_alloc(page, bytes);
#ifdef MADV_HUGEPAGE
    if (memory) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return memory;
}

static cpm_status out_of_memory(const builder *b) {
    return cpm_fail(b->context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a map of %zu photons", b->tree->count);
}

/* --- survey ---------------------------------------------------------------------------------------------------- */

static cpm_status survey(builder *b) {
    cpm_tree *tree = b->tree;
    const cpm_photon *photons = b->given;
    const size_t count = tree->count, bins = tree->bins, limit = tree->spectra_count;
    float lx = FLT_MAX, ly = FLT_MAX, lz = FLT_MAX, hx = -FLT_MAX, hy = -FLT_MAX, hz = -FLT_MAX;
    size_t bad = count, split = 0;
#pragma omp parallel for num_threads(b->threads) schedule(static) reduction(min : lx, ly, lz, bad)                     \
    reduction(max : hx, hy, hz) reduction(+ : split)
    for (size_t i = 0; i < count; i++) {
        const float x = photons[i].position[0], y = photons[i].position[1], z = photons[i].position[2];
        lx = x < lx ? x : lx, ly = y < ly ? y : ly, lz = z < lz ? z : lz;
        hx = x > hx ? x : hx, hy = y > hy ? y : hy, hz = z > hz ? z : hz;
        const size_t all = photons[i].bin == CPM_ALL_BINS;
        const int good = (x - x) + (y - y) + (z - z) == 0.0f && photons[i].spectrum + (all ? bins : 1) <= limit &&
                         (all || photons[i].bin < bins);
        split += !all;
        bad = good || bad < i ? bad : i;
    }
    if (bad < count)
        return cpm_fail(b->context, CPM_ERROR_INTERNAL,
                        "photon %zu is at (%g, %g, %g) with bin %u and spectrum %u; a map takes finite positions, bins "
                        "below %zu or all, spectra below %zu",
                        bad, (double)photons[bad].position[0], (double)photons[bad].position[1],
                        (double)photons[bad].position[2], photons[bad].bin, photons[bad].spectrum, bins, limit);
    b->low[0] = lx, b->low[1] = ly, b->low[2] = lz, b->high[0] = hx, b->high[1] = hy, b->high[2] = hz;
    tree->unsplit = split == 0;
    tree->spectra_count = split + (count - split) * bins;
    if (tree->spectra_count > UINT32_MAX)
        return cpm_fail(b->context, CPM_ERROR_UNSUPPORTED, "%zu photons with %zu values; a map holds 2^32 values",
                        count, tree->spectra_count);

    float largest = 0.0f;
    for (int a = 0; a < 3; a++) largest = fmaxf(largest, fmaxf(fabsf(b->low[a]), fabsf(b->high[a])));
    int exponent = 0;
    frexpf(largest, &exponent); /* largest = [0.5, 1) 2^exponent */
    exponent = exponent < -100 ? -100 : exponent > 126 ? 126 : exponent;
    tree->unit = ldexpf(1.0f, -exponent);
    for (int a = 0; a < 3; a++)
        tree->extent = fmaxf(tree->extent, b->high[a] * tree->unit - b->low[a] * tree->unit);
    b->index_bits = cpm_index_bits(count);
    return CPM_OK;
}

/* --- keys and runs --------------------------------------------------------------------------------------------- */

/* Keys of keys[first .. first + count) in `grid` (`fresh`: of photons 0 .. count), ordered by their upper bits; stable.
 * Until photons move there, the memory of tree->photons is scratch. */
static int32_t partition(builder *b, size_t first, size_t count, const cpm_cells *grid, int fresh) {
    const uint64_t index = (UINT64_C(1) << b->index_bits) - 1;
    uint64_t *keys = b->keys + first, *scratch = (uint64_t *)(void *)b->tree->photons;
    uint32_t *starts = calloc((size_t)b->threads * DIGITS, sizeof *starts); /* [thread][digit] */
    if (!starts) return 0;
#pragma omp parallel num_threads(b->threads)
    {
        const size_t thread = (size_t)omp_get_thread_num(), threads = (size_t)omp_get_num_threads();
        const size_t from = count * thread / threads, to = count * (thread + 1) / threads;
        uint32_t *mine = starts + thread * DIGITS;
        for (size_t i = from; i < to; i++) {
            const uint64_t at = fresh ? i : keys[i] & index;
            scratch[i] = cpm_cells_key(grid, &b->given[at], at);
            mine[scratch[i] >> UPPER_LOW]++;
        }
#pragma omp barrier
#pragma omp single
        for (uint32_t digit = 0, sum = 0; digit < DIGITS; digit++)
            for (size_t t = 0; t < threads; t++) {
                const uint32_t n = starts[t * DIGITS + digit];
                starts[t * DIGITS + digit] = sum;
                sum += n;
            }
        for (size_t i = from; i < to; i++) keys[mine[scratch[i] >> UPPER_LOW]++] = scratch[i];
    }
    free(starts);
    return 1;
}

/* Plans the tree over [first, first + count) down to runs; returns its number, -1 out of memory. */
static int plan_tree(builder *b, size_t first, size_t count) {
    const uint64_t *keys = b->keys + first;
    int is_run = count <= RUN_SMALL;
    if (!is_run && cpm_keys_agree(keys, count, UPPER_LOW)) {
        is_run = count <= b->run_large;
        if (!is_run) {
            float low[3], high[3];
            cpm_keys_box(b->given, keys, count, b->index_bits, low, high);
            const cpm_cells grid = cpm_cells_make(low, high, b->tree->unit, b->index_bits);
            if (grid.cells == 0.0) is_run = 1; /* a single point */
            else if (!partition(b, first, count, &grid, 0)) return -1;
        }
    }
    if (b->plan_count == b->plan_capacity) {
        const size_t capacity = b->plan_capacity ? 2 * b->plan_capacity : 256;
        plan *plans = realloc(b->plans, capacity * sizeof *plans);
        if (!plans) return -1;
        b->plans = plans, b->plan_capacity = capacity;
    }
    const size_t number = b->plan_count++;
    b->plans[number] = (plan){.first = first, .count = count};
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

/* --- subtrees -------------------------------------------------------------------------------------------------- */

/* Copies the nodes of all runs into one array, in the runs' order, so that the array does not depend on threads. */
static int32_t gather_nodes(builder *b, const cpm_grove *groves) {
    cpm_tree *tree = b->tree;
    size_t node_count = 0;
    for (size_t i = 0; i < b->plan_count; i++) node_count += b->plans[i].n ? 1 : b->plans[i].node_count;
    node_count = node_count ? node_count : 1; /* a single leaf still gets a node above it */
    tree->nodes = aligned_alloc(64, (node_count * sizeof *tree->nodes + 63) / 64 * 64);
    if (!tree->nodes) return 0;

    size_t at = 0;
    for (size_t i = 0; i < b->plan_count; i++) {
        plan *p = &b->plans[i];
        if (p->n || !p->node_count) continue;
        const uint32_t shift = (uint32_t)(at - p->node_first);
        memcpy(&tree->nodes[at], &groves[p->thread].nodes[p->node_first], p->node_count * sizeof *tree->nodes);
        for (size_t j = at; j < at + p->node_count; j++)
            for (int c = 0; c < CPM_WIDE; c++)
                if (!tree->nodes[j].count[c]) tree->nodes[j].first[c] += shift;
        p->made.first += shift;
        at += p->node_count;
    }
    for (size_t i = b->plan_count; i-- > 0;) { /* children before parents */
        plan *p = &b->plans[i];
        cpm_child children[CPM_WIDE];
        for (int c = 0; c < p->n; c++) children[c] = b->plans[p->children[c]].made;
        if (p->n) p->made = cpm_node_join(&tree->nodes[at], children, p->n, (uint32_t)at), at++;
    }
    cpm_child top = b->plans[0].made;
    if (top.count) top = cpm_node_join(&tree->nodes[at], &b->plans[0].made, 1, (uint32_t)at), at++;
    tree->node_count = at, tree->top = top.first, tree->depth = top.depth;
    return 1;
}

static int32_t grow(builder *b) {
    cpm_tree *tree = b->tree;
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
            plan *p = &b->plans[i];
            if (p->n || failed) continue;
            p->thread = omp_get_thread_num();
            p->node_first = grove->node_count;
            p->made = cpm_grove_grow(grove, p->first, p->count);
            p->node_count = grove->node_count - p->node_first;
            failed |= grove->out_of_memory;
        }
        free(grove->scratch);
    }
    if (!failed) failed = !gather_nodes(b, groves);
    for (int t = 0; t < b->threads; t++) free(groves[t].nodes);
    free(groves);
    return !failed;
}

/* --- spectra --------------------------------------------------------------------------------------------------- */

/* Spectra in the photons' order, where the given photons were if there is room. A chunk of photons is one thread's; where its spectra begin is counted first. */
static int32_t move_spectra(builder *b) {
    cpm_tree *tree = b->tree;
    const size_t bins = tree->bins, chunks = (size_t)b->threads;
    const size_t bytes = (tree->spectra_count + CPM_PAD) * sizeof *tree->spectra;
    size_t *starts = calloc(chunks + 1, sizeof *starts);
    if (bytes <= tree->count * sizeof *b->given + sizeof(uint16_t[CPM_PAD])) { /* fresh pages cost as much as filling */
        tree->spectra = realloc(b->given, bytes);
        if (tree->spectra) b->given = NULL;
    } else {
        free(b->given);
        b->given = NULL;
        tree->spectra = large_alloc(bytes);
    }
    if (!tree->spectra || !starts) {
        free(starts);
        return 0;
    }
    memset(tree->spectra + tree->spectra_count, 0, CPM_PAD * sizeof *tree->spectra);
    if (!tree->unsplit) {
#pragma omp parallel for num_threads(b->threads) schedule(static, 1)
        for (size_t c = 0; c < chunks; c++)
            for (size_t i = tree->count * c / chunks; i < tree->count * (c + 1) / chunks; i++)
                starts[c + 1] += tree->photons[i].bin == CPM_ALL_BINS ? bins : 1;
        for (size_t c = 0; c < chunks; c++) starts[c + 1] += starts[c];
    }
#pragma omp parallel for num_threads(b->threads) schedule(static, 1)
    for (size_t c = 0; c < chunks; c++) {
        const size_t from = tree->count * c / chunks, to = tree->count * (c + 1) / chunks;
        size_t at = tree->unsplit ? from * bins : starts[c];
        for (size_t i = from; i < to; i++) {
            cpm_photon *p = &tree->photons[i];
            if (i + SPECTRA_AHEAD < to) {
                const char *next = (const char *)(b->given_spectra + p[SPECTRA_AHEAD].spectrum);
                __builtin_prefetch(next);
                __builtin_prefetch(next + 31);
            }
            const size_t n = p->bin == CPM_ALL_BINS ? bins : 1;
            memcpy(tree->spectra + at, b->given_spectra + p->spectrum, n * sizeof *tree->spectra);
            p->spectrum = (uint32_t)at;
            at += n;
        }
    }
    free(starts);
    return 1;
}

/* --- all of it ------------------------------------------------------------------------------------------------- */

static cpm_status build(builder *b) {
    cpm_tree *tree = b->tree;
    if (tree->count > UINT32_MAX)
        return cpm_fail(b->context, CPM_ERROR_UNSUPPORTED, "%zu photons; a map holds 2^32", tree->count);
    if (tree->bins < 1 || tree->bins > CPM_MAX_BINS)
        return cpm_fail(b->context, CPM_ERROR_INVALID_ARGUMENT, "%zu bins; 1 to %d are possible", tree->bins,
                        CPM_MAX_BINS);
    if (tree->count == 0) {
        tree->spectra_count = 0;
        return CPM_OK;
    }
    const cpm_status status = survey(b);
    if (status != CPM_OK) return status;

    b->run_large = tree->count / (size_t)(16 * b->threads);
    b->run_large = b->run_large > RUN_LARGE ? b->run_large : RUN_LARGE;
    b->keys = large_alloc(tree->count * sizeof *b->keys);
    tree->photons = large_alloc(tree->count * sizeof *tree->photons);
    if (!b->keys || !tree->photons) return out_of_memory(b);
    const cpm_cells grid = cpm_cells_make(b->low, b->high, tree->unit, b->index_bits);
    if (!partition(b, 0, tree->count, &grid, 1) || plan_tree(b, 0, tree->count) < 0) return out_of_memory(b);

    tree->points = large_alloc((3 * tree->count + CPM_PAD) * sizeof *tree->points);
    if (!tree->points) return out_of_memory(b);
    memset(tree->points + 3 * tree->count, 0, CPM_PAD * sizeof *tree->points);
    if (!grow(b)) return out_of_memory(b);
    free(b->keys);
    b->keys = NULL;
    return move_spectra(b) ? CPM_OK : out_of_memory(b);
}

cpm_status cpm_tree_build(cpm_context *context, cpm_photon *photons, uint16_t *spectra, size_t count,
                          size_t spectra_count, size_t bins, double scale, cpm_tree **tree) {
    *tree = NULL;
    builder b = {.context = context,
                 .tree = calloc(1, sizeof(cpm_tree)),
                 .given = photons,
                 .given_spectra = spectra,
                 .threads = context ? context->threads : 1};
    cpm_status status;
    if (b.tree) {
        b.tree->count = count, b.tree->spectra_count = spectra_count, b.tree->bins = bins, b.tree->scale = scale;
        b.tree->unit = 1.0f;
        if (count < 4 * RUN_SMALL) b.threads = 1; /* not worth waking anyone */
        status = build(&b);
    } else {
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a map of %zu photons", count);
    }
    free(b.keys);
    free(b.plans);
    free(b.given);
    free(b.given_spectra);
    if (status == CPM_OK) *tree = b.tree;
    else cpm_tree_free(b.tree);
    return status;
}
