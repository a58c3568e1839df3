/* check.h: cmocka, and what the C tests share. */
#ifndef CPM_TESTS_CHECK_H
#define CPM_TESTS_CHECK_H
#include <setjmp.h> /* this order is cmocka's wish */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "cpm/cpm.h"

/* The message beside the status: a failing test then says what the library said. */
#define assert_status(context, expected, call)                                                                         \
    do {                                                                                                               \
        const cpm_status got_ = (call);                                                                                \
        if (got_ != (expected))                                                                                        \
            fail_msg("%s: %s (%d), wanted %s; message: %s", #call, cpm_status_string(got_), (int)got_,                 \
                     cpm_status_string(expected), cpm_context_last_error(context));                                    \
    } while (0)
#define assert_ok(context, call) assert_status(context, CPM_OK, call)

static inline cpm_context *new_context(void) {
    cpm_context *context = NULL;
    assert_int_equal(cpm_context_create(NULL, &context), CPM_OK);
    assert_non_null(context);
    return context;
}
#endif
