/* backend/opencl/photons.c: the photon pass on a device: a wavefront of flights in persistent buffers.
 *
 * Each work-item has segments of the buffers and a range of path numbers (cl/shared/path.h). A wave is: follow all
 * flights to their next surface, let them meet it, start fresh paths where there is room. After some waves the host
 * takes what was stored, counts what is left, and tells the user; so whatever is asked for, the device holds only a few
 * waves' photons. */
#include "photons.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdlib.h>
#include <string.h>

#include "cl/shared/bins.h"
#include "backend/backend.h"
#include "follow.h"
#include "photons_buffers.h"

#define MOMENT 0.1    /* seconds that the waves between two looks may take */
#define LEAST_FRESH 8 /* flights of an item: a packet */

typedef struct cpm_stored {
    cl_int photons;
} cpm_stored;

typedef struct photon_pass {
    const cpm_pass *pass;
    cpm_opencl *opencl;
    const cpm_emitter *emitters;
    size_t emitter_count;
    cpm_opencl_world world;
    cpm_opencl_follow_plan plan;
    cpm_photon_kernels kernels;
    cpm_photon_buffers buffers;
    cpm_photon_sizes sizes;
    cpm_tally *tallies; /* as read last */
    cl_int *counts;
    uint64_t seed;
    cpm_vec origin;
    cpm_store *stores;
    cpm_store_part parts[CPM_POPULATIONS];
    cpm_stored *stored; /* by each item, between the last two looks */
    int waves;          /* until the next one: as many as take a moment */
} photon_pass;

/* ------------------------------------------------------------------------------------------------ one wave */

/* Arguments from `next` on; sizes and values alternate until a size of 0. */
typedef struct argument {
    size_t size;
    const void *value;
} argument;

static cl_int give(const cpm_opencl *o, cl_kernel kernel, cl_uint *next, const argument *arguments, size_t count) {
    cl_int code = CL_SUCCESS;
    for (size_t i = 0; i < count && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, (*next)++, arguments[i].size, arguments[i].value);
    return code;
}
#define GIVE(kernel, next, ...)                                                                                        \
    give(p->opencl, kernel, next, (const argument[]){__VA_ARGS__},                                                     \
         sizeof((const argument[]){__VA_ARGS__}) / sizeof(argument))
#define OF(value)                                                                                                      \
    { sizeof(value), &(value) }

static cl_int give_next(const photon_pass *p, cl_kernel kernel, cl_uint *next) {
    const cpm_photon_buffers *b = &p->buffers;
    const cpm_photon_side *side = &b->side[1 - b->now];
    return GIVE(kernel, next, OF(side->flights), OF(side->walkers), OF(side->powers), OF(side->counts), OF(b->tallies),
                OF(b->energies), OF(p->sizes.stride), OF(p->sizes.bins));
}

static cl_int give_now(const photon_pass *p, cl_kernel kernel, cl_uint *next) {
    const cpm_photon_buffers *b = &p->buffers;
    const cpm_photon_side *side = &b->side[b->now];
    return GIVE(kernel, next, OF(side->flights), OF(side->walkers), OF(side->powers), OF(side->counts), OF(b->arrivals),
                OF(b->reflectance), OF(b->shares), OF(b->largest), OF(b->one), OF(b->multiply), OF(b->add));
}

static cl_int meet(const photon_pass *p, int stage) {
    const cpm_photon_buffers *b = &p->buffers;
    const cl_ulong seed = p->seed;
    cl_uint next = CPM_WORLD_BUFFERS;
    cl_kernel kernel = p->kernels.meet;
    cl_int code = cpm_opencl_world_give(&p->world, kernel);
    if (code == CL_SUCCESS) code = give_next(p, kernel, &next);
    if (code == CL_SUCCESS) code = give_now(p, kernel, &next);
    if (code == CL_SUCCESS)
        code = GIVE(kernel, &next, OF(b->photons[stage]), OF(b->spectra[stage]), OF(p->sizes.stage),
                    OF(p->sizes.halves), OF(seed), OF(p->origin.x), OF(p->origin.y), OF(p->origin.z));
    if (code == CL_SUCCESS) code = cpm_opencl_run(p->opencl, kernel, p->sizes.items);
    if (code != CL_SUCCESS || !p->kernels.specular) return code;
    kernel = p->kernels.specular;
    next = CPM_WORLD_BUFFERS;
    code = cpm_opencl_world_give(&p->world, kernel);
    if (code == CL_SUCCESS) code = give_next(p, kernel, &next);
    if (code == CL_SUCCESS) code = give_now(p, kernel, &next);
    if (code == CL_SUCCESS) code = GIVE(kernel, &next, OF(seed));
    return code == CL_SUCCESS ? cpm_opencl_run(p->opencl, kernel, p->sizes.items) : code;
}

