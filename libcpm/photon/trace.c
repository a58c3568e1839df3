/* photon/trace.c: the photon pass: emit, follow curved paths, store, Russian roulette.
 *
 * Paths go in batches: all of a batch are followed to their next surface (so that rays fill their lanes), then each is
 * scattered; survivors go on. Those that met something diffuse are scattered in blocks, by lanes (pass_lanes.h);
 * mirrors and boundaries one by one. Random numbers are keyed by (seed, path, surface, bin), never by the batch. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "backend/native/bundles.h"
#include "backend/native/parabolas.h"
#include "cl/shared/scatter.h"
#include "cl/shared/store.h"
#include "cl/types/walker.h"
#include "photons.h"

#define BATCH 512
#define MEMORY_SHARE 0.4 /* of the machine's, for stored photons: building their map takes as much again */
#define SHARP 1e-12 /* radians between refracted colours of one path: caustics are finer than any circle of photons */

typedef struct crowd { /* a batch's live paths; powers: room for bins floats each, those of its own bins come first */
    cpm_walker *walkers;
    cpm_flight *flights;
    float *powers;
    cpm_leeway *leeways; /* NULL: bundles part wherever a medium disperses */
    size_t count, capacity, bins;
} crowd;

typedef struct task { /* one thread's */
    const cpm_pass *pass;
    const cpm_pass_code *code;
    const cpm_emitter *emitters;
    const float *shares; /* materials x bins: reflectance over the largest of its material */
    const cpm_dither_table *dither;
    size_t emitter_count;
    uint64_t seed;
    cpm_vec origin;
    cpm_store_part parts[CPM_POPULATIONS];
    double *energy; /* CPM_ENERGY_ROWS x bins: this batch's */
    uint64_t segments, lost, emitted, stored_bytes;
    double evaluations;
    int together; /* bundles may stay together where a medium disperses */
    crowd now, next, parted;
    cpm_bundles bundles;
    cpm_leeway leeway;     /* of the path that is dealt with, where it has arrived */
    cpm_arrival *arrivals; /* of a part of `now` */
    size_t arrival_capacity;
    union { /* scratch of one block */
        struct {
            cpm_emissions made;
            cpm_flight flights[CPM_BLOCK];
            float weights[CPM_BLOCK];
            uint32_t paths[CPM_BLOCK];
        } emission;
        struct {
            cpm_meetings met;
            cpm_powers powers[CPM_BLOCK];
        } meeting;
    } block;
    struct { /* scratch of a block of far lights' paths, CPM_BLOCK x bins each; NULL until needed */
        cpm_flight *flights;
        cpm_arrival *arrivals;
        uint32_t *paths;
        float *powers;
    } far;
    int failed;
} task;

/* ------------------------------------------------------------------------------------------------ live paths */

static int crowd_reserve(crowd *c, size_t more, int together) {
    size_t wanted = c->count + more;
    if (wanted <= c->capacity) return 1;
    size_t capacity = wanted + wanted / 2;
    if (together) {
        void *leeways = realloc(c->leeways, capacity * sizeof *c->leeways);
        if (!leeways) return 0;
        c->leeways = leeways;
    }
    void *walkers = realloc(c->walkers, capacity * sizeof *c->walkers);
    if (walkers) c->walkers = walkers;
    void *flights = realloc(c->flights, capacity * sizeof *c->flights);
    if (flights) c->flights = flights;
    void *powers = realloc(c->powers, capacity * c->bins * sizeof *c->powers);
    if (powers) c->powers = powers;
    if (!walkers || !powers || !flights) return 0;
    c->capacity = capacity;
    return 1;
}

static void crowd_free(crowd *c) { free(c->walkers), free(c->powers), free(c->flights), free(c->leeways); }

/* A path goes on. */
static void survive(task *t, const cpm_walker *w, const cpm_flight *flight, const float *powers, size_t count) {
    if (!crowd_reserve(&t->next, 1, t->together)) {
        t->failed = 1;
        return;
    }
    if (t->together) t->next.leeways[t->next.count] = t->leeway;
    memcpy(&t->next.powers[t->next.count * t->next.bins], powers, count * sizeof *powers);
    t->next.walkers[t->next.count] = *w;
    t->next.flights[t->next.count] = *flight;
    t->next.count++;
}

