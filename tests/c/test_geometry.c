/* Hits of straight and curved rays against brute force in long double over every primitive; nothing gets through a
 * wall. */
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry/geometry.h"

#define TRIANGLES 400

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }
static cpm_vec random_point(double size) {
    double x = size * (2.0 * uniform() - 1.0), y = size * (2.0 * uniform() - 1.0), z = size * (2.0 * uniform() - 1.0);
    return cpm_v(x, y, z);
}

static void random_triangles(cpm_triangle *t, size_t count, double size) {
    for (size_t i = 0; i < count; i++) {
        cpm_vec a = random_point(1.0), b = random_point(size), c = random_point(size);
        memset(&t[i], 0, sizeof t[i]);
        t[i].corner[0] = a.x, t[i].corner[1] = a.y, t[i].corner[2] = a.z;
        t[i].edge1[0] = b.x, t[i].edge1[1] = b.y, t[i].edge1[2] = b.z;
        t[i].edge2[0] = c.x, t[i].edge2[1] = c.y, t[i].edge2[2] = c.z;
        assert_true(cpm_triangle_complete(&t[i], 2.0));
    }
}

/* First crossing by marching the curve in small steps and halving, for one triangle; > 1: none. */
static long double march(const cpm_curve *k, const cpm_triangle *t, double from) {
    const int steps = 4000;
    long double previous = 0.0L, at = from;
    for (int i = 0; i <= steps; i++) {
        long double theta = from + (1.0L - from) * i / steps;
        cpm_vec r = cpm_curve_at(k, (double)theta);
        long double f = ((long double)r.x - t->corner[0]) * t->normal[0] +
                        ((long double)r.y - t->corner[1]) * t->normal[1] +
                        ((long double)r.z - t->corner[2]) * t->normal[2];
        if (i && previous * f < 0.0L) {
            double u, v, low = (double)at, high = (double)theta;
            for (int h = 0; h < 60; h++) {
                double middle = 0.5 * (low + high);
                cpm_vec m = cpm_curve_at(k, middle);
                double g = (m.x - t->corner[0]) * t->normal[0] + (m.y - t->corner[1]) * t->normal[1] +
                           (m.z - t->corner[2]) * t->normal[2];
                if ((g < 0.0) == (previous < 0.0L))
                    low = middle;
                else
                    high = middle;
            }
            if (cpm_triangle_contains(t, cpm_curve_at(k, low), &u, &v)) return low;
        }
        previous = f;
        at = theta;
    }
    return 2.0L;
}

static cpm_curve random_curve(int degree, double bend) {
    cpm_curve k = {.degree = degree};
    k.c[0] = random_point(1.2);
    k.c[1] = random_point(2.0);
    for (int i = 2; i <= degree; i++) k.c[i] = random_point(bend / i);
    return k;
}

static void curves_meet_what_brute_force_meets(void **state) {
    (void)state;
    cpm_triangle triangles[TRIANGLES];
    cpm_context *context = new_context();
    srand(2);
    random_triangles(triangles, TRIANGLES, 0.3);
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, triangles, TRIANGLES, NULL, 0, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 1, 1));
    int hits = 0;
    for (int trial = 0; trial < 120; trial++) {
        cpm_curve k = random_curve(trial % 2 ? 2 : 5, trial % 3 ? 1.0 : 0.05);
        cpm_hit hit;
        cpm_geometry_curve(g, &k, 1.0, -1, 0.0, NULL, &hit);
        long double best = 2.0L;
        for (size_t i = 0; i < TRIANGLES; i++) {
            long double t = march(&k, &triangles[i], 0.0);
            if (t < best) best = t;
        }
        if (best > 1.0L) {
            assert_int_equal(hit.primitive, -1);
            continue;
        }
        hits++;
        assert_true(hit.primitive >= 0);
        assert_true(fabsl(hit.t - best) < 1e-12L);
    }
    assert_true(hits > 40);
    cpm_geometry_free(g);
    cpm_context_release(context);
}

