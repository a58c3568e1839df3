/* test_null_scene.c: scenes, shapes, bounds, lights and cameras given nonsense. See abuse.h. */
#include "abuse.h"

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
    const int32_t kinds[] = {-1, 0, 6, INT32_MAX};
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

static void far_lights(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *s = plain_scene(context);
    const double one = 1.0, wavelengths[2] = {500, 600};
    const double limb[2][7] = {{500, 1}, {600, 0.5, 0.5}};
    const float pixels[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const cpm_box box = {{0, 0, 0}, {1, 1, 1}}, flat_box = {{0, 0, 0}, {1, 0, 1}};
    const cpm_light_desc sun = {.struct_size = sizeof sun,
                                .kind = CPM_LIGHT_SUN,
                                .target = {0, 3, 4},
                                .emission = flat(&one),
                                .limb = limb[0],
                                .limb_count = 2,
                                .aim = &box};
    const cpm_light_desc sky = {.struct_size = sizeof sky,
                                .kind = CPM_LIGHT_ENVIRONMENT,
                                .target = {0, 0, -1},
                                .up = {0, 1, 0},
                                .emission = {wavelengths, NULL, 2},
                                .pixels = pixels,
                                .width = 2,
                                .height = 2};
    cpm_light_desc l = {.struct_size = sizeof l, .kind = CPM_LIGHT_ENVIRONMENT, .emission = flat(&one)};
    int32_t index;
    assert_ok(context, cpm_scene_add_light(s, &sun, NULL));
    assert_ok(context, cpm_scene_add_light(s, &sky, NULL));
    assert_ok(context, cpm_scene_add_light(s, &l, &index));
    assert_int_equal(index, 3);
    l.struct_size = offsetof(cpm_light_desc, up); /* a caller from before there was a sky */
    assert_ok(context, cpm_scene_add_light(s, &l, NULL));
    const double radii[] = {NAN, INFINITY, -1.0, 90.0};
    for (size_t i = 0; i < COUNT_OF(radii); i++) {
        l = sun, l.cutoff = radii[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    l = sun, l.target[1] = l.target[2] = 0.0;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = sun, l.limb_count = 0;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = sun, l.aim = &flat_box;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    const double falling[2][7] = {{600, 1}, {500, 1}}, no_number[1][7] = {{500, NAN}};
    l = sun, l.limb = falling[0];
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = sun, l.limb = no_number[0], l.limb_count = 1;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    const int32_t sizes[] = {-1, 0, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        l = sky, l.width = l.height = sizes[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    l = sky, l.emission.wavelengths = NULL;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = sky, l.emission.count = 0;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    const float bad_pixels[3][8] = {{-1}, {0, NAN}, {0, 0, INFINITY}};
    for (size_t i = 0; i < COUNT_OF(bad_pixels); i++) {
        l = sky, l.pixels = bad_pixels[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    l = sky, l.up[1] = 0.0;
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    l = sky, l.target[1] = 5.0, l.target[2] = 0.0; /* along up */
    assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        l = sun, l.target[1] = not_numbers[i];
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
        l = sun, l.emission = flat(&not_numbers[i]);
        assert_status(context, REFUSED, cpm_scene_add_light(s, &l, &index));
    }
    cpm_scene_release(s);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes),
        cmocka_unit_test(far_lights),
        cmocka_unit_test(meshes),
        cmocka_unit_test(bounds_lights_cameras),
    };
    return cmocka_run_group_tests_name("null_scene", tests, NULL, NULL);
}
