/* shared/map_search.h: the k nearest photons, and the irradiance that they carry.
 *
 * Not the usual heap of k: all photons within a guessed radius are listed (their number is nearly right when neighbours
 * are asked one after the other), then the k-th smallest distance is selected. Too few: the radius grows. Too many for
 * the buffer: it is cut to the k nearest, and the radius shrinks to theirs. The list always holds every photon within
 * the radius that could be among the k nearest, so the guess changes the cost and never the result. */
#ifndef CPM_SHARED_MAP_SEARCH_H
#define CPM_SHARED_MAP_SEARCH_H
#include "bins.h"
#include "map_select.h"

#define CPM_LARGEST_FLOAT 3.402823466e38f

/* --- selection ------------------------------------------------------------------------------------------------- */

CPM_INLINE cpm_u64 cpm_map_order(const cpm_map_search *s, cpm_u32 id) {
    CPM_GLOBAL const cpm_photon *p = &s->map.photons[id];
    return cpm_photon_order(p->path, p->bounce, p->bin);
}

/* Keeps, of n listed, those nearer than t and the `ties` first ones at t by (path, bounce, bin). Returns how many. */
CPM_INLINE size_t cpm_map_keep(const cpm_map_search *s, size_t n, float t, size_t ties) {
    if (ties == 0) return lanes_below(s->distance, s->id, n, t);
    size_t tied = 0;
    for (size_t i = 0; i < n; i++)
        if (s->distance[i] == t) s->order[tied++] = cpm_map_order(s, s->id[i]);
    const cpm_u64 last = ties < tied ? cpm_kth_order(s->order, tied, ties) : ~(cpm_u64)0;
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        int keep = s->distance[i] < t;
        if (s->distance[i] == t) keep = cpm_map_order(s, s->id[i]) <= last;
        s->distance[m] = s->distance[i], s->id[m] = s->id[i];
        m += (size_t)keep;
    }
    return m;
}

/* --- listing --------------------------------------------------------------------------------------------------- */

/* Of the children in `mask`: those that may hold photons facing as `normal` does; *all: those that hold no others. */
CPM_INLINE cpm_u32 cpm_map_facing(CPM_GLOBAL const cpm_map_node *node, cpm_u32 mask_, const float *normal,
                                  cpm_u32 *all) {
    cpm_u32 some = 0, every = 0;
    for (cpm_u32 rest = mask_; rest; rest &= rest - 1) {
        const int i = cpm_lowest_bit(rest);
        float least = 0.0f, most = 0.0f;
        for (int a = 0; a < 3; a++) {
            const float low = normal[a] * (float)node->facing_low[i][a];
            const float high = normal[a] * (float)node->facing_high[i][a];
            least += low < high ? low : high;
            most += low < high ? high : low;
        }
        /* cos 60 degrees, with room for rounding: in between, each photon decides */
        some |= (cpm_u32)(most >= 0.499f * CPM_FACING) << i;
        every |= (cpm_u32)(least >= 0.501f * CPM_FACING) << i;
    }
    *all = every;
    return some;
}

typedef struct cpm_map_listing {
    const cpm_map_search *search;
    const float *point, *normal;
    cpm_u32 k;
    float radius2;
    size_t n;
} cpm_map_listing;

/* Makes room for `more`: cuts the list to its k nearest. */
CPM_APART void cpm_map_cut(cpm_map_listing *l) {
    size_t below;
    const float t = cpm_kth_distance(l->search->distance, l->n, l->k, l->radius2, &below);
    l->n = cpm_map_keep(l->search, l->n, t, l->k - below);
    l->radius2 = t;
}

/* Keeps those listed from `from` on that face as the normal does. */
CPM_INLINE void cpm_map_keep_facing(cpm_map_listing *l, size_t from) {
    const cpm_map_search *s = l->search;
    size_t m = from;
    for (size_t i = from; i < l->n; i++) {
        s->distance[m] = s->distance[i], s->id[m] = s->id[i];
        m += cpm_same_side(s->map.photons[s->id[i]].normal, l->normal[0], l->normal[1], l->normal[2]) != 0;
    }
    l->n = m;
}

/* A leaf in one point: beyond its first k photons none can be among the k nearest. */
CPM_APART void cpm_map_list_point(cpm_map_listing *l, cpm_u32 first, cpm_u32 count, int mixed) {
    const cpm_map_search *s = l->search;
    CPM_GLOBAL const float *p = s->map.points + 3 * (size_t)first;
    const float d = cpm_distance2(p[0] - l->point[0], p[count] - l->point[1], p[2 * (size_t)count] - l->point[2]);
    if (!(d <= l->radius2)) return;
    const cpm_u32 most = count < l->k ? count : l->k;
    if (l->n + most > s->capacity) cpm_map_cut(l);
    if (!(d <= l->radius2)) return;
    for (cpm_u32 i = 0, listed = 0; i < count && listed < most; i++) {
        if (mixed && !cpm_same_side(s->map.photons[first + i].normal, l->normal[0], l->normal[1], l->normal[2]))
            continue;
        s->distance[l->n] = d, s->id[l->n] = first + i;
        l->n++, listed++;
    }
}

