/* backend/opencl/eye.c: the eye pass as a wavefront. A batch of pixels' rays go on together, level after level: they
 * are followed to what they meet, gather there, are added to their pixels, and the branches behind what is specular
 * take their place. The host only counts: which branches gather, how many follow each, where those go. Branches stay in
 * the order of their pixels, and of a pixel's in the order in which the native backend has them; so sums are equal too.
 *
 * How many branches a batch will have is not known before. Where they become more than there is room for, the batch
 * begins again with half of its pixels. */
#include "eye.h"

#include "eye_buffers.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <math.h>
#include <omp.h>
#include <string.h>

#include "backend/backend.h"
#include "photon/tree.h"

#define TILE 16 /* pixels go in tiles: neighbours gather from the same photons */

typedef struct eyes {
    const cpm_pass *pass;
    const cpm_gather *gather;
    const cpm_opencl *o;
    const cpm_eye *eye;
    cpm_opencl_world world;
    cpm_opencl_follow_plan plan;
    cpm_eye_kernels kernels;
    cpm_eye_device device;
    cpm_eye_host host;
    cpm_opencl_map maps[CPM_POPULATIONS];
    cpm_opencl_scratch scratch;
    int host_gathers; /* the maps do not fit the device */
    cl_int live;      /* branches that live now */
    int now;          /* their side */
    cl_int pixels;    /* of the batch */
    uint64_t rays, segments, gathers;
    double evaluations;
} eyes;

typedef enum outcome { DONE, TOO_MANY, FAILED } outcome;

static cl_int share_of(const eyes *e, cl_int count) {
    const cl_int items = (cl_int)e->device.items;
    return ((count + items - 1) / items + 7) / 8 * 8;
}

static cl_int write(const eyes *e, cl_mem to, const void *from, size_t size) {
    return e->o->cl->EnqueueWriteBuffer(e->o->queue, to, CL_FALSE, 0, size, from, 0, NULL, NULL);
}

static cl_int read(const eyes *e, cl_mem from, void *to, size_t size) {
    return e->o->cl->EnqueueReadBuffer(e->o->queue, from, CL_TRUE, 0, size, to, 0, NULL, NULL);
}

/* The world's and the eye's tables, as kernels take them. */
static cpm_opencl_arguments begin(const eyes *e, cl_kernel kernel, int with_world) {
    cpm_opencl_arguments a = {e->o, kernel, 0, CL_SUCCESS};
    if (with_world) cpm_opencl_give_buffers(&a, e->world.buffers, CPM_WORLD_BUFFERS);
    cpm_opencl_give_buffers(&a, e->device.tables, CPM_EYE_TABLES);
    return a;
}

static void give_int(cpm_opencl_arguments *a, cl_int value) { cpm_opencl_give(a, sizeof value, &value); }

static cl_int run(const eyes *e, cpm_opencl_arguments *a, cl_int count, cl_int share) {
    give_int(a, count), give_int(a, share);
    return a->code == CL_SUCCESS ? cpm_opencl_run(e->o, a->kernel, (size_t)((count + share - 1) / share)) : a->code;
}

/* Samples [first, end) of the batch's pixels. */
static cl_int start(eyes *e, int32_t first, int32_t end) {
    const cpm_eye_frame *is = &e->eye->is;
    const cl_int each = (end - first) * (is->splits ? is->bins : 1);
    cpm_opencl_arguments a = begin(e, e->kernels.start, 0);
    e->live = e->pixels * each, e->now = 0;
    for (cl_int i = 0; i < e->live; i++) e->host.owner[0][i] = i / each;
    cpm_opencl_give_buffers(&a, &e->device.pixels, 1);
    give_int(&a, first), give_int(&a, each);
    cpm_opencl_give_buffers(&a, &e->device.flights[0], 1), cpm_opencl_give_buffers(&a, &e->device.weights[0], 1);
    return run(e, &a, e->live, share_of(e, e->live));
}

