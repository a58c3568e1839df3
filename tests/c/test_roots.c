/* Roots of polynomials in an interval, against polynomials made from their roots. */
#include "check.h"

#include <math.h>
#include <stdlib.h>

#include "cl/shared/roots.h"

/* prod (t - r_i) times (t^2 + 1)^extra, lowest power first. */
static int from_roots(const double *r, int count, int extra, double *f) {
    int degree = 0;
    f[0] = 1.0;
    for (int i = 0; i < count; i++) {
        f[degree + 1] = 0.0;
        for (int k = degree + 1; k > 0; k--) f[k] = f[k - 1] - r[i] * f[k];
        f[0] *= -r[i];
        degree++;
    }
    for (int i = 0; i < extra; i++) {
        f[degree + 1] = f[degree + 2] = 0.0;
        for (int k = degree + 2; k > 1; k--) f[k] += f[k - 2];
        degree += 2;
    }
    return degree;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }

static void separated_roots_are_found_in_order(void **state) {
    (void)state;
    srand(1);
    for (int trial = 0; trial < 20000; trial++) {
        double r[5], f[12], found[10];
        int count = rand() % 6;
        for (int i = 0; i < count; i++) r[i] = -0.5 + 0.4 * i + 0.3 * uniform(); /* at least 0.1 apart */
        int degree = from_roots(r, count, rand() % 2, f);
        qsort(r, (size_t)count, sizeof *r, compare);
        int got = cpm_roots(f, degree, 0.0, 1.0, found), want = 0;
        for (int i = 0; i < count; i++)
            if (r[i] > 0.0 && r[i] <= 1.0) {
                assert_true(want < got);
                assert_true(fabs(found[want] - r[i]) < 1e-11);
                want++;
            }
        assert_int_equal(got, want);
    }
}

static void the_interval_is_open_below_and_closed_above(void **state) {
    (void)state;
    double found[10]; /* to the last bit for degrees 1 and 2; above, up to rounding of the coefficients */
    const double square[3] = {2.0, -3.0, 1.0}; /* 1 and 2 */
    assert_int_equal(cpm_roots(square, 2, 1.0, 2.0, found), 1);
    assert_true(found[0] == 2.0);
}

static void no_root_is_no_root(void **state) {
    (void)state;
    double found[10];
    const double positive[6] = {1.0, -1.0, 1.0, -1.0, 1.0, 0.5}, nothing[6] = {0.0};
    assert_int_equal(cpm_roots(positive, 5, 0.0, 1.0, found), 0);
    assert_int_equal(cpm_roots(nothing, 2, 0.0, 1.0, found), 0);
    const double linear[2] = {1.0, -4.0};
    assert_int_equal(cpm_roots(linear, 1, 0.0, 0.2, found), 0);
    assert_int_equal(cpm_roots(linear, 1, 0.0, 0.25, found), 1);
}

static void a_small_root_keeps_its_digits(void **state) {
    (void)state;
    double found[10];
    const double f[3] = {1e-12, -1.0, 1.0}; /* the textbook formula gives 1.00009e-12 */
    assert_int_equal(cpm_roots(f, 2, 0.0, 0.5, found), 1);
    assert_true(fabs(found[0] / 1.000000000001e-12 - 1.0) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separated_roots_are_found_in_order),
        cmocka_unit_test(the_interval_is_open_below_and_closed_above),
        cmocka_unit_test(no_root_is_no_root),
        cmocka_unit_test(a_small_root_keeps_its_digits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
