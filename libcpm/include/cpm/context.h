/* cpm/context.h: a context owns threads, messages, progress and cancelling. There is no global state.
 *
 * Calls on different contexts never interfere. Calls on one context may come from several threads; the last error is
 * kept per context, so read it from the thread that saw the failure before calling again. */
#ifndef CPM_CONTEXT_H
#define CPM_CONTEXT_H
#include <stddef.h>
#include <stdint.h>

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define CPM_VERSION_MAJOR 0
#define CPM_VERSION_MINOR 1
#define CPM_VERSION_PATCH 0

typedef struct cpm_context cpm_context;

/* Called from the thread that made the long call, a few times a second. `stage` names the stage of the pipeline
 * ("project", "trace", "map", "gather", "write"), `fraction` is in [0, 1]. Return 0 to go on, anything else to cancel:
 * the call then returns CPM_ERROR_CANCELLED and leaves nothing behind. */
typedef int32_t (*cpm_progress_callback)(void *user, const char *stage, double fraction);

typedef struct cpm_context_options {
    size_t struct_size; /* sizeof(cpm_context_options) as the caller compiled it */
    int32_t threads;    /* 0: as many as the machine has; else 1..1024 */
    int32_t reserved;   /* 0 */
} cpm_context_options;

/* `options` may be NULL. On failure *context is NULL. */
CPM_API cpm_status cpm_context_create(const cpm_context_options *options, cpm_context **context);
CPM_API void cpm_context_retain(cpm_context *context);
CPM_API void cpm_context_release(cpm_context *context);

/* The message of the last failure on this context: what, its value, what is allowed. "" when there was none. */
CPM_API const char *cpm_context_last_error(const cpm_context *context);

/* NULL takes the callback away. */
CPM_API cpm_status cpm_context_set_progress(cpm_context *context, cpm_progress_callback callback, void *user);
CPM_API int32_t cpm_context_threads(const cpm_context *context);

/* The library's version as "major.minor.patch", and a line that names what it was built with (for bug reports):
 * "embree 3.13.5, openexr 3.1.5, opencl headers 3.0, isa x86-64-v4". */
CPM_API const char *cpm_version(void);
CPM_API const char *cpm_build_info(void);

#ifdef __cplusplus
}
#endif
#endif