static cl_int follow(eyes *e) {
    const cl_int share = share_of(e, e->live), items = (e->live + share - 1) / share;
    cpm_opencl_arguments a = begin(e, e->kernels.see, 1);
    for (cl_int i = 0; i < items; i++) e->host.counts[i] = i + 1 < items ? share : e->live - i * share;
    cl_int code = write(e, e->device.counts, e->host.counts, (size_t)items * sizeof *e->host.counts);
    if (code == CL_SUCCESS)
        code = cpm_opencl_follow(&e->plan, e->device.flights[e->now], e->device.arrivals, e->device.counts,
                                 (size_t)items, share);
    cpm_opencl_give_buffers(&a, &e->device.arrivals, 1), cpm_opencl_give_buffers(&a, &e->device.seen, 1);
    cpm_opencl_give_buffers(&a, &e->device.evaluations, 1);
    if (code == CL_SUCCESS) code = run(e, &a, e->live, share);
    if (code == CL_SUCCESS) code = read(e, e->device.seen, e->host.seen, (size_t)e->live);
    if (code == CL_SUCCESS) code = read(e, e->device.evaluations, e->host.evaluations, (size_t)items * sizeof(double));
    for (cl_int i = 0; i < items && code == CL_SUCCESS; i++) e->evaluations += e->host.evaluations[i];
    e->segments += (uint64_t)e->live;
    return code;
}

/* The branches that gather; their number. */
static cl_int list_gathers(eyes *e) {
    cl_int count = 0;
    for (cl_int i = 0; i < e->live; i++) {
        e->host.gathered[i] = count;
        if (e->host.seen[i] == CPM_SEEN_DIFFUSE) e->host.list[count++] = i;
        if (e->host.gathered[i] == count) e->host.gathered[i] = 0; /* of no use, but in range */
    }
    e->gathers += (uint64_t)count;
    return count;
}

static cl_int search(const eyes *e, int population, cl_int count) {
    const cl_uint nearest = (cl_uint)e->gather->nearest;
    const double radius = e->gather->max_radius[population];
    const cl_int items = (cl_int)e->scratch.items;
    cpm_opencl_arguments a = begin(e, e->kernels.gather, 1);
    cpm_opencl_give_buffers(&a, e->maps[population].buffers, CPM_MAP_BUFFERS);
    const cl_mem more[] = {e->device.map_origin, e->device.arrivals, e->device.list, e->device.irradiance,
                           e->device.whole};
    cpm_opencl_give_buffers(&a, more, 5);
    cpm_opencl_give_buffers(&a, e->scratch.buffers, CPM_SCRATCH_BUFFERS);
    cpm_opencl_give(&a, sizeof e->scratch.capacity, &e->scratch.capacity);
    cpm_opencl_give(&a, sizeof radius, &radius), cpm_opencl_give(&a, sizeof nearest, &nearest);
    return run(e, &a, count, (count + items - 1) / items);
}

static cl_int gather_on_device(eyes *e, cl_int count) {
    const double none = 0.0;
    cl_int code = write(e, e->device.list, e->host.list, (size_t)count * sizeof *e->host.list);
    const cl_mem clear[2] = {e->device.irradiance, e->device.whole};
    const size_t sizes[2] = {(size_t)count * (size_t)e->device.bins * sizeof none, (size_t)count * sizeof none};
    for (int i = 0; i < 2 && code == CL_SUCCESS; i++)
        code = e->o->cl->EnqueueFillBuffer(e->o->queue, clear[i], &none, sizeof none, 0, sizes[i], 0, NULL, NULL);
    for (int i = 0; i < CPM_POPULATIONS && code == CL_SUCCESS; i++)
        if (cpm_tree_count(e->gather->photons->trees[cpm_gather_order[i]]))
            code = search(e, cpm_gather_order[i], count);
    return code;
}

/* Where the maps do not fit the device. */
static cl_int gather_on_host(eyes *e, cl_int count, int *failed) {
    const cpm_world *w = &e->pass->world;
    const size_t bins = (size_t)e->device.bins;
    cl_int code = read(e, e->device.arrivals, e->host.arrivals, (size_t)e->live * sizeof *e->host.arrivals);
    if (code != CL_SUCCESS) return code;
#pragma omp parallel num_threads(e->pass->context->threads)
    {
        cpm_map_query *queries[CPM_POPULATIONS];
        const int ready = cpm_gather_queries(e->gather, queries);
        if (!ready) {
#pragma omp atomic write
            *failed = 1;
        }
#pragma omp for schedule(dynamic, 64)
        for (cl_int q = 0; q < count; q++)
            if (ready && !cpm_cancelled(e->pass->context))
                cpm_gather_seen(e->gather, w, queries, &e->host.arrivals[e->host.list[q]],
                                &e->host.irradiance[(size_t)q * bins]);
        cpm_gather_queries_free(queries);
    }
    return write(e, e->device.irradiance, e->host.irradiance, (size_t)count * bins * sizeof(double));
}

