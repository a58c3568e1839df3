/* backend/opencl/trace.c: rays alone in a medium: buffers, slices that fit the device, the kernel of kernels/trace.cl.
 */
#include "trace.h"

#include "device.h"
#include "program.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <string.h>

#define SLICE 262144    /* rays between two looks at the progress callback */
#define ITEMS_A_UNIT 16 /* work-items: enough to share out, few enough to fill their lanes */

enum { MEDIUM, TABLE, CONTROL, GOAL, STARTS, ENDS, POSITIONS, BUFFERS };

typedef struct slice_buffers {
    cl_mem buffer[BUFFERS];
} slice_buffers;

static void release(const cpm_opencl *o, slice_buffers *b) {
    for (int i = 0; i < BUFFERS; i++)
        if (b->buffer[i]) o->cl->ReleaseMemObject(b->buffer[i]);
}

static cl_int buffer(const cpm_opencl *o, slice_buffers *b, int which, cl_mem_flags flags, size_t size,
                     const void *contents) {
    cl_int code = CL_SUCCESS;
    b->buffer[which] = cpm_opencl_buffer(o, flags, size, contents, &code);
    return code;
}

/* Rays at a time: a share of the memory, and of the largest buffer there may be. */
static int64_t slice_of(const cpm_opencl *o, int64_t samples, int64_t count) {
    const uint64_t ray = sizeof(cpm_ray_start) + sizeof(cpm_ray_end), path = 24 * (uint64_t)samples;
    const uint64_t each = ray + path, most = path > sizeof(cpm_ray_end) ? path : sizeof(cpm_ray_end);
    uint64_t fit = cpm_opencl_budget(o) / each, largest = o->largest / most;
    if (fit > largest) fit = largest;
    if (fit > SLICE) fit = SLICE;
    if (fit > (uint64_t)count) fit = (uint64_t)count;
    return fit ? (int64_t)fit : 1;
}

/* One packet a ray on a processor, as wide as its registers may be; single rays elsewhere: there lanes are threads. */
static void options_of(const cpm_opencl *o, const cpm_medium *medium, int32_t method, int single, char *options,
                       size_t size) {
    snprintf(options, size,
             "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -DCPM_WIDTH=%d -DCPM_SINGLE=%d "
             "-DCPM_MEDIA=%u -DCPM_METHODS=%u",
             o->is_cpu ? 8 : 1, single != 0, (unsigned)cpm_medium_kinds(medium), 1u << method);
}

static cl_int set_arguments(const cpm_opencl *o, cl_kernel kernel, const slice_buffers *b, int64_t samples,
                            int64_t count, int64_t share) {
    const cl_long numbers[3] = {samples, count, share};
    cl_int code = CL_SUCCESS;
    for (cl_uint i = 0; i < BUFFERS && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, i, sizeof(cl_mem), &b->buffer[i]);
    for (cl_uint i = 0; i < 3 && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, BUFFERS + i, sizeof(cl_long), &numbers[i]);
    return code;
}

