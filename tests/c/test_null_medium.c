/* test_null_medium.c: media and rays given nonsense. See abuse.h. */
#include "abuse.h"

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

static void media_lenses(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    assert_status(context, REFUSED, cpm_medium_create_parabolic(context, 1.5, 0.1, up, origin, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_luneburg(context, 1.0, origin, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_fisheye(context, 1.5, 1.0, origin, NULL, NULL));
    assert_status(context, REFUSED, cpm_medium_create_eaton(context, 1.0, origin, NULL, NULL));
    for (size_t i = 0; i < COUNT_OF(not_positive); i++) {
        const double bad = not_positive[i];
        assert_refused(context, m, cpm_medium_create_parabolic(context, bad, 0.1, up, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_fisheye(context, bad, 1.0, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_fisheye(context, 1.5, bad, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_luneburg(context, bad, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_eaton(context, bad, origin, NULL, &m));
    }
    const double alphas[] = {NAN, INFINITY, -INFINITY, -1.0, 1e100, -0x1p-1074, 0x1p-1074};
    for (size_t i = 0; i < COUNT_OF(alphas); i++)
        assert_refused(context, m, cpm_medium_create_parabolic(context, 1.5, alphas[i], up, origin, NULL, &m));
    assert_refused(context, m, cpm_medium_create_parabolic(context, 1.5, 0.1, origin, origin, NULL, &m));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        const double bad[3] = {0, not_numbers[i], 0};
        assert_refused(context, m, cpm_medium_create_parabolic(context, 1.5, 0.1, bad, origin, NULL, &m));
        assert_refused(context, m, cpm_medium_create_parabolic(context, 1.5, 0.1, up, bad, NULL, &m));
        assert_refused(context, m, cpm_medium_create_luneburg(context, 1.0, bad, NULL, &m));
        assert_refused(context, m, cpm_medium_create_fisheye(context, 1.5, 1.0, bad, NULL, &m));
        assert_refused(context, m, cpm_medium_create_eaton(context, 1.0, bad, NULL, &m));
    }
    assert_ok(context,
              cpm_medium_create_parabolic(context, 1.5, 0.1, NULL, NULL, NULL, &m)); /* +z through the origin */
    double n = 0;
    assert_ok(context, cpm_medium_evaluate(context, m, up, 1, 550.0, &n, NULL));
    assert_true(fabs(n - 1.5 * sqrt(0.99)) < 1e-15);
    cpm_medium_release(m);
    cpm_context_release(context);
}

static void media_sources(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    const double centers[6] = {0, 0, 0, 1, 0, 0}, strengths[2] = {0.1, -0.1}, exponents[2] = {2, 1.5};
    const cpm_sources_desc good = {
        .struct_size = sizeof good, .count = 2, .centers = centers, .strengths = strengths, .exponents = exponents};
    assert_ok(context, cpm_medium_create_sources(context, &good, NULL, &m)); /* directions NULL: points */
    cpm_medium_release(m);
    assert_refused(context, m, cpm_medium_create_sources(context, NULL, NULL, &m));
    assert_status(context, REFUSED, cpm_medium_create_sources(context, &good, NULL, NULL));
    cpm_sources_desc d = good;
    d.struct_size = 0;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    d = good, d.count = 0;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    d.count = SIZE_MAX;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    d = good, d.centers = NULL;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    d = good, d.strengths = NULL;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    d = good, d.exponents = NULL;
    assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        const double place[6] = {0, 0, 0, 0, not_numbers[i], 0}, strength[2] = {1, not_numbers[i]};
        d = good, d.centers = place;
        assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
        assert_non_null(strstr(cpm_context_last_error(context), "centers[1, 1]"));
        d = good, d.directions = place;
        assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
        assert_non_null(strstr(cpm_context_last_error(context), "directions[1, 1]"));
        d = good, d.strengths = strength;
        assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
        assert_non_null(strstr(cpm_context_last_error(context), "strengths[1]"));
    }
    const double bad[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0, 64.5};
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        const double exponent[2] = {1, bad[i]};
        d = good, d.exponents = exponent;
        assert_refused(context, m, cpm_medium_create_sources(context, &d, NULL, &m));
        assert_non_null(strstr(cpm_context_last_error(context), "exponent[1]"));
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
    const int32_t kinds[] = {-1, 6, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(kinds); i++) {
        d.kind = kinds[i];
        assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    }
    for (int32_t kind = CPM_DISPERSION_CONSTANT; kind <= CPM_DISPERSION_GAS; kind++)
        for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
            d.kind = kind;
            d.coefficients[0] = not_numbers[i];
            assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
        }
    for (int32_t count = 0; count <= 7; count++) { /* a gas has four numbers, then pairs */
        d = (cpm_dispersion){
            .struct_size = sizeof d, .kind = CPM_DISPERSION_GAS, .count = count, .coefficients = {3e-4}};
        if (count != 4 && count != 6) assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    }
    d = (cpm_dispersion){.struct_size = 0};
    assert_refused(context, m, cpm_medium_create_dispersive(context, &d, &m));
    cpm_context_release(context);
}

static void media_catalogue(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_dispersion d = {.struct_size = sizeof d};
    const char *names[] = {"BK7", "n-bk7", "F2", "SF11", "Fused Silica", "SiO2", "water", "sapphire", "diamond", "AIR"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        cpm_medium *m = NULL;
        const double point[3] = {0, 0, 0};
        double n = 0;
        assert_ok(context, cpm_dispersion_catalogue(context, names[i], &d));
        assert_ok(context, cpm_medium_create_dispersive(context, &d, &m));
        assert_ok(context, cpm_medium_evaluate(context, m, point, 1, 587.5618, &n, NULL));
        assert_true(n > 1.0002 && n < 2.42);
        if (i < 2) assert_true(fabs(n - 1.51680) < 6e-6); /* SCHOTT's data sheet */
        cpm_medium_release(m);
    }
    assert_status(context, REFUSED, cpm_dispersion_catalogue(NULL, "BK7", &d));
    assert_status(context, REFUSED, cpm_dispersion_catalogue(context, NULL, &d));
    assert_status(context, REFUSED, cpm_dispersion_catalogue(context, "BK7", NULL));
    const char *unknown[] = {"", "BK", "BK77", "unobtainium",
                             "a name that is longer than any of the catalogue's names"};
    for (size_t i = 0; i < COUNT_OF(unknown); i++) {
        assert_status(context, REFUSED, cpm_dispersion_catalogue(context, unknown[i], &d));
        assert_non_null(strstr(cpm_context_last_error(context), "BK7, F2, SF11, fused silica"));
    }
    d.struct_size = 8;
    assert_status(context, REFUSED, cpm_dispersion_catalogue(context, "BK7", &d));
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

    const size_t kinks[][2] = {{1, 1}, {0, 1}, {2, 0}, {3, 0}, {SIZE_MAX, 0}}; /* only {1} serves three heights */
    for (size_t i = 0; i < COUNT_OF(kinks); i++) {
        d = good, d.kinks = kinks[i], d.kink_count = i < 2 ? 2 : 1;
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    }
    d = good, d.kink_count = 1;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d.kinks = kinks[0], d.interpolation = CPM_INTERPOLATION_STEP;
    assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    d.interpolation = CPM_INTERPOLATION_CUBIC;
    assert_ok(context, cpm_medium_create_layered(context, &d, NULL, &m));
    cpm_medium_release(m);

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

static void media_shells(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    const double heights[] = {-1.0, 0.0, 2.0}, n[] = {1.3, 1.2, 1.1};
    const cpm_layered_desc good = {
        .struct_size = sizeof good, .heights = heights, .n = n, .count = 3, .interpolation = 1, .radius = 5.0};
    cpm_layered_desc d = good;
    assert_ok(context, cpm_medium_create_layered(context, &d, NULL, &m));
    cpm_medium_release(m);
    const double radii[] = {-5.0, NAN, INFINITY, -INFINITY, 1.0, 0x1p-1074};
    for (size_t i = 0; i < COUNT_OF(radii); i++) {
        d = good, d.radius = radii[i];
        assert_refused(context, m, cpm_medium_create_layered(context, &d, NULL, &m));
    }
    d = good, d.struct_size = offsetof(cpm_layered_desc, radius); /* a program compiled before there was one: flat */
    d.radius = NAN;
    assert_ok(context, cpm_medium_create_layered(context, &d, NULL, &m));
    cpm_medium_release(m);
    cpm_context_release(context);
}

static void media_expression(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL;
    const cpm_instruction first = {.operation = CPM_OPERATION_SCALE, .target = 5, .a = 1, .k = 0.1};
    cpm_instruction code[2] = {first, {.operation = CPM_OPERATION_CONSTANT, .target = 6, .k = 0.1}};
    const cpm_expression_desc good = {
        .struct_size = sizeof good, .instructions = code, .count = 2, .results = {5, 2, 6, 2}};
    cpm_expression_desc d = good;
    assert_status(context, REFUSED, cpm_medium_create_expression(context, &d, NULL, NULL));
    assert_refused(context, m, cpm_medium_create_expression(context, NULL, NULL, &m));
    assert_ok(context, cpm_medium_create_expression(context, &d, NULL, &m));
    cpm_medium_release(m);
    const size_t counts[] = {0, CPM_MAX_INSTRUCTIONS + 1, SIZE_MAX};
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        d = good, d.count = counts[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &d, NULL, &m));
    }
    d = good, d.instructions = NULL;
    assert_refused(context, m, cpm_medium_create_expression(context, &d, NULL, &m));
    const int32_t registers[] = {-1, 7, 127, 128, 255, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(registers); i++) {
        for (int k = 0; k < 4; k++) {
            d = good, d.results[k] = registers[i];
            assert_refused(context, m, cpm_medium_create_expression(context, &d, NULL, &m));
        }
        code[0] = first, code[0].a = registers[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &good, NULL, &m));
    }
    const int32_t targets[] = {-1, 0, 4, 128, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(targets); i++) {
        code[0] = first, code[0].target = targets[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &good, NULL, &m));
    }
    const int32_t operations[] = {0, -1, 10, 19, 38, 256 + CPM_OPERATION_SCALE, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(operations); i++) {
        code[0] = first, code[0].operation = operations[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &good, NULL, &m));
    }
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        code[0] = first, code[0].k = not_numbers[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &good, NULL, &m));
        code[0] = first, code[0].l = not_numbers[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &good, NULL, &m));
        code[0] = first;
        d = good, d.feature = not_numbers[i];
        assert_refused(context, m, cpm_medium_create_expression(context, &d, NULL, &m));
    }
    const cpm_dispersion glass = {
        .struct_size = sizeof glass, .kind = CPM_DISPERSION_CAUCHY, .count = 2, .coefficients = {1.5, 0.01}};
    assert_ok(context, cpm_medium_create_expression(context, &good, &glass, &m));
    cpm_medium_release(m);
    code[0].a = 4; /* the wavelength: it disperses by itself */
    assert_refused(context, m, cpm_medium_create_expression(context, &good, &glass, &m));
    cpm_context_release(context);
}

