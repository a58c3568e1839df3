/* api/context.h: the context's inside, and the one way to fail. */
#ifndef CPM_API_CONTEXT_H
#define CPM_API_CONTEXT_H
#include <stdatomic.h>

#include "cpm/cpm.h"

struct cpm_context {
    atomic_int references;
    int32_t threads;
    void *opencl; /* cpm_opencl of backend/opencl/device.h; NULL: the native backend */
    cpm_progress_callback progress;
    void *progress_user;
    atomic_int cancelled; /* set once the callback says so, cleared when a long call begins */
    /* What cpm_progress was told last, and when it told the user: for cpm_poll. */
    const char *_Atomic stage;
    _Atomic double fraction, told;
    atomic_flag lock;     /* guards message */
    char message[1024];
};

/* Stores the message and returns `status`: `return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "rtol is %g; ...")`.
 * `context` may be NULL. */
cpm_status cpm_fail(cpm_context *context, cpm_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Clears the cancel flag: first line of a long call. */
void cpm_progress_begin(cpm_context *context);
/* Reports from the calling thread; nonzero: cancelled, so leave as soon as you can. Other threads only read
 * cpm_cancelled(). */
int32_t cpm_progress(cpm_context *context, const char *stage, double fraction);
/* Gives the user a chance to cancel in the midst of long work: repeats the last report where it is 50 ms old. Cheap, from
 * any thread (only that of the caller asks the user); `context` may be NULL. Nonzero: cancelled. */
int32_t cpm_poll(cpm_context *context);
/* Where the thread of the caller has no more work but the others have: polls until `*done` is `all`. */
void cpm_wait(cpm_context *context, const int *done, int all);
static inline int32_t cpm_cancelled(cpm_context *context) {
    return atomic_load_explicit(&context->cancelled, memory_order_relaxed);
}

/* Copies the caller's struct into ours: the fields that the caller knows, zeros beyond. */
#define CPM_TAKE(ours, theirs)                                                                                         \
    do {                                                                                                               \
        size_t take_ = (theirs)->struct_size < sizeof(ours) ? (theirs)->struct_size : sizeof(ours);                    \
        memset(&(ours), 0, sizeof(ours));                                                                              \
        memcpy(&(ours), (theirs), take_);                                                                              \
        (ours).struct_size = sizeof(ours);                                                                             \
    } while (0)

/* Monotonic seconds, for the stage table. */
double cpm_seconds(void);
#endif
