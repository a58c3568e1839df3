/* backend/native/bundles.c: see bundles.h. */
#include "bundles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LIKE_REFLECTANCE 1e-3 /* Fresnel reflectances that may be taken for one */

struct cpm_bundle_node { /* some bins of one flight: paths of the first, the middle and the last of them */
    size_t from;
    int32_t first, count;
    size_t low, middle, high; /* all the same: one way for all */
};
#define UNKNOWN SIZE_MAX

static int grow(void **array, size_t element, size_t wanted) {
    void *grown = realloc(*array, wanted * element);
    if (grown) *array = grown;
    return grown != NULL;
}

/* Room for `more` paths and nodes beside those that there are. */
static int reserve(cpm_bundles *b, size_t paths, size_t nodes) {
    if (b->path_count + paths > b->path_capacity) {
        const size_t wanted = 2 * (b->path_count + paths);
        if (!grow((void **)&b->flights, sizeof *b->flights, wanted)) return 0;
        if (!grow((void **)&b->arrivals, sizeof *b->arrivals, wanted)) return 0;
        if (!grow((void **)&b->owners, sizeof *b->owners, wanted)) return 0;
        b->path_capacity = wanted;
    }
    if (b->node_count + nodes > b->node_capacity) {
        const size_t wanted = 2 * (b->node_count + nodes);
        if (!grow((void **)&b->nodes, sizeof *b->nodes, wanted)) return 0;
        if (!grow((void **)&b->parted, sizeof *b->parted, wanted)) return 0;
        b->node_capacity = wanted;
    }
    return 1;
}

static int reserve_flights(cpm_bundles *b, size_t count) {
    if (count <= b->flight_capacity) return 1;
    if (!grow((void **)&b->starts, sizeof *b->starts, 2 * count)) return 0;
    b->flight_capacity = 2 * count;
    return 1;
}

static size_t add_path(cpm_bundles *b, const cpm_flight *flight, size_t from, int32_t bin) {
    b->flights[b->path_count] = *flight;
    b->flights[b->path_count].bin = bin;
    b->owners[b->path_count] = from;
    return b->path_count++;
}

static int same_region(const cpm_region *a, const cpm_region *b) {
    return a->count == b->count && !memcmp(a->media, b->media, a->count * sizeof *a->media);
}

static double apart(cpm_vec a, cpm_vec b) { return cpm_norm(cpm_sub(a, b)); }

/* Surfaces that a path goes on from in a direction of its own, so that directions and normals must agree too. */
static int goes_on(const cpm_pass *pass, const shape *s) {
    if (s->material == CPM_NO_MATERIAL) return 1;
    const int32_t kind = pass->scene->materials[s->material].kind;
    return kind == CPM_MATERIAL_MIRROR || kind == CPM_MATERIAL_DIELECTRIC;
}

static cpm_vec normal_at(const cpm_pass *pass, const cpm_hit *hit) {
    return cpm_shading_normal(pass->scene, hit, cpm_geometric_normal(pass->scene, hit));
}

/* May another wavelength's arrival be taken for the middle one's? */
static int alike(const cpm_pass *pass, cpm_bundle_use use, const cpm_flight *flight, const cpm_leeway *leeway,
                 const cpm_arrival *middle, const cpm_arrival *other) {
    if (middle->status != other->status) return 0;
    if (middle->status == CPM_RAY_LEFT)
        return use == CPM_BUNDLES_OF_PHOTONS || apart(middle->direction, other->direction) <= leeway->angle;
    if (middle->status != CPM_RAY_HIT) return 1; /* neither carries anything on */
    const int32_t shape_index = cpm_primitive_shape(pass->scene, middle->hit.primitive);
    if (shape_index != cpm_primitive_shape(pass->scene, other->hit.primitive)) return 0;
    cpm_vec off = cpm_sub(other->hit.position, middle->hit.position);
    if (use == CPM_BUNDLES_OF_EYE) off = cpm_along(off, -cpm_vdot(off, middle->direction), middle->direction);
    const double room = leeway->size + leeway->angle * apart(middle->hit.position, flight->position);
    if (!(cpm_norm(off) <= room)) return 0;
    if (!goes_on(pass, &pass->scene->shapes[shape_index])) return 1;
    if (!same_region(&middle->behind, &other->behind)) return 0;
    const double turn = 2.0 * apart(normal_at(pass, &middle->hit), normal_at(pass, &other->hit));
    return apart(middle->direction, other->direction) + turn <= leeway->angle;
}