/* The tree walk is float: slivers, nanometres and planets must not be where that shows. */
static void the_walk_finds_what_every_primitive_asked_alone_says(void **state) {
    (void)state;
    static const double scales[] = {1e-9, 1.0, 6.4e6};
    enum { SLIVERS = 3000, CURVES = 3000 };
    cpm_triangle *triangles = malloc(SLIVERS * sizeof *triangles);
    cpm_sphere spheres[20];
    cpm_context *context = new_context();
    assert_non_null(triangles);
    srand(8);
    for (size_t scale = 0; scale < 3; scale++) {
        const double size = scales[scale];
        const cpm_vec away = cpm_v(3.0 * size, -size, 7.0 * size);
        for (size_t i = 0; i < SLIVERS; i++) {
            double thin = i % 3 ? 1.0 : pow(10.0, -6.0 * uniform());
            cpm_vec a = cpm_add(away, random_point(size)), b = random_point(0.2 * size),
                    c = cpm_add(cpm_scaled(uniform(), b), cpm_scaled(thin, random_point(0.2 * size)));
            memset(&triangles[i], 0, sizeof triangles[i]);
            triangles[i].corner[0] = a.x, triangles[i].corner[1] = a.y, triangles[i].corner[2] = a.z;
            triangles[i].edge1[0] = b.x, triangles[i].edge1[1] = b.y, triangles[i].edge1[2] = b.z;
            triangles[i].edge2[0] = c.x, triangles[i].edge2[1] = c.y, triangles[i].edge2[2] = c.z;
            assert_true(cpm_triangle_complete(&triangles[i], 10.0 * size));
        }
        for (size_t i = 0; i < 20; i++) {
            cpm_vec c = cpm_add(away, random_point(size));
            spheres[i] = (cpm_sphere){{c.x, c.y, c.z}, 0.1 * size * uniform()};
        }
        cpm_geometry *g;
        assert_ok(context, cpm_geometry_create(context, triangles, SLIVERS, spheres, 20, &g));
        assert_ok(context, cpm_geometry_prepare(context, g, 0, 1));
        int hits = 0, on_left = 0;
        for (int trial = 0; trial < CURVES; trial++) {
            cpm_curve k = random_curve(trial % 3 ? 2 : 5, trial % 4 ? 0.3 : 3.0);
            int32_t left = trial % 5 ? -1 : trial % SLIVERS;
            for (int i = 0; i <= k.degree; i++) k.c[i] = cpm_scaled(size, k.c[i]);
            k.c[0] = cpm_add(k.c[0], away);
            if (left >= 0) { /* on that triangle */
                const cpm_triangle *t = &triangles[left];
                k.c[0] = cpm_v(t->corner[0] + 0.3 * t->edge1[0] + 0.3 * t->edge2[0],
                               t->corner[1] + 0.3 * t->edge1[1] + 0.3 * t->edge2[1],
                               t->corner[2] + 0.3 * t->edge1[2] + 0.3 * t->edge2[2]);
                if (k.degree == 2) k.c[2] = cpm_scaled(-1.02, k.c[1]); /* and back */
            }
            double best = 2.0, u, v, from = 0.0;
            int32_t primitive = -1;
            for (size_t i = 0; i < SLIVERS + 20; i++) {
                double t = i < SLIVERS ? cpm_curve_triangle(&k, &triangles[i], (int32_t)i == left, 0.0, 1.0, &u, &v)
                                       : cpm_curve_sphere(&k, &spheres[i - SLIVERS], 0, 0.0, 1.0);
                if (t > 0.0 && t < best) best = t, primitive = (int32_t)i;
            }
            cpm_hit one, many;
            cpm_geometry_curve(g, &k, 1.0, left, 0.0, NULL, &one);
            cpm_geometry_curves(g, &k, &from, &left, 1, &many);
            hits += primitive >= 0, on_left += primitive >= 0 && primitive == left;
            assert_int_equal(one.primitive, primitive);
            assert_int_equal(many.primitive, primitive);
            if (primitive < 0) continue;
            assert_true(fabs(one.t - best) <= 1e-11 * best + 1e-13);
            assert_true(fabs(many.t - best) <= 1e-11 * best + 1e-13);
            assert_true(cpm_norm(cpm_sub(many.position, cpm_curve_at(&k, many.t))) == 0.0);
        }
        assert_true(hits > CURVES / 3);
        assert_true(on_left > 0);
        cpm_geometry_free(g);
    }
    free(triangles);
    cpm_context_release(context);
}

