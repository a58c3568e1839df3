/* backend/opencl/device.h: one device, its queue and its programs, as a cpm_context holds it. */
#ifndef CPM_OPENCL_DEVICE_H
#define CPM_OPENCL_DEVICE_H
#include "api/context.h"
#include "cpm/device.h"
#include "loader.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
typedef struct cpm_program cpm_program; /* program.h */

typedef struct cpm_opencl {
    const cpm_cl_functions *cl;
    cl_device_id device;
    cl_context context;
    cl_command_queue queue; /* in order */
    char name[128], driver[64], version[64];
    int32_t units, is_cpu;
    uint64_t memory, largest; /* bytes: all, and of one buffer */
    uint64_t budget;          /* bytes that the caller allows; 0: not said */
    cpm_program *programs;    /* built so far */
    cpm_device_stats stats;
    atomic_flag lock; /* guards programs and the queue: one call at a time */
} cpm_opencl;

/* A buffer with the contents, if any; NULL with `code` set where it cannot be had. Sizes of 0 are made 8. */
cl_mem cpm_opencl_buffer(const cpm_opencl *opencl, cl_mem_flags flags, size_t size, const void *contents, cl_int *code);
/* Bytes that may be used. */
uint64_t cpm_opencl_budget(const cpm_opencl *opencl);
void cpm_opencl_lock(cpm_opencl *opencl);
void cpm_opencl_unlock(cpm_opencl *opencl);

/* Fails with a message of the context: what OpenCL said, and what may be done. */
cpm_status cpm_opencl_failed(cpm_context *context, const cpm_opencl *opencl, const char *doing, cl_int code);
#endif

/* Called by cpm_context_set_device and cpm_context_release. Where the library was built without OpenCL, opening fails.
 */
cpm_status cpm_opencl_open(cpm_context *context, int32_t device, void *caller_context, void *caller_queue);
void cpm_opencl_close(cpm_context *context);
/* Bytes that the open device may be used for; 0: chosen. */
void cpm_opencl_allow(cpm_context *context, uint64_t bytes);
#endif