/* Some bins of one flight. Its first bin's path is given, its last bin's where it is known; the middle one's is new
 * where it is neither. */
static void add_node(cpm_bundles *b, const cpm_flight *flight, size_t from, int32_t first, int32_t count, size_t low,
                     size_t high) {
    const int32_t middle = first + count / 2, last = first + count - 1;
    if (last == first) high = low;
    if (high == UNKNOWN) high = add_path(b, flight, from, last);
    const size_t between = middle == last ? high : add_path(b, flight, from, middle);
    b->nodes[b->node_count++] = (cpm_bundle_node){from, first, count, low, between, high};
}

static int is_one(const cpm_bundles *b, const cpm_pass *pass, cpm_bundle_use use, const cpm_bundle_node *n,
                  const cpm_flight *flight, const cpm_leeway *leeway) {
    const cpm_arrival *middle = &b->arrivals[n->middle];
    return (n->low == n->middle || alike(pass, use, flight, leeway, middle, &b->arrivals[n->low])) &&
           (n->high == n->middle || alike(pass, use, flight, leeway, middle, &b->arrivals[n->high]));
}

/* Nodes [first, end) have their arrivals: each is done, or is parted into two nodes more. */
static int judge(cpm_bundles *b, const cpm_pass *pass, cpm_bundle_use use, const cpm_flight *flights,
                 const cpm_leeway *leeways, size_t first, size_t end) {
    for (size_t i = first; i < end; i++) {
        const cpm_bundle_node n = b->nodes[i];
        if (!reserve(b, 3, 2)) return 0;
        if (is_one(b, pass, use, &n, &flights[n.from], &leeways[n.from])) {
            cpm_parted *p = &b->parted[b->count++];
            p->from = n.from;
            p->bin = cpm_bins_run(n.first, n.count, (int32_t)pass->bins);
            p->padding = 0;
            p->arrival = b->arrivals[n.middle];
            p->arrival.evaluations = 0.0; /* shared out at the end */
            continue;
        }
        const int32_t lower = n.count / 2;
        add_node(b, &flights[n.from], n.from, n.first, lower, n.low, UNKNOWN);
        add_node(b, &flights[n.from], n.from, n.first + lower, n.count - lower, n.middle, n.high);
    }
    return 1;
}

static int by_place(const void *a, const void *b) {
    const cpm_parted *x = a, *y = b;
    if (x->from != y->from) return x->from < y->from ? -1 : 1;
    return cpm_bins_first(x->bin) - cpm_bins_first(y->bin);
}

/* What all paths of a flight cost goes with its first part: whole numbers, so the order of adding is no matter. */
static void share_evaluations(cpm_bundles *b) {
    for (size_t i = 0; i < b->count; i++)
        if (!i || b->parted[i].from != b->parted[i - 1].from) b->starts[b->parted[i].from] = i;
    for (size_t i = 0; i < b->path_count; i++)
        b->parted[b->starts[b->owners[i]]].arrival.evaluations += b->arrivals[i].evaluations;
}

