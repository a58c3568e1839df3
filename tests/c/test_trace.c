/* test_trace.c: rays alone in a medium against closed forms written out here, their statuses, and the two interfaces of
 * backend/native/advance.h that the scene tracer uses. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "backend/native/advance.h"
#include "check.h"
#include "cl/shared/elementary.h"
#include "medium/medium.h"

static const double zero[3] = {0, 0, 0}, down[3] = {0, -0.1, 0};

typedef struct one_ray {
    double position[3], direction[3], momentum[3], length, path, drift, error;
    int64_t evaluations, steps;
    int32_t status, method;
} one_ray;

static cpm_rays_request request_of(const double *r, const double *d, const double *length, int32_t method) {
    static const double wavelength = 550.0;
    return (cpm_rays_request){.struct_size = sizeof(cpm_rays_request),
                              .count = 1,
                              .origins = r,
                              .directions = d,
                              .wavelengths = &wavelength,
                              .lengths = length,
                              .method = method};
}
static cpm_status run(cpm_context *context, const cpm_medium *m, const cpm_rays_request *q, one_ray *out) {
    cpm_rays_result result = {.struct_size = sizeof result,
                              .position = out->position,
                              .direction = out->direction,
                              .momentum = out->momentum,
                              .length = &out->length,
                              .optical_path = &out->path,
                              .drift = &out->drift,
                              .error_estimate = &out->error,
                              .evaluations = &out->evaluations,
                              .steps = &out->steps,
                              .status = &out->status,
                              .method = &out->method};
    return cpm_rays_trace(context, m, NULL, q, &result);
}
static one_ray trace(cpm_context *context, const cpm_medium *m, const double *r, const double *d, double length,
                     int32_t method, double rtol) {
    cpm_rays_request q = request_of(r, d, &length, method);
    one_ray out;
    q.rtol = rtol;
    assert_ok(context, run(context, m, &q, &out));
    return out;
}
static void assert_near3(const double a[3], double x, double y, double z, double tolerance) {
    if (!(fabs(a[0] - x) <= tolerance && fabs(a[1] - y) <= tolerance && fabs(a[2] - z) <= tolerance))
        fail_msg("(%.17g, %.17g, %.17g) is not (%.17g, %.17g, %.17g) to %g", a[0], a[1], a[2], x, y, z, tolerance);
}
static void assert_near(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.17g is not %.17g to %g", a, b, tolerance);
}

/* Straight, with no evaluation, whatever the method. */
static void test_straight(void **state) {
    cpm_context *context = *state;
    cpm_medium *m = NULL;
    assert_ok(context, cpm_medium_create_homogeneous(context, 1.5, NULL, &m));
    const double r[3] = {1, 2, 3}, d[3] = {0, 3, 4};
    for (int32_t method = CPM_METHOD_AUTO; method <= CPM_METHOD_DOPRI5; method++) {
        one_ray a = trace(context, m, r, d, 10.0, method, 0.0);
        assert_near3(a.position, 1, 8, 11, 1e-14);
        assert_near3(a.momentum, 0, 0.9, 1.2, 1e-15);
        assert_near(a.path, 15.0, 1e-14);
        assert_int_equal(a.evaluations, 0);
        assert_int_equal(a.status, CPM_RAY_ARRIVED);
        assert_int_equal(a.method, CPM_METHOD_EXACT);
    }
    cpm_medium_release(m);
}

/* n^2 = 1.69 - 0.1 y, thrown level: y = -0.025 x^2/n0^2; its arc length is the parabola's. */
static void test_parabola(void **state) {
    cpm_context *context = *state;
    cpm_medium *m = NULL;
    assert_ok(context, cpm_medium_create_linear_squared(context, 1.69, down, NULL, NULL, &m));
    const double d[3] = {1, 0, 0}, k = -0.025 / 1.69, x = 4.0, u = 2 * k * x;
    const double length = x * 0.5 * (sqrt(1 + u * u) + asinh(u) / u);
    one_ray a = trace(context, m, zero, d, length, CPM_METHOD_AUTO, 0.0);
    assert_near3(a.position, x, k * x * x, 0, 2e-15);
    assert_int_equal(a.evaluations, 0);
    assert_int_equal(a.method, CPM_METHOD_EXACT);
    one_ray b = trace(context, m, zero, d, length, CPM_METHOD_DOPRI5, 1e-9);
    assert_near3(b.position, x, k * x * x, 0, 1e-9 * length);
    assert_near(b.momentum[0], 1.3, 1e-15);
    assert_true(b.evaluations > 0 && b.method == CPM_METHOD_DOPRI5);
    one_ray c = trace(context, m, zero, d, length, CPM_METHOD_EULER, 0.0);
    assert_near3(c.position, x, k * x * x, 0, 1e-2 * length);
    cpm_medium_release(m);
}

