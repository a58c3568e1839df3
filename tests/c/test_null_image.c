/* test_null_image.c: photons and images given nonsense, and scenes with nothing in them. See abuse.h. */
#include "abuse.h"

static void photons_and_images(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = plain_scene(context);
    const double wavelength = 550.0, falling[2] = {600.0, 500.0};
    cpm_photons *p = NULL;
    cpm_image *image = NULL;
    const cpm_photons_options good = {
        .struct_size = sizeof good, .photons = 1000, .wavelengths = &wavelength, .wavelength_count = 1};
    assert_refused(context, p, cpm_photons_trace(context, NULL, &good, &p));
    assert_refused(context, p, cpm_photons_trace(context, s, NULL, &p));
    assert_status(context, REFUSED, cpm_photons_trace(context, s, &good, NULL));
    cpm_photons_options o = good;
    o.wavelengths = NULL;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    o = good, o.wavelength_count = 0;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    o = good, o.wavelength_count = CPM_MAX_BINS + 1;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    o = good, o.wavelengths = falling, o.wavelength_count = 2;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    o = good, o.photons = (uint64_t)UINT32_MAX + 1;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    o = good, o.batch = -1;
    assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    const double tolerances[] = {-1e-9, 100.001, INFINITY, NAN};
    for (size_t i = 0; i < COUNT_OF(tolerances); i++) {
        o = good, o.bundle_tolerance = tolerances[i];
        assert_refused(context, p, cpm_photons_trace(context, s, &o, &p));
    }
    o = good, o.photons = 0; /* allowed: empty maps */
    assert_ok(context, cpm_photons_trace(context, s, &o, &p));
    assert_int_equal(cpm_photons_count(p, CPM_MAP_DIFFUSE), 0);
    double e = -1.0;
    assert_ok(context, cpm_photons_irradiance(context, p, CPM_MAP_DIFFUSE, origin, up, 1, 10, 0.0, &e));
    assert_true(e == 0.0);
    cpm_photons_release(p);

    assert_ok(context, cpm_photons_trace(context, s, &good, &p));
    assert_int_equal(cpm_photons_bins(p), 1);
    assert_true(cpm_photons_count(p, CPM_MAP_DIFFUSE) > 0);
    assert_int_equal(cpm_photons_count(p, CPM_MAP_CAUSTIC), 0);
    const cpm_map wrong_map = (cpm_map)3;
    assert_int_equal(cpm_photons_count(p, wrong_map), 0);
    cpm_photons_arrays arrays = {.struct_size = sizeof arrays};
    assert_int_equal(cpm_photons_read(p, CPM_MAP_DIFFUSE, &arrays), CPM_OK);
    assert_int_equal(cpm_photons_read(p, CPM_MAP_DIFFUSE, NULL), REFUSED);
    assert_int_equal(cpm_photons_read(p, wrong_map, &arrays), REFUSED);
    assert_int_equal(cpm_photons_stats(p, NULL), REFUSED);
    assert_int_equal(cpm_photons_energy(p, NULL, NULL, NULL, NULL, NULL), CPM_OK);
    const cpm_map map = CPM_MAP_DIFFUSE;
    assert_status(context, REFUSED, cpm_photons_irradiance(context, NULL, map, origin, up, 1, 10, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, wrong_map, origin, up, 1, 10, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, NULL, up, 1, 10, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, NULL, 1, 10, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, up, 1, 10, 0.0, NULL));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, up, 1, 1, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, up, 1, -5, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, up, 1, 10, NAN, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, origin, 1, 10, 0.0, &e));
    const double bad[3] = {0, NAN, 0};
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, bad, up, 1, 10, 0.0, &e));
    assert_status(context, REFUSED, cpm_photons_irradiance(context, p, map, origin, bad, 1, 10, 0.0, &e));
    assert_ok(context, cpm_photons_irradiance(context, p, map, NULL, NULL, 0, 10, 0.0, NULL));
    assert_ok(context, cpm_photons_irradiance(context, p, map, origin, up, 1, 1000000, 0.0, &e));

    const cpm_render_options render = {.struct_size = sizeof render,
                                       .width = 3,
                                       .height = 2,
                                       .photons = 1000,
                                       .wavelengths = &wavelength,
                                       .wavelength_count = 1,
                                       .nearest = 10,
                                       .samples = 1};
    assert_refused(context, image, cpm_image_render(context, NULL, &render, &image));
    assert_refused(context, image, cpm_image_render(context, s, NULL, &image));
    assert_status(context, REFUSED, cpm_image_render(context, s, &render, NULL));
    assert_refused(context, image, cpm_image_gather(context, s, NULL, &render, &image));
    assert_refused(context, image, cpm_image_gather(context, NULL, p, &render, &image));
    assert_refused(context, image, cpm_image_gather(context, s, p, NULL, &image));
    cpm_render_options r;
    const int32_t sizes[] = {0, -1, 65537, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        r = render, r.width = sizes[i];
        assert_refused(context, image, cpm_image_render(context, s, &r, &image));
        r = render, r.height = sizes[i];
        assert_refused(context, image, cpm_image_render(context, s, &r, &image));
    }
    const int32_t few[] = {1, 0, -1, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(few); i++) {
        r = render, r.nearest = few[i];
        assert_refused(context, image, cpm_image_render(context, s, &r, &image));
    }
    r = render, r.samples = 0;
    assert_refused(context, image, cpm_image_render(context, s, &r, &image));
    r = render, r.max_radius = NAN;
    assert_refused(context, image, cpm_image_render(context, s, &r, &image));
    for (size_t i = 0; i < COUNT_OF(tolerances); i++) {
        r = render, r.bundle_tolerance = tolerances[i];
        assert_refused(context, image, cpm_image_render(context, s, &r, &image));
        assert_refused(context, image, cpm_image_gather(context, s, p, &r, &image));
    }
    assert_ok(context, cpm_image_render(context, s, &render, &image));
    cpm_image_release(image);
    assert_ok(context, cpm_image_gather(context, s, p, &render, &image));
    cpm_image_release(image);
    cpm_photons_release(p);
    cpm_scene_release(s);
    cpm_context_release(context);
}