/* A curve that comes from far outside: what lies before `from` need not be looked at. */
static void curves_from_outside_are_asked_where_the_box_is(void **state) {
    (void)state;
    cpm_triangle triangles[TRIANGLES];
    cpm_context *context = new_context();
    srand(9);
    random_triangles(triangles, TRIANGLES, 0.3);
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, triangles, TRIANGLES, NULL, 0, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 0, 1));
    cpm_curve curves[200];
    double from[200];
    int32_t left[200];
    cpm_hit hits[200], one;
    int met = 0;
    for (int i = 0; i < 200; i++) {
        cpm_vec d = cpm_unit(random_point(1.0)), at = random_point(0.7);
        memset(&curves[i], 0, sizeof curves[i]);
        curves[i].degree = 2;
        curves[i].c[2] = random_point(0.5);
        curves[i].c[1] = cpm_sub(cpm_scaled(10.0, d), curves[i].c[2]); /* at theta = 1/2 through the middle of things */
        curves[i].c[0] = cpm_sub(at, cpm_add(cpm_scaled(0.5, curves[i].c[1]), cpm_scaled(0.25, curves[i].c[2])));
        from[i] = 0.1, left[i] = -1;
    }
    cpm_geometry_curves(g, curves, from, left, 200, hits);
    for (int i = 0; i < 200; i++) {
        cpm_geometry_curve(g, &curves[i], 1.0, -1, 0.0, NULL, &one);
        assert_int_equal(hits[i].primitive, one.primitive);
        if (one.primitive >= 0) assert_true(fabs(hits[i].t - one.t) < 1e-13);
        met += one.primitive >= 0;
    }
    assert_true(met > 50);
    cpm_geometry_free(g);
    cpm_context_release(context);
}

static void straight_rays_agree_with_the_curve_scene(void **state) {
    (void)state;
    cpm_triangle triangles[TRIANGLES];
    const cpm_sphere spheres[2] = {{{0.3, 0.1, -0.2}, 0.4}, {{-0.5, 0.4, 0.5}, 0.25}};
    cpm_context *context = new_context();
    srand(3);
    random_triangles(triangles, TRIANGLES, 0.2);
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, triangles, TRIANGLES, spheres, 2, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 1, 1));
    int differ = 0, on_sphere = 0;
    for (int trial = 0; trial < 20000; trial++) {
        cpm_vec o = random_point(1.5), d = cpm_unit(random_point(1.0));
        cpm_hit fast, exact;
        cpm_geometry_straight(g, o, d, -1, 0.0, NULL, 0, &fast);
        cpm_geometry_straight(g, o, d, -1, 0.0, NULL, 1, &exact);
        on_sphere += exact.primitive >= TRIANGLES;
        if (fast.primitive != exact.primitive)
            differ++; /* within float of an edge */
        else if (fast.primitive >= 0)
            assert_true(fabs(fast.t - exact.t) < 1e-12 * (1.0 + fast.t));
    }
    assert_true(differ <= 2);
    assert_true(on_sphere > 100);
    cpm_geometry_free(g);
    cpm_context_release(context);
}

static void a_ray_leaves_the_sphere_it_starts_on_and_meets_it_again(void **state) {
    (void)state;
    const cpm_sphere sphere = {{0.0, 0.0, 0.0}, 1.0};
    cpm_context *context = new_context();
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, NULL, 0, &sphere, 1, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 1, 1));
    srand(4);
    for (int trial = 0; trial < 2000; trial++) {
        cpm_vec n = cpm_unit(random_point(1.0)), d = cpm_unit(random_point(1.0));
        double c = -cpm_vdot(n, d);
        cpm_hit hit;
        cpm_geometry_straight(g, n, d, 0, 0.0, NULL, trial % 2, &hit);
        if (c > 1e-6) { /* inward: the far side, 2 cos theta away */
            assert_int_equal(hit.primitive, 0);
            assert_true(fabs(hit.t - 2.0 * c) < 1e-12);
        } else if (c < -1e-6) {
            assert_int_equal(hit.primitive, -1);
        }
    }
    cpm_geometry_free(g);
    cpm_context_release(context);
}