/* n sin(angle to up) is the same all along in every layered medium, also past a turning point. */
static void test_snell(void **state) {
    cpm_context *context = *state;
    double heights[41], n[41];
    for (int i = 0; i < 41; i++) heights[i] = -2.0 + 0.1 * i, n[i] = 1.25 - 0.2 * tanh(2 * heights[i]);
    cpm_layered_desc desc = {.struct_size = sizeof desc, .heights = heights, .n = n, .count = 41};
    const double r[3] = {0, -1, 0};
    for (int32_t kind = CPM_INTERPOLATION_CUBIC; kind <= CPM_INTERPOLATION_STEP; kind++) {
        cpm_medium *m = NULL;
        desc.interpolation = kind;
        assert_ok(context, cpm_medium_create_layered(context, &desc, NULL, &m));
        for (int angle = 5; angle < 90; angle += 5) {
            const double a = angle * 3.14159265358979324 / 180, d[3] = {sin(a), cos(a), 0};
            double start = cpm_medium_n_toward(m, 1.0, r, d);
            one_ray end = trace(context, m, r, d, 20.0, CPM_METHOD_AUTO, 1e-8);
            assert_int_equal(end.status, CPM_RAY_ARRIVED);
            assert_near(end.momentum[0], start * sin(a), 1e-14);
            double there = cpm_medium_n_toward(m, 1.0, end.position, end.direction);
            double size = sqrt(end.momentum[0] * end.momentum[0] + end.momentum[1] * end.momentum[1]);
            assert_near(size, there, kind == CPM_INTERPOLATION_CUBIC ? 1e-6 : 1e-13);
            int upward = end.direction[1] > 0, turns = start * sin(a) > n[40] + 0.05,
                passes = start * sin(a) < n[40] - 0.01;
            if ((turns && upward) || (passes && !upward))
                fail_msg("interpolation %d, %d degrees: ends %s", (int)kind, angle, upward ? "up" : "down");
        }
        cpm_medium_release(m);
    }
}

/* There and back: the path reversed ends where it began. */
static void test_reversal(void **state) {
    cpm_context *context = *state;
    cpm_medium *m = NULL;
    const double g[3] = {0.03, -0.08, 0.05}, d[3] = {1, 0.5, -0.2};
    assert_ok(context, cpm_medium_create_linear(context, 1.3, g, NULL, NULL, &m));
    for (int32_t method = CPM_METHOD_EXACT; method <= CPM_METHOD_DOPRI5;
         method += CPM_METHOD_DOPRI5 - CPM_METHOD_EXACT) {
        one_ray a = trace(context, m, zero, d, 3.0, method, 1e-10);
        const double back[3] = {-a.direction[0], -a.direction[1], -a.direction[2]};
        one_ray b = trace(context, m, a.position, back, 3.0, method, 1e-10);
        assert_near3(b.position, 0, 0, 0, method == CPM_METHOD_EXACT ? 4e-15 : 6e-10);
        assert_near(a.path, b.path, 1e-9);
    }
    cpm_medium_release(m);
}

