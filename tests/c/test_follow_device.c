/* Flights of a scene followed on an OpenCL device and here: the same arrivals to the last bit, in media that need no
 * transcendental function, whatever the segments that work-items have. */
#include <stdlib.h>

#include "abuse.h"
#include "backend/native/follow.h"
#include "backend/opencl/follow.h"

#define FLIGHTS 4096

static const double wavelengths[3] = {450.0, 550.0, 650.0};

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }
static cpm_vec random_vector(void) {
    double x = 2.0 * uniform() - 1.0, y = 2.0 * uniform() - 1.0, z = 2.0 * uniform() - 1.0;
    return cpm_v(x, y, z);
}

/* A room of two walls and a floor with two balls in it, one of glass. */
static cpm_scene *room(cpm_context *context, cpm_medium *medium, int32_t method, double step, int bounded) {
    static const double half = 0.5;
    static const double vertices[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, -1, 1}, {-1, -1, 1},
                                          {-1, 1, -1},  {1, 1, -1},  {1, 1, 1},  {-1, 1, 1}};
    static const uint32_t faces[6][3] = {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {0, 4, 7}, {0, 7, 3}};
    const cpm_scene_options options = {.struct_size = sizeof options, .medium = medium, .method = method, .step = step};
    const cpm_material diffuse = {
        .struct_size = sizeof diffuse, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = flat(&half)};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = vertices[0],
                                .vertex_count = 8,
                                .faces = faces[0],
                                .face_count = 6,
                                .material = &diffuse,
                                .name = "walls"};
    cpm_scene *scene = NULL;
    int32_t index;
    assert_ok(context, cpm_scene_create(context, &options, &scene));
    assert_ok(context, cpm_scene_add_mesh(scene, &mesh, &index));
    assert_ok(context, cpm_scene_add_sphere(scene, (const double[3]){0.3, -0.5, 0.1}, 0.3, &diffuse, "ball", &index));
    if (bounded) {
        cpm_medium *glass = NULL, *bent = NULL;
        assert_ok(context, cpm_medium_create_homogeneous(context, 1.5, NULL, &glass));
        assert_ok(context,
                  cpm_medium_create_linear_squared(context, 1.8, (const double[3]){0, -0.3, 0}, origin, NULL, &bent));
        const cpm_bounds ball = {
            .struct_size = sizeof ball, .kind = CPM_BOUNDS_SPHERE, .center = {-0.4, 0, 0}, .radius = 0.3};
        const cpm_bounds box = {
            .struct_size = sizeof box, .kind = CPM_BOUNDS_BOX, .box = {{-0.5, -0.2, -0.2}, {0.1, 0.3, 0.6}}};
        assert_ok(context, cpm_scene_add_medium(scene, glass, &ball, &index));
        assert_ok(context, cpm_scene_add_medium(scene, bent, &box, &index));
        cpm_medium_release(glass), cpm_medium_release(bent);
    }
    return scene;
}

static void make_flights(const cpm_pass *pass, cpm_flight *flights) {
    for (int i = 0; i < FLIGHTS; i++) {
        cpm_flight *f = &flights[i];
        memset(f, 0, sizeof *f);
        f->position = cpm_scaled(i % 7 ? 0.95 : 3.0, random_vector());
        f->direction = cpm_unit(random_vector());
        f->region = cpm_region_at(pass, f->position, f->direction);
        f->left = i % 5 ? -1 : i % 6;
        f->bin = i % 4 - 1;
        f->exact = i % 11 == 0;
        f->crossing = i % 13 == 0;
    }
}

/* On the device, in `items` segments. */
static void on_device(const cpm_pass *pass, const cpm_flight *flights, size_t items, cpm_arrival *arrivals) {
    cpm_context *context = pass->context;
    const cpm_opencl *o = context->opencl;
    cpm_opencl_world world;
    cpm_opencl_follow_plan plan;
    const cl_int share = (cl_int)(FLIGHTS / items);
    cl_int counts[FLIGHTS], code;
    for (size_t i = 0; i < items; i++) counts[i] = share;
    assert_ok(context, cpm_opencl_world_open(pass, &world));
    assert_ok(context, cpm_opencl_follow_open(&world, &plan));
    cl_mem from = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, FLIGHTS * sizeof *flights, flights, &code);
    cl_mem to = cpm_opencl_buffer(o, CL_MEM_READ_WRITE, FLIGHTS * sizeof *arrivals, NULL, &code);
    cl_mem of = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, items * sizeof *counts, counts, &code);
    assert_int_equal(code, CL_SUCCESS);
    assert_int_equal(cpm_opencl_follow(&plan, from, to, of, items, share), CL_SUCCESS);
    assert_int_equal(
        o->cl->EnqueueReadBuffer(o->queue, to, CL_TRUE, 0, FLIGHTS * sizeof *arrivals, arrivals, 0, NULL, NULL),
        CL_SUCCESS);
    o->cl->ReleaseMemObject(from), o->cl->ReleaseMemObject(to), o->cl->ReleaseMemObject(of);
    cpm_opencl_follow_close(&plan);
    cpm_opencl_world_close(&world);
}

