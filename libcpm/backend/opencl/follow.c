/* backend/opencl/follow.c: see follow.h. */
#include "follow.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/types/lanes.h"
#include "medium/method.h"
#include "program.h"

#define LANES 8
#define FAR_STEP 1e300 /* CPM_INFINITE of double lanes */

static cpm_status kernel_of(cpm_context *context, const char *name, const char *function, int width, const char *more,
                            cl_kernel *kernel) {
    char options[256];
    cpm_opencl_options(context->opencl, width, more, options, sizeof options);
    return cpm_program_kernel(context, name, function, options, kernel);
}

/* As the host's lanes are controlled (backend/native/dispatch.c); what follows from it the kernel adds. */
static cpm_step_control control_of(const cpm_pass *pass, int32_t method) {
    const cpm_scene_options *o = &pass->options;
    return (cpm_step_control){.method = method,
                              .rtol = cpm_method_rtol(method, o->rtol),
                              .dense = 1,
                              .atol = o->atol,
                              .step = o->step,
                              .max_step = o->max_step > 0.0 ? o->max_step : FAR_STEP,
                              .max_evaluations = 1e6};
}

static cpm_status way_of(const cpm_pass *pass, size_t m, cpm_opencl_way *way) {
    cpm_context *context = pass->context;
    const cpm_opencl *o = context->opencl;
    const cpm_medium *medium = pass->scene->media[m].medium;
    const unsigned kinds = (unsigned)cpm_medium_kinds(medium);
    char more[64];
    way->medium = (cl_int)m;
    if (pass->way[m] == CPM_WAY_EXACT) {
        snprintf(more, sizeof more, "-DCPM_MEDIA=%u", kinds);
        if (medium->data.kind == CPM_MEDIUM_LINEAR_SQUARED)
            return kernel_of(context, "follow_parabolas", "cpm_follow_parabolas", LANES, more, &way->kernel);
        return kernel_of(context, "follow_exact", "cpm_follow_exact", 1, more, &way->kernel);
    }
    const cpm_step_control control = control_of(pass, pass->method[m]);
    cl_int code = CL_SUCCESS;
    way->control = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, sizeof control, &control, &code);
    if (code != CL_SUCCESS) return cpm_opencl_failed(context, o, "making a buffer", code);
    snprintf(more, sizeof more, "-DCPM_MEDIA=%u -DCPM_METHODS=%u", kinds, 1u << pass->method[m]);
    return kernel_of(context, "follow_integrated", "cpm_follow_integrated", LANES, more, &way->kernel);
}

cpm_status cpm_opencl_follow_open(const cpm_opencl_world *world, cpm_opencl_follow_plan *plan) {
    const cpm_pass *pass = world->pass;
    cpm_context *context = pass->context;
    const size_t media = pass->scene->medium_count;
    int straight = 0;
    cpm_status status = CPM_OK;
    memset(plan, 0, sizeof *plan);
    plan->world = world;
    plan->ways = calloc(media + 1, sizeof *plan->ways);
    if (!plan->ways) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the ways of %zu media", media);
    for (size_t m = 0; m < media; m++) straight |= pass->way[m] == CPM_WAY_STRAIGHT;
    if (straight) {
        plan->ways[0].medium = -1;
        status = kernel_of(context, "follow_straight", "cpm_follow_straight", 1, "", &plan->ways[0].kernel);
        plan->way_count = 1;
    }
    for (size_t m = 0; m < media && !status; m++)
        if (pass->way[m] != CPM_WAY_STRAIGHT) status = way_of(pass, m, &plan->ways[plan->way_count++]);
    if (!status && (pass->features & CPM_FEATURE_BOUNDARIES))
        status = kernel_of(context, "behind", "cpm_behind", 1, "", &plan->behind);
    if (status) cpm_opencl_follow_close(plan);
    return status;
}

void cpm_opencl_follow_close(cpm_opencl_follow_plan *plan) {
    const cpm_opencl *o = plan->world ? plan->world->pass->context->opencl : NULL;
    for (size_t i = 0; i < plan->way_count; i++)
        if (plan->ways[i].control) o->cl->ReleaseMemObject(plan->ways[i].control);
    free(plan->ways);
    memset(plan, 0, sizeof *plan);
}

