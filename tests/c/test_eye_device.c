/* Pictures on an OpenCL device: the same bits whatever memory it may use, and where its maps do not fit; what is said
 * where nothing does. Sanitizer builds look for what is left behind. */
#include <stdlib.h>

#include "abuse.h"
#include "backend/opencl/device.h"
#include "cpm/device.h"

#define WIDTH 40
#define HEIGHT 30
#define BINS 3
#define VALUES ((size_t)WIDTH * HEIGHT * BINS)

static const double wavelengths[BINS] = {450.0, 550.0, 650.0};

/* The plain scene with a ball of glass that disperses and one that mirrors. */
static cpm_scene *balls(cpm_context *context) {
    static const double nearly = 0.9;
    cpm_scene *scene = plain_scene(context);
    cpm_dispersion dispersion = {.struct_size = sizeof dispersion};
    cpm_medium *glass = NULL;
    int32_t index;
    assert_ok(context, cpm_dispersion_catalogue(context, "BK7", &dispersion));
    assert_ok(context, cpm_medium_create_homogeneous(context, 1.0, &dispersion, &glass));
    const cpm_material clear = {.struct_size = sizeof clear, .kind = CPM_MATERIAL_DIELECTRIC, .interior = glass},
                       mirror = {
                           .struct_size = sizeof mirror, .kind = CPM_MATERIAL_MIRROR, .reflectance = flat(&nearly)};
    assert_ok(context, cpm_scene_add_sphere(scene, (const double[3]){-0.3, 0.4, 0.0}, 0.3, &clear, "glass", &index));
    assert_ok(context, cpm_scene_add_sphere(scene, (const double[3]){0.4, 0.3, 0.2}, 0.2, &mirror, "mirror", &index));
    cpm_medium_release(glass);
    return scene;
}

static cpm_status draw(cpm_context *context, cpm_scene *scene, int32_t samples, cpm_image **image) {
    const cpm_render_options options = {.struct_size = sizeof options,
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .photons = 20000,
                                        .nearest = 40,
                                        .samples = samples,
                                        .wavelengths = wavelengths,
                                        .wavelength_count = BINS,
                                        .no_edge_correction = 1};
    return cpm_image_render(context, scene, &options, image);
}

static void use(cpm_context *context, uint64_t memory) {
    const cpm_device_options device = {.struct_size = sizeof device, .memory = memory};
    assert_ok(context, cpm_context_set_device(context, &device));
}

static void same(const cpm_image *a, const cpm_image *b) {
    const float *x = cpm_image_data(a), *y = cpm_image_data(b);
    double sum = 0.0;
    for (size_t i = 0; i < VALUES; i++) {
        sum += (double)x[i];
        if (memcmp(&x[i], &y[i], sizeof *x)) fail_msg("value %zu is %.9g and %.9g", i, (double)x[i], (double)y[i]);
    }
    assert_true(sum > 0.0);
}

static void memory_does_not_change_a_picture(void **state) {
    (void)state;
    static const uint64_t memory[] = {0, 4000000, 700000};
    cpm_context *context = new_context();
    cpm_scene *scene = balls(context);
    cpm_image *native = NULL, *device = NULL;
    assert_ok(context, draw(context, scene, 5, &native));
    for (size_t i = 0; i < COUNT_OF(memory); i++) {
        use(context, memory[i]);
        assert_ok(context, draw(context, scene, 5, &device));
        same(native, device);
        cpm_image_release(device);
    }
    cpm_image_release(native);
    cpm_scene_release(scene);
    cpm_context_release(context);
}

static void maps_too_large_for_a_buffer_are_searched_here(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *scene = balls(context);
    cpm_image *native = NULL, *device = NULL;
    const double points[6] = {0.5, 0.0, -0.5, -0.5, 0.0, 0.5}, normals[6] = {0, 1, 0, 0, 1, 0};
    double irradiance[2][2 * BINS];
    assert_ok(context, draw(context, scene, 1, &native));
    use(context, 0);
    ((cpm_opencl *)context->opencl)->largest = 150000; /* some 10000 photons are 320 kB */
    assert_ok(context, draw(context, scene, 1, &device));
    same(native, device);
    cpm_image_release(native), cpm_image_release(device);

    const cpm_photons_options few = {
        .struct_size = sizeof few, .photons = 20000, .wavelengths = wavelengths, .wavelength_count = BINS};
    cpm_photons *photons = NULL;
    assert_ok(context, cpm_photons_trace(context, scene, &few, &photons));
    for (int i = 0; i < 2; i++) {
        assert_ok(context, cpm_photons_irradiance(context, photons, CPM_MAP_DIFFUSE, points, normals, 2, 40, 0.0,
                                                  irradiance[i]));
        assert_ok(context, cpm_context_set_device(context, NULL));
    }
    assert_true(irradiance[0][0] > 0.0);
    assert_memory_equal(irradiance[0], irradiance[1], sizeof irradiance[0]);
    cpm_photons_release(photons);
    cpm_scene_release(scene);
    cpm_context_release(context);
}

static void too_little_memory_is_said(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *scene = balls(context);
    cpm_photons *photons = NULL;
    cpm_image *image = NULL;
    const cpm_photons_options few = {
        .struct_size = sizeof few, .photons = 2000, .wavelengths = wavelengths, .wavelength_count = BINS};
    const cpm_render_options options = {
        .struct_size = sizeof options, .width = 4, .height = 3, .nearest = 100000, .samples = 1};
    assert_ok(context, cpm_photons_trace(context, scene, &few, &photons));
    use(context, 60000);
    assert_refused_as(context, CPM_ERROR_OUT_OF_MEMORY, image,
                      cpm_image_gather(context, scene, photons, &options, &image));
    assert_non_null(strstr(cpm_context_last_error(context), "nearest is 100000"));
    use(context, 2000);
    assert_refused_as(context, CPM_ERROR_OUT_OF_MEMORY, image,
                      cpm_image_gather(context, scene, photons, &options, &image));
    assert_non_null(strstr(cpm_context_last_error(context), "allow more"));
    cpm_photons_release(photons);
    cpm_scene_release(scene);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_does_not_change_a_picture),
        cmocka_unit_test(maps_too_large_for_a_buffer_are_searched_here),
        cmocka_unit_test(too_little_memory_is_said),
    };
    setenv("CPM_CACHE_DIR", "", 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
