/* test_status.c: status codes and their texts, versions, and the struct_size of every descriptor. */
#include <string.h>

#include "check.h"

#define COUNT(name, value, text) +1
enum { STATUS_COUNT = 0 CPM_STATUS_LIST(COUNT), RAY_STATUS_COUNT = 0 CPM_RAY_STATUS_LIST(COUNT) };
#undef COUNT

static void ok_is_zero(void **state) {
    (void)state;
    assert_int_equal(CPM_OK, 0);
    assert_int_equal(CPM_RAY_ARRIVED, 0);
}

/* These numbers are in compiled programs and in Python's cpm.RayStatus: they never change. */
static void values_are_pinned(void **state) {
    (void)state;
    assert_int_equal(CPM_ERROR_INVALID_ARGUMENT, 1);
    assert_int_equal(CPM_ERROR_OUT_OF_MEMORY, 2);
    assert_int_equal(CPM_ERROR_UNSUPPORTED, 3);
    assert_int_equal(CPM_ERROR_IO, 4);
    assert_int_equal(CPM_ERROR_CANCELLED, 5);
    assert_int_equal(CPM_ERROR_BACKEND, 6);
    assert_int_equal(CPM_ERROR_INTERNAL, 20);
    assert_int_equal(CPM_RAY_HIT, 1);
    assert_int_equal(CPM_RAY_LEFT, 2);
    assert_int_equal(CPM_RAY_EVALUATIONS_EXHAUSTED, 10);
    assert_int_equal(CPM_RAY_STEP_UNDERFLOW, 11);
    assert_int_equal(CPM_RAY_CUTOFF, 12);
    assert_int_equal(CPM_RAY_CAPTURED, 13);
}

static void texts_differ(void **state) {
    (void)state;
#define TEXT(name, value, text) cpm_status_string(name),
    const char *texts[] = {CPM_STATUS_LIST(TEXT)};
#undef TEXT
#define TEXT(name, value, text) cpm_ray_status_string(name),
    const char *ray_texts[] = {CPM_RAY_STATUS_LIST(TEXT)};
#undef TEXT
    for (int i = 0; i < STATUS_COUNT; i++) {
        assert_non_null(texts[i]);
        assert_true(strlen(texts[i]) > 3);
        for (int j = 0; j < i; j++) assert_string_not_equal(texts[i], texts[j]);
    }
    for (int i = 0; i < RAY_STATUS_COUNT; i++)
        for (int j = 0; j < i; j++) assert_string_not_equal(ray_texts[i], ray_texts[j]);
}

static void unknown_values_have_a_text(void **state) {
    (void)state;
    const int unknown[] = {-1, 7, 19, 21, 1 << 30};
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
        cpm_status status;
        cpm_ray_status ray;
        memcpy(&status, &unknown[i], sizeof status);
        memcpy(&ray, &unknown[i], sizeof ray);
        assert_string_equal(cpm_status_string(status), "unknown status");
        assert_string_equal(cpm_ray_status_string(ray), "unknown status");
    }
}

static void version_matches_the_header(void **state) {
    (void)state;
    char expected[32];
    snprintf(expected, sizeof expected, "%d.%d.%d", CPM_VERSION_MAJOR, CPM_VERSION_MINOR, CPM_VERSION_PATCH);
    assert_string_equal(cpm_version(), expected);
    assert_non_null(strstr(cpm_build_info(), "embree "));
    assert_non_null(strstr(cpm_build_info(), "isa "));
    assert_null(strstr(cpm_build_info(), "unknown"));
}

/* CPM_TAKE and every caller rely on it. */
static void struct_size_comes_first(void **state) {
    (void)state;
#define FIRST(type) assert_int_equal(offsetof(type, struct_size), 0)
    FIRST(cpm_context_options);
    FIRST(cpm_dispersion);
    FIRST(cpm_layered_desc);
    FIRST(cpm_grid_desc);
    FIRST(cpm_rays_request);
    FIRST(cpm_rays_result);
    FIRST(cpm_scene_options);
    FIRST(cpm_material);
    FIRST(cpm_mesh_desc);
    FIRST(cpm_bounds);
    FIRST(cpm_light_desc);
    FIRST(cpm_camera);
    FIRST(cpm_photons_options);
    FIRST(cpm_photons_arrays);
    FIRST(cpm_stats);
    FIRST(cpm_render_options);
#undef FIRST
}

static void context_threads(void **state) {
    (void)state;
    cpm_context *context = NULL;
    cpm_context_options options = {.struct_size = sizeof options, .threads = 3};
    assert_int_equal(cpm_context_create(&options, &context), CPM_OK);
    assert_int_equal(cpm_context_threads(context), 3);
    assert_string_equal(cpm_context_last_error(context), "");
    cpm_context_retain(context);
    cpm_context_release(context);
    assert_int_equal(cpm_context_threads(context), 3);
    cpm_context_release(context);

    const int32_t refused[] = {-1, INT32_MIN, 1025, INT32_MAX};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        options.threads = refused[i];
        context = (cpm_context *)&options;
        assert_int_equal(cpm_context_create(&options, &context), CPM_ERROR_INVALID_ARGUMENT);
        assert_null(context);
    }
    /* A caller that knows only struct_size: the rest is the default. */
    options = (cpm_context_options){.struct_size = sizeof options.struct_size, .threads = -5};
    assert_int_equal(cpm_context_create(&options, &context), CPM_OK);
    assert_true(cpm_context_threads(context) >= 1);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ok_is_zero),
        cmocka_unit_test(values_are_pinned),
        cmocka_unit_test(texts_differ),
        cmocka_unit_test(unknown_values_have_a_text),
        cmocka_unit_test(version_matches_the_header),
        cmocka_unit_test(struct_size_comes_first),
        cmocka_unit_test(context_threads),
    };
    return cmocka_run_group_tests_name("status", tests, NULL, NULL);
}