static cl_int start(const cpm_opencl_follow_plan *plan, cl_kernel kernel, const cpm_opencl_way *way, cl_mem flights,
                    cl_mem arrivals, cl_mem counts, size_t items, cl_int share) {
    const cpm_opencl *o = plan->world->pass->context->opencl;
    cl_uint next = CPM_WORLD_BUFFERS;
    cl_int code = cpm_opencl_world_give(plan->world, kernel);
    if (code == CL_SUCCESS) code = o->cl->SetKernelArg(kernel, next++, sizeof flights, &flights);
    if (code == CL_SUCCESS) code = o->cl->SetKernelArg(kernel, next++, sizeof arrivals, &arrivals);
    if (code == CL_SUCCESS) code = o->cl->SetKernelArg(kernel, next++, sizeof counts, &counts);
    if (code == CL_SUCCESS) code = o->cl->SetKernelArg(kernel, next++, sizeof share, &share);
    if (code == CL_SUCCESS && way && way->medium >= 0)
        code = o->cl->SetKernelArg(kernel, next++, sizeof way->medium, &way->medium);
    if (code == CL_SUCCESS && way && way->control)
        code = o->cl->SetKernelArg(kernel, next++, sizeof way->control, &way->control);
    return code == CL_SUCCESS ? cpm_opencl_run(o, kernel, items) : code;
}

cl_int cpm_opencl_follow(const cpm_opencl_follow_plan *plan, cl_mem flights, cl_mem arrivals, cl_mem counts,
                         size_t items, cl_int share) {
    cl_int code = CL_SUCCESS;
    for (size_t i = 0; i < plan->way_count && code == CL_SUCCESS; i++)
        code = start(plan, plan->ways[i].kernel, &plan->ways[i], flights, arrivals, counts, items, share);
    if (code == CL_SUCCESS && plan->behind)
        code = start(plan, plan->behind, NULL, flights, arrivals, counts, items, share);
    return code;
}

/* ------------------------------------------------------------------------------------------- the host's flights */

#define SLICE 65536 /* flights on the device at a time */

static cl_int follow_slice(const cpm_opencl_follow_plan *plan, const cpm_flight *flights, size_t count, size_t items,
                           cpm_arrival *arrivals) {
    const cpm_opencl *o = plan->world->pass->context->opencl;
    const size_t share = (count + items - 1) / items;
    cl_int code = CL_SUCCESS, other = CL_SUCCESS, *counts = calloc(items, sizeof *counts);
    if (!counts) return CL_OUT_OF_HOST_MEMORY;
    for (size_t i = 0; i < items; i++) {
        const size_t left = i * share < count ? count - i * share : 0;
        counts[i] = (cl_int)(left < share ? left : share);
    }
    cl_mem buffers[3];
    buffers[0] = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, count * sizeof *flights, flights, &code);
    buffers[1] = cpm_opencl_buffer(o, CL_MEM_READ_WRITE, count * sizeof *arrivals, NULL, &other);
    if (code == CL_SUCCESS) code = other;
    buffers[2] = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, items * sizeof *counts, counts, &other);
    if (code == CL_SUCCESS) code = other;
    if (code == CL_SUCCESS) code = cpm_opencl_follow(plan, buffers[0], buffers[1], buffers[2], items, (cl_int)share);
    if (code == CL_SUCCESS)
        code = o->cl->EnqueueReadBuffer(o->queue, buffers[1], CL_TRUE, 0, count * sizeof *arrivals, arrivals, 0, NULL,
                                        NULL);
    o->cl->Finish(o->queue);
    for (int i = 0; i < 3; i++)
        if (buffers[i]) o->cl->ReleaseMemObject(buffers[i]);
    free(counts);
    return code;
}

cpm_status cpm_opencl_follow_all(const cpm_pass *pass, const cpm_flight *flights, size_t count, cpm_arrival *arrivals) {
    cpm_context *context = pass->context;
    cpm_opencl *o = context->opencl;
    cpm_opencl_world world = {0};
    cpm_opencl_follow_plan plan = {0};
    cpm_opencl_lock(o);
    cpm_status status = cpm_opencl_world_open(pass, &world);
    if (!status) status = cpm_opencl_follow_open(&world, &plan);
    for (size_t i = 0; i < count && !status; i += SLICE) {
        const size_t now = count - i < SLICE ? count - i : SLICE;
        const size_t most = o->is_cpu ? (size_t)o->units * CPM_ITEMS_A_UNIT : now;
        const cl_int code = follow_slice(&plan, flights + i, now, now < most ? now : most, arrivals + i);
        if (code != CL_SUCCESS) status = cpm_opencl_failed(context, o, "following rays", code);
    }
    cpm_opencl_follow_close(&plan);
    cpm_opencl_world_close(&world);
    cpm_opencl_unlock(o);
    return status;
}

#else
cpm_status cpm_opencl_follow_all(const cpm_pass *pass, const cpm_flight *flights, size_t count, cpm_arrival *arrivals) {
    (void)flights, (void)count, (void)arrivals;
    return cpm_fail(pass->context, CPM_ERROR_UNSUPPORTED,
                    "this library was built without OpenCL; use the native backend");
}
#endif
