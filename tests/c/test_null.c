/* test_null.c: abuse. Every public function is given NULL and nonsense; each returns a status, sets its output handle
 * to NULL, leaves a message that says something, and never crashes. Sanitizer builds run this too. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "check.h"

#define REFUSED CPM_ERROR_INVALID_ARGUMENT
#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

static const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0}, one[3] = {1, 1, 1};
static const double not_numbers[] = {NAN, INFINITY, -INFINITY};
static const double not_positive[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0};
static char somewhere; /* a handle that must be overwritten with NULL */

/* The call fails with `status`, clears the handle and says why. */
#define assert_refused_as(context, status, handle, call)                                                               \
    do {                                                                                                               \
        *(void **)&(handle) = &somewhere;                                                                              \
        assert_status(context, status, call);                                                                          \
        assert_null(handle);                                                                                           \
        assert_true(strlen(cpm_context_last_error(context)) > 3);                                                      \
    } while (0)
#define assert_refused(context, handle, call) assert_refused_as(context, REFUSED, handle, call)

static cpm_medium *plain_medium(cpm_context *context) {
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_homogeneous(context, 1.5, NULL, &medium));
    return medium;
}

static cpm_spectrum flat(const double *value) { return (cpm_spectrum){.values = value, .count = 1}; }

/* A floor, a point light, a camera: enough to render. */
static cpm_scene *plain_scene(cpm_context *context) {
    static const double half = 0.5, ten = 10.0;
    static const double vertices[4][3] = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    static const uint32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    cpm_scene *scene = NULL;
    const cpm_scene_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_scene_create(context, &options, &scene));
    const cpm_material material = {
        .struct_size = sizeof material, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = flat(&half)};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = vertices[0],
                                .vertex_count = 4,
                                .faces = faces[0],
                                .face_count = 2,
                                .material = &material,
                                .name = "floor"};
    int32_t index = -1;
    assert_ok(context, cpm_scene_add_mesh(scene, &mesh, &index));
    assert_true(index >= 0);
    const cpm_light_desc light = {
        .struct_size = sizeof light, .kind = CPM_LIGHT_POINT, .position = {0, 1, 0}, .emission = flat(&ten)};
    assert_ok(context, cpm_scene_add_light(scene, &light, &index));
    const cpm_camera camera = {
        .struct_size = sizeof camera, .origin = {0, 2, 2}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov = 40.0};
    assert_ok(context, cpm_scene_set_camera(scene, &camera));
    return scene;
}

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
    assert_int_equal(cpm_medium_create_homogeneous(NULL, 1.0, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_dispersive(NULL, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_linear_squared(NULL, 1.0, up, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_linear(NULL, 1.0, up, origin, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_layered(NULL, &layered, NULL, &made), REFUSED);
    assert_int_equal(cpm_medium_create_grid(NULL, &grid, NULL, &made), REFUSED);
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

static void media_simple(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    assert_status(context, REFUSED, cpm_medium_create_homogeneous(context, 1.0, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_linear(context, 1.0, up, origin, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_linear_squared(context, 1.0, up, origin, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_dispersive(context, NULL, NULL));
    assert_refused(context, m, cpm_medium_create_dispersive(context, NULL, &m));
    assert_refused(context, m, cpm_medium_create_linear(context, 1.0, NULL, origin, NULL, &m));
    assert_refused(context, m, cpm_medium_create_linear_squared(context, 1.0, NULL, origin, NULL, &m));
    for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
        assert_refused(context, m, cpm_medium_create_homogeneous(context, not_positive[i], NULL, &m));
        assert_refused(context, m, cpm_medium_create_linear(context, not_positive[i], up, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_linear_squared(context, not_positive[i], up, origin, NULL, &m));
    }
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        const double bad[3] = {0, not_numbers[i], 0};
        assert_refused(context, m, cpm_medium_create_linear(context, 1.0, bad, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_linear(context, 1.0, up, bad, NULL, &m));
        assert_refused(context, m, cpm_medium_create_linear_squared(context, 1.0, bad, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_linear_squared(context, 1.0, up, bad, NULL, &m));
    }
    cpm_context_release(context);
}

static void media_dispersion(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    cpm_dispersion d = {
        .struct_size = sizeof d, .kind = CPM_DISPERSION_CAUCHY, .count = 2, .coefficients = {1.5, 0.01}};
    assert_ok(context, cpm_medium_create_dispersive(context, &d, &m));
    cpm_medium_release(m);
    const int32_t counts[] = {0, -1, INT32_MIN, CPM_DISPERSION_MAX_COEFFICIENTS + 1, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        d.count = counts[i];
        assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    }
    d.count = 2;
    const int32_t kinds[] = {-1, 5, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(kinds); i++) {
        d.kind = kinds[i];
        assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    }
    for (int32_t kind = CPM_DISPERSION_CONSTANT; kind <= CPM_DISPERSION_TABULATED; kind++)
        for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
            d.kind = kind;
            d.coefficients[0] = not_numbers[i];
            assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
        }
    d = (cpm_dispersion){.struct_size = 0};
    assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    cpm_context_release(context);
}

static void media_tables(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    const double heights[3] = {0, 1, 2}, values[3] = {1.3, 1.2, 1.1};
    const cpm_layered_desc good = {.struct_size = sizeof good,
                                   .heights = heights,
                                   .n = values,
                                   .count = 3,
                                   .interpolation = CPM_INTERPOLATION_CUBIC};
    assert_refused(context, m, cpm_medium_create_layered(context, NULL, NULL, &m));
    assert_status(context, REFUSED, cpm_medium_create_layered(context, &good, NULL, NULL));
    cpm_layered_desc d = good;
    d.heights = NULL;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d = good, d.n = NULL;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d = good, d.count = 0;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d = good, d.count = 1;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    const int32_t interpolations[] = {-1, CPM_INTERPOLATION_LINEAR, 4, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(interpolations); i++) {
        d = good, d.interpolation = interpolations[i];
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    }
    for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
        const double bad[3] = {1.3, not_positive[i], 1.1};
        d = good, d.n = bad;
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
        assert_non_null(strchr(cpm_context_last_error(context), '1')); /* the index of the bad sample */
    }
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        const double bad[3] = {0, not_numbers[i], 2};
        d = good, d.heights = bad;
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
        d = good, d.up[0] = not_numbers[i];
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
        d = good, d.origin[2] = not_numbers[i];
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    }
    const double unsorted[3] = {0, 2, 1}, repeated[3] = {0, 1, 1};
    d = good, d.heights = unsorted;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d = good, d.heights = repeated;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));

    const double samples[8] = {1.1, 1.1, 1.1, 1.1, 1.2, 1.2, 1.2, 1.2};
    const cpm_grid_desc grid = {.struct_size = sizeof grid, .values = samples, .size = {2, 2, 2}, .spacing = {1, 1, 1}};
    assert_refused(context, m, cpm_medium_create_grid(context, NULL, NULL, &m));
    assert_status(context, REFUSED, cpm_medium_create_grid(context, &grid, NULL, NULL));
    cpm_grid_desc g = grid;
    g.values = NULL;
    assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
    for (int axis = 0; axis < 3; axis++) {
        g = grid, g.size[axis] = 0;
        assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
        for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
            g = grid, g.spacing[axis] = not_positive[i];
            assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
        }
        for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
            g = grid, g.origin[axis] = not_numbers[i];
            assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
        }
    }
    /* Sizes whose product overflows: refused before anything is read. */
    const size_t huge[][3] = {{SIZE_MAX, 1, 1}, {SIZE_MAX, SIZE_MAX, SIZE_MAX}, {(size_t)1 << 32, (size_t)1 << 32, 2}};
    for (size_t i = 0; i < COUNT_OF(huge); i++) {
        g = grid;
        memcpy(g.size, huge[i], sizeof g.size);
        m = (cpm_medium *)&somewhere;
        assert_int_not_equal(cpm_medium_create_grid(context, &g, NULL, &m), CPM_OK);
        assert_null(m);
    }
    const int32_t grid_interpolations[] = {-1, CPM_INTERPOLATION_LINEAR_SQUARED, CPM_INTERPOLATION_STEP, 99};
    for (size_t i = 0; i < COUNT_OF(grid_interpolations); i++) {
        g = grid, g.interpolation = grid_interpolations[i];
        assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
    }
    for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
        double bad[8];
        memcpy(bad, samples, sizeof bad);
        bad[5] = not_positive[i];
        g = grid, g.values = bad;
        assert_refused(context, m, cpm_medium_create_grid(context, &g, NULL, &m));
    }
    cpm_context_release(context);
}