static cl_int film(eyes *e) {
    cpm_opencl_arguments a = begin(e, e->kernels.film, 1);
    const cl_int *owner = e->host.owner[e->now];
    for (cl_int p = 0, i = 0; p <= e->pixels; p++) {
        while (i < e->live && owner[i] < p) i++;
        e->host.first_branch[p] = i;
    }
    cl_int code = write(e, e->device.first_branch, e->host.first_branch, ((size_t)e->pixels + 1) * sizeof(cl_int));
    if (code == CL_SUCCESS) code = write(e, e->device.gathered, e->host.gathered, (size_t)e->live * sizeof(cl_int));
    const cl_mem all[] = {e->device.flights[e->now], e->device.arrivals,   e->device.weights[e->now], e->device.seen,
                          e->device.gathered,        e->device.irradiance, e->device.first_branch,    e->device.sums};
    cpm_opencl_give_buffers(&a, all, 8);
    return code == CL_SUCCESS ? run(e, &a, e->pixels, share_of(e, e->pixels)) : code;
}

static cl_int branch_kernel(eyes *e, cl_int depth, cl_int counting) {
    cpm_opencl_arguments a = begin(e, e->kernels.branch, 1);
    const cl_mem from[] = {e->device.flights[e->now], e->device.arrivals, e->device.weights[e->now], e->device.seen};
    const cl_mem to[] = {e->device.children, e->device.flights[!e->now], e->device.weights[!e->now]};
    cpm_opencl_give_buffers(&a, from, 4);
    give_int(&a, depth), give_int(&a, counting);
    cpm_opencl_give_buffers(&a, to, 3);
    return run(e, &a, e->live, share_of(e, e->live));
}

/* The branches that follow those that live now take their place. */
static cl_int branch(eyes *e, cl_int depth, outcome *how) {
    cl_int code = CL_SUCCESS, total = 0, specular = 0;
    for (cl_int i = 0; i < e->live && !specular; i++) specular = e->host.seen[i] >= CPM_SEEN_MIRROR;
    if (specular) code = branch_kernel(e, depth, 1);
    if (specular && code == CL_SUCCESS)
        code = read(e, e->device.children, e->host.children, (size_t)e->live * sizeof(cl_int));
    for (cl_int i = 0; specular && i < e->live && code == CL_SUCCESS; i++) {
        const cl_int count = e->host.children[i];
        if (count > e->device.capacity - total) {
            *how = TOO_MANY;
            return CL_SUCCESS;
        }
        e->host.children[i] = total;
        for (cl_int k = 0; k < count; k++) e->host.owner[!e->now][total++] = e->host.owner[e->now][i];
    }
    if (total && code == CL_SUCCESS)
        code = write(e, e->device.children, e->host.children, (size_t)e->live * sizeof(cl_int));
    if (total && code == CL_SUCCESS) code = branch_kernel(e, depth, 0);
    e->live = total, e->now = !e->now;
    return code;
}

/* The live branches to their ends. */
static outcome follow_branches(eyes *e) {
    cpm_context *context = e->pass->context;
    outcome how = DONE;
    int no_memory = 0;
    cl_int code = CL_SUCCESS;
    for (cl_int depth = 0; e->live && code == CL_SUCCESS && how == DONE && !cpm_poll(context); depth++) {
        code = follow(e);
        const cl_int count = list_gathers(e);
        if (count && code == CL_SUCCESS)
            code = e->host_gathers ? gather_on_host(e, count, &no_memory) : gather_on_device(e, count);
        if (code == CL_SUCCESS) code = film(e);
        if (!e->kernels.branch) break;
        if (code == CL_SUCCESS) code = branch(e, depth, &how);
    }
    if (e->o->cl->Finish(e->o->queue) != CL_SUCCESS && code == CL_SUCCESS) code = CL_OUT_OF_RESOURCES;
    if (code != CL_SUCCESS) cpm_opencl_failed(context, e->o, "following eye rays", code);
    if (no_memory) cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to search the photon maps");
    return code != CL_SUCCESS || no_memory ? FAILED : how;
}

