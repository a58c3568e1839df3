/* photon/trace.c: the photon pass: emit, follow curved paths, store, Russian roulette.
 *
 * Paths go in batches: all of a batch are followed to their next surface (so that integrated rays fill their lanes),
 * then each is scattered; survivors go on. Random numbers are keyed by (seed, path, surface, bin), never by the batch.
 *
 * Store before roulette. A diffuse surface reflects power P_b rho_b; the path survives with the largest rho of its
 * bundle, its powers then P_b rho_b/rho_max. Gain and loss are what roulette adds and takes: zero in the mean. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cl/shared/octahedral.h"
#include "cl/shared/fresnel.h"
#include "cl/shared/philox.h"
#include "cl/shared/sampling.h"
#include "photons.h"

#define BATCH 512
#define MEMORY_SHARE 0.4 /* of the machine's, for stored photons: building their map takes as much again */
#define MAX_BOUNCES 4096 /* a closed room of albedo 1 would keep its photons for ever: beyond, they are lost */

typedef struct walker {
    cpm_flight flight;
    uint32_t path;
    uint16_t bounce;   /* surfaces met; also which block of random numbers comes next */
    uint16_t crossings; /* boundaries passed unbroken since: they use blocks too */
    uint8_t specular;  /* only specular surfaces so far, one at least */
    uint8_t direct;    /* nothing met so far */
} walker;

typedef struct crowd { /* a batch's live paths; powers: bins floats each */
    walker *walkers;
    float *powers;
    cpm_arrival *arrivals;
    cpm_flight *flights;
    size_t count, capacity, bins;
} crowd;

typedef struct task {
    const cpm_pass *pass;
    const cpm_emitter *emitters;
    size_t emitter_count;
    uint64_t seed;
    cpm_vec origin;
    cpm_store *stores; /* CPM_POPULATIONS */
    double *energy;    /* CPM_ENERGY_ROWS x bins: this batch's */
    uint64_t segments, lost, emitted;
    double evaluations;
    crowd now, next;
    int failed;
} task;

static int crowd_reserve(crowd *c, size_t more) {
    size_t wanted = c->count + more;
    if (wanted <= c->capacity) return 1;
    size_t capacity = wanted + wanted / 2;
    void *walkers = realloc(c->walkers, capacity * sizeof *c->walkers);
    if (walkers) c->walkers = walkers;
    void *powers = realloc(c->powers, capacity * c->bins * sizeof *c->powers);
    if (powers) c->powers = powers;
    void *arrivals = realloc(c->arrivals, capacity * sizeof *c->arrivals);
    if (arrivals) c->arrivals = arrivals;
    void *flights = realloc(c->flights, capacity * sizeof *c->flights);
    if (flights) c->flights = flights;
    if (!walkers || !powers || !arrivals || !flights) return 0;
    c->capacity = capacity;
    return 1;
}

static void crowd_free(crowd *c) { free(c->walkers), free(c->powers), free(c->arrivals), free(c->flights); }

/* Bins that a flight carries: [*first, *first + count). */
static size_t carried(const task *t, const cpm_flight *flight, size_t *first) {
    *first = flight->bin < 0 ? 0 : (size_t)flight->bin;
    return flight->bin < 0 ? t->pass->bins : 1;
}

static void account(task *t, const cpm_flight *flight, const float *powers, int row) {
    size_t first, count = carried(t, flight, &first);
    double *to = &t->energy[(size_t)row * t->pass->bins + first];
    for (size_t b = 0; b < count; b++) to[b] += (double)powers[b];
}

/* A path goes on with new powers. */
static void survive(task *t, const walker *w, const cpm_flight *flight, const float *powers, size_t count) {
    if (!crowd_reserve(&t->next, 1)) {
        t->failed = 1;
        return;
    }
    walker *to = &t->next.walkers[t->next.count];
    *to = *w;
    to->flight = *flight;
    memcpy(&t->next.powers[t->next.count * t->pass->bins], powers, count * sizeof *powers);
    t->next.count++;
}

