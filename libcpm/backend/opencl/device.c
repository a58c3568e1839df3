/* backend/opencl/device.c: which devices there are, and opening one. */
#include "device.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cpm/device.h"

/* The fields that the caller knows. */
static void give(void *theirs, size_t size, void *ours, size_t whole) {
    if (size > whole) size = whole;
    memcpy(ours, &size, sizeof size); /* struct_size comes first in every struct */
    memcpy(theirs, ours, size);
}

cpm_status cpm_context_set_device(cpm_context *context, const cpm_device_options *options) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_device_options o = {.struct_size = sizeof o};
    if (options) CPM_TAKE(o, options);
    cpm_opencl_close(context);
    const cpm_status status = options ? cpm_opencl_open(context, o.device, o.opencl_context, o.opencl_queue) : CPM_OK;
    if (options && !status) cpm_opencl_allow(context, o.memory);
    return status;
}

#ifdef CPM_OPENCL_HEADERS_VERSION
#include "program.h"

#define MAX_PLATFORMS 32
#define MAX_DEVICES 64
#define MEMORY_SHARE 4 /* part of a device's memory that is used where nothing is said */

/* Every device of every platform; a platform that fails has none. */
static size_t all_devices(const cpm_cl_functions *cl, cl_device_id devices[MAX_DEVICES]) {
    cl_platform_id platforms[MAX_PLATFORMS];
    cl_uint platform_count = 0;
    size_t count = 0;
    if (!cl || cl->GetPlatformIDs(MAX_PLATFORMS, platforms, &platform_count) != CL_SUCCESS) return 0;
    if (platform_count > MAX_PLATFORMS) platform_count = MAX_PLATFORMS;
    for (cl_uint p = 0; p < platform_count; p++) {
        cl_uint found = 0, room = (cl_uint)(MAX_DEVICES - count);
        if (!room || cl->GetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, room, devices + count, &found) != CL_SUCCESS)
            continue;
        count += found < room ? found : room;
    }
    return count;
}

static void text_of(const cpm_cl_functions *cl, cl_device_id device, cl_device_info what, char *out, size_t size) {
    char text[512] = "";
    if (cl->GetDeviceInfo(device, what, sizeof text, text, NULL) != CL_SUCCESS) text[0] = '\0';
    text[sizeof text - 1] = '\0';
    snprintf(out, size, "%.*s", (int)size - 1, text);
}

static void describe(const cpm_cl_functions *cl, cl_device_id device, cpm_device_info *info) {
    cl_platform_id platform = NULL;
    cl_uint units = 0;
    cl_device_type type = 0;
    cl_ulong memory = 0;
    cl_device_fp_config doubles = 0;
    text_of(cl, device, CL_DEVICE_NAME, info->name, sizeof info->name);
    text_of(cl, device, CL_DEVICE_VERSION, info->version, sizeof info->version);
    cl->GetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
    if (platform) cl->GetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof info->platform, info->platform, NULL);
    info->platform[sizeof info->platform - 1] = '\0';
    cl->GetDeviceInfo(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    cl->GetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    cl->GetDeviceInfo(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory, NULL);
    if (cl->GetDeviceInfo(device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, NULL) != CL_SUCCESS)
        doubles = 0;
    info->units = (int32_t)units;
    info->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    info->double_precision = doubles != 0;
    info->memory = memory;
}

cpm_status cpm_opencl_failed(cpm_context *context, const cpm_opencl *opencl, const char *doing, cl_int code) {
    const int memory =
        code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_RESOURCES || code == CL_OUT_OF_HOST_MEMORY;
    return cpm_fail(context, memory ? CPM_ERROR_OUT_OF_MEMORY : CPM_ERROR_BACKEND,
                    "OpenCL device '%s': %s failed with %s (%d); %s", opencl->name, doing, cpm_cl_error(code),
                    (int)code,
                    memory ? "ask for fewer rays at a time, or use another device or the native backend"
                           : "open a new context, or use another device or the native backend");
}

cl_mem cpm_opencl_buffer(const cpm_opencl *o, cl_mem_flags flags, size_t size, const void *contents, cl_int *code) {
    static const double nothing = 0.0;
    const void *from = size ? contents : contents ? &nothing : NULL;
    cl_mem buffer = o->cl->CreateBuffer(o->context, flags | (from ? CL_MEM_COPY_HOST_PTR : 0),
                                        size ? size : sizeof nothing, (void *)(uintptr_t)from, code);
    return *code == CL_SUCCESS ? buffer : NULL;
}

uint64_t cpm_opencl_budget(const cpm_opencl *o) { return o->budget ? o->budget : o->memory / MEMORY_SHARE; }

void cpm_opencl_allow(cpm_context *context, uint64_t bytes) { ((cpm_opencl *)context->opencl)->budget = bytes; }

void cpm_opencl_lock(cpm_opencl *o) {
    while (atomic_flag_test_and_set_explicit(&o->lock, memory_order_acquire)) sched_yield(); /* a pass may take long */
}

void cpm_opencl_unlock(cpm_opencl *o) { atomic_flag_clear_explicit(&o->lock, memory_order_release); }