/* A scene without camera, light or shape: a camera is needed for a picture, the rest only makes it black. */
static void empty_scenes(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = NULL;
    cpm_photons *p = NULL;
    cpm_image *image = NULL;
    const double wavelength = 550.0;
    assert_ok(context, cpm_scene_create(context, NULL, &s));
    const cpm_photons_options photons = {
        .struct_size = sizeof photons, .photons = 100, .wavelengths = &wavelength, .wavelength_count = 1};
    assert_ok(context, cpm_photons_trace(context, s, &photons, &p));
    assert_int_equal(cpm_photons_count(p, CPM_MAP_DIFFUSE), 0);
    const cpm_render_options render = {.struct_size = sizeof render,
                                       .width = 3,
                                       .height = 2,
                                       .photons = 100,
                                       .wavelengths = &wavelength,
                                       .wavelength_count = 1,
                                       .nearest = 10,
                                       .samples = 1};
    assert_refused(context, image, cpm_image_render(context, s, &render, &image));
    assert_non_null(strstr(cpm_context_last_error(context), "camera"));
    const cpm_camera camera = {.struct_size = sizeof camera, .origin = {0, 2, 2}, .up = {0, 1, 0}, .fov = 40.0};
    assert_ok(context, cpm_scene_set_camera(s, &camera));
    assert_ok(context, cpm_image_render(context, s, &render, &image));
    for (int i = 0; i < 6; i++) assert_true(cpm_image_data(image)[i] == 0.0f);
    cpm_image_release(image);
    cpm_photons_release(p);
    cpm_scene_release(s);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photons_and_images),
        cmocka_unit_test(empty_scenes),
    };
    return cmocka_run_group_tests_name("null_image", tests, NULL, NULL);
}