static cpm_random random_of(const task *t, const walker *w) {
    uint32_t bin = w->flight.bin < 0 ? 0 : (uint32_t)w->flight.bin + 1;
    return cpm_philox(t->seed, w->path, (uint32_t)w->bounce << 16 | w->crossings, CPM_STREAM_SCATTER, bin);
}

static void store(task *t, const walker *w, const cpm_arrival *a, cpm_vec normal, const float *powers, size_t count) {
    cpm_photon photon;
    cpm_vec local = cpm_sub(a->hit.position, t->origin);
    photon.position[0] = (float)local.x, photon.position[1] = (float)local.y, photon.position[2] = (float)local.z;
    photon.direction = cpm_octahedral_encode(a->direction);
    photon.normal = cpm_octahedral_encode(normal);
    photon.path = w->path;
    photon.bin = (unsigned short)(w->flight.bin < 0 ? CPM_ALL_BINS : (unsigned)w->flight.bin);
    photon.bounce = w->bounce;
    int population = w->direct ? CPM_DIRECT : w->specular ? CPM_CAUSTIC : CPM_LATER;
    if (!cpm_store_photon(&t->stores[population], &photon, powers, count)) t->failed = 1;
}

/* Roulette over a reflecting surface, whose spectrum is `reflectance`; 1: the powers are those of the survivor. */
static int roulette(task *t, const walker *w, const float *reflectance, float *powers, double u) {
    size_t first, count = carried(t, &w->flight, &first);
    float most = 0.0f;
    for (size_t b = 0; b < count; b++) if (reflectance[first + b] > most) most = reflectance[first + b];
    int alive = u < (double)most;
    double *energy = t->energy;
    const size_t bins = t->pass->bins;
    for (size_t b = 0; b < count; b++) {
        double before = (double)powers[b], kept = before * (double)reflectance[first + b];
        float after = alive ? powers[b] * (reflectance[first + b] / most) : 0.0f;
        double change = (double)after - kept;
        energy[CPM_ABSORBED * bins + first + b] += before - kept;
        energy[(alive ? CPM_GAIN : CPM_LOSS) * bins + first + b] += alive ? change : -change;
        energy[CPM_VARIANCE * bins + first + b] += change * change;
        powers[b] = after;
    }
    return alive;
}

static void meet_surface(task *t, walker *w, const cpm_arrival *a, float *powers, const material *m) {
    const cpm_pass *pass = t->pass;
    size_t first, count = carried(t, &w->flight, &first);
    cpm_vec normal = cpm_geometric_normal(pass->scene, &a->hit);
    if (cpm_vdot(normal, a->direction) > 0.0) normal = cpm_scaled(-1.0, normal);
    const float *reflectance = &pass->reflectance[(size_t)(m - pass->scene->materials) * pass->bins];
    if (m->kind != CPM_MATERIAL_MIRROR) store(t, w, a, normal, powers, count);
    if (m->kind == CPM_MATERIAL_BLACK) {
        account(t, &w->flight, powers, CPM_ABSORBED);
        return;
    }
    cpm_random r = random_of(t, w);
    if (!roulette(t, w, reflectance, powers, cpm_uniform(r.v[2]))) return;
    cpm_vec direction;
    if (m->kind == CPM_MATERIAL_MIRROR) {
        cpm_vec shading = cpm_shading_normal(pass->scene, &a->hit, normal);
        direction = cpm_reflect(a->direction, shading);
        if (cpm_vdot(direction, normal) <= 0.0) direction = cpm_reflect(a->direction, normal);
        w->specular = w->direct || w->specular;
    } else {
        direction = cpm_sample_cosine(normal, cpm_uniform(r.v[0]), cpm_uniform(r.v[1]));
        w->specular = 0;
    }
    w->direct = 0;
    w->bounce++;
    w->crossings = 0;
    cpm_flight flight = cpm_depart(pass, &w->flight, a, direction);
    survive(t, w, &flight, powers, count);
}