/* Bins that a flight carries: [*first, *first + count). */
static size_t carried(const task *t, const cpm_flight *flight, size_t *first) {
    *first = (size_t)cpm_bins_first(flight->bin);
    return (size_t)cpm_bins_count(flight->bin, (int32_t)t->pass->bins);
}

static void account(task *t, const cpm_flight *flight, const float *powers, int row) {
    size_t first, count = carried(t, flight, &first);
    double *to = &t->energy[(size_t)row * t->pass->bins + first];
    for (size_t b = 0; b < count; b++) to[b] += (double)powers[b];
}

/* ------------------------------------------------------------------------------------------------ scattering */

static cpm_random random_of(const task *t, const cpm_walker *w, const cpm_flight *flight) {
    return cpm_philox(t->seed, w->path, cpm_scatter_block(w->bounce, w->crossings), CPM_STREAM_SCATTER,
                      cpm_scatter_bin(flight->bin));
}

static cpm_roulette_rows rows_of(const task *t) {
    const size_t bins = t->pass->bins;
    return (cpm_roulette_rows){&t->energy[CPM_ABSORBED * bins], &t->energy[CPM_GAIN * bins],
                               &t->energy[CPM_LOSS * bins], &t->energy[CPM_VARIANCE * bins]};
}

/* Roulette at a surface, with the random number `chance`; what survives would go to `after`. */
static void play(const task *t, const cpm_flight *flight, int32_t material, const float *powers, double chance,
                 float *after, cpm_powers *p) {
    static const float one = 1.0f;
    size_t first, count = carried(t, flight, &first);
    const size_t at = (size_t)material * t->pass->bins + first;
    const int alone = flight->bin >= 0;
    p->before = powers;
    p->reflectance = &t->pass->reflectance[at];
    p->share = alone ? &one : &t->shares[at];
    p->after = after;
    p->spectrum = NULL;
    p->first = (uint32_t)first, p->bins = (uint32_t)count;
    p->alive = chance < (double)(alone ? *p->reflectance : t->pass->reflectance_max[material]);
}

/* Gives the photon a place; its powers are to follow. */
static void store(task *t, const cpm_walker *w, const cpm_flight *flight, const cpm_arrival *a, uint32_t direction,
                  uint32_t normal, cpm_powers *p) {
    const int population = cpm_population(w);
    uint32_t index;
    cpm_photon *photon = cpm_store_place(&t->parts[population], p->bins, &index);
    if (!photon) {
        t->failed = 1;
        return;
    }
    cpm_photon_pack(photon, cpm_sub(a->hit.position, t->origin), direction, normal, index, w->path, w->bounce,
                    flight->bin);
    p->spectrum = &t->parts[population].store->spectra[index];
    p->dither = cpm_dither_start(w->path, w->bounce, cpm_bins_stored(flight->bin));
    t->stored_bytes += sizeof *photon + p->bins * sizeof *p->spectrum;
}

/* A path that has met something diffuse or black: of the current part of `now`. */
typedef struct encounter {
    uint32_t number;
    int32_t material;
} encounter;

static void describe(const task *t, size_t first, const encounter *met, size_t count, cpm_meetings *m) {
    for (size_t k = 0; k < count; k++) {
        const cpm_walker *w = &t->now.walkers[first + met[k].number];
        const cpm_flight *f = &t->now.flights[first + met[k].number];
        const cpm_arrival *a = &t->arrivals[met[k].number];
        const cpm_facet facet = world_facet(&t->pass->world, a->hit.primitive, a->hit.position);
        m->came[0][k] = a->direction.x, m->came[1][k] = a->direction.y, m->came[2][k] = a->direction.z;
        m->start[0][k] = f->position.x, m->start[1][k] = f->position.y, m->start[2][k] = f->position.z;
        m->hit[0][k] = a->hit.position.x, m->hit[1][k] = a->hit.position.y, m->hit[2][k] = a->hit.position.z;
        m->normal[0][k] = facet.normal.x, m->normal[1][k] = facet.normal.y, m->normal[2][k] = facet.normal.z;
        m->factor[k] = facet.factor;
        m->path[k] = w->path;
        m->block[k] = cpm_scatter_block(w->bounce, w->crossings);
        m->bin[k] = cpm_scatter_bin(f->bin);
    }
}