/* May any item still start paths of this emitter? */
static int is_wanted(const photon_pass *p, const cpm_emitter *e) {
    for (size_t i = 0; i < p->sizes.items; i++)
        if (p->tallies[i].next < p->tallies[i].end && p->tallies[i].next < e->first + e->count &&
            p->tallies[i].end > e->first)
            return 1;
    return 0;
}

static cl_int start_paths(const photon_pass *p) {
    cl_int code = CL_SUCCESS;
    for (size_t i = 0; i < p->emitter_count && code == CL_SUCCESS; i++) {
        const cpm_emitter *e = &p->emitters[i];
        const cpm_emitter_buffers *b = &p->buffers.emitters[i];
        const cl_ulong first = e->first, last = e->first + e->count;
        if (!e->count || !is_wanted(p, e)) continue;
        const int area = e->light->kind == CPM_LIGHT_AREA;
        cl_kernel kernel = area ? p->kernels.start_area : p->kernels.start_delta;
        cl_uint next = area ? CPM_WORLD_BUFFERS : 0;
        if (area) code = cpm_opencl_world_give(&p->world, kernel);
        if (code == CL_SUCCESS) code = give_next(p, kernel, &next);
        const cl_int apart = p->pass->disperses[cpm_region_medium(&e->region)];
        if (code == CL_SUCCESS)
            code = area ? GIVE(kernel, &next, OF(b->data), OF(b->area), OF(b->spectrum), OF(first), OF(last),
                               OF(p->sizes.fresh), OF(e->power_factor))
                        : GIVE(kernel, &next, OF(b->data), OF(b->cumulative), OF(b->guide), OF(b->weight),
                               OF(b->spectrum), OF(b->region), OF(first), OF(last), OF(p->sizes.fresh), OF(apart));
        if (code == CL_SUCCESS) code = cpm_opencl_run(p->opencl, kernel, p->sizes.items);
    }
    return code;
}

static cl_int wave(photon_pass *p, int stage) {
    const cpm_photon_side *side = &p->buffers.side[p->buffers.now];
    cl_int code =
        cpm_opencl_follow(&p->plan, side->flights, p->buffers.arrivals, side->counts, p->sizes.items, p->sizes.stride);
    if (code == CL_SUCCESS) code = meet(p, stage);
    if (code == CL_SUCCESS) code = start_paths(p);
    p->buffers.now = 1 - p->buffers.now;
    return code;
}

/* ------------------------------------------------------------------------------------------------ what comes back */

/* One item's stored photons into the stores. 0: no room. */
static int take(const photon_pass *p, const cpm_photon *photons, const uint16_t *spectra, size_t count,
                cpm_store_part *parts) {
    const uint32_t place = (UINT32_C(1) << CPM_STAGED_POPULATION) - 1;
    for (size_t i = 0; i < count; i++) {
        const size_t bins = cpm_photon_count(photons[i].bin, (uint32_t)p->sizes.bins);
        const uint16_t *from = &spectra[photons[i].spectrum & place];
        const uint32_t population = photons[i].spectrum >> CPM_STAGED_POPULATION;
        cpm_store_part *part = &parts[population];
        uint32_t index;
        cpm_photon *to = cpm_store_place(part, bins, &index);
        if (!to) return 0;
        *to = photons[i];
        to->spectrum = index;
        memcpy(&part->store->spectra[index], from, bins * sizeof *from);
    }
    return 1;
}

/* What was stored in a stage, where the host sees it. */
typedef struct staged {
    const cpm_photon *photons;
    const uint16_t *spectra;
} staged;

static cl_int see(const photon_pass *p, int stage, staged *seen) {
    const cpm_opencl *o = p->opencl;
    const cpm_photon_sizes *s = &p->sizes;
    cl_int code = CL_SUCCESS;
    seen->spectra = NULL;
    seen->photons = o->cl->EnqueueMapBuffer(o->queue, p->buffers.photons[stage], CL_TRUE, CL_MAP_READ, 0,
                                            s->items * (size_t)s->stage * sizeof *seen->photons, 0, NULL, NULL, &code);
    if (code != CL_SUCCESS) seen->photons = NULL;
    if (code == CL_SUCCESS)
        seen->spectra =
            o->cl->EnqueueMapBuffer(o->queue, p->buffers.spectra[stage], CL_TRUE, CL_MAP_READ, 0,
                                    s->items * (size_t)s->halves * sizeof *seen->spectra, 0, NULL, NULL, &code);
    if (code != CL_SUCCESS) seen->spectra = NULL;
    return code;
}