static void meet_boundary(task *t, walker *w, const cpm_arrival *a, const float *powers) {
    const cpm_pass *pass = t->pass;
    cpm_passage passage;
    if (cpm_splits(pass, &w->flight, a)) { /* each wavelength its own way */
        for (size_t b = 0; b < pass->bins; b++) {
            if (powers[b] == 0.0f) continue;
            walker one = *w;
            one.flight.bin = (int32_t)b;
            meet_boundary(t, &one, a, &powers[b]);
        }
        return;
    }
    size_t first, count = carried(t, &w->flight, &first);
    if (!cpm_pass_boundary(pass, &w->flight, a, &passage)) {
        account(t, &w->flight, powers, CPM_ESCAPED);
        t->lost++;
        return;
    }
    const cpm_flight *flight = &passage.transmitted;
    if (passage.jumps) {
        cpm_random r = random_of(t, w);
        if (cpm_uniform(r.v[3]) < passage.reflectance) flight = &passage.reflected;
        w->specular = w->direct || w->specular;
        w->direct = 0;
        w->bounce++;
        w->crossings = 0;
    } else {
        w->crossings++;
    }
    survive(t, w, flight, powers, count);
}

static void arrive(task *t, walker *w, const cpm_arrival *a, float *powers) {
    const cpm_scene *scene = t->pass->scene;
    t->segments++;
    t->evaluations += a->evaluations;
    if (a->status != CPM_RAY_HIT || w->bounce >= MAX_BOUNCES || w->crossings == UINT16_MAX) {
        account(t, &w->flight, powers, CPM_ESCAPED);
        t->lost += a->status != CPM_RAY_LEFT;
        return;
    }
    const shape *s = &scene->shapes[cpm_primitive_shape(scene, a->hit.primitive)];
    if (s->material == CPM_NO_MATERIAL || scene->materials[s->material].kind == CPM_MATERIAL_DIELECTRIC)
        meet_boundary(t, w, a, powers);
    else
        meet_surface(t, w, a, powers, &scene->materials[s->material]);
}

static void emit_batch(task *t, uint64_t first, uint64_t end) {
    size_t bins = t->pass->bins;
    const cpm_emitter *e = t->emitters, *last = t->emitters + t->emitter_count;
    float *powers = malloc(bins * sizeof *powers);
    if (!powers) {
        t->failed = 1;
        return;
    }
    for (uint64_t path = first; path < end; path++) {
        while (e < last && path >= e->first + e->count) e++;
        if (e == last) break;
        walker w = {.path = (uint32_t)path, .direct = 1};
        if (!cpm_emit(t->pass, e, path, &w.flight, powers)) continue;
        account(t, &w.flight, powers, CPM_EMITTED);
        t->emitted++;
        int splits = t->pass->disperses[cpm_region_medium(&w.flight.region)];
        for (size_t b = 0; b < (splits ? bins : 1); b++) {
            w.flight.bin = splits ? (int32_t)b : -1;
            if (!splits || powers[b] > 0.0f) survive(t, &w, &w.flight, &powers[b], splits ? 1 : bins);
        }
    }
    free(powers);
}

static void run_batch(task *t, uint64_t first, uint64_t end) {
    size_t bins = t->pass->bins;
    t->next.count = 0;
    emit_batch(t, first, end);
    while (t->next.count && !t->failed && !cpm_cancelled(t->pass->context)) {
        crowd swap = t->now;
        t->now = t->next;
        t->next = swap;
        t->next.count = 0;
        for (size_t i = 0; i < t->now.count; i++) t->now.flights[i] = t->now.walkers[i].flight;
        cpm_follow(t->pass, t->now.flights, t->now.count, NULL, t->now.arrivals);
        for (size_t i = 0; i < t->now.count && !t->failed; i++)
            arrive(t, &t->now.walkers[i], &t->now.arrivals[i], &t->now.powers[i * bins]);
    }
}

/* One thread: batches until there are none. Each batch's energies are summed apart and added in order later, so that
 * the sums do not depend on which thread did what. */