/* Pixel number `index` in the order of tiles, as row x width + column. */
static int32_t pixel_at(const cpm_eye_frame *is, int64_t index) {
    const int64_t tall = (int64_t)is->width * TILE, row = index / tall * TILE;
    const int64_t high = is->height - row < TILE ? is->height - row : TILE, rest = index % tall;
    const int64_t column = rest / (TILE * high) * TILE, wide = is->width - column < TILE ? is->width - column : TILE;
    const int64_t at = rest - column * high;
    return (int32_t)((row + at / wide) * is->width + column + at % wide);
}

/* The picture's pixels from number `first` on, in the order of tiles. */
static outcome paint(eyes *e, int64_t first, cpm_image *image) {
    const cpm_eye_frame *is = &e->eye->is;
    const size_t bins = (size_t)is->bins;
    const double none = 0.0;
    outcome how = DONE;
    for (cl_int p = 0; p < e->pixels; p++) e->host.pixels[p] = pixel_at(is, first + p);
    cl_int code = write(e, e->device.pixels, e->host.pixels, (size_t)e->pixels * sizeof(cl_int));
    if (code == CL_SUCCESS)
        code = e->o->cl->EnqueueFillBuffer(e->o->queue, e->device.sums, &none, sizeof none, 0,
                                           (size_t)e->pixels * bins * sizeof none, 0, NULL, NULL);
    for (int32_t s = 0; s < is->samples && code == CL_SUCCESS && how == DONE; s += CPM_EYE_SAMPLES_AT_ONCE) {
        const int32_t end = is->samples - s < CPM_EYE_SAMPLES_AT_ONCE ? is->samples : s + CPM_EYE_SAMPLES_AT_ONCE;
        code = start(e, s, end);
        if (code == CL_SUCCESS) how = follow_branches(e);
        if (cpm_cancelled(e->pass->context)) return DONE;
    }
    if (how != DONE) return how;
    if (code == CL_SUCCESS) code = read(e, e->device.sums, e->host.sums, (size_t)e->pixels * bins * sizeof(double));
    if (code != CL_SUCCESS) {
        cpm_opencl_failed(e->pass->context, e->o, "following eye rays", code);
        return FAILED;
    }
    e->rays += (uint64_t)e->pixels * (uint64_t)is->samples;
    for (cl_int p = 0; p < e->pixels; p++)
        for (size_t b = 0; b < bins; b++)
            image->data[(size_t)e->host.pixels[p] * bins + b] =
                (float)(e->host.sums[(size_t)p * bins + b] / is->samples);
    return DONE;
}

static cpm_status paint_all(eyes *e, cpm_image *image) {
    cpm_context *context = e->pass->context;
    const cpm_eye_frame *is = &e->eye->is;
    const int64_t all = (int64_t)is->width * is->height;
    const int32_t at_once = is->samples < CPM_EYE_SAMPLES_AT_ONCE ? is->samples : CPM_EYE_SAMPLES_AT_ONCE;
    int64_t most = e->device.capacity / (at_once * (is->splits ? is->bins : 1));
    if (most > all) most = all;
    if (most < 1) most = 1;
    for (int64_t first = 0; first < all;) {
        const eyes before = *e;
        e->pixels = (cl_int)(all - first < most ? all - first : most);
        const outcome how = paint(e, first, image);
        if (how == FAILED) return CPM_ERROR_BACKEND; /* the message is there */
        if (cpm_cancelled(context)) return CPM_OK;
        if (how == TOO_MANY) {
            e->segments = before.segments, e->gathers = before.gathers, e->evaluations = before.evaluations;
            if (e->pixels == 1)
                return cpm_fail(
                    context, CPM_ERROR_OUT_OF_MEMORY,
                    "the branches of one pixel are more than %d, for which the memory of OpenCL device '%s' "
                    "suffices; allow more, or use the native backend",
                    (int)e->device.capacity, e->o->name);
            most = (e->pixels + 1) / 2;
            continue;
        }
        first += e->pixels;
        cpm_progress(context, "gather", (double)first / (double)all);
    }
    image->stats.eye_rays += e->rays;
    image->stats.eye_segments += e->segments;
    image->stats.gathers += e->gathers;
    image->stats.eye_evaluations = (uint64_t)e->evaluations;
    return CPM_OK;
}

