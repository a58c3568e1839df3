/* backend/opencl/map.c: see map.h. */
#include "map.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <string.h>

#include "photon/tree.h"

typedef struct array {
    const void *from;
    size_t size;
} array;

static void arrays_of(const cpm_map_tree *tree, array arrays[CPM_MAP_BUFFERS - 1]) {
    arrays[0] = (array){tree->nodes, tree->node_count * sizeof *tree->nodes};
    arrays[1] = (array){tree->points, (3 * tree->count + CPM_PAD) * sizeof *tree->points};
    arrays[2] = (array){tree->photons, tree->count * sizeof *tree->photons};
    arrays[3] = (array){tree->spectra, (tree->spectra_count + CPM_PAD) * sizeof *tree->spectra};
}

uint64_t cpm_opencl_map_bytes(const cpm_opencl *o, const cpm_map_tree *tree) {
    array arrays[CPM_MAP_BUFFERS - 1];
    uint64_t sum = 0;
    if (!tree->count || o->is_cpu) return sizeof(cpm_map_numbers);
    arrays_of(tree, arrays);
    for (int i = 0; i < CPM_MAP_BUFFERS - 1; i++) sum += arrays[i].size;
    return sum + sizeof(cpm_map_numbers);
}

int cpm_opencl_map_fits(const cpm_opencl *o, const cpm_map_tree *tree, uint64_t allowed) {
    array arrays[CPM_MAP_BUFFERS - 1];
    if (!tree->count) return 1;
    arrays_of(tree, arrays);
    for (int i = 0; i < CPM_MAP_BUFFERS - 1; i++)
        if (arrays[i].size > o->largest) return 0;
    return cpm_opencl_map_bytes(o, tree) <= allowed;
}

cl_int cpm_opencl_map_open(const cpm_opencl *o, const cpm_map_tree *tree, cpm_opencl_map *map) {
    const cpm_map_numbers is = cpm_tree_view(tree).is;
    array arrays[CPM_MAP_BUFFERS - 1] = {{NULL, 0}};
    cl_int code = CL_SUCCESS;
    memset(map, 0, sizeof *map);
    if (tree->count) arrays_of(tree, arrays);
    for (int i = 0; i < CPM_MAP_BUFFERS - 1 && code == CL_SUCCESS; i++)
        if (o->is_cpu && arrays[i].size) /* it may read ours */
            map->buffers[i] = o->cl->CreateBuffer(o->context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, arrays[i].size,
                                                  (void *)(uintptr_t)arrays[i].from, &code);
        else
            map->buffers[i] = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, arrays[i].size, arrays[i].from, &code);
    if (code == CL_SUCCESS) map->buffers[4] = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, sizeof is, &is, &code);
    if (code != CL_SUCCESS) cpm_opencl_map_close(o, map);
    return code;
}

static void release(const cpm_opencl *o, cl_mem *buffers, int count) {
    for (int i = 0; i < count; i++)
        if (buffers[i]) o->cl->ReleaseMemObject(buffers[i]);
}

void cpm_opencl_map_close(const cpm_opencl *o, cpm_opencl_map *map) {
    release(o, map->buffers, CPM_MAP_BUFFERS);
    memset(map, 0, sizeof *map);
}

cpm_status cpm_opencl_scratch_open(cpm_context *context, const cpm_map_tree *const trees[CPM_POPULATIONS], int32_t k,
                                   size_t items, uint64_t allowed, cpm_opencl_scratch *scratch) {
    const cpm_opencl *o = context->opencl;
    size_t count = 0, depth = 0, bins = 0;
    for (int t = 0; t < CPM_POPULATIONS; t++) {
        if (!trees[t]) continue;
        count = trees[t]->count > count ? trees[t]->count : count;
        depth = (size_t)trees[t]->depth > depth ? (size_t)trees[t]->depth : depth;
        bins = trees[t]->bins > bins ? trees[t]->bins : bins;
    }
    memset(scratch, 0, sizeof *scratch);
    scratch->capacity = CPM_MAP_CAPACITY((size_t)k, count);
    const size_t capacity = (size_t)scratch->capacity;
    const size_t each[CPM_SCRATCH_BUFFERS] = {4 * (capacity + CPM_PAD), 4 * (capacity + CPM_PAD), 8 * capacity,
                                              8 * (depth + 1), 8 * (bins + CPM_PAD)};
    size_t all = 0, largest = 0;
    for (int i = 0; i < CPM_SCRATCH_BUFFERS; i++) {
        all += each[i];
        largest = each[i] > largest ? each[i] : largest;
    }
    if (items > allowed / all) items = (size_t)(allowed / all);
    if (items > o->largest / largest) items = (size_t)(o->largest / largest);
    if (!items)
        return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY,
                        "nearest is %d: one search takes %.3f MB of OpenCL device '%s', of which %.3f MB are left; ask "
                        "for fewer, allow more memory, or use the native backend",
                        (int)k, 1e-6 * (double)all, o->name, 1e-6 * (double)allowed);
    scratch->items = items;
    cl_int code = CL_SUCCESS;
    for (int i = 0; i < CPM_SCRATCH_BUFFERS && code == CL_SUCCESS; i++)
        scratch->buffers[i] = cpm_opencl_buffer(o, CL_MEM_READ_WRITE, items * each[i], NULL, &code);
    if (code == CL_SUCCESS) return CPM_OK;
    cpm_opencl_scratch_close(o, scratch);
    return cpm_opencl_failed(context, o, "making room to search the photon map", code);
}

void cpm_opencl_scratch_close(const cpm_opencl *o, cpm_opencl_scratch *scratch) {
    release(o, scratch->buffers, CPM_SCRATCH_BUFFERS);
    memset(scratch, 0, sizeof *scratch);
}

void cpm_opencl_give(cpm_opencl_arguments *a, size_t size, const void *value) {
    if (a->code == CL_SUCCESS) a->code = a->opencl->cl->SetKernelArg(a->kernel, a->next++, size, value);
}

void cpm_opencl_give_buffers(cpm_opencl_arguments *a, const cl_mem *buffers, int count) {
    for (int i = 0; i < count; i++) cpm_opencl_give(a, sizeof(cl_mem), &buffers[i]);
}
#endif
