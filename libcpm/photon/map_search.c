/* photon/map_search.c: the k nearest photons, and the sum of their spectra. Compiled once for each instruction set.
 *
 * Not the usual heap of k: all photons within a guessed radius are listed (their number is nearly right when neighbours
 * are asked one after the other), then the k-th smallest distance is selected. Too few: the radius grows. Too many for
 * the buffer: it is cut to the k nearest, and the radius shrinks to theirs. The list always holds every photon within
 * the radius that could be among the k nearest, so the guess changes the cost and never the result. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/bins.h"
#include "cl/shared/gather.h"
#include "cl/shared/half.h"
#include "tree.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__AVX512BW__)
#include "lanes_v4.h"
#elif defined(__AVX2__) && defined(__F16C__)
#include "lanes_list.h"
#include "lanes_v3.h"
#else
#include "lanes_any.h"
#include "lanes_list.h"
#endif
#include "map_select.h"

/* --- selection ------------------------------------------------------------------------------------------------- */

static int by_value(const void *a, const void *b) {
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Keeps, of n listed, those nearer than t and the `ties` first ones at t by (path, bounce, bin). Returns how many. */
static size_t keep_nearest(cpm_query *query, size_t n, float t, size_t ties) {
    if (ties == 0) return lanes_below(query->distance, query->id, n, t);
    const cpm_photon *photons = query->tree->photons;
    size_t tied = 0;
    for (size_t i = 0; i < n; i++)
        if (query->distance[i] == t) {
            const cpm_photon *p = &photons[query->id[i]];
            query->order[tied++] = cpm_photon_order(p->path, p->bounce, p->bin);
        }
    uint64_t last = UINT64_MAX;
    if (ties < tied) {
        qsort(query->order, tied, sizeof *query->order, by_value);
        last = query->order[ties - 1];
    }
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        int keep = query->distance[i] < t;
        if (query->distance[i] == t) {
            const cpm_photon *p = &photons[query->id[i]];
            keep = cpm_photon_order(p->path, p->bounce, p->bin) <= last;
        }
        query->distance[m] = query->distance[i], query->id[m] = query->id[i];
        m += (size_t)keep;
    }
    return m;
}

/* --- listing --------------------------------------------------------------------------------------------------- */

/* Of the children in `mask`: those that may hold photons facing as `normal` does; *all: those that hold no others. */
static uint32_t facing(const cpm_node *node, uint32_t mask, const float *normal, uint32_t *all) {
    uint32_t some = 0, every = 0;
    for (uint32_t rest = mask; rest; rest &= rest - 1) {
        const int i = __builtin_ctz(rest);
        float least = 0.0f, most = 0.0f;
        for (int a = 0; a < 3; a++) {
            const float low = normal[a] * (float)node->facing_low[i][a];
            const float high = normal[a] * (float)node->facing_high[i][a];
            least += low < high ? low : high;
            most += low < high ? high : low;
        }
        /* cos 60 degrees, with room for rounding: in between, each photon decides */
        some |= (uint32_t)(most >= 0.499f * CPM_FACING) << i;
        every |= (uint32_t)(least >= 0.501f * CPM_FACING) << i;
    }
    *all = every;
    return some;
}

typedef struct listing {
    cpm_query *query;
    const float *point, *normal;
    uint32_t k;
    float radius2;
    size_t n;
} listing;

/* Makes room for `more`: cuts the list to its k nearest. */
static void cut(listing *l) {
    size_t below;
    const float t = kth_distance(l->query->distance, l->n, l->k, l->radius2, &below);
    l->n = keep_nearest(l->query, l->n, t, l->k - below);
    l->radius2 = t;
}

/* Keeps those listed from `from` on that face as the normal does. */
static void keep_facing(listing *l, size_t from) {
    const cpm_query *q = l->query;
    size_t m = from;
    for (size_t i = from; i < l->n; i++) {
        q->distance[m] = q->distance[i], q->id[m] = q->id[i];
        m += cpm_same_side(q->tree->photons[q->id[i]].normal, l->normal[0], l->normal[1], l->normal[2]) != 0;
    }
    l->n = m;
}

/* A leaf in one point: beyond its first k photons none can be among the k nearest. */
static void list_point(listing *l, uint32_t first, uint32_t count, int mixed) {
    const cpm_query *q = l->query;
    const float *p = q->tree->points + 3 * (size_t)first;
    const float d = cpm_distance2(p[0] - l->point[0], p[count] - l->point[1], p[2 * (size_t)count] - l->point[2]);
    if (!(d <= l->radius2)) return;
    const uint32_t most = count < l->k ? count : l->k;
    if (l->n + most > q->capacity) cut(l);
    if (!(d <= l->radius2)) return;
    for (uint32_t i = 0, listed = 0; i < count && listed < most; i++) {
        if (mixed && !cpm_same_side(q->tree->photons[first + i].normal, l->normal[0], l->normal[1], l->normal[2]))
            continue;
        q->distance[l->n] = d, q->id[l->n] = first + i;
        l->n++, listed++;
    }
}