/* Maps and their searches' room, or the decision to leave them to the host. */
static cpm_status open_maps(eyes *e, uint64_t allowed, uint64_t *taken) {
    cpm_context *context = e->pass->context;
    const cpm_map_tree *const *trees = (const cpm_map_tree *const *)e->gather->photons->trees;
    cl_int code = CL_SUCCESS;
    *taken = 0;
    for (int t = 0; t < CPM_POPULATIONS; t++) {
        if (!cpm_opencl_map_fits(e->o, trees[t], allowed - *taken))
            e->host_gathers = 1;
        else
            *taken += cpm_opencl_map_bytes(e->o, trees[t]);
    }
    if (e->host_gathers) *taken = 0;
    for (int t = 0; t < CPM_POPULATIONS && !e->host_gathers && code == CL_SUCCESS; t++)
        if (trees[t]->count) code = cpm_opencl_map_open(e->o, trees[t], &e->maps[t]);
    if (code != CL_SUCCESS) return cpm_opencl_failed(context, e->o, "making the photon maps' buffers", code);
    if (e->host_gathers) return CPM_OK;
    return cpm_opencl_scratch_open(context, trees, e->gather->nearest, (size_t)e->o->units * 32, allowed / 2,
                                   &e->scratch);
}

static cpm_status run_eyes(eyes *e, cpm_image *image) {
    cpm_context *context = e->pass->context;
    const uint64_t budget = cpm_opencl_budget(e->o);
    uint64_t taken = 0;
    cpm_status status = cpm_opencl_world_open(e->pass, &e->world);
    if (!status && e->world.bytes > budget / 2)
        status =
            cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY,
                     "the scene takes %.3f MB of OpenCL device '%s', of which %.3f MB may be used; allow more, or use "
                     "the native backend",
                     1e-6 * (double)e->world.bytes, e->o->name, 1e-6 * (double)budget);
    if (!status) status = cpm_opencl_follow_open(&e->world, &e->plan);
    if (!status) status = cpm_eye_kernels_of(e->pass, &e->kernels);
    if (!status) status = open_maps(e, (budget - e->world.bytes) / 2, &taken);
    if (!status)
        status = cpm_eye_device_open(e->pass, e->gather, e->eye, (budget - e->world.bytes - taken) / 2, &e->device);
    if (!status && !cpm_eye_host_open(&e->device, e->host_gathers, &e->host))
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass");
    if (!status) status = paint_all(e, image);
    cpm_eye_host_close(&e->host);
    cpm_eye_device_close(e->o, &e->device);
    cpm_opencl_scratch_close(e->o, &e->scratch);
    for (int t = 0; t < CPM_POPULATIONS; t++) cpm_opencl_map_close(e->o, &e->maps[t]);
    cpm_opencl_follow_close(&e->plan);
    cpm_opencl_world_close(&e->world);
    return status;
}

cpm_status cpm_opencl_eye(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                          cpm_image *image) {
    cpm_eye_tables tables;
    eyes e = {.pass = pass, .gather = gather, .o = pass->context->opencl, .eye = &tables.eye};
    cpm_progress(pass->context, "gather", 0.0);
    cpm_status status = cpm_eye_begin(pass, gather, seed, samples, image, &tables);
    if (!status) status = cpm_opencl_refuses(pass);
    if (!status) {
        cpm_opencl_lock(pass->context->opencl);
        status = run_eyes(&e, image);
        cpm_opencl_unlock(pass->context->opencl);
    }
    cpm_eye_end(&tables);
    if (!status && cpm_progress(pass->context, "gather", 1.0))
        status = cpm_fail(pass->context, CPM_ERROR_CANCELLED, "cancelled while gathering");
    return status;
}
#else
cpm_status cpm_opencl_eye(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                          cpm_image *image) {
    (void)gather, (void)seed, (void)samples, (void)image;
    return cpm_fail(pass->context, CPM_ERROR_UNSUPPORTED,
                    "this library was built without OpenCL; use the native backend");
}
#endif
