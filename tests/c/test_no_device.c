/* A library built without OpenCL has no devices, says so, and goes on. Built in the place of test_device.c and
 * test_hits_device.c. */
#include "abuse.h"

static void there_are_no_devices(void **state) {
    (void)state;
    cpm_context *context = new_context();
    size_t count = 7;
    cpm_device_info info = {.struct_size = sizeof info};
    cpm_device_stats stats = {.struct_size = sizeof stats, .compiled = 7};
    const cpm_device_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_device_count(context, &count));
    assert_int_equal(count, 0);
    assert_status(context, REFUSED, cpm_device_describe(context, 0, &info));
    assert_status(context, CPM_ERROR_UNSUPPORTED, cpm_context_set_device(context, &options));
    assert_non_null(strstr(cpm_context_last_error(context), "without OpenCL"));
    assert_ok(context, cpm_context_set_device(context, NULL));
    assert_ok(context, cpm_context_device_stats(context, &stats));
    assert_int_equal(stats.compiled, 0);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(there_are_no_devices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