static cl_int unsee(const photon_pass *p, int stage, const staged *seen) {
    const cpm_opencl *o = p->opencl;
    cl_int code = CL_SUCCESS, other = CL_SUCCESS;
    if (seen->photons)
        code = o->cl->EnqueueUnmapMemObject(o->queue, p->buffers.photons[stage], (void *)(uintptr_t)seen->photons, 0,
                                            NULL, NULL);
    if (seen->spectra)
        other = o->cl->EnqueueUnmapMemObject(o->queue, p->buffers.spectra[stage], (void *)(uintptr_t)seen->spectra, 0,
                                             NULL, NULL);
    return code == CL_SUCCESS ? other : code;
}

/* All items' photons, `stored` of them, into the stores. 0: no room. */
static int drain(photon_pass *p, const staged *seen, const cpm_stored *stored) {
    const cpm_photon_sizes *s = &p->sizes;
    for (size_t i = 0; i < s->items; i++)
        if (!take(p, seen->photons + i * (size_t)s->stage, seen->spectra + i * (size_t)s->halves,
                  (size_t)stored[i].photons, p->parts))
            return 0;
    return 1;
}

/* Waits for the waves; *left: flights and paths that are still to come, *bytes: of what was stored. */
static cl_int look(photon_pass *p, uint64_t *left, uint64_t *bytes) {
    const cpm_opencl *o = p->opencl;
    const size_t items = p->sizes.items;
    cl_int code = o->cl->EnqueueReadBuffer(o->queue, p->buffers.tallies, CL_FALSE, 0, items * sizeof *p->tallies,
                                           p->tallies, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        code = o->cl->EnqueueReadBuffer(o->queue, p->buffers.side[p->buffers.now].counts, CL_TRUE, 0,
                                        items * sizeof *p->counts, p->counts, 0, NULL, NULL);
    int shining = 0; /* or dark lights keep some path numbers */
    for (size_t i = 0; i < p->emitter_count && code == CL_SUCCESS; i++)
        shining |= p->emitters[i].count && is_wanted(p, &p->emitters[i]);
    *left = 0;
    for (size_t i = 0; i < items && code == CL_SUCCESS; i++) {
        *left += (uint64_t)p->counts[i] + (shining ? p->tallies[i].end - p->tallies[i].next : 0);
        *bytes += (uint64_t)p->tallies[i].photons * sizeof(cpm_photon) + (uint64_t)p->tallies[i].halves * 2;
        p->stored[i].photons = p->tallies[i].photons;
        p->tallies[i].photons = p->tallies[i].halves = 0;
    }
    return code;
}

/* Some waves, which store into `stage`; does not wait. */
static cl_int start_waves(photon_pass *p, int stage) {
    const cpm_opencl *o = p->opencl;
    cl_int code = CL_SUCCESS;
    for (int i = 0; i < p->waves && code == CL_SUCCESS; i++) code = wave(p, stage);
    return code == CL_SUCCESS ? o->cl->Flush(o->queue) : code;
}

static cpm_status collect(photon_pass *p, double *energy, cpm_stats *stats) {
    const cpm_opencl *o = p->opencl;
    const size_t row = CPM_ENERGY_ROWS * p->pass->bins, items = p->sizes.items;
    double *energies = malloc(items * row * sizeof *energies), evaluations = 0.0;
    if (!energies) return cpm_fail(p->pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for energies");
    const cl_int code = o->cl->EnqueueReadBuffer(o->queue, p->buffers.energies, CL_TRUE, 0,
                                                 items * row * sizeof *energies, energies, 0, NULL, NULL);
    for (size_t i = 0; i < items && code == CL_SUCCESS; i++) {
        for (size_t k = 0; k < row; k++) energy[k] += energies[i * row + k];
        evaluations += p->tallies[i].evaluations;
        stats->photons_emitted += p->tallies[i].emitted;
        stats->photon_segments += p->tallies[i].segments;
        stats->photons_lost += p->tallies[i].lost;
    }
    stats->photon_evaluations = (uint64_t)evaluations;
    free(energies);
    return code == CL_SUCCESS ? CPM_OK : cpm_opencl_failed(p->pass->context, o, "reading energies", code);
}

/* ------------------------------------------------------------------------------------------------------- the pass */

/* Looks that are far apart keep the user waiting, and near ones the device: fewer waves, then fewer flights in one. */
static void pace(photon_pass *p, double seconds) {
    if (seconds < MOMENT && p->waves < CPM_WAVES)
        p->waves *= 2;
    else if (seconds > 3.0 * MOMENT && p->waves > 1)
        p->waves /= 2;
    else if (seconds > 3.0 * MOMENT && p->sizes.fresh > LEAST_FRESH)
        p->sizes.fresh /= 2;
}

/* The device goes on into the other stage while the host takes what is in one. */
static cpm_status waves(photon_pass *p, uint64_t photons, uint64_t most) {
    cpm_context *context = p->pass->context;
    uint64_t bytes = 0, left = photons;
    int room = 1, cancelled = 0, stage = 0;
    p->waves = 1;
    cl_int code = start_paths(p);
    p->buffers.now = 1;
    if (code == CL_SUCCESS && left) code = start_waves(p, stage);
    while (code == CL_SUCCESS && left && room && !cancelled && bytes <= most) {
        staged seen = {NULL, NULL};
        const double start = cpm_seconds();
        code = look(p, &left, &bytes);
        pace(p, cpm_seconds() - start);
        if (code == CL_SUCCESS) code = see(p, stage, &seen);
        if (code == CL_SUCCESS && left) /* what they have stored counts from 0 again */
            code = p->opencl->cl->EnqueueWriteBuffer(p->opencl->queue, p->buffers.tallies, CL_FALSE, 0,
                                                     p->sizes.items * sizeof *p->tallies, p->tallies, 0, NULL, NULL);
        if (code == CL_SUCCESS && left) code = start_waves(p, 1 - stage);
        if (code == CL_SUCCESS) room = drain(p, &seen, p->stored);
        const cl_int back = unsee(p, stage, &seen);
        if (code == CL_SUCCESS) code = back;
        stage = 1 - stage;
        const uint64_t waiting = left < photons ? left : photons;
        cancelled = cpm_progress(context, "trace", 1.0 - (double)waiting / (double)photons);
    }
    if (code != CL_SUCCESS) return cpm_opencl_failed(context, p->opencl, "tracing photons", code);
    if (bytes > most) return cpm_stores_too_full(context, photons, most);
    if (!room)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to store the photons of %llu paths",
                        (unsigned long long)photons);
    return cancelled ? cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing photons") : CPM_OK;
}

static cpm_status begin(photon_pass *p, uint64_t photons, int32_t batch, uint64_t *most) {
    cpm_context *context = p->pass->context;
    cpm_status status = cpm_opencl_world_open(p->pass, &p->world);
    if (!status) status = cpm_opencl_follow_open(&p->world, &p->plan);
    if (!status) status = cpm_photon_kernels_of(p->pass, p->emitters, p->emitter_count, &p->kernels);
    if (!status) status = cpm_photon_sizes_of(p->pass, photons, batch, p->world.bytes, &p->sizes);
    if (status) return status;
    p->tallies = calloc(p->sizes.items, sizeof *p->tallies);
    p->counts = calloc(p->sizes.items, sizeof *p->counts);
    p->stored = calloc(p->sizes.items, sizeof *p->stored);
    *most = cpm_stores_open(1, p->stores);
    if (!p->tallies || !p->counts || !p->stored || !*most)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to store the photons of %llu paths",
                        (unsigned long long)photons);
    for (size_t i = 0; i < p->sizes.items; i++) {
        p->tallies[i].next = photons / p->sizes.items * i + photons % p->sizes.items * i / p->sizes.items;
        p->tallies[i].end = photons / p->sizes.items * (i + 1) + photons % p->sizes.items * (i + 1) / p->sizes.items;
    }
    for (int k = 0; k < CPM_POPULATIONS; k++) p->parts[k].store = &p->stores[k];
    return cpm_photon_buffers_open(p->pass, p->emitters, p->emitter_count, &p->sizes, p->tallies, &p->buffers);
}