/* Encounters of paths first.. of `now`, at most a block. */
static void meet_diffuse(task *t, size_t first, const encounter *met, size_t count) {
    const cpm_scene *scene = t->pass->scene;
    cpm_meetings *m = &t->block.meeting.met;
    cpm_powers *powers = t->block.meeting.powers;
    describe(t, first, met, count, m);
    t->code->meet(t->seed, cpm_geometry_scale(t->pass->geometry), count, m);
    if (!crowd_reserve(&t->next, count + 1, t->together)) t->failed = 1;
    size_t survivors = t->next.count;
    for (size_t k = 0; k < count && !t->failed; k++) {
        const cpm_walker *w = &t->now.walkers[first + met[k].number];
        const cpm_flight *f = &t->now.flights[first + met[k].number];
        const cpm_arrival *a = &t->arrivals[met[k].number];
        const int black = scene->materials[met[k].material].kind == CPM_MATERIAL_BLACK;
        play(t, f, met[k].material, &t->now.powers[(first + met[k].number) * t->now.bins], m->chance[k],
             black ? NULL : &t->next.powers[survivors * t->next.bins], &powers[k]);
        store(t, w, f, a, m->direction_code[k], m->normal_code[k], &powers[k]);
        if (black || !powers[k].alive) continue;
        /* field by field where they belong: a copy of what has just been written would wait for it */
        cpm_walker *next = &t->next.walkers[survivors];
        if (t->together) t->next.leeways[survivors] = cpm_leeway_after(&t->now.leeways[first + met[k].number], f, a);
        cpm_flight *to = &t->next.flights[survivors++];
        next->path = w->path;
        next->bounce = (uint16_t)(w->bounce + 1);
        next->crossings = next->specular = next->direct = 0;
        to->position = cpm_v(m->from[0][k], m->from[1][k], m->from[2][k]);
        to->direction = cpm_v(m->toward[0][k], m->toward[1][k], m->toward[2][k]);
        to->region = f->region;
        to->left = a->hit.primitive;
        to->bin = f->bin;
        to->exact = cpm_geometry_near_edge(t->pass->geometry, &a->hit);
        to->crossing = 0;
    }
    if (t->failed) return;
    const cpm_roulette_rows rows = rows_of(t);
    t->code->settle(powers, count, t->dither, &rows);
    t->next.count = survivors;
}

static void meet_mirror(task *t, cpm_walker *w, const cpm_flight *f, const cpm_arrival *a, const float *powers,
                        int32_t material) {
    const cpm_pass *pass = t->pass;
    cpm_vec facing = scatter_facing(cpm_geometric_normal(pass->scene, &a->hit), a->direction);
    cpm_random r = random_of(t, w, f);
    float after[CPM_MAX_BINS];
    cpm_powers p;
    play(t, f, material, powers, cpm_uniform(r.v[2]), after, &p);
    const cpm_roulette_rows rows = rows_of(t);
    t->code->settle(&p, 1, t->dither, &rows);
    if (!p.alive) return;
    cpm_vec direction = scatter_mirror(a->direction, cpm_shading_normal(pass->scene, &a->hit, facing), facing);
    cpm_walker_reflects(w);
    cpm_flight flight = cpm_depart(pass, f, a, direction);
    survive(t, w, &flight, after, p.bins);
}

static void meet_boundary(task *t, cpm_walker *w, const cpm_flight *f, const cpm_arrival *a, const float *powers) {
    const cpm_pass *pass = t->pass;
    cpm_passage passage;
    size_t first, count = carried(t, f, &first);
    if (cpm_bundle_parts(pass, f, a, t->together ? SHARP : 0.0)) { /* each its own way */
        for (int upper = 0; upper < 2; upper++) {
            cpm_walker one = *w;
            cpm_flight half;
            cpm_arrival at;
            const size_t before = cpm_bundle_half(pass, f, a, upper, &half, &at);
            meet_boundary(t, &one, &half, &at, &powers[before]);
        }
        return;
    }
    if (count == 1 && powers[0] == 0.0f) return; /* a dark bin of a bundle that has just parted */
    if (!cpm_pass_boundary(pass, f, a, &passage)) {
        account(t, f, powers, CPM_ESCAPED);
        t->lost++;
        return;
    }
    const cpm_flight *flight = &passage.transmitted;
    if (passage.jumps) {
        cpm_random r = random_of(t, w, f);
        if (cpm_uniform(r.v[3]) < passage.reflectance) flight = &passage.reflected;
        cpm_walker_reflects(w);
    } else {
        w->crossings++;
    }
    survive(t, w, flight, powers, count);
}