static cpm_status slices(cpm_context *context, cl_kernel kernel, slice_buffers *b, const cpm_ray_start *starts,
                         cpm_ray_end *ends, double *positions, int64_t samples, int64_t count, int64_t slice,
                         double from, double to) {
    const cpm_opencl *o = context->opencl;
    for (int64_t first = 0; first < count; first += slice) {
        const int64_t now = count - first < slice ? count - first : slice, items = (int64_t)o->units * ITEMS_A_UNIT;
        const int64_t share = ((now + items - 1) / items + 7) / 8 * 8;
        const size_t global = (size_t)((now + share - 1) / share);
        const size_t path = (size_t)samples * 3 * sizeof(double);
        cl_int code = o->cl->EnqueueWriteBuffer(o->queue, b->buffer[STARTS], CL_FALSE, 0, (size_t)now * sizeof *starts,
                                                starts + first, 0, NULL, NULL);
        if (code == CL_SUCCESS && samples) /* a second run: it reads where the first ended */
            code = o->cl->EnqueueWriteBuffer(o->queue, b->buffer[ENDS], CL_FALSE, 0, (size_t)now * sizeof *ends,
                                             ends + first, 0, NULL, NULL);
        if (code == CL_SUCCESS) code = set_arguments(o, kernel, b, samples, now, share);
        if (code == CL_SUCCESS)
            code = o->cl->EnqueueNDRangeKernel(o->queue, kernel, 1, NULL, &global, NULL, 0, NULL, NULL);
        if (code == CL_SUCCESS)
            code = o->cl->EnqueueReadBuffer(o->queue, b->buffer[ENDS], CL_TRUE, 0, (size_t)now * sizeof *ends,
                                            ends + first, 0, NULL, NULL);
        if (code == CL_SUCCESS && samples)
            code = o->cl->EnqueueReadBuffer(o->queue, b->buffer[POSITIONS], CL_TRUE, 0, (size_t)now * path,
                                            positions + 3 * samples * first, 0, NULL, NULL);
        if (code != CL_SUCCESS) {
            o->cl->Finish(o->queue);
            return cpm_opencl_failed(context, o, "tracing rays", code);
        }
        if (cpm_progress(context, "trace", from + (to - from) * (double)(first + now) / (double)count))
            return cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing rays");
    }
    return CPM_OK;
}

cpm_status cpm_opencl_trace(cpm_context *context, const cpm_medium *medium, const cpm_step_control *control,
                            const cpm_ray_goal *goal, int single_precision, const cpm_ray_start *starts,
                            cpm_ray_end *ends, double *positions, int64_t samples, int64_t count, double from,
                            double to) {
    cpm_opencl *o = context->opencl;
    char options[256];
    cl_kernel kernel = NULL;
    slice_buffers b = {{0}};
    const int64_t slice = slice_of(o, samples, count);
    options_of(o, medium, control->method, single_precision, options, sizeof options);
    cpm_opencl_lock(o);
    cpm_status status = cpm_program_kernel(context, "trace", "cpm_trace", options, &kernel);
    if (status == CPM_OK) {
        const size_t rays = (size_t)slice, path = (size_t)samples * 3 * sizeof(double);
        cl_int code = buffer(o, &b, MEDIUM, CL_MEM_READ_ONLY, sizeof medium->data, &medium->data);
        if (code == CL_SUCCESS)
            code = buffer(o, &b, TABLE, CL_MEM_READ_ONLY, medium->table_count * sizeof(double), medium->table);
        if (code == CL_SUCCESS) code = buffer(o, &b, CONTROL, CL_MEM_READ_ONLY, sizeof *control, control);
        if (code == CL_SUCCESS) code = buffer(o, &b, GOAL, CL_MEM_READ_ONLY, sizeof *goal, goal);
        if (code == CL_SUCCESS) code = buffer(o, &b, STARTS, CL_MEM_READ_ONLY, rays * sizeof *starts, NULL);
        if (code == CL_SUCCESS) code = buffer(o, &b, ENDS, CL_MEM_READ_WRITE, rays * sizeof *ends, NULL);
        if (code == CL_SUCCESS) code = buffer(o, &b, POSITIONS, CL_MEM_READ_WRITE, rays * path, NULL);
        status = code == CL_SUCCESS
                     ? slices(context, kernel, &b, starts, ends, positions, samples, count, slice, from, to)
                     : cpm_opencl_failed(context, o, "making buffers", code);
        release(o, &b);
    }
    cpm_opencl_unlock(o);
    return status;
}
#else
cpm_status cpm_opencl_trace(cpm_context *context, const cpm_medium *medium, const cpm_step_control *control,
                            const cpm_ray_goal *goal, int single_precision, const cpm_ray_start *starts,
                            cpm_ray_end *ends, double *positions, int64_t samples, int64_t count, double from,
                            double to) {
    (void)medium, (void)control, (void)goal, (void)single_precision, (void)starts, (void)ends, (void)positions;
    (void)samples, (void)count, (void)from, (void)to;
    return cpm_fail(context, CPM_ERROR_UNSUPPORTED, "this library was built without OpenCL; use the native backend");
}
#endif