typedef struct shared_work {
    const cpm_pass *pass;
    uint64_t photons, batch, batches;
    uint64_t next;     /* atomic */
    double *energies;  /* batches x CPM_ENERGY_ROWS x bins */
    uint64_t segments, lost, emitted;
    double *evaluations; /* batches */
    uint64_t bytes, most_bytes; /* of all stores, and what they may take */
    int failed, too_many;
} shared_work;

static uint64_t stored_bytes(const task *t) {
    uint64_t bytes = 0;
    for (int p = 0; p < CPM_POPULATIONS; p++)
        bytes += t->stores[p].count * sizeof(cpm_photon) + t->stores[p].spectra_count * sizeof(uint16_t);
    return bytes;
}

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
        uint64_t bytes = stored_bytes(t), grown = bytes - counted;
        counted = bytes;
#pragma omp atomic capture
        all = shared->bytes += grown;
        if (all > shared->most_bytes) {
            t->failed = 1;
#pragma omp atomic write
            shared->too_many = 1;
        }
        if (reports && batch % 16 == 0) cpm_progress(context, "trace", (double)batch / (double)shared->batches);
    }
}

cpm_status cpm_trace_paths(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                           uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                           double *energy, cpm_stats *stats) {
    cpm_context *context = pass->context;
    const size_t row = CPM_ENERGY_ROWS * pass->bins;
    shared_work shared = {.pass = pass, .photons = photons, .batch = batch > 0 ? (uint64_t)batch : BATCH};
    if (shared.batch < photons / 65536) shared.batch = photons / 65536 + 1; /* keeps the energy table small */
    shared.batches = (photons + shared.batch - 1) / shared.batch;
    shared.energies = calloc(shared.batches * row + 1, sizeof *shared.energies);
    shared.evaluations = calloc(shared.batches + 1, sizeof *shared.evaluations);
    if (!shared.energies || !shared.evaluations) shared.failed = 1;
    shared.most_bytes = (uint64_t)(MEMORY_SHARE * (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE));
#pragma omp parallel num_threads(context->threads) if (!shared.failed)
    {
        cpm_store mine[CPM_POPULATIONS] = {0};
        task t = {.pass = pass, .emitters = emitters, .emitter_count = emitter_count, .seed = seed, .origin = origin,
                  .stores = mine};
        t.now.bins = t.next.bins = pass->bins;
        if (!shared.failed) work(&t, &shared, omp_get_thread_num() == 0);
        crowd_free(&t.now), crowd_free(&t.next);
#pragma omp critical(cpm_collect)
        {
            shared.segments += t.segments, shared.lost += t.lost, shared.emitted += t.emitted;
            for (int p = 0; p < CPM_POPULATIONS; p++)
                if (!t.failed && !cpm_store_append(&stores[p], &mine[p])) t.failed = 1;
            if (t.failed) shared.failed = 1;
        }
        for (int p = 0; p < CPM_POPULATIONS; p++) cpm_store_free(&mine[p]);
    }
    double evaluations = 0.0;
    for (uint64_t b = 0; b < shared.batches && !shared.failed; b++) {
        for (size_t i = 0; i < row; i++) energy[i] += shared.energies[b * row + i];
        evaluations += shared.evaluations[b];
    }
    free(shared.energies), free(shared.evaluations);
    stats->photons_emitted = shared.emitted;
    stats->photon_segments = shared.segments;
    stats->photons_lost = shared.lost;
    stats->photon_evaluations = (uint64_t)evaluations;
    if (shared.too_many)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "photons is %llu: those stored take more than %.1f GB, %.0f %% of "
                        "this machine's memory; ask for fewer", (unsigned long long)photons,
                        1e-9 * (double)shared.most_bytes, 100.0 * MEMORY_SHARE);
    if (shared.failed) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to store the photons of %llu paths",
                                       (unsigned long long)photons);
    if (cpm_progress(context, "trace", 1.0)) return cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing photons");
    return CPM_OK;
}