/* What a path does where it has arrived. Returns the material if it is diffuse or black, to be dealt with in a block,
 * else CPM_NO_MATERIAL. */
static int32_t arrive(task *t, size_t number, const cpm_arrival *a) {
    const cpm_scene *scene = t->pass->scene;
    cpm_walker *w = &t->now.walkers[number];
    const cpm_flight *f = &t->now.flights[number];
    const float *powers = &t->now.powers[number * t->now.bins];
    t->evaluations += a->evaluations;
    if (a->status != CPM_RAY_HIT || w->bounce >= CPM_MAX_BOUNCES || w->crossings == CPM_MAX_CROSSINGS) {
        account(t, f, powers, CPM_ESCAPED);
        t->lost += a->status != CPM_RAY_LEFT;
        return CPM_NO_MATERIAL;
    }
    const int32_t material = scene->shapes[cpm_primitive_shape(scene, a->hit.primitive)].material;
    const int32_t kind = material == CPM_NO_MATERIAL ? CPM_MATERIAL_DIELECTRIC : scene->materials[material].kind;
    if (kind == CPM_MATERIAL_DIELECTRIC)
        meet_boundary(t, w, f, a, powers);
    else if (kind == CPM_MATERIAL_MIRROR)
        meet_mirror(t, w, f, a, powers, material);
    else
        return material;
    return CPM_NO_MATERIAL;
}

/* ------------------------------------------------------------------------------------------------- a batch */

/* A path starts in a medium that disperses: each wavelength goes its own way. */
static void start_apart(task *t, uint32_t path, cpm_flight *flight) {
    float powers[CPM_MAX_BINS];
    const cpm_walker w = {.path = path, .direct = 1};
    memcpy(powers, &t->next.powers[t->next.count * t->next.bins], t->next.bins * sizeof *powers);
    for (size_t b = 0; b < t->next.bins; b++) {
        flight->bin = (int32_t)b;
        if (powers[b] > 0.0f) survive(t, &w, flight, &powers[b], 1);
    }
}

/* A path starts with all its bins; its powers are there. */
static void start(task *t, const cpm_emitter *e, uint32_t path, float weight, const cpm_flight *flight) {
    cpm_walker *w = &t->next.walkers[t->next.count];
    if (t->together) t->next.leeways[t->next.count] = cpm_emitter_leeway(t->pass, e, weight);
    t->next.flights[t->next.count++] = *flight;
    w->path = path;
    w->bounce = w->crossings = w->specular = 0;
    w->direct = 1;
}

/* The same where something disperses. */
static void start_dispersed(task *t, const cpm_emitter *e, uint32_t path, float weight, cpm_flight *flight,
                            double *emitted) {
    float own[CPM_MAX_BINS];
    if (!crowd_reserve(&t->next, 1, t->together)) {
        t->failed = 1;
        return;
    }
    t->code->power(&weight, 1, cpm_emit_spectrum(t->pass, e, flight, own), t->next.bins,
                   &t->next.powers[t->next.count * t->next.bins], emitted);
    if (t->pass->disperses[cpm_region_medium(&flight->region)] && !t->together)
        start_apart(t, path, flight);
    else
        start(t, e, path, weight, flight);
}

/* Paths that one emitter starts, at most a block. */
static void emit_block(task *t, const cpm_emitter *e, uint64_t path, size_t count) {
    const size_t bins = t->pass->bins;
    const int disperses = (t->pass->features & CPM_FEATURE_DISPERSION) != 0;
    cpm_flight *flights = t->block.emission.flights;
    const float *weights = t->block.emission.weights;
    const uint32_t *paths = t->block.emission.paths;
    double *emitted = &t->energy[CPM_EMITTED * bins];
    count = cpm_emit(t->pass, e, path, count, &t->block.emission.made, flights, t->block.emission.paths,
                     t->block.emission.weights);
    t->emitted += count;
    if (!crowd_reserve(&t->next, count, t->together)) t->failed = 1;
    if (!disperses && !t->failed)
        t->code->power(weights, count, e->weight, bins, &t->next.powers[t->next.count * bins], emitted);
    for (size_t i = 0; i < count && !t->failed; i++) {
        if (disperses)
            start_dispersed(t, e, paths[i], weights[i], &flights[i], emitted);
        else
            start(t, e, paths[i], weights[i], &flights[i]);
    }
}

