/* test_null.c: contexts, handles, and NULL for every argument that may not be. See abuse.h. */
#include "abuse.h"

static void null_handles(void **state) {
    (void)state;
    cpm_context_retain(NULL);
    cpm_context_release(NULL);
    cpm_medium_retain(NULL);
    cpm_medium_release(NULL);
    cpm_scene_retain(NULL);
    cpm_scene_release(NULL);
    cpm_photons_retain(NULL);
    cpm_photons_release(NULL);
    cpm_image_retain(NULL);
    cpm_image_release(NULL);
    assert_int_equal(cpm_context_create(NULL, NULL), REFUSED);
    assert_string_equal(cpm_context_last_error(NULL), "");
    assert_int_equal(cpm_context_set_progress(NULL, NULL, NULL), REFUSED);
    assert_int_equal(cpm_context_threads(NULL), 0);
    assert_int_equal(cpm_photons_count(NULL, CPM_MAP_DIFFUSE), 0);
    assert_int_equal(cpm_photons_bins(NULL), 0);
    assert_null(cpm_image_data(NULL));
    assert_null(cpm_image_wavelengths(NULL));
    int32_t width = 1, height = 1;
    size_t bins = 1;
    assert_int_equal(cpm_image_size(NULL, &width, &height, &bins), REFUSED);
    cpm_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(cpm_image_stats(NULL, &stats), REFUSED);
    assert_int_equal(cpm_photons_stats(NULL, &stats), REFUSED);
    assert_int_equal(cpm_photons_energy(NULL, NULL, NULL, NULL, NULL, NULL), REFUSED);
    assert_int_equal(cpm_photons_roulette_variance(NULL, NULL), REFUSED);
    cpm_photons_arrays arrays = {.struct_size = sizeof arrays};
    assert_int_equal(cpm_photons_read(NULL, CPM_MAP_DIFFUSE, &arrays), REFUSED);
}

static void null_context(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *medium = plain_medium(context), *made = NULL;
    cpm_scene *scene = plain_scene(context), *scene_made = NULL;
    cpm_photons *photons = NULL;
    cpm_image *image = NULL;
    double n = 0;
    const float value = 1.0f;
    const double wavelength = 550.0;
    const cpm_photons_options photon_options = {
        .struct_size = sizeof photon_options, .photons = 10, .wavelengths = &wavelength, .wavelength_count = 1};
    const cpm_render_options render_options = {.struct_size = sizeof render_options,
                                               .width = 2,
                                               .height = 2,
                                               .photons = 10,
                                               .wavelengths = &wavelength,
                                               .wavelength_count = 1,
                                               .nearest = 5,
                                               .samples = 1};
    const cpm_layered_desc layered = {.struct_size = sizeof layered};
    const cpm_grid_desc grid = {.struct_size = sizeof grid};
    const cpm_rays_request request = {.struct_size = sizeof request};
    cpm_rays_result result = {.struct_size = sizeof result};
    const cpm_sources_desc sources = {
        .struct_size = sizeof sources, .count = 1, .centers = one, .strengths = one, .exponents = one};
    assert_int_equal(cpm_medium_create_homogeneous(NULL, 1.0, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_dispersive(NULL, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_linear_squared(NULL, 1.0, up, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_linear(NULL, 1.0, up, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_layered(NULL, &layered, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_grid(NULL, &grid, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_parabolic(NULL, 1.5, 0.1, up, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_luneburg(NULL, 1.0, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_fisheye(NULL, 1.5, 1.0, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_eaton(NULL, 1.0, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_sources(NULL, &sources, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_evaluate(NULL, medium, origin, 1, 550.0, &n, NULL), REFUSED);
    assert_int_equal(cpm_rays_trace(NULL, medium, NULL, &request, &result), REFUSED);
    assert_int_equal(cpm_scene_create(NULL, NULL, &scene_made), REFUSED);
    assert_int_equal(cpm_photons_trace(NULL, scene, &photon_options, &photons), REFUSED);
    assert_int_equal(cpm_photons_irradiance(NULL, NULL, CPM_MAP_DIFFUSE, origin, up, 1, 10, 0.0, &n), REFUSED);
    assert_int_equal(cpm_image_render(NULL, scene, &render_options, &image), REFUSED);
    assert_int_equal(cpm_image_gather(NULL, scene, NULL, &render_options, &image), REFUSED);
    assert_int_equal(cpm_image_create(NULL, 1, 1, &wavelength, 1, &value, &image), REFUSED);
    assert_int_equal(cpm_image_write_exr(NULL, NULL, "a.exr", NULL), REFUSED);
    assert_null(made);
    assert_null(scene_made);
    assert_null(photons);
    assert_null(image);
    cpm_scene_release(scene);
    cpm_medium_release(medium);
    cpm_context_release(context);
}

/* What a handle needs outlives the caller's own reference to it. */
static void released_early(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *medium = plain_medium(context);
    cpm_scene *s = NULL;
    const cpm_scene_options options = {.struct_size = sizeof options, .medium = medium};
    assert_ok(context, cpm_scene_create(context, &options, &s));
    cpm_medium_release(medium);
    cpm_context_release(context);
    const cpm_camera camera = {.struct_size = sizeof camera, .origin = {0, 2, 2}, .up = {0, 1, 0}, .fov = 40.0};
    assert_int_equal(cpm_scene_set_camera(s, &camera), CPM_OK);
    assert_int_equal(cpm_scene_set_camera(s, NULL), REFUSED);
    cpm_scene_release(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(null_handles),
        cmocka_unit_test(null_context),
        cmocka_unit_test(released_early),
    };
    return cmocka_run_group_tests_name("null", tests, NULL, NULL);
}
