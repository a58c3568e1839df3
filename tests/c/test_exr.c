/* test_exr.c: spectral OpenEXR: channels' names, layout, values read back. */
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/colour.h"
#include "io/exr.h"
#include "picture_folder.h"
#include "read_exr.h"
#include "render/image.h"

static void names_of_channels(void **state) {
    (void)state;
    const struct {
        double wavelength;
        const char *name;
    } cases[] = {
        {550.0, "S0.550,000nm"},
        {409.375, "S0.409,375nm"},
        {1234.5, "S0.1234,500nm"},
        {587.5618, "S0.587,5618nm"},
        {0.001, "S0.0,001nm"},
        {1e6 / 3.0, NULL},
        {400.0 + 100.0 / 3.0, NULL},
        {1e9, "S0.1,0000000000000000e+09nm"},
        {5e-324, NULL},
        {1.7976931348623157e308, NULL},
    };
    for (int pass = 0; pass < 2; pass++) {
        /* A German locale, where there is one, prints a comma and reads no point. */
        if (pass == 1 && !setlocale(LC_NUMERIC, "de_DE.UTF-8")) break;
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            char name[CPM_EXR_NAME_SIZE];
            cpm_exr_channel_name(cases[i].wavelength, name);
            if (cases[i].name) assert_string_equal(name, cases[i].name);
            const size_t length = strlen(name);
            assert_true(length < CPM_EXR_NAME_SIZE);
            assert_int_equal(strncmp(name, "S0.", 3), 0);
            assert_string_equal(name + length - 2, "nm");
            if (pass == 0) { /* reads back as the same number */
                name[length - 2] = 0;
                char *comma = strchr(name, ',');
                assert_non_null(comma);
                *comma = '.';
                assert_true(strtod(name + 3, NULL) == cases[i].wavelength);
            }
        }
    }
    setlocale(LC_NUMERIC, "C");
}

#ifdef CPM_WITH_OPENEXR
/* Every value of every bin in its place, for heights on both sides of the 16 lines of a chunk, and many bins. */
static void written_equals_read(void **state) {
    (void)state;
    const struct {
        int32_t width, height;
        size_t bins;
    } cases[] = {{1, 1, 1}, {7, 5, 16}, {31, 16, 3}, {5, 17, 16}, {3, 40, 256}, {64, 33, 2}};
    cpm_context *context = new_context();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        cpm_image *image = gradient_image(context, cases[k].width, cases[k].height, cases[k].bins);
        assert_ok(context, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
        exr_content *content = read_exr(in_folder("a.exr"));
        assert_int_equal(content->width, cases[k].width);
        assert_int_equal(content->height, cases[k].height);
        assert_int_equal(content->count, cases[k].bins + 3);
        assert_string_equal(content->layout, "1.0");
        assert_string_equal(content->units, "W.m^-2.sr^-1.nm^-1");
        assert_int_equal(content->compression, EXR_COMPRESSION_ZIP);
        for (int i = 1; i < content->count; i++) assert_true(strcmp(content->names[i - 1], content->names[i]) < 0);
        const size_t pixels = (size_t)cases[k].width * (size_t)cases[k].height;
        for (size_t b = 0; b < cases[k].bins; b++) {
            char name[CPM_EXR_NAME_SIZE];
            cpm_exr_channel_name(cpm_image_wavelengths(image)[b], name);
            const float *values = find_channel(content, name);
            for (size_t p = 0; p < pixels; p++) assert_true(values[p] == cpm_image_data(image)[p * cases[k].bins + b]);
        }
        /* The preview is the weighted sum. */
        double weights[CPM_MAX_BINS][3];
        cpm_colour_weights(cpm_image_wavelengths(image), cases[k].bins, weights);
        float *rgb = malloc(pixels * 3 * sizeof *rgb);
        cpm_colour_rgb(cpm_image_data(image), pixels, cases[k].bins, (const double(*)[3])weights, rgb);
        static const char *const names[3] = {"R", "G", "B"};
        for (size_t c = 0; c < 3; c++)
            for (size_t p = 0; p < pixels; p++) assert_true(find_channel(content, names[c])[p] == rgb[3 * p + c]);
        free(rgb);
        free_content(content);
        cpm_image_release(image);
        assert_int_equal(empty_folder(), 1);
    }
    cpm_context_release(context);
}

static void callers_rgb_is_written(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 5, 20, 4);
    float rgb[5 * 20 * 3];
    for (int i = 0; i < 5 * 20 * 3; i++) rgb[i] = (float)i;
    assert_ok(context, cpm_image_write_exr(context, image, in_folder("a.exr"), rgb));
    exr_content *content = read_exr(in_folder("a.exr"));
    for (int p = 0; p < 5 * 20; p++) {
        assert_true(find_channel(content, "R")[p] == (float)(3 * p));
        assert_true(find_channel(content, "G")[p] == (float)(3 * p + 1));
        assert_true(find_channel(content, "B")[p] == (float)(3 * p + 2));
    }
    free_content(content);
    assert_int_equal(empty_folder(), 1);
    cpm_image_release(image);
    cpm_context_release(context);
}

/* Channels are sorted by name, which is not by wavelength: 1050 nm before 950 nm. */
static void infrared(void **state) {
    (void)state;
    cpm_context *context = new_context();
    const double wavelengths[2] = {950.0, 1050.0};
    const float values[2] = {1.0f, 2.0f};
    cpm_image *image = NULL;
    assert_ok(context, cpm_image_create(context, 1, 1, wavelengths, 2, values, &image));
    assert_ok(context, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
    exr_content *content = read_exr(in_folder("a.exr"));
    assert_true(find_channel(content, "S0.950,000nm")[0] == 1.0f);
    assert_true(find_channel(content, "S0.1050,000nm")[0] == 2.0f);
    free_content(content);
    assert_int_equal(empty_folder(), 1);
    cpm_image_release(image);
    cpm_context_release(context);
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_channels),
#ifdef CPM_WITH_OPENEXR
        cmocka_unit_test(written_equals_read),
        cmocka_unit_test(callers_rgb_is_written),
        cmocka_unit_test(infrared),
#endif
    };
    return cmocka_run_group_tests_name("exr", tests, make_folder, remove_folder);
}