cpm_status cpm_opencl_photons(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                              uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                              double *energy, cpm_stats *stats) {
    cpm_context *context = pass->context;
    photon_pass p = {.pass = pass,
                     .opencl = context->opencl,
                     .emitters = emitters,
                     .emitter_count = emitter_count,
                     .seed = seed,
                     .origin = origin,
                     .stores = stores};
    uint64_t most = 0;
    cpm_opencl_lock(p.opencl);
    cpm_status status = cpm_opencl_refuses(pass);
    if (!status) status = begin(&p, photons, batch, &most);
    if (!status) status = waves(&p, photons, most);
    if (!status) status = collect(&p, energy, stats);
    p.opencl->cl->Finish(p.opencl->queue);
    for (int k = 0; k < CPM_POPULATIONS && !status; k++) cpm_store_close(&stores[k], &p.parts[k], 1);
    cpm_photon_buffers_close(p.opencl, &p.buffers);
    cpm_opencl_follow_close(&p.plan);
    cpm_opencl_world_close(&p.world);
    cpm_opencl_unlock(p.opencl);
    free(p.tallies), free(p.counts), free(p.stored);
    if (!status && cpm_progress(context, "trace", 1.0))
        status = cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing photons");
    return status;
}

#else
cpm_status cpm_opencl_photons(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                              uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                              double *energy, cpm_stats *stats) {
    (void)emitters, (void)emitter_count, (void)photons, (void)seed, (void)batch, (void)origin, (void)stores;
    (void)energy, (void)stats;
    return cpm_fail(pass->context, CPM_ERROR_UNSUPPORTED,
                    "this library was built without OpenCL; use the native backend");
}
#endif