static cpm_status open_queue(cpm_context *context, cpm_opencl *o, void *caller_context, void *caller_queue) {
    cl_int code = CL_SUCCESS;
    if (caller_queue) {
        cl_context theirs = NULL;
        o->queue = caller_queue;
        code = o->cl->GetCommandQueueInfo(o->queue, CL_QUEUE_DEVICE, sizeof o->device, &o->device, NULL);
        if (code == CL_SUCCESS)
            code = o->cl->GetCommandQueueInfo(o->queue, CL_QUEUE_CONTEXT, sizeof theirs, &theirs, NULL);
        if (code == CL_SUCCESS && caller_context && theirs != (cl_context)caller_context) {
            o->queue = NULL;
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "opencl_queue belongs to another OpenCL context than opencl_context");
        }
        o->context = theirs;
        if (code == CL_SUCCESS)
            o->cl->RetainContext(o->context), o->cl->RetainCommandQueue(o->queue);
        else
            o->queue = NULL, o->context = NULL;
        return code == CL_SUCCESS ? CPM_OK : cpm_opencl_failed(context, o, "asking the caller's queue", code);
    }
    if (caller_context) {
        o->context = caller_context;
        o->cl->RetainContext(o->context);
    } else {
        o->context = o->cl->CreateContext(NULL, 1, &o->device, NULL, NULL, &code);
        if (code != CL_SUCCESS) {
            o->context = NULL;
            return cpm_opencl_failed(context, o, "making a context", code);
        }
    }
    o->queue = o->cl->CreateCommandQueue(o->context, o->device, 0, &code);
    if (code == CL_SUCCESS) return CPM_OK;
    o->queue = NULL;
    return cpm_opencl_failed(context, o, "making a queue", code);
}

cpm_status cpm_opencl_open(cpm_context *context, int32_t device, void *caller_context, void *caller_queue) {
    const cpm_cl_functions *cl = cpm_cl();
    cl_device_id devices[MAX_DEVICES];
    const size_t count = all_devices(cl, devices);
    if (!count)
        return cpm_fail(context, CPM_ERROR_BACKEND,
                        "no OpenCL %s was found; install one (pocl-opencl-icd), or use the "
                        "native backend",
                        cl ? "device" : "loader (libOpenCL.so.1)");
    if (device < 0 || (size_t)device >= count)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "device is %d; must be 0 to %zu", (int)device, count - 1);
    cpm_opencl *o = calloc(1, sizeof *o);
    if (!o) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an OpenCL device");
    o->cl = cl;
    o->device = devices[device];
    atomic_flag_clear(&o->lock);
    context->opencl = o;
    cpm_status status = open_queue(context, o, caller_context, caller_queue);
    if (status == CPM_OK) {
        cpm_device_info info = {.struct_size = sizeof info};
        cl_ulong largest = 0;
        describe(cl, o->device, &info);
        cl->GetDeviceInfo(o->device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof largest, &largest, NULL);
        memcpy(o->name, info.name, sizeof o->name), memcpy(o->version, info.version, sizeof o->version);
        text_of(cl, o->device, CL_DRIVER_VERSION, o->driver, sizeof o->driver);
        o->units = info.units > 0 ? info.units : 1, o->is_cpu = info.is_cpu;
        o->memory = info.memory, o->largest = largest;
        if (!info.double_precision)
            status = cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                              "OpenCL device '%s' has no double precision, which rays need; use another device or the "
                              "native backend",
                              o->name);
    }
    if (status != CPM_OK) cpm_opencl_close(context);
    return status;
}

void cpm_opencl_close(cpm_context *context) {
    cpm_opencl *o = context->opencl;
    if (!o) return;
    cpm_programs_free(o);
    if (o->queue) o->cl->ReleaseCommandQueue(o->queue);
    if (o->context) o->cl->ReleaseContext(o->context);
    free(o);
    context->opencl = NULL;
}

cpm_status cpm_device_count(cpm_context *context, size_t *count) {
    cl_device_id devices[MAX_DEVICES];
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!count) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is NULL");
    *count = all_devices(cpm_cl(), devices);
    return CPM_OK;
}

cpm_status cpm_device_describe(cpm_context *context, size_t index, cpm_device_info *info) {
    cl_device_id devices[MAX_DEVICES];
    cpm_device_info ours = {.struct_size = sizeof ours};
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!info) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "info is NULL");
    const size_t count = all_devices(cpm_cl(), devices);
    if (index >= count)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "index is %zu; there are %zu devices", index, count);
    describe(cpm_cl(), devices[index], &ours);
    give(info, info->struct_size, &ours, sizeof ours);
    return CPM_OK;
}

cpm_status cpm_context_device_stats(cpm_context *context, cpm_device_stats *stats) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!stats) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "stats is NULL");
    cpm_device_stats ours = {.struct_size = sizeof ours};
    if (context->opencl) ours = ((const cpm_opencl *)context->opencl)->stats;
    give(stats, stats->struct_size, &ours, sizeof ours);
    return CPM_OK;
}

#else /* ------------------------------------------------------------------------------ built without OpenCL's headers \
       */

cpm_status cpm_opencl_open(cpm_context *context, int32_t device, void *caller_context, void *caller_queue) {
    (void)device, (void)caller_context, (void)caller_queue;
    return cpm_fail(context, CPM_ERROR_UNSUPPORTED, "this library was built without OpenCL; use the native backend");
}

void cpm_opencl_close(cpm_context *context) { (void)context; }

void cpm_opencl_allow(cpm_context *context, uint64_t bytes) { (void)context, (void)bytes; }

cpm_status cpm_device_count(cpm_context *context, size_t *count) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!count) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is NULL");
    *count = 0;
    return CPM_OK;
}

cpm_status cpm_device_describe(cpm_context *context, size_t index, cpm_device_info *info) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!info) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "info is NULL");
    return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "index is %zu; there are 0 devices", index);
}

cpm_status cpm_context_device_stats(cpm_context *context, cpm_device_stats *stats) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!stats) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "stats is NULL");
    cpm_device_stats ours = {.struct_size = sizeof ours};
    give(stats, stats->struct_size, &ours, sizeof ours);
    return CPM_OK;
}
#endif
