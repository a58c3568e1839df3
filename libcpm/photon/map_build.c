/* photon/map_build.c: from photons in any order to a tree.
 *
 * 1. One pass over the photons: their box, whether spectra are in range.
 * 2. Keys, partitioned by their upper bits (map_plan.c; parallel, one pass).
 * 3. The upper part of the tree is planned down to runs that one thread can take; a run in a single cell that is too
 *    long for that is divided anew, by all threads.
 * 4. Each thread grows subtrees (map_grow.c): that is where the photons move. The upper nodes are filled in.
 * 5. The spectra follow the photons.
 *
 * Peak: the given arrays, and 32 + 12 + 8 + about 6 bytes a photon beside them. */
#define _DEFAULT_SOURCE /* madvise */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "cl/shared/bins.h"
#include "map_build.h"
#include "pages.h"

#define SURVEY_CHUNK 65536
#define SPECTRA_AHEAD 24 /* photons whose spectra are on their way from memory */
#define FEW 32768        /* photons for which it is not worth waking other threads */

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

/* Why a step was not done. */
static cpm_status given_up(const cpm_builder *b) {
    if (cpm_poll(b->context))
        return cpm_fail(b->context, CPM_ERROR_CANCELLED, "cancelled while building the photon maps");
    return cpm_fail(b->context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a map of %zu photons", b->tree->count);
}

/* --- survey ---------------------------------------------------------------------------------------------------- */

static cpm_status survey(cpm_builder *b) {
    cpm_map_tree *tree = b->tree;
    const cpm_photon *photons = b->given;
    const size_t count = tree->count, bins = tree->bins, limit = tree->spectra_count;
    float lx = FLT_MAX, ly = FLT_MAX, lz = FLT_MAX, hx = -FLT_MAX, hy = -FLT_MAX, hz = -FLT_MAX;
    size_t bad = count, split = 0, powers = 0;
#pragma omp parallel for num_threads(b->threads) schedule(dynamic, SURVEY_CHUNK)                                      \
    reduction(min : lx, ly, lz, bad) reduction(max : hx, hy, hz) reduction(+ : split, powers)
    for (size_t i = 0; i < count; i++) {
        const float x = photons[i].position[0], y = photons[i].position[1], z = photons[i].position[2];
        lx = x < lx ? x : lx, ly = y < ly ? y : ly, lz = z < lz ? z : lz;
        hx = x > hx ? x : hx, hy = y > hy ? y : hy, hz = z > hz ? z : hz;
        const size_t all = photons[i].bin == CPM_ALL_BINS;
        const size_t carried = cpm_photon_count(photons[i].bin, (uint32_t)bins);
        const int good = (x - x) + (y - y) + (z - z) == 0.0f && photons[i].spectrum + carried <= limit &&
                         cpm_photon_first(photons[i].bin) + carried <= bins;
        split += !all;
        powers += carried;
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
    tree->spectra_count = powers;
    if (tree->spectra_count > UINT32_MAX)
        return cpm_fail(b->context, CPM_ERROR_UNSUPPORTED, "%zu photons with %zu values; a map holds 2^32 values",
                        count, tree->spectra_count);

    float largest = 0.0f;
    for (int a = 0; a < 3; a++) largest = fmaxf(largest, fmaxf(fabsf(b->low[a]), fabsf(b->high[a])));
    int exponent = 0;
    frexpf(largest, &exponent); /* largest = [0.5, 1) 2^exponent */
    exponent = exponent < -100 ? -100 : exponent > 126 ? 126 : exponent;
    tree->unit = ldexpf(1.0f, -exponent);
    for (int a = 0; a < 3; a++) tree->extent = fmaxf(tree->extent, b->high[a] * tree->unit - b->low[a] * tree->unit);
    b->index_bits = cpm_index_bits(count);
    return CPM_OK;
}

/* --- spectra --------------------------------------------------------------------------------------------------- */

/* Spectra in the photons' order, where the given photons were if there is room. Where a chunk's spectra begin is
 * counted first. */
static int32_t move_spectra(cpm_builder *b) {
    cpm_map_tree *tree = b->tree;
    const size_t bins = tree->bins, chunks = cpm_builder_chunks(b);
    const size_t bytes = (tree->spectra_count + CPM_PAD) * sizeof *tree->spectra;
    size_t *starts = calloc(chunks + 1, sizeof *starts);
    if (bytes <= tree->count * sizeof *b->given + sizeof(uint16_t[CPM_PAD])) {
        /* fresh pages cost as much as filling them */
        tree->release_spectra = b->release;
        if (b->release == free) {
            tree->spectra = realloc(b->given, bytes);
            if (!tree->spectra) free(b->given);
        } else { /* pages.h: those of the padding too */
            tree->spectra = (uint16_t *)(void *)b->given;
            cpm_pages_trim(b->given, bytes);
        }
    } else {
        b->release(b->given);
        tree->spectra = large_alloc(bytes);
        tree->release_spectra = free;
    }
    b->given = NULL;
    if (!tree->spectra || !starts) {
        free(starts);
        return 0;
    }
    memset(tree->spectra + tree->spectra_count, 0, CPM_PAD * sizeof *tree->spectra);
    if (!tree->unsplit) {
#pragma omp parallel for num_threads(b->threads) schedule(dynamic, 1)
        for (size_t c = 0; c < chunks; c++)
            for (size_t i = tree->count * c / chunks; i < tree->count * (c + 1) / chunks; i++)
                starts[c + 1] += cpm_photon_count(tree->photons[i].bin, (uint32_t)bins);
        for (size_t c = 0; c < chunks; c++) starts[c + 1] += starts[c];
    }
#pragma omp parallel for num_threads(b->threads) schedule(dynamic, 1)
    for (size_t c = 0; c < chunks; c++) {
        if (cpm_poll(b->context)) continue;
        const size_t from = tree->count * c / chunks, to = tree->count * (c + 1) / chunks;
        size_t at = tree->unsplit ? from * bins : starts[c];
        for (size_t i = from; i < to; i++) {
            cpm_photon *p = &tree->photons[i];
            if (i + SPECTRA_AHEAD < to) {
                const char *next = (const char *)(b->given_spectra + p[SPECTRA_AHEAD].spectrum);
                __builtin_prefetch(next);
                __builtin_prefetch(next + 31);
            }
            const size_t n = cpm_photon_count(p->bin, (uint32_t)bins);
            memcpy(tree->spectra + at, b->given_spectra + p->spectrum, n * sizeof *tree->spectra);
            p->spectrum = (uint32_t)at;
            at += n;
        }
    }
    free(starts);
    return !cpm_poll(b->context);
}

/* --- all of it ------------------------------------------------------------------------------------------------- */

static cpm_status build(cpm_builder *b) {
    cpm_map_tree *tree = b->tree;
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

    b->keys = large_alloc(tree->count * sizeof *b->keys);
    tree->photons = large_alloc(tree->count * sizeof *tree->photons);
    if (!b->keys || !tree->photons) return given_up(b);
    if (!cpm_builder_plan(b)) return given_up(b);
    tree->points = large_alloc((3 * tree->count + CPM_PAD) * sizeof *tree->points);
    if (!tree->points) return given_up(b);
    memset(tree->points + 3 * tree->count, 0, CPM_PAD * sizeof *tree->points);
    if (!cpm_builder_grow(b)) return given_up(b);
    free(b->keys);
    b->keys = NULL;
    return move_spectra(b) ? CPM_OK : given_up(b);
}

cpm_status cpm_tree_build(cpm_context *context, cpm_photon *photons, uint16_t *spectra, size_t count,
                          size_t spectra_count, void (*release)(void *), size_t bins, double scale,
                          cpm_map_tree **tree) {
    *tree = NULL;
    cpm_builder b = {.context = context,
                     .tree = calloc(1, sizeof(cpm_map_tree)),
                     .given = photons,
                     .given_spectra = spectra,
                     .release = release,
                     .threads = context ? context->threads : 1};
    cpm_status status;
    if (b.tree) {
        b.tree->count = count, b.tree->spectra_count = spectra_count, b.tree->bins = bins, b.tree->scale = scale;
        b.tree->unit = 1.0f;
        if (count < FEW) b.threads = 1;
        status = build(&b);
    } else {
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a map of %zu photons", count);
    }
    free(b.keys);
    free(b.plans);
    if (b.given) release(b.given);
    if (b.given_spectra) release(b.given_spectra);
    if (status == CPM_OK)
        *tree = b.tree;
    else
        cpm_tree_free(b.tree);
    return status;
}
