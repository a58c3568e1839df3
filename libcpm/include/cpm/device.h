/* cpm/device.h: what the library can compute on besides the processor's own threads: OpenCL devices.
 *
 * The OpenCL loader is looked for when first asked for; without one there are simply no devices. */
#ifndef CPM_DEVICE_H
#define CPM_DEVICE_H
#include "context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cpm_device_info {
    size_t struct_size;
    char name[128];
    char platform[128];
    char version[64]; /* "OpenCL 1.2 ...", as the device says it */
    int32_t units;    /* compute units */
    int32_t is_cpu;
    int32_t double_precision; /* 0: this library refuses the device: its rays carry doubles in either precision */
    int32_t reserved;
    uint64_t memory; /* bytes */
} cpm_device_info;

/* Devices of all platforms, in the loader's order; 0 without OpenCL. */
CPM_API cpm_status cpm_device_count(cpm_context *context, size_t *count);
/* `index` is below the count. */
CPM_API cpm_status cpm_device_describe(cpm_context *context, size_t index, cpm_device_info *info);

typedef struct cpm_device_options {
    size_t struct_size;
    int32_t device;       /* index, as above; not asked where a queue is given */
    int32_t reserved;     /* 0 */
    void *opencl_context; /* the caller's cl_context, to share; NULL: one of our own */
    void *opencl_queue;   /* the caller's cl_command_queue, in order; NULL: one of our own */
    uint64_t memory;      /* bytes of the device that may be used; 0: a quarter of what it has. What needs more comes in
                             parts */
} cpm_device_options;

/* From now on the context computes on that device; NULL: on the processor's threads again. Call it before the context
 * is used from several threads. Programs are kept for the context's life, and their binaries in CPM_CACHE_DIR (default:
 * cpm in XDG_CACHE_HOME, else in ~/.cache; an empty CPM_CACHE_DIR: nowhere). */
CPM_API cpm_status cpm_context_set_device(cpm_context *context, const cpm_device_options *options);

/* What building programs has cost this context: those compiled, those taken from the cache on disk, seconds of both,
 * and bytes of source that reached the compiler. */
typedef struct cpm_device_stats {
    size_t struct_size;
    int32_t compiled, cached;
    double seconds;
    uint64_t source_bytes;
} cpm_device_stats;
CPM_API cpm_status cpm_context_device_stats(cpm_context *context, cpm_device_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