/* The same of a sun or an environment. */
static void emit_far_block(task *t, const cpm_emitter *e, uint64_t path, size_t count) {
    const size_t bins = t->pass->bins, most = CPM_BLOCK * bins;
    if (!t->far.flights) {
        t->far.flights = malloc(most * sizeof *t->far.flights);
        t->far.arrivals = malloc(most * sizeof *t->far.arrivals);
        t->far.paths = malloc(most * sizeof *t->far.paths);
        t->far.powers = malloc(most * bins * sizeof *t->far.powers);
        if (!t->far.flights || !t->far.arrivals || !t->far.paths || !t->far.powers) t->failed = 1;
        if (t->failed) return;
    }
    const size_t made = cpm_far_emit(t->pass, e, path, count, &t->block.emission.made, t->far.flights, t->far.arrivals,
                                     t->far.paths, t->far.powers);
    uint32_t last = UINT32_MAX;
    if (t->together) t->leeway = cpm_emitter_leeway(t->pass, e, 1.0f); /* what survive() gives to each */
    for (size_t i = 0; i < made && !t->failed; i++) {
        const cpm_flight *f = &t->far.flights[i];
        const cpm_walker w = {.path = t->far.paths[i], .direct = 1};
        size_t first, carries = carried(t, f, &first);
        t->emitted += w.path != last;
        last = w.path;
        account(t, f, &t->far.powers[i * bins], CPM_EMITTED);
        survive(t, &w, f, &t->far.powers[i * bins], carries);
    }
}

static void emit_batch(task *t, uint64_t first, uint64_t end) {
    const cpm_emitter *e = t->emitters, *last = t->emitters + t->emitter_count;
    while (first < end && !t->failed) {
        while (e < last && first >= e->first + e->count) e++;
        if (e == last) return;
        uint64_t count = e->first + e->count - first;
        if (count > end - first) count = end - first;
        if (count > CPM_BLOCK) count = CPM_BLOCK;
        if (cpm_light_is_far(e->light))
            emit_far_block(t, e, first, (size_t)count);
        else
            emit_block(t, e, first, (size_t)count);
        first += count;
    }
}

static int arrivals_reserve(task *t, size_t count) {
    if (count <= t->arrival_capacity) return 1;
    free(t->arrivals);
    t->arrival_capacity = count;
    t->arrivals = malloc(count * sizeof *t->arrivals);
    if (!t->arrivals) t->failed = 1;
    return !t->failed;
}

/* Paths [first, first + count) of `now` have arrived, and are dealt with. */
static void deal(task *t, size_t first, size_t count) {
    encounter met[CPM_BLOCK];
    size_t n = 0;
    for (size_t i = 0; i < count && !t->failed; i++) {
        if (t->together)
            t->leeway = cpm_leeway_after(&t->now.leeways[first + i], &t->now.flights[first + i], &t->arrivals[i]);
        const int32_t material = arrive(t, first + i, &t->arrivals[i]);
        if (material != CPM_NO_MATERIAL) met[n++] = (encounter){(uint32_t)i, material};
        if (n == CPM_BLOCK || (n && i + 1 == count)) {
            meet_diffuse(t, first, met, n);
            n = 0;
        }
    }
}

/* Paths [first, first + count) of `now` fly to what they meet, and are dealt with there. */
static void advance(task *t, size_t first, size_t count) {
    if (!arrivals_reserve(t, count)) return;
    cpm_follow(t->pass, &t->now.flights[first], count, NULL, t->arrivals);
    t->segments += count;
    deal(t, first, count);
}

static int is_dark(const float *powers, size_t count) {
    for (size_t b = 0; b < count; b++)
        if (powers[b] > 0.0f) return 0;
    return 1;
}

/* The same where bundles may stay together: those that part become several paths on the way. */
static void advance_bundles(task *t, size_t first, size_t count) {
    const cpm_pass *pass = t->pass;
    cpm_bundles *b = &t->bundles;
    crowd *to = &t->parted;
    const crowd from = t->now;
    to->count = 0;
    if (!cpm_follow_bundles(b, pass, CPM_BUNDLES_OF_PHOTONS, &from.flights[first], &from.leeways[first], count, NULL) ||
        !crowd_reserve(to, b->count, 1) || !arrivals_reserve(t, b->count)) {
        t->failed = 1;
        return;
    }
    t->segments += b->followed;
    for (size_t i = 0; i < b->count; i++) {
        const cpm_parted *p = &b->parted[i];
        const size_t at = first + p->from, all = pass->bins, n = to->count;
        const int32_t before = cpm_bins_first(p->bin) - cpm_bins_first(from.flights[at].bin);
        const size_t carries = (size_t)cpm_bins_count(p->bin, (int32_t)all);
        const float *powers = &from.powers[at * all + (size_t)before];
        t->evaluations += p->arrival.evaluations;
        if (is_dark(powers, carries)) continue;
        memcpy(&to->powers[n * all], powers, carries * sizeof *powers);
        to->walkers[n] = from.walkers[at];
        to->flights[n] = from.flights[at];
        to->flights[n].bin = p->bin;
        to->leeways[n] = from.leeways[at];
        t->arrivals[n] = p->arrival;
        t->arrivals[n].evaluations = 0.0; /* counted */
        to->count++;
    }
    t->now = *to;
    deal(t, 0, t->now.count);
    t->now = from;
}