/* Cut-off at normal incidence on n = 0, a bound on evaluations, a plane that is not there: each ends, finite. */
static void test_statuses(void **state) {
    cpm_context *context = *state;
    cpm_medium *m = NULL, *bump = NULL;
    const double g[3] = {0, -1, 0}, up[3] = {0, 1, 0}, slanted[3] = {1, 1, 0}, plane[3] = {0, 0.9, 0};
    assert_ok(context, cpm_medium_create_linear_squared(context, 1.0, g, NULL, NULL, &m));
    for (int32_t method = CPM_METHOD_EXACT; method <= CPM_METHOD_DOPRI5;
         method += CPM_METHOD_DOPRI5 - CPM_METHOD_EXACT) {
        one_ray a = trace(context, m, zero, up, 3.0, method, 1e-8);
        assert_int_equal(a.status, CPM_RAY_CUTOFF);
        assert_near3(a.position, 0, 1, 0, 1e-6);
        assert_near(a.length, 1.0, 1e-6);
        assert_true(a.evaluations < 500);
        one_ray turned = trace(context, m, zero, slanted, 3.0, method, 1e-8);
        assert_int_equal(turned.status, CPM_RAY_ARRIVED);
        assert_true(turned.direction[1] < 0);

        cpm_rays_request q = request_of(zero, slanted, NULL, method);
        q.plane_point = plane, q.plane_normal = up; /* the ray turns at y = 0.5 */
        q.max_evaluations = 1000;
        one_ray b;
        assert_ok(context, run(context, m, &q, &b));
        assert_true(b.status == CPM_RAY_LEFT || b.status == CPM_RAY_EVALUATIONS_EXHAUSTED);
        assert_true(isfinite(b.position[0]) && isfinite(b.position[1]) && b.evaluations <= 1000);
        assert_int_equal(trace(context, m, zero, up, 0.0, method, 0.0).status, CPM_RAY_ARRIVED);
    }
    double n[64];
    for (int i = 0; i < 64; i++) n[i] = 1.3 + 0.1 * sin(i);
    cpm_grid_desc grid = {.struct_size = sizeof grid,
                          .values = n,
                          .size = {4, 4, 4},
                          .spacing = {1, 1, 1},
                          .interpolation = CPM_INTERPOLATION_LINEAR};
    assert_ok(context, cpm_medium_create_grid(context, &grid, NULL, &bump));
    const double length = 3.0, inside[3] = {0.3, 0.2, 0.1};
    cpm_rays_request q = request_of(inside, slanted, &length, CPM_METHOD_DOPRI5);
    q.rtol = 1e-10, q.max_evaluations = 60;
    one_ray a;
    assert_ok(context, run(context, bump, &q, &a));
    assert_int_equal(a.status, CPM_RAY_EVALUATIONS_EXHAUSTED);
    assert_true(a.evaluations <= 60 && a.length > 0.0 && a.length < length && isfinite(a.position[0]));
    cpm_medium_release(bump);
    cpm_medium_release(m);
}

static void assert_message(cpm_context *context, const cpm_medium *m, const cpm_rays_request *q, cpm_status status,
                           const char *part) {
    one_ray out;
    assert_int_equal(run(context, m, q, &out), status);
    if (!strstr(cpm_context_last_error(context), part))
        fail_msg("'%s' does not say '%s'", cpm_context_last_error(context), part);
}

/* NaN, a zero direction, a start where n^2 <= 0, methods that cannot be: refused, with the first bad index. */
static void test_refused(void **state) {
    cpm_context *context = *state;
    cpm_medium *m = NULL, *layers = NULL;
    const double g[3] = {0, -1, 0}, length = 1.0, long_way[2] = {1.0, NAN}, heights[2] = {0, 1}, n[2] = {1.2, 1.1};
    const double good[6] = {0, 0, 0, 0, 0, 0}, along[6] = {1, 0, 0, 0, 1, 0}, nan_there[6] = {0, 0, 0, 0, NAN, 0};
    const double above[6] = {0, 0, 0, 0, 2, 0};
    assert_ok(context, cpm_medium_create_linear_squared(context, 1.0, g, NULL, NULL, &m));
    cpm_rays_request q = request_of(nan_there, along, &length, 0);
    q.count = 2;
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "origins[1, 1]");
    q = request_of(good, good, &length, 0);
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "directions[0]");
    q = request_of(above, along, &length, 0);
    q.count = 2;
    for (q.method = 0; q.method <= CPM_METHOD_DOPRI5; q.method += CPM_METHOD_DOPRI5)
        assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "origins[1]");
    q = request_of(good, along, long_way, 0);
    q.count = 2, q.length_stride = 1;
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "lengths[1]");
    q = request_of(good, along, &length, CPM_METHOD_RK4);
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "step");
    q = request_of(good, along, &length, 9);
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "method");
    q = request_of(good, along, &length, 0);
    q.rtol = 1e-15;
    assert_message(context, m, &q, CPM_ERROR_INVALID_ARGUMENT, "rtol");
    cpm_layered_desc desc = {
        .struct_size = sizeof desc, .heights = heights, .n = n, .count = 2, .interpolation = CPM_INTERPOLATION_CUBIC};
    assert_ok(context, cpm_medium_create_layered(context, &desc, NULL, &layers));
    q = request_of(good, along, &length, CPM_METHOD_EXACT);
    assert_message(context, layers, &q, CPM_ERROR_UNSUPPORTED, "exact");
    cpm_medium_release(layers);
    desc.interpolation = CPM_INTERPOLATION_STEP;
    assert_ok(context, cpm_medium_create_layered(context, &desc, NULL, &layers));
    q.method = CPM_METHOD_DOPRI5;
    assert_message(context, layers, &q, CPM_ERROR_UNSUPPORTED, "exact");
    cpm_medium_release(layers);
    cpm_medium_release(m);
}