static void list_leaf(listing *l, uint32_t first, uint32_t count, int mixed) {
    const cpm_query *q = l->query;
    if (count > CPM_LEAF) {
        list_point(l, first, count, mixed);
        return;
    }
    if (l->n + count > q->capacity) cut(l);
    const size_t from = l->n;
    const float *points = q->tree->points + 3 * (size_t)first;
    l->n = lanes_leaf(points, first, count, l->point, l->radius2, q->distance, q->id, from);
    if (mixed) keep_facing(l, from);
}

/* Lists the photons within the radius, in the tree's order: depth first, children from left to right. On the stack:
 * a node, its children still to be visited, and those of them whose photons all face the right way. */
static void list_photons(listing *l) {
    const cpm_tree *tree = l->query->tree;
    uint64_t *stack = l->query->stack;
    int depth = 0, uniform = 0;
    uint32_t number = tree->top;
    for (;;) {
        const cpm_node *node = &tree->nodes[number];
        uint32_t todo = lanes_boxes(node, l->point, l->radius2), all = 0xffu;
        if (!uniform) todo = facing(node, todo, l->normal, &all);
        for (;;) {
            if (!todo) {
                if (!depth) return;
                const uint64_t entry = stack[--depth];
                number = (uint32_t)(entry >> 32), todo = (uint32_t)entry & 0xffu, all = (uint32_t)entry >> 8;
                node = &tree->nodes[number];
            }
            const int i = __builtin_ctz(todo);
            todo &= todo - 1;
            uniform = all >> i & 1;
            if (!node->count[i]) {
                if (todo) stack[depth++] = (uint64_t)number << 32 | all << 8 | todo;
                number = node->first[i];
                break;
            }
            list_leaf(l, node->first[i], node->count[i], !uniform);
        }
    }
}

/* --- the two functions ----------------------------------------------------------------------------------------- */

static cpm_found nearest(cpm_query *query, const float *point, const float *normal, uint32_t k, float limit) {
    const cpm_tree *tree = query->tree;
    const float fk = (float)k, spread = 1.0f + 2.5f / sqrtf(fk); /* of the number of photons, as it fluctuates */
    const float smallest = fmaxf(1e-14f * tree->extent * tree->extent, 1e-36f);
    float guess = query->guess > 0.0f ? query->guess * fk : tree->extent * tree->extent * fk / (float)tree->count;
    listing l = {.query = query, .point = point, .normal = normal, .k = k};
    l.radius2 = k > tree->count ? limit : fminf(fmaxf(guess * spread, smallest), limit);
    for (;;) {
        const float asked = l.radius2;
        l.n = 0;
        list_photons(&l);
        if (l.n >= k || asked >= limit) break;
        const float growth = fk * spread / (float)(l.n + 1); /* on a surface numbers go as squared radii */
        l.radius2 = fminf(asked * fminf(fmaxf(growth, 1.4f), 16.0f), limit);
    }
    cpm_found found = {.radius2 = limit, .count = (uint32_t)l.n, .enough = l.n >= k};
    if (found.enough) {
        size_t below;
        found.radius2 = kth_distance(query->distance, l.n, k, l.radius2, &below);
        found.count = (uint32_t)keep_nearest(query, l.n, found.radius2, k - 1 - below);
    }
    if (found.radius2 > 0.0f) query->guess = found.radius2 / fk;
    return found;
}

/* Trees of split photons: a run of bins or all of them, as each photon says. */
static void sum_split(const cpm_query *query, uint32_t count) {
    const cpm_tree *tree = query->tree;
    for (uint32_t i = 0; i < count; i++) {
        const cpm_photon *p = &tree->photons[query->id[i]];
        const uint16_t *halves = tree->spectra + p->spectrum;
        double *to = query->sum + cpm_photon_first(p->bin);
        const size_t carried = cpm_photon_count(p->bin, (uint32_t)tree->bins);
        for (size_t b = 0; b < carried; b++) to[b] += (double)cpm_half_to_float(halves[b]);
    }
}

static void sum(cpm_query *query, uint32_t count) {
    const cpm_tree *tree = query->tree;
    if (tree->unsplit) {
        for (size_t b = 0; b < tree->bins; b += 16)
            lanes_sum(tree->spectra + b, tree->bins, query->id, count, query->sum + b);
    } else {
        memset(query->sum, 0, tree->bins * sizeof *query->sum);
        sum_split(query, count);
    }
}

extern const cpm_search CPM_ISA_NAME(cpm_search);
const cpm_search CPM_ISA_NAME(cpm_search) = {.nearest = nearest, .sum = sum};
