/* test_half.c: 16-bit floats and octahedral directions against definitions, and against F16C where there is one. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "cl/shared/half.h"
#include "cl/shared/octahedral.h"
#include "cl/shared/philox.h"

static double definition(unsigned half) { /* IEEE 754, section 3.4 */
    const int exponent = (int)(half >> 10 & 31), fraction = (int)(half & 1023);
    const double sign = half & 0x8000u ? -1.0 : 1.0;
    if (exponent == 31) return fraction ? (double)NAN : sign * (double)INFINITY;
    if (exponent == 0) return sign * ldexp((double)fraction, -24);
    return sign * ldexp((double)(1024 + fraction), exponent - 25);
}

static void every_half_is_its_definition_and_comes_back(void **state) {
    (void)state;
    for (unsigned h = 0; h < 65536; h++) {
        const float x = cpm_half_to_float((unsigned short)h);
        const double wanted = definition(h);
        if (isnan(wanted)) {
            assert_true(isnan(x));
            assert_true(isnan(definition(cpm_half_from_float(x))));
            continue;
        }
        assert_true((double)x == wanted && !signbit(x) == !(h & 0x8000u));
        assert_int_equal(cpm_half_from_float(x), h);
    }
}

/* Floats of all magnitudes, and those half way between two halves, and their neighbours. */
static float sample(uint32_t i) {
    cpm_float_bits x;
    if (i % 2) {
        x.bits = cpm_philox(1, i, 0, 0, 0).v[0];
        if (i % 4 == 1) x.bits = (x.bits & 0x87ffffffu) | 0x30000000u; /* around the range of halves */
    } else {
        const uint32_t half = i / 2 % 31744;
        x.value = (float)(0.5 * (definition(half) + (half == 31743 ? 65536.0 : definition(half + 1))));
        x.bits += i / 63488 % 3 - 1;
    }
    return x.value;
}

static void floats_round_to_nearest_even(void **state) {
    (void)state;
    for (uint32_t i = 0; i < 2000000; i++) {
        const float x = sample(i);
        const unsigned half = cpm_half_from_float(x);
        if (isnan(x)) {
            assert_true(isnan(definition(half)));
        } else if (fabsf(x) >= 65520.0f) {
            assert_int_equal(half, 0x7c00u | (signbit(x) ? 0x8000u : 0u));
        } else {
            const double error = fabs(definition(half) - (double)x);
            const unsigned magnitude = half & 0x7fffu;
            const double above = magnitude == 31743 ? 65536.0 : definition(magnitude + 1);
            const double below = magnitude ? definition(magnitude - 1) : 1.0; /* nothing is nearer to 0 than 0 */
            const double to_above = fabs(above - fabs((double)x)), to_below = fabs(fabs((double)x) - below);
            assert_true(error <= to_above && error <= to_below);
            if (error == to_above || error == to_below) assert_int_equal(half & 1u, 0);
            assert_int_equal(half >> 15, signbit(x) != 0);
        }
    }
}

#if defined(__x86_64__)
#include <immintrin.h>

__attribute__((target("f16c"))) static void compare_f16c(void) {
    for (unsigned h = 0; h < 65536; h++) {
        float theirs[4];
        const float ours = cpm_half_to_float((unsigned short)h);
        _mm_storeu_ps(theirs, _mm_cvtph_ps(_mm_set1_epi16((short)h)));
        assert_memory_equal(&ours, theirs, sizeof ours);
    }
    for (uint32_t i = 0; i < 2000000; i++) {
        const float x = sample(i);
        const __m128i theirs = _mm_cvtps_ph(_mm_set1_ps(x), _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
        assert_int_equal(cpm_half_from_float(x), (unsigned)_mm_extract_epi16(theirs, 0));
    }
}
#endif

static void f16c_agrees(void **state) {
    (void)state;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2")) { /* clang 14 does not know "f16c"; no AVX2 without it */
        compare_f16c();
        return;
    }
#endif
    skip();
}

static void directions_come_back(void **state) {
    (void)state;
    double worst = 0.0;
    for (uint32_t i = 0; i < 1000000; i++) {
        const cpm_random r = cpm_philox(2, i, 0, 0, 0);
        cpm_vec v = cpm_v(cpm_uniform(r.v[0]) - 0.5, cpm_uniform(r.v[1]) - 0.5, cpm_uniform(r.v[2]) - 0.5);
        if (i % 8 == 0) v.z = 0.0; /* along the folds too */
        v = cpm_unit(v);
        const cpm_vec w = cpm_octahedral_decode(cpm_octahedral_encode(v));
        worst = fmax(worst, cpm_norm(cpm_cross(v, w)));
        assert_true(cpm_vdot(v, w) > 0.99 && fabs(cpm_norm(w) - 1.0) < 1e-15);
    }
    assert_true(worst < 6.5e-5);
    assert_true(worst > 2e-5); /* the bound says something */
}

static void axes_are_exact(void **state) {
    (void)state;
    for (int a = 0; a < 6; a++) {
        const double s = a & 1 ? -1.0 : 1.0;
        const cpm_vec v = cpm_v(a / 2 == 0 ? s : 0.0, a / 2 == 1 ? s : 0.0, a / 2 == 2 ? s : 0.0);
        const cpm_vec w = cpm_octahedral_decode(cpm_octahedral_encode(cpm_scaled(7.0, v)));
        assert_true(v.x == w.x && v.y == w.y && v.z == w.z);
    }
    assert_int_equal(cpm_octahedral_encode(cpm_v(0.0, 0.0, 0.0)), cpm_octahedral_encode(cpm_v(0.0, 0.0, 1.0)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_half_is_its_definition_and_comes_back),
        cmocka_unit_test(floats_round_to_nearest_even),
        cmocka_unit_test(f16c_agrees),
        cmocka_unit_test(directions_come_back),
        cmocka_unit_test(axes_are_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
