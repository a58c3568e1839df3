/* backend/opencl/gather.c: irradiance at the caller's points, on the device. */
#include "map.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <string.h>

#include "photon/tree.h"
#include "program.h"
#include "world.h"

#define ITEMS_A_UNIT 32
#define BATCH 65536 /* queries between two looks at the progress callback */

typedef struct batch {
    cl_mem points, normals, irradiance, radii, found, ids;
    cl_int size;
} batch;

static void batch_close(const cpm_opencl *o, batch *b) {
    const cl_mem all[] = {b->points, b->normals, b->irradiance, b->radii, b->found, b->ids};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i]) o->cl->ReleaseMemObject(all[i]);
}

static cl_int batch_open(const cpm_opencl *o, size_t count, size_t bins, uint64_t allowed, batch *b) {
    const uint64_t each = 24 + 8 * bins + 12;
    uint64_t size = allowed / each, largest = o->largest / (8 * bins > 12 ? 8 * bins : 12);
    cl_int code = CL_SUCCESS;
    memset(b, 0, sizeof *b);
    size = size < largest ? size : largest;
    size = size < BATCH ? size : BATCH;
    size = size < count ? size : count;
    const size_t n = size ? (size_t)size : 1;
    b->size = (cl_int)n;
    b->points = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, 12 * n, NULL, &code);
    if (code == CL_SUCCESS) b->normals = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, 12 * n, NULL, &code);
    if (code == CL_SUCCESS) b->irradiance = cpm_opencl_buffer(o, CL_MEM_READ_WRITE, 8 * n * bins, NULL, &code);
    if (code == CL_SUCCESS) b->radii = cpm_opencl_buffer(o, CL_MEM_WRITE_ONLY, 8 * n, NULL, &code);
    if (code == CL_SUCCESS) b->found = cpm_opencl_buffer(o, CL_MEM_WRITE_ONLY, 4 * n, NULL, &code);
    if (code == CL_SUCCESS) b->ids = cpm_opencl_buffer(o, CL_MEM_WRITE_ONLY, 0, NULL, &code); /* not kept */
    return code;
}

/* One tree's share of a batch. */
static cl_int search(const cpm_opencl *o, cl_kernel kernel, const cpm_opencl_map *map, const batch *b,
                     const cpm_opencl_scratch *scratch, cl_int count, int32_t k, double max_radius) {
    cpm_opencl_arguments a = {o, kernel, 0, CL_SUCCESS};
    const cl_mem queries[] = {b->points, b->normals, b->irradiance, b->radii, b->found, b->ids};
    const cl_uint nearest = (cl_uint)k;
    const cl_int no = 0;
    const cl_long n = count, share = (n + (cl_long)scratch->items - 1) / (cl_long)scratch->items;
    cpm_opencl_give_buffers(&a, map->buffers, CPM_MAP_BUFFERS);
    cpm_opencl_give_buffers(&a, queries, 6);
    cpm_opencl_give_buffers(&a, scratch->buffers, CPM_SCRATCH_BUFFERS);
    cpm_opencl_give(&a, sizeof scratch->capacity, &scratch->capacity);
    cpm_opencl_give(&a, sizeof max_radius, &max_radius);
    cpm_opencl_give(&a, sizeof nearest, &nearest);
    cpm_opencl_give(&a, sizeof no, &no), cpm_opencl_give(&a, sizeof no, &no);
    cpm_opencl_give(&a, sizeof n, &n), cpm_opencl_give(&a, sizeof share, &share);
    return a.code == CL_SUCCESS ? cpm_opencl_run(o, kernel, (size_t)((n + share - 1) / share)) : a.code;
}

typedef struct request {
    const float *points, *normals;
    size_t count, bins;
    int32_t nearest;
    double max_radius;
    double *irradiance;
} request;

