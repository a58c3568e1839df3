/* test_image.c: the film: what it is given, what it refuses, its preview colours. */
#include <math.h>
#include <string.h>

#include "io/colour.h"
#include "picture_folder.h"
#include "render/image.h"

static void image_keeps_what_it_is_given(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 7, 5, 16);
    int32_t width, height;
    size_t bins;
    assert_ok(context, cpm_image_size(image, &width, &height, &bins));
    assert_int_equal(width, 7);
    assert_int_equal(height, 5);
    assert_int_equal(bins, 16);
    assert_true(cpm_image_wavelengths(image)[0] == 409.375);
    assert_true(cpm_image_data(image)[7 * 5 * 16 - 1] == (7 * 5 * 16 - 1) * 0.25f + 1.0f);
    cpm_image_retain(image);
    cpm_image_release(image);
    assert_true(cpm_image_data(image)[0] == 1.0f);

    cpm_stats stats = {.struct_size = sizeof stats};
    assert_ok(context, cpm_image_stats(image, &stats));
    assert_int_equal(stats.struct_size, sizeof stats);
    /* An older caller's shorter struct: nothing is written past its end. */
    memset(&stats, 0x5a, sizeof stats);
    stats.struct_size = offsetof(cpm_stats, seconds_trace);
    assert_ok(context, cpm_image_stats(image, &stats));
    assert_int_equal(((unsigned char *)&stats)[offsetof(cpm_stats, seconds_trace)], 0x5a);
    assert_int_equal(stats.struct_size, offsetof(cpm_stats, seconds_trace));
    cpm_image_release(image);
    cpm_context_release(context);
}

static void image_refuses(void **state) {
    (void)state;
    cpm_context *context = new_context();
    const float value[4] = {1, 1, 1, 1};
    const double good[2] = {500.0, 600.0};
    const double bad[][2] = {{500.0, 500.0}, {600.0, 500.0}, {0.0, 500.0},
                             {-1.0, 500.0},  {NAN, 500.0},   {500.0, INFINITY}};
    const int32_t sizes[][2] = {{0, 1}, {1, 0}, {-1, 1}, {65537, 1}, {1, 65537}, {INT32_MIN, 1}, {1, INT32_MAX}};
    cpm_image *image;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        image = (cpm_image *)&image;
        assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_create(context, 1, 1, bad[i], 2, value, &image));
        assert_null(image);
        assert_non_null(strstr(cpm_context_last_error(context), "wavelengths["));
    }
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        assert_status(context, CPM_ERROR_INVALID_ARGUMENT,
                      cpm_image_create(context, sizes[i][0], sizes[i][1], good, 2, value, &image));
        assert_non_null(strstr(cpm_context_last_error(context), "1 to 65536"));
    }
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_create(context, 1, 1, good, 0, value, &image));
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT,
                  cpm_image_create(context, 1, 1, good, CPM_MAX_BINS + 1, value, &image));
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_create(context, 1, 1, NULL, 2, value, &image));
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_create(context, 1, 1, good, 2, NULL, &image));
    cpm_context_release(context);
}

static void colours(void **state) {
    (void)state;
    double wavelengths[31], weights[CPM_MAX_BINS][3], flat[3] = {0, 0, 0};
    for (int i = 0; i < 31; i++) wavelengths[i] = 400.0 + 10.0 * i;
    cpm_colour_weights(wavelengths, 31, weights);
    for (int i = 0; i < 31; i++)
        for (int c = 0; c < 3; c++) flat[c] += weights[i][c];
    /* Equal-energy white, (1, 1, 1) in XYZ, through the matrix of IEC 61966-2-1. */
    assert_true(fabs(flat[0] - 1.2048) < 0.02);
    assert_true(fabs(flat[1] - 0.9484) < 0.02);
    assert_true(fabs(flat[2] - 0.9087) < 0.02);
    /* And its luminance is 1. */
    assert_true(fabs(0.2126 * flat[0] + 0.7152 * flat[1] + 0.0722 * flat[2] - 1.0) < 0.01);
    const double *red = weights[22], *green = weights[13], *blue = weights[4]; /* 620, 530, 440 nm */
    assert_true(red[0] > red[1] && red[0] > red[2]);
    assert_true(green[1] > green[0] && green[1] > green[2]);
    assert_true(blue[2] > blue[0] && blue[2] > blue[1]);
    /* Bins of any width: two halves weigh as much as the whole. */
    const double coarse[2] = {475.0, 625.0};
    double two[2][3];
    cpm_colour_weights(coarse, 2, two);
    for (int c = 0; c < 3; c++) assert_true(fabs(two[0][c] + two[1][c] - flat[c]) < 0.02);
    /* One bin: grey. */
    cpm_colour_weights(coarse, 1, weights);
    const float value = 3.0f;
    float rgb[3];
    cpm_colour_rgb(&value, 1, 1, (const double(*)[3])weights, rgb);
    for (int c = 0; c < 3; c++) assert_true(rgb[c] == 3.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(image_keeps_what_it_is_given),
        cmocka_unit_test(image_refuses),
        cmocka_unit_test(colours),
    };
    return cmocka_run_group_tests_name("image", tests, NULL, NULL);
}
