/* api/context.c: contexts, messages, progress and cancelling. */
#include "context.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "backend/opencl/device.h"

#define MAX_THREADS 1024
#define TELL_EVERY 0.05  /* s between reports that nothing but cpm_poll makes */
#define WAIT_NAP 2000000 /* ns between looks at the other threads */

cpm_status cpm_context_create(const cpm_context_options *options, cpm_context **context) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    *context = NULL;
    cpm_context_options o = {.struct_size = sizeof o};
    if (options) CPM_TAKE(o, options);
    if (o.threads < 0 || o.threads > MAX_THREADS) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_context *c = calloc(1, sizeof *c);
    if (!c) return CPM_ERROR_OUT_OF_MEMORY;
    atomic_init(&c->references, 1);
    c->threads = o.threads ? o.threads : omp_get_num_procs();
    atomic_flag_clear(&c->lock);
    *context = c;
    return CPM_OK;
}

void cpm_context_retain(cpm_context *context) {
    if (context) atomic_fetch_add(&context->references, 1);
}

void cpm_context_release(cpm_context *context) {
    if (!context || atomic_fetch_sub(&context->references, 1) != 1) return;
    cpm_opencl_close(context);
    free(context);
}

const char *cpm_context_last_error(const cpm_context *context) { return context ? context->message : ""; }

int32_t cpm_context_threads(const cpm_context *context) { return context ? context->threads : 0; }

cpm_status cpm_context_set_progress(cpm_context *context, cpm_progress_callback callback, void *user) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    context->progress = callback;
    context->progress_user = user;
    return CPM_OK;
}

cpm_status cpm_fail(cpm_context *context, cpm_status status, const char *format, ...) {
    if (!context) return status;
    while (atomic_flag_test_and_set_explicit(&context->lock, memory_order_acquire)) {}
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(context->message, sizeof context->message, format, arguments);
    va_end(arguments);
    atomic_flag_clear_explicit(&context->lock, memory_order_release);
    return status;
}

void cpm_progress_begin(cpm_context *context) {
    atomic_store(&context->cancelled, 0);
    atomic_store(&context->stage, "project");
    atomic_store(&context->fraction, 0.0);
    atomic_store(&context->told, cpm_seconds());
}

int32_t cpm_progress(cpm_context *context, const char *stage, double fraction) {
    if (!context->progress || cpm_cancelled(context)) return cpm_cancelled(context);
    atomic_store(&context->stage, stage);
    atomic_store(&context->fraction, fraction);
    atomic_store(&context->told, cpm_seconds());
    if (context->progress(context->progress_user, stage, fmin(fmax(fraction, 0.0), 1.0)))
        atomic_store(&context->cancelled, 1);
    return cpm_cancelled(context);
}

int32_t cpm_poll(cpm_context *context) {
    if (!context) return 0;
    const char *stage = omp_get_thread_num() == 0 ? atomic_load(&context->stage) : NULL;
    if (!stage || cpm_seconds() - atomic_load(&context->told) < TELL_EVERY) return cpm_cancelled(context);
    return cpm_progress(context, stage, atomic_load(&context->fraction));
}

void cpm_wait(cpm_context *context, const int *done, int all) {
    for (;;) {
        int so_far;
#pragma omp atomic read
        so_far = *done;
        if (so_far >= all) return;
        cpm_poll(context);
        nanosleep(&(const struct timespec){.tv_nsec = WAIT_NAP}, NULL);
    }
}

double cpm_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