int cpm_follow_bundles(cpm_bundles *b, const cpm_pass *pass, cpm_bundle_use use, const cpm_flight *flights,
                       const cpm_leeway *leeways, size_t count, const cpm_follow_options *options) {
    const int32_t all = (int32_t)pass->bins;
    b->count = b->path_count = b->node_count = 0;
    if (!reserve_flights(b, count)) return 0;
    for (size_t i = 0; i < count; i++) {
        if (!reserve(b, 3, 1)) return 0;
        const int32_t first = cpm_bins_first(flights[i].bin), bins = cpm_bins_count(flights[i].bin, all);
        if (bins > 1 && pass->disperses[cpm_region_medium(&flights[i].region)]) {
            add_node(b, &flights[i], i, first, bins, add_path(b, &flights[i], i, first), UNKNOWN);
        } else { /* one way for all of them */
            const size_t path = add_path(b, &flights[i], i, flights[i].bin);
            b->nodes[b->node_count++] = (cpm_bundle_node){i, first, bins, path, path, path};
        }
    }
    for (size_t node = 0, path = 0; node < b->node_count;) {
        const size_t end = b->node_count;
        if (b->path_count > path)
            cpm_follow(pass, &b->flights[path], b->path_count - path, options, &b->arrivals[path]);
        path = b->path_count;
        if (!judge(b, pass, use, flights, leeways, node, end)) return 0;
        node = end;
    }
    qsort(b->parted, b->count, sizeof *b->parted, by_place);
    share_evaluations(b);
    b->followed = b->path_count;
    return 1;
}

void cpm_bundles_free(cpm_bundles *b) {
    free(b->parted), free(b->flights), free(b->arrivals), free(b->owners), free(b->nodes), free(b->starts);
    memset(b, 0, sizeof *b);
}

cpm_leeway cpm_leeway_after(const cpm_leeway *leeway, const cpm_flight *flight, const cpm_arrival *arrival) {
    cpm_leeway after = *leeway;
    after.size += leeway->angle * apart(arrival->hit.position, flight->position);
    return after;
}

/* ------------------------------------------------------------------------------------------------ at boundaries */

/* The arrival as a bin alone has it: n on the side that it comes from is its own. */
static void alone_at(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, int32_t bin,
                     cpm_flight *alone, cpm_arrival *at) {
    const int32_t before = cpm_region_medium(&flight->region);
    *alone = *flight;
    *at = *arrival;
    alone->bin = bin;
    if (pass->disperses[before]) at->n = cpm_pass_index(pass, before, bin, arrival->hit.position);
}

static int same_passage(const cpm_passage *a, const cpm_passage *b, double angle) {
    if (a->jumps != b->jumps || a->total != b->total) return 0;
    if (!a->jumps) return 1;
    if (fabs(a->reflectance - b->reflectance) > LIKE_REFLECTANCE) return 0;
    return a->total || apart(a->transmitted.direction, b->transmitted.direction) <= angle;
}

int cpm_bundle_parts(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, double angle) {
    const int32_t all = (int32_t)pass->bins, count = cpm_bins_count(flight->bin, all);
    if (count == 1 || !arrival->behind.count) return 0;
    if (!pass->disperses[cpm_region_medium(&flight->region)] && !pass->disperses[cpm_region_medium(&arrival->behind)])
        return 0;
    if (!(angle > 0.0)) return 1;
    const int32_t first = cpm_bins_first(flight->bin);
    const int32_t bins[3] = {cpm_bins_middle(flight->bin, all), first, first + count - 1};
    cpm_passage passages[3];
    for (int i = 0; i < 3; i++) {
        cpm_flight alone;
        cpm_arrival at;
        alone_at(pass, flight, arrival, bins[i], &alone, &at);
        if (!cpm_pass_boundary(pass, &alone, &at, &passages[i])) return 0; /* too many media: for all of them */
    }
    return !same_passage(&passages[0], &passages[1], angle) || !same_passage(&passages[0], &passages[2], angle);
}

size_t cpm_bundle_half(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, int upper,
                       cpm_flight *half, cpm_arrival *at) {
    const int32_t all = (int32_t)pass->bins, first = cpm_bins_first(flight->bin);
    const int32_t count = cpm_bins_count(flight->bin, all), lower = count / 2;
    const int32_t bin = upper ? cpm_bins_run(first + lower, count - lower, all) : cpm_bins_run(first, lower, all);
    alone_at(pass, flight, arrival, bin, half, at);
    return upper ? (size_t)lower : 0;
}