static cpm_status batches(cpm_context *context, cl_kernel kernel, const cpm_opencl_map *maps, int map_count,
                          const batch *b, const cpm_opencl_scratch *scratch, const request *r) {
    const cpm_opencl *o = context->opencl;
    for (size_t first = 0; first < r->count; first += (size_t)b->size) {
        const size_t now = r->count - first < (size_t)b->size ? r->count - first : (size_t)b->size;
        double *to = r->irradiance + first * r->bins;
        cl_int code =
            o->cl->EnqueueWriteBuffer(o->queue, b->points, CL_FALSE, 0, 12 * now, r->points + 3 * first, 0, NULL, NULL);
        if (code == CL_SUCCESS)
            code = o->cl->EnqueueWriteBuffer(o->queue, b->normals, CL_FALSE, 0, 12 * now, r->normals + 3 * first, 0,
                                             NULL, NULL);
        if (code == CL_SUCCESS)
            code =
                o->cl->EnqueueWriteBuffer(o->queue, b->irradiance, CL_FALSE, 0, 8 * now * r->bins, to, 0, NULL, NULL);
        for (int t = 0; t < map_count && code == CL_SUCCESS; t++)
            code = search(o, kernel, &maps[t], b, scratch, (cl_int)now, r->nearest, r->max_radius);
        if (code == CL_SUCCESS)
            code = o->cl->EnqueueReadBuffer(o->queue, b->irradiance, CL_TRUE, 0, 8 * now * r->bins, to, 0, NULL, NULL);
        if (code != CL_SUCCESS) {
            o->cl->Finish(o->queue);
            return cpm_opencl_failed(context, o, "gathering", code);
        }
        if (cpm_progress(context, "gather", (double)(first + now) / (double)r->count))
            return cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while estimating irradiance");
    }
    return CPM_OK;
}

cpm_status cpm_opencl_irradiance(cpm_context *context, const cpm_photons *photons, int first, int last,
                                 const float *points, const float *normals, size_t count, int32_t nearest,
                                 double max_radius, double *irradiance) {
    cpm_opencl *o = context->opencl;
    const request r = {points, normals, count, photons->bins, nearest, max_radius, irradiance};
    const cpm_map_tree *trees[CPM_POPULATIONS] = {NULL};
    cpm_opencl_map maps[CPM_POPULATIONS] = {0};
    cpm_opencl_scratch scratch = {0};
    batch b = {0};
    cl_kernel kernel = NULL;
    char options[256];
    uint64_t left = cpm_opencl_budget(o);
    int map_count = 0;
    cl_int code = CL_SUCCESS;
    if (!count) return CPM_OK;
    cpm_opencl_options(o, 1, "", options, sizeof options);
    cpm_opencl_lock(o);
    cpm_status status = cpm_program_kernel(context, "gather", "cpm_gather", options, &kernel);
    for (int t = first; t <= last && !status && code == CL_SUCCESS; t++) {
        const cpm_map_tree *tree = photons->trees[t];
        if (!tree->count) continue;
        trees[map_count] = tree;
        code = cpm_opencl_map_open(o, tree, &maps[map_count++]);
        left -= cpm_opencl_map_bytes(o, tree);
    }
    if (!status && code == CL_SUCCESS && map_count) {
        status = cpm_opencl_scratch_open(context, trees, nearest, (size_t)o->units * ITEMS_A_UNIT, left / 2, &scratch);
        if (!status) code = batch_open(o, count, photons->bins, left / 2, &b);
        if (!status && code == CL_SUCCESS) status = batches(context, kernel, maps, map_count, &b, &scratch, &r);
    }
    if (!status && code != CL_SUCCESS) status = cpm_opencl_failed(context, o, "making a photon map's buffers", code);
    batch_close(o, &b);
    cpm_opencl_scratch_close(o, &scratch);
    for (int t = 0; t < map_count; t++) cpm_opencl_map_close(o, &maps[t]);
    cpm_opencl_unlock(o);
    return status;
}
#endif
