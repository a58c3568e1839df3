/* backend/opencl/hits.c: the tree on a device: uploaded, walked by kernels/hits.cl. */
#include "hits.h"

#include "device.h"
#include "geometry/parts.h"
#include "program.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#define ITEMS_A_UNIT 64

enum { NODES, TRIANGLES, SPHERES, FRAME, CURVES, LEFT, HITS, BUFFERS };

static cl_int upload(const cpm_opencl *o, const cpm_geometry *g, const cpm_curve *curves, const int32_t *left,
                     size_t count, cl_mem buffers[BUFFERS]) {
    const struct {
        const void *from;
        size_t size;
    } what[BUFFERS] = {{g->tree.nodes, g->node_count * sizeof(cpm_tree_node)},
                       {g->tree.triangles, g->triangle_count * sizeof(cpm_triangle)},
                       {g->tree.spheres, g->sphere_count * sizeof(cpm_sphere)},
                       {&g->tree.frame, sizeof g->tree.frame},
                       {curves, count * sizeof *curves},
                       {left, count * sizeof *left},
                       {NULL, count * sizeof(cpm_hit)}};
    cl_int code = CL_SUCCESS;
    for (int i = 0; i < BUFFERS && code == CL_SUCCESS; i++)
        buffers[i] =
            cpm_opencl_buffer(o, i == HITS ? CL_MEM_WRITE_ONLY : CL_MEM_READ_ONLY, what[i].size, what[i].from, &code);
    return code;
}

static cl_int ask(const cpm_opencl *o, cl_kernel kernel, const cl_mem buffers[BUFFERS], size_t count, double theta_end,
                  cpm_hit *hits) {
    cl_int code = CL_SUCCESS;
    for (cl_uint i = 0; i < BUFFERS && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, i, sizeof(cl_mem), &buffers[i]);
    /* One item a group on a processor: a group's items share one stack there, and each has a tree's walk on it. */
    const size_t items = (size_t)o->units * ITEMS_A_UNIT, share = (count + items - 1) / items, one = 1;
    const size_t global = (count + share - 1) / share;
    const cl_long numbers[2] = {(cl_long)count, (cl_long)share};
    if (code == CL_SUCCESS) code = o->cl->SetKernelArg(kernel, BUFFERS, sizeof theta_end, &theta_end);
    for (cl_uint i = 0; i < 2 && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, BUFFERS + 1 + i, sizeof(cl_long), &numbers[i]);
    if (code == CL_SUCCESS)
        code = o->cl->EnqueueNDRangeKernel(o->queue, kernel, 1, NULL, &global, o->is_cpu ? &one : NULL, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        code = o->cl->EnqueueReadBuffer(o->queue, buffers[HITS], CL_TRUE, 0, count * sizeof *hits, hits, 0, NULL, NULL);
    if (code != CL_SUCCESS) o->cl->Finish(o->queue);
    return code;
}

cpm_status cpm_opencl_hits(cpm_context *context, const cpm_geometry *geometry, const cpm_curve *curves,
                           const int32_t *left, size_t count, double theta_end, cpm_hit *hits) {
    cpm_opencl *o = context->opencl;
    cl_kernel kernel = NULL;
    cl_mem buffers[BUFFERS] = {0};
    for (size_t i = 0; i < count; i++) hits[i].primitive = -1;
    if (!count || !geometry->tree.nodes) return CPM_OK;
    cpm_opencl_lock(o);
    cpm_status status = cpm_program_kernel(context, "hits", "cpm_hits", "-cl-std=CL1.2", &kernel);
    if (status == CPM_OK) {
        cl_int code = upload(o, geometry, curves, left, count, buffers);
        if (code == CL_SUCCESS) code = ask(o, kernel, buffers, count, theta_end, hits);
        if (code != CL_SUCCESS) status = cpm_opencl_failed(context, o, "looking for hits", code);
        for (int i = 0; i < BUFFERS; i++)
            if (buffers[i]) o->cl->ReleaseMemObject(buffers[i]);
    }
    cpm_opencl_unlock(o);
    return status;
}
#endif