CPM_INLINE void cpm_map_list_leaf(cpm_map_listing *l, cpm_u32 first, cpm_u32 count, int mixed) {
    const cpm_map_search *s = l->search;
    if (count > CPM_LEAF) {
        cpm_map_list_point(l, first, count, mixed);
        return;
    }
    if (l->n + count > s->capacity) cpm_map_cut(l);
    const size_t from = l->n;
    CPM_GLOBAL const float *points = s->map.points + 3 * (size_t)first;
    l->n = lanes_leaf(points, first, count, l->point, l->radius2, s->distance, s->id, from);
    if (mixed) cpm_map_keep_facing(l, from);
}

/* Lists the photons within the radius, in the map's order: depth first, children from left to right. On the stack:
 * a node, its children still to be visited, and those of them whose photons all face the right way. */
CPM_INLINE void cpm_map_list(cpm_map_listing *l) {
    const cpm_map_search *s = l->search;
    int depth = 0, uniform_ = 0;
    cpm_u32 number = s->map.is.top;
    for (;;) {
        CPM_GLOBAL const cpm_map_node *node = &s->map.nodes[number];
        cpm_u32 todo = lanes_boxes(node, l->point, l->radius2), all = 0xffu;
        if (!uniform_) todo = cpm_map_facing(node, todo, l->normal, &all);
        for (;;) {
            if (!todo) {
                if (!depth) return;
                const cpm_u64 entry = s->stack[--depth];
                number = (cpm_u32)(entry >> 32), todo = (cpm_u32)entry & 0xffu, all = (cpm_u32)entry >> 8;
                node = &s->map.nodes[number];
            }
            const int i = cpm_lowest_bit(todo);
            todo &= todo - 1;
            uniform_ = all >> i & 1;
            if (!node->count[i]) {
                if (todo) s->stack[depth++] = (cpm_u64)number << 32 | all << 8 | todo;
                number = node->first[i];
                break;
            }
            cpm_map_list_leaf(l, node->first[i], node->count[i], !uniform_);
        }
    }
}

/* --- the k nearest, and their sum ------------------------------------------------------------------------------ */

/* The k nearest within the squared radius `limit`; `point` scaled and finite, 1 <= k; the map is not empty. */
CPM_INLINE cpm_map_found cpm_map_nearest(cpm_map_search *s, const float *point, const float *normal, cpm_u32 k,
                                         float limit) {
    const cpm_map_numbers *is = &s->map.is;
    const float fk = (float)k, spread = 1.0f + 2.5f / cpm_root_float(fk); /* of their number, as it fluctuates */
    const float smallest = cpm_most(1e-14f * is->extent * is->extent, 1e-36f);
    const float guess = s->guess > 0.0f ? s->guess * fk : is->extent * is->extent * fk / (float)is->count;
    cpm_map_listing l;
    l.search = s, l.point = point, l.normal = normal, l.k = k, l.n = 0;
    l.radius2 = k > is->count ? limit : cpm_least(cpm_most(guess * spread, smallest), limit);
    for (;;) {
        const float asked = l.radius2;
        l.n = 0;
        cpm_map_list(&l);
        if (l.n >= k || asked >= limit) break;
        const float growth = fk * spread / (float)(l.n + 1); /* on a surface numbers go as squared radii */
        l.radius2 = cpm_least(asked * cpm_least(cpm_most(growth, 1.4f), 16.0f), limit);
    }
    cpm_map_found found;
    found.radius2 = limit, found.count = (cpm_u32)l.n, found.enough = l.n >= k;
    if (found.enough) {
        size_t below;
        found.radius2 = cpm_kth_distance(s->distance, l.n, k, l.radius2, &below);
        found.count = (cpm_u32)cpm_map_keep(s, l.n, found.radius2, k - 1 - below);
    }
    if (found.radius2 > 0.0f) s->guess = found.radius2 / fk;
    return found;
}