/* The lanes that the scene tracer drives give what cpm_rays_trace gives: eight rays loaded at different times. */
static void test_lanes(void **state) {
    cpm_context *context = *state;
    double n[125];
    for (int i = 0; i < 125; i++) n[i] = 1.3 + 0.05 * sin(0.7 * i);
    cpm_grid_desc grid = {.struct_size = sizeof grid,
                          .values = n,
                          .size = {5, 5, 5},
                          .spacing = {0.5, 0.5, 0.5},
                          .origin = {-1, -1, -1},
                          .interpolation = CPM_INTERPOLATION_CUBIC};
    cpm_medium *m = NULL;
    assert_ok(context, cpm_medium_create_grid(context, &grid, NULL, &m));
    cpm_lane_control control = {
        .medium = &m->data, .table = m->table, .method = CPM_METHOD_DOPRI5, .rtol = 1e-9, .expected_length = 1.5};
    static cpm_lane_rays rays;
    memset(&rays, 0, sizeof rays);
    for (int i = 0; i < 8; i++) rays.status[i] = CPM_RAY_ARRIVED;
    for (int i = 0; i < 8; i++) {
        int64_t fresh[8] = {0};
        fresh[i] = 1;
        double d[3] = {1, 0.3 * i - 1, 0.2};
        for (int k = 0; k < 3; k++) rays.r[k][i] = 0.1 * (k + 1) - 0.05 * i, rays.p[k][i] = d[k];
        rays.scale[i] = 1.0;
        cpm_lanes_start(&control, &rays, fresh);
        const double r[3] = {rays.r[0][i], rays.r[1][i], rays.r[2][i]};
        assert_near(rays.n[i], cpm_medium_n(m, 1.0, r), 0.0);
        cpm_lanes_step(&control, &rays); /* those loaded before move on beside it */
        assert_int_equal(rays.status[i], -1);
    }
    for (int step = 0; step < 200; step++) {
        cpm_lanes_step(&control, &rays);
        for (int i = 0; i < 8; i++) {
            if (!rays.accepted[i] || rays.length[i] < 1.5) continue;
            cpm_piece piece;
            double r[3], start[3] = {0.1 - 0.05 * i, 0.2 - 0.05 * i, 0.3 - 0.05 * i}, d[3] = {1, 0.3 * i - 1, 0.2};
            cpm_lane_piece(&rays, i, &piece);
            cpm_piece_position(&piece, cpm_piece_theta(&piece, 1.5), r);
            one_ray a = trace(context, m, start, d, 1.5, CPM_METHOD_DOPRI5, 1e-12);
            assert_near3(r, a.position[0], a.position[1], a.position[2], 3e-8);
            rays.status[i] = CPM_RAY_ARRIVED;
            rays.accepted[i] = 0;
        }
    }
    for (int i = 0; i < 8; i++) assert_int_equal(rays.status[i], CPM_RAY_ARRIVED);
    cpm_medium_release(m);
}