static void media_sum(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = NULL, *term = NULL, *layers = NULL;
    const double heights[] = {0.0, 1.0}, n[] = {1.3, 1.2};
    const cpm_layered_desc step = {
        .struct_size = sizeof step, .heights = heights, .n = n, .count = 2, .interpolation = CPM_INTERPOLATION_STEP};
    assert_ok(context, cpm_medium_create_linear(context, 1.3, up, origin, NULL, &term));
    assert_ok(context, cpm_medium_create_layered(context, &step, NULL, &layers));
    cpm_medium *terms[CPM_MAX_TERMS + 1];
    for (size_t i = 0; i < COUNT_OF(terms); i++) terms[i] = term;
    assert_status(context, REFUSED, cpm_medium_create_sum(context, terms, 2, NULL));
    assert_refused(context, m, cpm_medium_create_sum(context, NULL, 2, &m));
    assert_refused(context, m, cpm_medium_create_sum(context, terms, 0, &m));
    assert_refused(context, m, cpm_medium_create_sum(context, terms, CPM_MAX_TERMS + 1, &m));
    assert_refused(context, m, cpm_medium_create_sum(context, terms, SIZE_MAX, &m));
    terms[1] = NULL;
    assert_refused(context, m, cpm_medium_create_sum(context, terms, 2, &m));
    terms[1] = layers;
    m = term;
    assert_status(context, CPM_ERROR_UNSUPPORTED, cpm_medium_create_sum(context, terms, 2, &m));
    assert_null(m);
    terms[1] = term;
    assert_ok(context, cpm_medium_create_sum(context, terms, CPM_MAX_TERMS, &m));
    terms[0] = m, terms[1] = term; /* one too many, once it is taken apart */
    cpm_medium *more = NULL;
    assert_refused(context, more, cpm_medium_create_sum(context, terms, 2, &more));
    cpm_medium_release(m);
    cpm_medium_release(layers);
    cpm_medium_release(term);
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

static void extinction(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_medium *m = plain_medium(context);
    const double w[2] = {400, 700}, v[2] = {2, 1}, falling[2] = {700, 400}, negative[2] = {1, -1};
    assert_int_equal(cpm_medium_set_extinction(NULL, m, w, v, 2), REFUSED);
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, NULL, w, v, 2));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, NULL, v, 2));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, w, NULL, 2));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, w, v, 0));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, falling, v, 2));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, w, negative, 2));
    for (size_t i = 0; i < COUNT_OF(not_numbers); i++) {
        assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, w, &not_numbers[i], 1));
        assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, &not_numbers[i], v, 1));
    }
    assert_ok(context, cpm_medium_set_extinction(context, m, w, v, 2));
    assert_status(context, REFUSED, cpm_medium_set_extinction(context, m, w, v, 2)); /* once */
    cpm_medium_release(m);
    cpm_context_release(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extinction),
        cmocka_unit_test(media_simple),     cmocka_unit_test(media_dispersion), cmocka_unit_test(media_catalogue), cmocka_unit_test(media_lenses),
        cmocka_unit_test(media_sources),    cmocka_unit_test(media_tables),     cmocka_unit_test(media_shells),
        cmocka_unit_test(media_expression), cmocka_unit_test(media_sum),        cmocka_unit_test(medium_evaluate),
        cmocka_unit_test(rays),
    };
    return cmocka_run_group_tests_name("null_medium", tests, NULL, NULL);
}
