/* Curves' hits on an OpenCL device and here: one walk in two compilers, the same bits. Slivers, grazing curves, curves
 * along faces and through shared edges, spheres, and a mesh of 1e5 triangles. */
#include <stdlib.h>

#include "abuse.h"
#include "backend/opencl/hits.h"
#include "geometry/geometry.h"

#define CURVES 20000

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }
static cpm_vec random_point(double size) {
    double x = size * (2.0 * uniform() - 1.0), y = size * (2.0 * uniform() - 1.0), z = size * (2.0 * uniform() - 1.0);
    return cpm_v(x, y, z);
}

static void set_triangle(cpm_triangle *t, cpm_vec a, cpm_vec b, cpm_vec c) {
    memset(t, 0, sizeof *t);
    t->corner[0] = a.x, t->corner[1] = a.y, t->corner[2] = a.z;
    t->edge1[0] = b.x - a.x, t->edge1[1] = b.y - a.y, t->edge1[2] = b.z - a.z;
    t->edge2[0] = c.x - a.x, t->edge2[1] = c.y - a.y, t->edge2[2] = c.z - a.z;
    assert_true(cpm_triangle_complete(t, 2.0));
}

static cpm_vec on_ball(int i, int j, int n, double radius) {
    const double pi = 3.14159265358979323846, polar = pi * (0.02 + 0.96 * i / n), around = 2.0 * pi * (j % n) / n;
    return cpm_v(radius * sin(polar) * cos(around), radius * cos(polar), radius * sin(polar) * sin(around));
}

/* A sphere of 2 n^2 triangles that share all their corners. */
static size_t ball(cpm_triangle *t, int n) {
    size_t count = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            cpm_vec a = on_ball(i, j, n, 1.0), b = on_ball(i + 1, j, n, 1.0), c = on_ball(i, j + 1, n, 1.0),
                    d = on_ball(i + 1, j + 1, n, 1.0);
            set_triangle(&t[count++], a, b, c);
            set_triangle(&t[count++], c, b, d);
        }
    return count;
}

static size_t slivers(cpm_triangle *t, int n) {
    for (int i = 0; i < n; i++) {
        cpm_vec a = random_point(1.0), b = cpm_add(a, random_point(0.4)), c = cpm_add(a, random_point(0.4));
        if (i % 3 == 0) c = cpm_along(cpm_along(a, uniform(), cpm_sub(b, a)), 1e-5, random_point(1.0));
        set_triangle(&t[i], a, b, c);
    }
    return (size_t)n;
}

static void compare(size_t (*make)(cpm_triangle *, int), int n, size_t room, size_t least_hits) {
    cpm_triangle *triangles = malloc(room * sizeof *triangles);
    cpm_curve *curves = calloc(CURVES, sizeof *curves);
    int32_t *left = malloc(CURVES * sizeof *left);
    cpm_hit *device = calloc(CURVES, sizeof *device);
    const cpm_sphere spheres[2] = {{{0.2, 0.1, 0.0}, 0.2}, {{-0.3, 0.4, 0.3}, 0.15}};
    assert_true(triangles && curves && left && device);
    srand(11);
    const size_t count = make(triangles, n);
    cpm_context *context = new_context();
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, triangles, count, spheres, 2, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 0, 1));
    for (int i = 0; i < CURVES; i++) {
        const cpm_triangle *t = &triangles[(size_t)(uniform() * (double)count)];
        const cpm_vec corner = cpm_v(t->corner[0], t->corner[1], t->corner[2]);
        const cpm_vec e1 = cpm_v(t->edge1[0], t->edge1[1], t->edge1[2]),
                      e2 = cpm_v(t->edge2[0], t->edge2[1], t->edge2[2]);
        cpm_curve *k = &curves[i];
        k->degree = i % 3 == 0 ? 1 : i % 3 == 1 ? 2 : 5;
        left[i] = -1;
        k->c[0] = random_point(1.5), k->c[1] = random_point(3.0);
        for (int c = 2; c <= k->degree; c++) k->c[c] = random_point((i % 2 ? 1.0 : 0.05) / c);
        switch (i % 5) {
        case 0: k->c[1] = cpm_sub(corner, k->c[0]); break;                     /* at a corner that triangles share */
        case 1: k->c[1] = cpm_sub(cpm_along(corner, 0.5, e1), k->c[0]); break; /* at an edge */
        case 2: k->c[0] = cpm_along(corner, -1.0, e1), k->c[1] = cpm_scaled(3.0, e1); break; /* along a face */
        case 3:                                                                              /* off a triangle */
            left[i] = (int32_t)(t - triangles);
            k->c[0] = cpm_along(cpm_along(corner, 0.3, e1), 0.3, e2);
            break;
        default: break;
        }
    }
    const cpm_device_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_context_set_device(context, &options));
    assert_ok(context, cpm_opencl_hits(context, g, curves, left, CURVES, 1.0, device));
    size_t hits = 0;
    for (int i = 0; i < CURVES; i++) {
        cpm_hit here;
        cpm_geometry_curve(g, &curves[i], 1.0, left[i], 0.0, NULL, &here);
        assert_int_equal(device[i].primitive, here.primitive);
        if (here.primitive < 0) continue;
        hits++;
        assert_memory_equal(&device[i].t, &here.t, sizeof here.t);
        assert_memory_equal(&device[i].u, &here.u, sizeof here.u);
        assert_memory_equal(&device[i].v, &here.v, sizeof here.v);
        assert_memory_equal(&device[i].position, &here.position, sizeof here.position);
    }
    assert_true(hits > least_hits);
    cpm_geometry_free(g);
    cpm_context_release(context);
    free(triangles), free(curves), free(left), free(device);
}

static void slivers_and_grazing_curves(void **state) {
    (void)state;
    compare(slivers, 800, 800, CURVES / 3);
}

static void a_mesh_of_1e5_triangles(void **state) {
    (void)state;
    compare(ball, 224, 2 * 224 * 224, CURVES / 2);
}

static void a_scene_of_nothing_has_no_hits(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_geometry *g;
    cpm_curve curve = {.degree = 1};
    cpm_hit hit = {.primitive = 7};
    const int32_t left = -1;
    const cpm_device_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_geometry_create(context, NULL, 0, NULL, 0, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 0, 1));
    assert_ok(context, cpm_context_set_device(context, &options));
    assert_ok(context, cpm_opencl_hits(context, g, &curve, &left, 1, 1.0, &hit));
    assert_int_equal(hit.primitive, -1);
    cpm_geometry_free(g);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slivers_and_grazing_curves),
        cmocka_unit_test(a_mesh_of_1e5_triangles),
        cmocka_unit_test(a_scene_of_nothing_has_no_hits),
    };
    setenv("CPM_CACHE_DIR", "", 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