/* Chained exact pieces end where the whole path does: a catenary in short pieces, layers in many. */
static void test_exact_pieces(void **state) {
    cpm_context *context = *state;
    double heights[9], n[9];
    for (int i = 0; i < 9; i++) heights[i] = -2.0 + 0.5 * i, n[i] = 1.3 - 0.02 * i * i + 0.1 * i;
    cpm_layered_desc desc = {.struct_size = sizeof desc, .heights = heights, .n = n, .count = 9};
    const double g[3] = {0.05, -0.2, 0.1};
    for (int kind = 0; kind < 4; kind++) {
        cpm_medium *m = NULL;
        desc.interpolation = kind == 3 ? CPM_INTERPOLATION_STEP : CPM_INTERPOLATION_LINEAR_SQUARED;
        if (kind == 0)
            assert_ok(context, cpm_medium_create_linear(context, 1.3, g, NULL, NULL, &m));
        else if (kind == 1)
            assert_ok(context, cpm_medium_create_linear_squared(context, 1.69, g, NULL, NULL, &m));
        else
            assert_ok(context, cpm_medium_create_layered(context, &desc, NULL, &m));
        const double d[3] = {0.6, 0.64, -0.48}, start[3] = {0.1, -1.23, 0.2};
        double r[3] = {0.1, -1.23, 0.2}, p[3], length = 0.0, evaluations = 0.0,
               index = cpm_medium_n_toward(m, 1.0, start, d);
        for (int k = 0; k < 3; k++) p[k] = index * d[k];
        cpm_piece piece;
        int pieces = 0;
        while (length < 6.0 && pieces < 1000) {
            assert_int_equal(cpm_exact_next(&m->data, m->table, 1.0, r, p, 0.7, 0.0, length, &piece, &evaluations), 0);
            assert_near3(piece.r0, r[0], r[1], r[2], 0.0);
            memcpy(r, piece.r1, sizeof r);
            memcpy(p, piece.p1, sizeof p);
            length = piece.length1;
            pieces++;
        }
        one_ray a = trace(context, m, start, d, length, CPM_METHOD_EXACT, 0.0);
        assert_near3(r, a.position[0], a.position[1], a.position[2], 2e-13);
        assert_near3(p, a.momentum[0], a.momentum[1], a.momentum[2],
                     kind == 3 ? 1.0 : 2e-13); /* 3: before the last face */
        double middle[3], at = kind == 0 ? cpm_piece_length(&piece, 0.5)
                                         : piece.length0 + cpm_exact_length(piece.p0, piece.g0, 0.5 * piece.h);
        one_ray b = trace(context, m, start, d, at, CPM_METHOD_EXACT, 0.0);
        cpm_piece_position(&piece, 0.5, middle);
        assert_near3(middle, b.position[0], b.position[1], b.position[2], 2e-13);
        cpm_medium_release(m);
    }
}

/* exp, log, sin, cos within the bounds that elementary.h states. */
static void test_elementary(void **state) {
    (void)state;
    for (int i = 0; i <= 200000; i++) {
        double u = i / 200000.0, x = -700.0 + 1400.0 * u, e = (double)expl(x);
        assert_near(cpm_exp(x) / e, 1.0, 3e-16);
        double y = exp(-600.0 + 1200.0 * u), l = (double)logl(y);
        assert_near(cpm_log(y), l, 2.3e-16 * fabs(l) + 1e-300);
        double z = -1000.0 + 2000.0 * u;
        assert_near(cpm_sin(z), (double)sinl(z), 2.5e-16);
        assert_near(cpm_cos(z), (double)cosl(z), 2.5e-16);
    }
    assert_true(isnan(cpm_exp(NAN)) && isnan(cpm_log(-1.0)) && isnan(cpm_sin(INFINITY)));
    assert_true(isinf(cpm_exp(1000.0)) && cpm_exp(-1000.0) == 0.0 && isinf(cpm_log(0.0)) && cpm_exp(0.0) == 1.0);
}

static int make_context(void **state) {
    *state = new_context();
    return 0;
}
static int drop_context(void **state) {
    cpm_context_release(*state);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_straight, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_parabola, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_snell, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_reversal, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_statuses, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_refused, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_lanes, make_context, drop_context),
        cmocka_unit_test_setup_teardown(test_exact_pieces, make_context, drop_context),
        cmocka_unit_test(test_elementary),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