static void medium_evaluate(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *medium = plain_medium(context);
    double n = 0, gradient[3];
    assert_ok(context, cpm_medium_evaluate(context, medium, origin, 1, 550.0, &n, gradient));
    assert_true(n == 1.5);
    assert_ok(context, cpm_medium_evaluate(context, medium, origin, 0, 550.0, &n, NULL));
    assert_status(context, REFUSED, cpm_medium_evaluate(context, NULL, origin, 1, 550.0, &n, NULL));
    assert_status(context, REFUSED, cpm_medium_evaluate(context, medium, NULL, 1, 550.0, &n, NULL));
    assert_status(context, REFUSED, cpm_medium_evaluate(context, medium, origin, 1, 550.0, NULL, NULL));
    for (size_t i = 0; i < COUNT_OF(not_positive); i++)
        assert_status(context, REFUSED, cpm_medium_evaluate(context, medium, origin, 1, not_positive[i], &n, NULL));
    cpm_medium_release(medium);
    cpm_context_release(context);
}

static void rays(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *medium = plain_medium(context);
    cpm_scene *scene = plain_scene(context);
    const double wavelength = 550.0, length = 1.0;
    const cpm_rays_request good = {.struct_size = sizeof good,
                                   .count = 1,
                                   .origins = one,
                                   .directions = up,
                                   .wavelengths = &wavelength,
                                   .lengths = &length};
    double position[3];
    cpm_rays_result result = {.struct_size = sizeof result, .position = position};
    assert_ok(context, cpm_rays_trace(context, medium, NULL, &good, &result));
    assert_true(fabs(position[1] - 2.0) < 1e-12);
    cpm_rays_result nothing = {.struct_size = sizeof nothing};
    assert_ok(context, cpm_rays_trace(context, medium, NULL, &good, &nothing));
    assert_status(context, REFUSED, cpm_rays_trace(context, NULL, NULL, &good, &result));
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, scene, &good, &result));
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, NULL, &result));
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &good, NULL));
    cpm_rays_request r = good;
    r.count = 0;
    r.origins = r.directions = r.wavelengths = r.lengths = NULL;
    r.lengths = &length;
    assert_ok(context, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.origins = NULL;
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.directions = NULL;
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.wavelengths = NULL;
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.lengths = NULL; /* neither a length nor a plane */
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.plane_point = origin, r.plane_normal = up; /* both */
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    r = good, r.directions = origin; /* zero direction */
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        const double bad[3] = {0, not_numbers[i], 1};
        r = good, r.origins = bad;
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        assert_non_null(strchr(cpm_context_last_error(context), '0')); /* its index */
        r = good, r.directions = bad;
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.wavelengths = &not_numbers[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.lengths = &not_numbers[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.rtol = not_numbers[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.atol = not_numbers[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.step = not_numbers[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    }
    const double max_steps[] = {NAN, -INFINITY, -1.0}; /* infinity is what 0 is: no bound */
    for (size_t i = 0; i < COUNT_OF(max_steps); i++) {
        r = good, r.max_step = max_steps[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    }
    const double tolerances[] = {-1.0, 1e-15, 1.5, DBL_MAX, -0x1p-1074};
    for (size_t i = 0; i < COUNT_OF(tolerances); i++) {
        r = good, r.rtol = tolerances[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    }
    const int32_t methods[] = {-1, 99, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        r = good, r.method = methods[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
        r = good, r.error_mode = methods[i];
        assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    }
    r = good, r.max_evaluations = -1;
    assert_status(context, REFUSED, cpm_rays_trace(context, medium, NULL, &r, &result));
    cpm_scene_release(scene);
    cpm_medium_release(medium);
    cpm_context_release(context);
}

static void scenes(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = NULL;
    assert_status(context, REFUSED, cpm_scene_create(context, NULL, NULL));
    assert_ok(context, cpm_scene_create(context, NULL, &s)); /* all defaults */
    cpm_scene_release(s);
    const cpm_box backward = {{1, 1, 1}, {0, 0, 0}};
    cpm_box bad_box = {{0, 0, 0}, {1, NAN, 1}};
    const cpm_scene_options good = {.struct_size = sizeof good};
    cpm_scene_options o = good;
    o.extent = &backward;
    assert_refused(context, s, cpm_scene_create(context, &o, &s));
    o.extent = &bad_box;
    assert_refused(context, s, cpm_scene_create(context, &o, &s));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        o = good, o.rtol = not_numbers[i];
        assert_refused(context, s, cpm_scene_create(context, &o, &s));
        o = good, o.step = not_numbers[i];
        assert_refused(context, s, cpm_scene_create(context, &o, &s));
    }
    o = good, o.max_step = NAN;
    assert_refused(context, s, cpm_scene_create(context, &o, &s));
    o = good, o.max_step = -1.0;
    assert_refused(context, s, cpm_scene_create(context, &o, &s));
    o = good, o.method = 99;
    assert_refused(context, s, cpm_scene_create(context, &o, &s));

    int32_t index;
    uint32_t features;
    const double wavelength = 550.0;
    assert_int_equal(cpm_scene_add_mesh(NULL, NULL, &index), REFUSED);
    assert_int_equal(cpm_scene_add_sphere(NULL, origin, 1.0, NULL, NULL, &index), REFUSED);
    assert_int_equal(cpm_scene_add_medium(NULL, NULL, NULL, NULL), REFUSED);
    assert_int_equal(cpm_scene_add_light(NULL, NULL, &index), REFUSED);
    assert_int_equal(cpm_scene_set_camera(NULL, NULL), REFUSED);
    assert_int_equal(cpm_scene_features(NULL, &wavelength, 1, &features), REFUSED);
    assert_int_equal(cpm_scene_extent(NULL, &(cpm_box){0}), REFUSED);
    assert_status(context, REFUSED, cpm_scene_extent(s, NULL));
    s = plain_scene(context);
    assert_status(context, REFUSED, cpm_scene_add_mesh(s, NULL, &index));
    assert_status(context, REFUSED, cpm_scene_add_medium(s, NULL, NULL, NULL));
    assert_status(context, REFUSED, cpm_scene_add_light(s, NULL, &index));
    assert_status(context, REFUSED, cpm_scene_set_camera(s, NULL));
    assert_status(context, REFUSED, cpm_scene_features(s, &wavelength, 1, NULL));
    assert_ok(context, cpm_scene_features(s, &wavelength, 1, &features));
    cpm_scene_release(s);
    cpm_context_release(context);
}

static void meshes(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = plain_scene(context);
    cpm_medium *medium = plain_medium(context);
    const double half = 0.5;
    const double vertices[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint32_t faces[3] = {0, 1, 2};
    const cpm_material diffuse = {
        .struct_size = sizeof diffuse, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = flat(&half)};
    const cpm_mesh_desc good = {.struct_size = sizeof good,
                                .vertices = vertices[0],
                                .vertex_count = 3,
                                .faces = faces,
                                .face_count = 1,
                                .material = &diffuse};
    int32_t index = -7;
    assert_ok(context, cpm_scene_add_mesh(s, &good, NULL));
    cpm_mesh_desc d = good;
    d.vertices = NULL;
    assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
    d = good, d.faces = NULL;
    assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
    d = good, d.material = NULL;
    assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
    const uint32_t outside[][3] = {{0, 1, 3}, {UINT32_MAX, 1, 2}};
    for (size_t i = 0; i < COUNT_OF(outside); i++) {
        d = good, d.faces = outside[i];
        assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
    }
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        double bad[3][3];
        memcpy(bad, vertices, sizeof bad);
        bad[2][1] = not_numbers[i];
        d = good, d.vertices = bad[0];
        assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
        d = good, d.normals = bad[0];
        assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
        const double center[3] = {not_numbers[i], 0, 0};
        assert_status(context, REFUSED, cpm_scene_add_sphere(s, center, 1.0, &diffuse, NULL, &index));
    }
    for (size_t i = 0; i < COUNT_OF(not_positive); i++)
        assert_status(context, REFUSED, cpm_scene_add_sphere(s, origin, not_positive[i], &diffuse, NULL, &index));
    assert_status(context, REFUSED, cpm_scene_add_sphere(s, NULL, 1.0, &diffuse, NULL, &index));

    /* Materials. */
    const double wavelengths[2] = {500, 600}, falling[2] = {600, 500}, fine[2] = {0.5, 0.6};
    const double too_much[2] = {0.5, 1.5}, negative[2] = {-0.1, 0};
    const cpm_spectrum spectra[] = {{NULL, too_much + 1, 1}, {NULL, negative, 1},        {wavelengths, too_much, 2},
                                    {falling, fine, 2},      {wavelengths, negative, 2}, {NULL, &not_numbers[0], 1},
                                    {not_numbers, fine, 2},  {NULL, &not_numbers[1], 1}};
    for (size_t i = 0; i < COUNT_OF(spectra); i++) {
        cpm_material m = diffuse;
        m.reflectance = spectra[i];
        assert_status(context, REFUSED, cpm_scene_add_sphere(s, origin, 1.0, &m, NULL, &index));
    }
    const int32_t kinds[] = {-1, 4, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(kinds); i++) {
        cpm_material m = diffuse;
        m.kind = kinds[i];
        assert_status(context, REFUSED, cpm_scene_add_sphere(s, origin, 1.0, &m, NULL, &index));
    }
    cpm_material glass = {.struct_size = sizeof glass, .kind = CPM_MATERIAL_DIELECTRIC};
    assert_status(context, REFUSED, cpm_scene_add_sphere(s, origin, 1.0, &glass, NULL, &index));
    glass.interior = medium;
    d = good, d.material = &glass, d.name = "shard"; /* an open shape cannot be filled; the message names it */
    assert_status(context, REFUSED, cpm_scene_add_mesh(s, &d, &index));
    assert_non_null(strstr(cpm_context_last_error(context), "shard"));
    cpm_medium_release(medium);
    cpm_scene_release(s);
    cpm_context_release(context);
}

static void bounds_lights_cameras(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = plain_scene(context);
    cpm_medium *medium = plain_medium(context);
    int32_t index;
    cpm_bounds b = {.struct_size = sizeof b, .kind = CPM_BOUNDS_SPHERE, .radius = 1.0};
    assert_ok(context, cpm_scene_add_medium(s, medium, &b, &index));
    assert_int_equal(index, 1);
    assert_status(context, REFUSED, cpm_scene_add_medium(s, NULL, &b, &index));
    for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
        b.radius = not_positive[i];
        assert_status(context, REFUSED, cpm_scene_add_medium(s, medium, &b, &index));
    }
    b = (cpm_bounds){.struct_size = sizeof b, .kind = CPM_BOUNDS_BOX, .box = {{1, 1, 1}, {0, 0, 0}}};
    assert_status(context, REFUSED, cpm_scene_add_medium(s, medium, &b, &index));
    const int32_t shapes[] = {-1, 0 /* open */, 99, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(shapes); i++) {
        b = (cpm_bounds){.struct_size = sizeof b, .kind = CPM_BOUNDS_SHAPE, .shape = shapes[i]};
        assert_status(context, REFUSED, cpm_scene_add_medium(s, medium, &b, &index));
    }
    b = (cpm_bounds){.struct_size = sizeof b, .kind = 99};
    assert_status(context, REFUSED, cpm_scene_add_medium(s, medium, &b, &index));

    const double ten = 10.0, below = -1.0;
    const cpm_light_desc spot = {.struct_size = sizeof spot,
                                 .kind = CPM_LIGHT_SPOT,
                                 .position = {0, 1, 0},
                                 .cutoff = 10.0,
                                 .emission = flat(&ten)};
    assert_ok(context, cpm_scene_add_light(s, &spot, NULL));
    cpm_light_desc l;
    const int32_t kinds[] = {-1, 0, 4, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(kinds); i++) {
        l = spot, l.kind = kinds[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    const double cutoffs[] = {NAN, INFINITY, 0.0, -1.0, 180.5};
    for (size_t i = 0; i < COUNT_OF(cutoffs); i++) {
        l = spot, l.cutoff = cutoffs[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    l = spot, memcpy(l.target, l.position, sizeof l.target); /* no direction */
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = spot, l.emission = flat(&below);
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        l = spot, l.position[1] = not_numbers[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
        l = spot, l.emission = flat(&not_numbers[i]);
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    l = spot, l.kind = CPM_LIGHT_AREA;
    const int32_t area_shapes[] = {-1, 99, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(area_shapes); i++) {
        l.shape = area_shapes[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }

    const cpm_camera good = {.struct_size = sizeof good, .origin = {0, 2, 2}, .up = {0, 1, 0}, .fov = 40.0};
    cpm_camera c;
    const double fovs[] = {NAN, INFINITY, 0.0, -1.0, 180.0};
    for (size_t i = 0; i < COUNT_OF(fovs); i++) {
        c = good, c.fov = fovs[i];
        assert_status(context, REFUSED, cpm_scene_set_camera(s, &c));
    }
    c = good, memcpy(c.target, c.origin, sizeof c.target);
    assert_status(context, REFUSED, cpm_scene_set_camera(s, &c));
    c = good, c.up[1] = 2.0, c.up[2] = 2.0; /* up along the view */
    assert_status(context, REFUSED, cpm_scene_set_camera(s, &c));
    c = good, c.up[1] = 0.0;
    assert_status(context, REFUSED, cpm_scene_set_camera(s, &c));
    c = good, c.origin[0] = NAN;
    assert_status(context, REFUSED, cpm_scene_set_camera(s, &c));
    cpm_medium_release(medium);
    cpm_scene_release(s);
    cpm_context_release(context);
}

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
        cmocka_unit_test(media_simple),
        cmocka_unit_test(media_dispersion),
        cmocka_unit_test(media_tables),
        cmocka_unit_test(medium_evaluate),
        cmocka_unit_test(rays),
        cmocka_unit_test(scenes),
        cmocka_unit_test(meshes),
        cmocka_unit_test(bounds_lights_cameras),
        cmocka_unit_test(photons_and_images),
        cmocka_unit_test(empty_scenes),
        cmocka_unit_test(released_early),
    };
    return cmocka_run_group_tests_name("null", tests, NULL, NULL);
}