static int same(const cpm_arrival *a, const cpm_arrival *b, int boundaries) {
    return a->status == b->status && a->hit.primitive == b->hit.primitive &&
           !memcmp(&a->hit.position, &b->hit.position, sizeof a->hit.position) &&
           !memcmp(&a->direction, &b->direction, sizeof a->direction) && !memcmp(&a->n, &b->n, sizeof a->n) &&
           (a->status != CPM_RAY_HIT || (!memcmp(&a->hit.u, &b->hit.u, 2 * sizeof a->hit.u))) &&
           a->evaluations == b->evaluations && a->steps == b->steps && a->method == b->method &&
           (!boundaries || (a->behind.count == b->behind.count &&
                            !memcmp(a->behind.media, b->behind.media, a->behind.count * sizeof *a->behind.media)));
}

static void compare(cpm_medium *(*make)(cpm_context *), int32_t method, double step, int bounded) {
    cpm_context *context = new_context();
    cpm_medium *medium = make(context);
    cpm_scene *scene = room(context, medium, method, step, bounded);
    cpm_flight *flights = calloc(FLIGHTS, sizeof *flights);
    cpm_arrival *here = calloc(FLIGHTS, sizeof *here), *there = calloc(FLIGHTS, sizeof *there);
    const cpm_device_options options = {.struct_size = sizeof options};
    cpm_pass pass;
    assert_true(flights && here && there);
    srand(3);
    assert_ok(context, cpm_pass_begin(context, scene, wavelengths, 3, &pass));
    make_flights(&pass, flights);
    cpm_follow(&pass, flights, FLIGHTS, NULL, here);
    assert_ok(context, cpm_context_set_device(context, &options));
    int hits = 0;
    for (size_t items = 4; items <= 256; items *= 8) {
        memset(there, 0, FLIGHTS * sizeof *there);
        on_device(&pass, flights, items, there);
        for (int i = 0; i < FLIGHTS; i++) {
            hits += here[i].status == CPM_RAY_HIT;
            if (!same(&here[i], &there[i], bounded))
                fail_msg("flight %d: status %d and %d, primitive %d and %d, x %.17g and %.17g, n %.17g and %.17g", i,
                         here[i].status, there[i].status, here[i].hit.primitive, there[i].hit.primitive,
                         here[i].hit.position.x, there[i].hit.position.x, here[i].n, there[i].n);
        }
    }
    assert_true(hits > FLIGHTS / 2);
    cpm_pass_end(&pass);
    cpm_scene_release(scene);
    cpm_medium_release(medium);
    cpm_context_release(context);
    free(flights), free(here), free(there);
}

static cpm_medium *uniform_medium(cpm_context *context) {
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_homogeneous(context, 1.2, NULL, &medium));
    return medium;
}

static cpm_medium *linear_squared(cpm_context *context) {
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_linear_squared(context, 1.69, (const double[3]){0.05, -0.3, 0.02}, origin,
                                                        NULL, &medium));
    return medium;
}

static cpm_medium *layered(cpm_context *context, int32_t interpolation) {
    static const double heights[5] = {-1.0, -0.5, 0.0, 0.6, 1.1}, n[5] = {1.3, 1.35, 1.25, 1.2, 1.1};
    const cpm_layered_desc desc = {.struct_size = sizeof desc,
                                   .heights = heights,
                                   .n = n,
                                   .count = 5,
                                   .up = {0, 1, 0},
                                   .interpolation = interpolation};
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_layered(context, &desc, NULL, &medium));
    return medium;
}
static cpm_medium *layers(cpm_context *context) { return layered(context, CPM_INTERPOLATION_LINEAR_SQUARED); }
static cpm_medium *cubic_layers(cpm_context *context) { return layered(context, CPM_INTERPOLATION_CUBIC); }

static void straight(void **state) {
    (void)state;
    compare(uniform_medium, CPM_METHOD_AUTO, 0.0, 0);
}
static void parabolas(void **state) {
    (void)state;
    compare(linear_squared, CPM_METHOD_AUTO, 0.0, 0);
}
static void pieces(void **state) {
    (void)state;
    compare(layers, CPM_METHOD_AUTO, 0.0, 0);
}
static void integrated(void **state) {
    (void)state;
    compare(cubic_layers, CPM_METHOD_AUTO, 0.0, 0);
    compare(linear_squared, CPM_METHOD_RK4, 0.05, 0);
    compare(linear_squared, CPM_METHOD_ADAMS, 0.0, 0);
}
static void bounded(void **state) {
    (void)state;
    compare(uniform_medium, CPM_METHOD_AUTO, 0.0, 1);
    compare(linear_squared, CPM_METHOD_AUTO, 0.0, 1);
    compare(cubic_layers, CPM_METHOD_AUTO, 0.0, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(straight),   cmocka_unit_test(parabolas), cmocka_unit_test(pieces),
        cmocka_unit_test(integrated), cmocka_unit_test(bounded),
    };
    setenv("CPM_CACHE_DIR", "", 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