/* A parabola thrown up from a triangle falls back on it. */
static void a_curve_falls_back_on_the_triangle_that_it_left(void **state) {
    (void)state;
    cpm_triangle floor = {.edge1 = {0, 0, 10}, .edge2 = {10, 0, 0}};
    cpm_context *context = new_context();
    cpm_geometry *g;
    assert_true(cpm_triangle_complete(&floor, 10.0));
    assert_ok(context, cpm_geometry_create(context, &floor, 1, NULL, 0, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 0, 1));
    cpm_curve k = {.degree = 2};
    k.c[0] = cpm_v(1.0, 0.0, 1.0), k.c[1] = cpm_v(1.0, 3.0, 0.5), k.c[2] = cpm_v(0.0, -4.0, 0.0);
    cpm_hit hit;
    cpm_geometry_curve(g, &k, 1.0, 0, 0.0, NULL, &hit);
    assert_int_equal(hit.primitive, 0);
    assert_true(fabs(hit.t - 0.75) < 1e-15);
    cpm_geometry_free(g);
    cpm_context_release(context);
}

/* A closed box, rays bounced about inside it at random, aimed at edges and corners too: not one may get out. */
static void nothing_leaves_a_closed_box(void **state) {
    (void)state;
    static const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    cpm_triangle triangles[12];
    for (int i = 0; i < 12; i++) {
        double c[3][3];
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) c[k][axis] = (faces[i][k] >> axis & 1 ? 1.7 : -1.3) + 0.1 * axis;
        memset(&triangles[i], 0, sizeof triangles[i]);
        for (int axis = 0; axis < 3; axis++) {
            triangles[i].corner[axis] = c[0][axis];
            triangles[i].edge1[axis] = c[1][axis] - c[0][axis];
            triangles[i].edge2[axis] = c[2][axis] - c[0][axis];
        }
        assert_true(cpm_triangle_complete(&triangles[i], 2.0));
    }
    cpm_context *context = new_context();
    cpm_geometry *g;
    assert_ok(context, cpm_geometry_create(context, triangles, 12, NULL, 0, &g));
    assert_ok(context, cpm_geometry_prepare(context, g, 1, 1));
    srand(5);
    for (int curved = 0; curved < 2; curved++) {
        cpm_vec at = cpm_v(0.1, 0.2, 0.3);
        int32_t left = -1, near_edge = 0;
        for (int i = 0; i < 300000; i++) {
            cpm_vec d = cpm_unit(random_point(1.0));
            int walls = (at.x < -1.3 + 1e-3) + (at.x > 1.7 - 1e-3) + (at.y < -1.2 + 1e-3) + (at.y > 1.8 - 1e-3) +
                        (at.z < -1.1 + 1e-3) + (at.z > 1.9 - 1e-3);
            if (i % 3 == 0 && walls < 2) { /* at a corner or an edge, but not from right beside it, grazing */
                double x = i % 2 ? 1.7 : -1.3, y = i % 5 > 2 ? 1.8 : -1.2, z = i % 7 ? 1.9 : -1.1 + 3.0 * uniform();
                d = cpm_sub(cpm_v(x, y, z), at);
                if (!(cpm_norm(d) > 1e-9)) continue;
                d = cpm_unit(d);
            }
            if (left >= 0) { /* into the box */
                const double *n = triangles[left].normal;
                if (d.x * n[0] + d.y * n[1] + d.z * n[2] > 0.0) d = cpm_scaled(-1.0, d);
            }
            cpm_hit hit;
            cpm_curve k = {.degree = 2};
            if (curved) {
                k.c[0] = at, k.c[1] = cpm_scaled(20.0, d), k.c[2] = cpm_v(0.0, -9.0, 3.0);
                cpm_geometry_curve(g, &k, 1.0, left, 0.0, NULL, &hit);
            } else {
                cpm_geometry_straight(g, at, d, left, 0.0, NULL, near_edge, &hit);
            }
            assert_true(hit.primitive >= 0);
            at = cpm_geometry_step_back(g, &hit, at, curved ? cpm_unit(cpm_curve_tangent(&k, hit.t)) : d);
            left = hit.primitive;
            near_edge = cpm_geometry_near_edge(g, &hit);
        }
    }
    cpm_geometry_free(g);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_meet_what_brute_force_meets),
        cmocka_unit_test(the_walk_finds_what_every_primitive_asked_alone_says),
        cmocka_unit_test(curves_from_outside_are_asked_where_the_box_is),
        cmocka_unit_test(straight_rays_agree_with_the_curve_scene),
        cmocka_unit_test(a_ray_leaves_the_sphere_it_starts_on_and_meets_it_again),
        cmocka_unit_test(a_curve_falls_back_on_the_triangle_that_it_left),
        cmocka_unit_test(nothing_leaves_a_closed_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