/* Paths that are followed at a time: few, so that their arrivals stay in the nearest cache, but as many as fill the
 * lanes of curved rays. */
static size_t share_of(const task *t) {
    if (t->together) return 64 + 4096 / t->pass->bins; /* enough for lanes, and their paths are not too many */
    if (t->pass->features & CPM_FEATURE_INTEGRATOR) return t->now.count;
    return t->pass->features & CPM_FEATURE_CURVED ? CPM_PARABOLAS : CPM_BLOCK;
}

static void run_batch(task *t, uint64_t first, uint64_t end) {
    t->next.count = 0;
    emit_batch(t, first, end);
    while (t->next.count && !t->failed && !cpm_cancelled(t->pass->context)) {
        crowd swap = t->now;
        t->now = t->next;
        t->next = swap;
        t->next.count = 0;
        const size_t share = share_of(t);
        for (size_t i = 0; i < t->now.count && !t->failed; i += share) {
            const size_t count = t->now.count - i < share ? t->now.count - i : share;
            if (t->together)
                advance_bundles(t, i, count);
            else
                advance(t, i, count);
        }
    }
}

/* One thread: batches until there are none. Each batch's energies are summed apart and added in order later, so that
 * the sums do not depend on which thread did what. */
typedef struct shared_work {
    const cpm_pass *pass;
    uint64_t photons, batch, batches;
    uint64_t next;    /* atomic */
    double *energies; /* batches x CPM_ENERGY_ROWS x bins */
    uint64_t segments, lost, emitted;
    double *evaluations;        /* batches */
    uint64_t bytes, most_bytes; /* of all stores, and what they may take */
    float *shares;
    cpm_store_part *parts; /* threads x populations */
    int failed, too_many;
} shared_work;

static void work(task *t, shared_work *shared, int reports) {
    uint64_t counted = 0, all;
    int stop;
    const size_t row = CPM_ENERGY_ROWS * t->pass->bins;
    cpm_context *context = t->pass->context;
    for (;;) {
        uint64_t batch;
#pragma omp atomic capture
        batch = shared->next++;
#pragma omp atomic read
        stop = shared->too_many;
        if (batch >= shared->batches || t->failed || stop || cpm_cancelled(context)) break;
        t->energy = &shared->energies[batch * row];
        t->evaluations = 0.0;
        uint64_t end = (batch + 1) * shared->batch;
        run_batch(t, batch * shared->batch, end < shared->photons ? end : shared->photons);
        shared->evaluations[batch] = t->evaluations;
        const uint64_t grown = t->stored_bytes - counted;
        counted = t->stored_bytes;
#pragma omp atomic capture
        all = shared->bytes += grown;
        if (all > shared->most_bytes) {
            t->failed = 1;
#pragma omp atomic write
            shared->too_many = 1;
        }
        if (reports) cpm_progress(context, "trace", (double)batch / (double)shared->batches);
    }
}

float *cpm_surface_shares(const cpm_pass *pass) {
    const size_t bins = pass->bins, materials = pass->scene->material_count;
    float *shares = calloc(materials * bins + 1, sizeof *shares);
    for (size_t i = 0; shares && i < materials * bins; i++)
        if (pass->reflectance_max[i / bins] > 0.0f) shares[i] = pass->reflectance[i] / pass->reflectance_max[i / bins];
    return shares;
}

uint64_t cpm_stores_open(int32_t threads, cpm_store stores[CPM_POPULATIONS]) {
    const uint64_t most = (uint64_t)(MEMORY_SHARE * (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE));
    const uint64_t unfilled = ((uint64_t)threads + 1) << 18; /* the threads' last runs */
    for (int p = 0; p < CPM_POPULATIONS; p++)
        if (!cpm_store_open(&stores[p], most + unfilled)) return 0;
    return most;
}