/* Half-float powers of photons id[0..count), summed over photons, to sum[bins]. */
CPM_INLINE void cpm_map_sum(const cpm_map_search *s, cpm_u32 count) {
    const cpm_u32 bins = s->map.is.bins;
    if (s->map.is.unsplit) {
        for (cpm_u32 b = 0; b < bins; b += 16) lanes_sum(s->map.spectra + b, bins, s->id, count, s->sum + b);
        return;
    }
    for (cpm_u32 b = 0; b < bins; b++) s->sum[b] = 0.0;
    for (cpm_u32 i = 0; i < count; i++) { /* a run of bins or all of them, as each photon says */
        CPM_GLOBAL const cpm_photon *p = &s->map.photons[s->id[i]];
        CPM_GLOBAL const unsigned short *halves = s->map.spectra + p->spectrum;
        const cpm_u32 first = cpm_photon_first(p->bin), carried = cpm_photon_count(p->bin, bins);
        for (cpm_u32 b = 0; b < carried; b++) s->sum[first + b] += (double)cpm_half_to_float(halves[b]);
    }
}

/* A host that is compiled for several instruction sets calls the one that it has. */
#ifndef CPM_MAP_NEAREST
#define CPM_MAP_NEAREST(search, point, normal, k, limit) cpm_map_nearest(search, point, normal, k, limit)
#define CPM_MAP_SUM(search, count) cpm_map_sum(search, count)
#endif

/* What is asked, in the map's units. */
typedef struct cpm_map_asked {
    float point[3];
    float limit;    /* squared */
    double least2;  /* m^2: k photons in one single point, or a vanishing max_radius: no density is finite. The
                     * spacing of floats there is the least radius that means anything */
    cpm_i32 finite; /* 0: infinitely far from all */
} cpm_map_asked;

CPM_INLINE cpm_map_asked cpm_map_ask(const cpm_map_numbers *is, const float *point, double max_radius) {
    const double unit = (double)is->unit, limit = max_radius * unit;
    cpm_map_asked q;
    float largest = 0.0f;
    for (int a = 0; a < 3; a++) {
        q.point[a] = point[a] * is->unit;
        largest = cpm_most(largest, q.point[a] < 0.0f ? -q.point[a] : q.point[a]);
    }
    q.finite = largest <= CPM_LARGEST_FLOAT;
    q.limit = (float)(limit * limit < (double)CPM_LARGEST_FLOAT ? limit * limit : (double)CPM_LARGEST_FLOAT);
    const double spacing =
        5.9604644775390625e-8 * ((double)largest > 5.9604644775390625e-8 ? (double)largest : 5.9604644775390625e-8);
    q.least2 = (spacing / unit) * (spacing / unit);
    return q;
}

/* Of what was found: the squared radius to divide by, m^2. */
CPM_INLINE double cpm_map_radius2(const cpm_map_numbers *is, const cpm_map_asked *q, const cpm_map_found *found,
                                  double max_radius) {
    const double unit = (double)is->unit;
    const double radius2 = found->enough ? (double)found->radius2 / (unit * unit) : max_radius * max_radius;
    return radius2 > q->least2 ? radius2 : q->least2;
}

/* The k nearest, as libcpm/photon/map.h has it: r_k and what is to be summed. Nothing for an empty map or a radius that
 * is not positive: 0 then, and found->enough 0. */
CPM_INLINE int cpm_map_find(cpm_map_search *s, const float *point, const float *normal, cpm_u32 k, double max_radius,
                            cpm_map_found *found, double *radius2) {
    found->radius2 = 0.0f, found->count = 0, found->enough = 0;
    if (s->map.is.count == 0 || !(max_radius > 0.0)) return 0;
    const cpm_map_asked q = cpm_map_ask(&s->map.is, point, max_radius);
    if (q.finite) *found = CPM_MAP_NEAREST(s, q.point, normal, k < 1 ? 1 : k, q.limit);
    *radius2 = cpm_map_radius2(&s->map.is, &q, found, max_radius);
    return 1;
}

/* Irradiance, added to irradiance[bins]; returns the radius used, 0 where nothing can be found. */
CPM_INLINE double cpm_map_irradiance(cpm_map_search *s, const float *point, const float *normal, cpm_u32 k,
                                     double max_radius, cpm_map_found *found, CPM_GLOBAL double *irradiance) {
    double radius2;
    if (!cpm_map_find(s, point, normal, k, max_radius, found, &radius2)) return 0.0;
    if (found->count > 0) {
        CPM_MAP_SUM(s, found->count);
        const double factor = cpm_gather_factor(s->map.is.scale, radius2);
        for (cpm_u32 b = 0; b < s->map.is.bins; b++) irradiance[b] += factor * s->sum[b];
    }
    return found->enough ? cpm_sqrt(radius2) : max_radius;
}

/* r_k itself; max_radius where there are fewer. */
CPM_INLINE double cpm_map_kth_radius(cpm_map_search *s, const float *point, const float *normal, cpm_u32 k,
                                     double max_radius, cpm_map_found *found) {
    double radius2;
    if (!cpm_map_find(s, point, normal, k, max_radius, found, &radius2)) return 0.0;
    return found->enough ? cpm_sqrt((double)found->radius2) / (double)s->map.is.unit : max_radius;
}
#endif