cpm_status cpm_stores_too_full(cpm_context *context, uint64_t photons, uint64_t most) {
    return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY,
                    "photons is %llu: those stored take more than %.1f GB, %.0f %% of "
                    "this machine's memory; ask for fewer",
                    (unsigned long long)photons, 1e-9 * (double)most, 100.0 * MEMORY_SHARE);
}

static int prepare(shared_work *shared, int32_t threads, cpm_store stores[CPM_POPULATIONS]) {
    const size_t row = CPM_ENERGY_ROWS * shared->pass->bins;
    shared->energies = calloc(shared->batches * row + 1, sizeof *shared->energies);
    shared->evaluations = calloc(shared->batches + 1, sizeof *shared->evaluations);
    shared->parts = calloc((size_t)threads * CPM_POPULATIONS, sizeof *shared->parts);
    shared->shares = cpm_surface_shares(shared->pass);
    shared->most_bytes = cpm_stores_open(threads, stores);
    return shared->energies && shared->evaluations && shared->parts && shared->shares && shared->most_bytes;
}

static void close_stores(const shared_work *shared, int32_t threads, cpm_store stores[CPM_POPULATIONS]) {
    for (int p = 0; p < CPM_POPULATIONS; p++) cpm_store_close(&stores[p], &shared->parts[p * threads], (size_t)threads);
}

cpm_status cpm_trace_paths(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                           uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                           double *energy, cpm_stats *stats) {
    cpm_context *context = pass->context;
    const size_t row = CPM_ENERGY_ROWS * pass->bins;
    const int32_t threads = context->threads;
    shared_work shared = {.pass = pass, .photons = photons, .batch = batch > 0 ? (uint64_t)batch : BATCH};
    cpm_dither_table dither;
    cpm_dither_table_fill(&dither);
    if (shared.batch < photons / 65536) shared.batch = photons / 65536 + 1; /* keeps the energy table small */
    shared.batches = (photons + shared.batch - 1) / shared.batch;
    shared.failed = !prepare(&shared, threads, stores);
#pragma omp parallel num_threads(threads) if (!shared.failed)
    {
        task t = {.pass = pass,
                  .code = cpm_pass_code_chosen(),
                  .emitters = emitters,
                  .emitter_count = emitter_count,
                  .shares = shared.shares,
                  .dither = &dither,
                  .seed = seed,
                  .origin = origin};
        const int number = omp_get_thread_num();
        for (int p = 0; p < CPM_POPULATIONS; p++) t.parts[p].store = &stores[p];
        t.now.bins = t.next.bins = t.parted.bins = pass->bins;
        t.together = cpm_pass_bundles(pass);
        if (!shared.failed) work(&t, &shared, number == 0);
        free(t.far.flights), free(t.far.arrivals), free(t.far.paths), free(t.far.powers);
        crowd_free(&t.now), crowd_free(&t.next), crowd_free(&t.parted), free(t.arrivals);
        cpm_bundles_free(&t.bundles);
        for (int p = 0; p < CPM_POPULATIONS && !shared.failed; p++) shared.parts[p * threads + number] = t.parts[p];
#pragma omp critical(cpm_collect)
        {
            shared.segments += t.segments, shared.lost += t.lost, shared.emitted += t.emitted;
            if (t.failed) shared.failed = 1;
        }
    }
    if (!shared.failed) close_stores(&shared, threads, stores);
    double evaluations = 0.0;
    for (uint64_t b = 0; b < shared.batches && !shared.failed; b++) {
        for (size_t i = 0; i < row; i++) energy[i] += shared.energies[b * row + i];
        evaluations += shared.evaluations[b];
    }
    free(shared.energies), free(shared.evaluations), free(shared.parts), free(shared.shares);
    stats->photons_emitted = shared.emitted;
    stats->photon_segments = shared.segments;
    stats->photons_lost = shared.lost;
    stats->photon_evaluations = (uint64_t)evaluations;
    if (shared.too_many)
        return cpm_stores_too_full(context, photons, shared.most_bytes);
    if (shared.failed)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to store the photons of %llu paths",
                        (unsigned long long)photons);
    if (cpm_progress(context, "trace", 1.0))
        return cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing photons");
    return CPM_OK;
}
