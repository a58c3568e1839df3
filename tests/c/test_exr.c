/* test_exr.c: the film and its spectral OpenEXR: layout, values, names, preview colours, and never half a file. */
#include <dirent.h>
#include <locale.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "check.h"
#include "io/colour.h"
#include "io/exr.h"
#include "render/image.h"

static char folder[64];

static const char *in_folder(const char *name) {
    static char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/cpm-test-exr-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

/* Counts what is in the folder, and empties it. */
static int empty_folder(void) {
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        count++;
        remove(in_folder(entry->d_name));
    }
    closedir(directory);
    return count;
}

static int remove_folder(void **state) {
    (void)state;
    empty_folder();
    return rmdir(folder);
}

/* 16 bins over 400..700 nm, and values that tell every pixel and bin apart. */
static cpm_image *gradient_image(cpm_context *context, int32_t width, int32_t height, size_t bins) {
    double wavelengths[CPM_MAX_BINS];
    for (size_t i = 0; i < bins; i++) wavelengths[i] = 400.0 + 300.0 * ((double)i + 0.5) / (double)bins;
    const size_t count = (size_t)width * (size_t)height * bins;
    float *values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++) values[i] = (float)i * 0.25f + 1.0f;
    cpm_image *image = NULL;
    assert_ok(context, cpm_image_create(context, width, height, wavelengths, bins, values, &image));
    free(values);
    return image;
}

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

#ifdef CPM_WITH_OPENEXR
#include <openexr.h>

/* Reads every channel of a file whole: channels[i] is height x width, in the file's order. */
typedef struct exr_content {
    int32_t width, height;
    int count;
    char names[CPM_MAX_BINS + 3][CPM_EXR_NAME_SIZE];
    float *values[CPM_MAX_BINS + 3];
    char layout[16], units[32];
    exr_compression_t compression;
} exr_content;

static void copy_string(exr_context_t exr, const char *name, char *to, size_t size) {
    int32_t length = 0;
    const char *text = NULL;
    assert_int_equal(exr_attr_get_string(exr, 0, name, &length, &text), EXR_ERR_SUCCESS);
    snprintf(to, size, "%.*s", (int)length, text);
}

static exr_content *read_exr(const char *path) {
    exr_context_t exr = NULL;
    assert_int_equal(exr_start_read(&exr, path, NULL), EXR_ERR_SUCCESS);
    exr_content *content = calloc(1, sizeof *content);
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list = NULL;
    int32_t lines = 0;
    assert_int_equal(exr_get_data_window(exr, 0, &window), EXR_ERR_SUCCESS);
    assert_int_equal(exr_get_channels(exr, 0, &list), EXR_ERR_SUCCESS);
    assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &lines), EXR_ERR_SUCCESS);
    assert_int_equal(exr_get_compression(exr, 0, &content->compression), EXR_ERR_SUCCESS);
    copy_string(exr, "spectralLayoutVersion", content->layout, sizeof content->layout);
    copy_string(exr, "emissiveUnits", content->units, sizeof content->units);
    content->width = window.max.x - window.min.x + 1;
    content->height = window.max.y - window.min.y + 1;
    content->count = list->num_channels;
    const size_t width = (size_t)content->width;
    for (int i = 0; i < list->num_channels; i++) {
        snprintf(content->names[i], CPM_EXR_NAME_SIZE, "%s", list->entries[i].name.str);
        assert_int_equal(list->entries[i].pixel_type, EXR_PIXEL_FLOAT);
        content->values[i] = calloc((size_t)content->height * width, sizeof(float));
    }
    exr_decode_pipeline_t pipeline;
    memset(&pipeline, 0, sizeof pipeline);
    for (int32_t y = 0; y < content->height; y += lines) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_read_scanline_chunk_info(exr, 0, y, &chunk), EXR_ERR_SUCCESS);
        assert_int_equal(y == 0 ? exr_decoding_initialize(exr, 0, &chunk, &pipeline)
                                : exr_decoding_update(exr, 0, &chunk, &pipeline),
                         EXR_ERR_SUCCESS);
        for (int i = 0; i < content->count; i++) {
            exr_coding_channel_info_t *to = &pipeline.channels[i];
            to->decode_to_ptr = (uint8_t *)(content->values[i] + (size_t)y * width);
            to->user_pixel_stride = sizeof(float);
            to->user_line_stride = (int32_t)(width * sizeof(float));
            to->user_bytes_per_element = sizeof(float);
            to->user_data_type = EXR_PIXEL_FLOAT;
        }
        if (y == 0) assert_int_equal(exr_decoding_choose_default_routines(exr, 0, &pipeline), EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_run(exr, 0, &pipeline), EXR_ERR_SUCCESS);
    }
    exr_decoding_destroy(exr, &pipeline);
    exr_finish(&exr);
    return content;
}

static void free_content(exr_content *content) {
    for (int i = 0; i < content->count; i++) free(content->values[i]);
    free(content);
}

static const float *find_channel(const exr_content *content, const char *name) {
    for (int i = 0; i < content->count; i++)
        if (strcmp(content->names[i], name) == 0) return content->values[i];
    fail_msg("no channel %s", name);
    return NULL;
}

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

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void assert_text(const char *path, const char *text) {
    char read[64] = "";
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    read[fread(read, 1, sizeof read - 1, file)] = 0;
    fclose(file);
    assert_string_equal(read, text);
}

static void bad_paths(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 4, 4, 4);
    assert_status(context, CPM_ERROR_IO, cpm_image_write_exr(context, image, in_folder("none/a.exr"), NULL));
    assert_non_null(strstr(cpm_context_last_error(context), "No such file or directory"));
    assert_non_null(strstr(cpm_context_last_error(context), "none/a.exr"));
    /* A folder, a device: not replaced. */
    assert_status(context, CPM_ERROR_IO, cpm_image_write_exr(context, image, folder, NULL));
    assert_status(context, CPM_ERROR_IO, cpm_image_write_exr(context, image, "/dev/null", NULL));
    assert_non_null(strstr(cpm_context_last_error(context), "not a regular file"));
    struct stat null_device;
    assert_int_equal(stat("/dev/null", &null_device), 0);
    assert_true(S_ISCHR(null_device.st_mode));
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_write_exr(context, image, "", NULL));
    assert_status(context, CPM_ERROR_INVALID_ARGUMENT, cpm_image_write_exr(context, image, NULL, NULL));
    /* A name at the system's limit leaves no room for the suffix of the file beside it: refused, not cut. */
    char name[300];
    memset(name, 'a', sizeof name);
    strcpy(name + 251, ".exr");
    char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_status(context, CPM_ERROR_IO, cpm_image_write_exr(context, image, path, NULL));
    assert_int_equal(empty_folder(), 0);
    cpm_image_release(image);
    cpm_context_release(context);
}

/* A full disk, played by the limit on a file's size: the old file stays, nothing is left beside it. */
static void full_disk(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 200, 100, 16);
    write_text(in_folder("a.exr"), "old");
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const rlim_t limits[] = {0, 100, 2000, 20000, 100000};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        const struct rlimit small = {.rlim_cur = limits[i], .rlim_max = before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        const cpm_status status = cpm_image_write_exr(context, image, in_folder("a.exr"), NULL);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        assert_int_equal(status, CPM_ERROR_IO);
        assert_non_null(strstr(cpm_context_last_error(context), "File too large"));
        assert_text(in_folder("a.exr"), "old");
    }
    signal(SIGXFSZ, handler);
    assert_int_equal(empty_folder(), 1);
    cpm_image_release(image);
    cpm_context_release(context);
}

static int32_t stop_at_half(void *user, const char *stage, double fraction) {
    int *calls = user;
    ++*calls;
    assert_string_equal(stage, "write");
    return fraction >= 0.5;
}

static void cancelled_leaves_the_old_file(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 20, 200, 8);
    write_text(in_folder("a.exr"), "old");
    int calls = 0;
    assert_ok(context, cpm_context_set_progress(context, stop_at_half, &calls));
    assert_status(context, CPM_ERROR_CANCELLED, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
    assert_true(calls > 1);
    assert_text(in_folder("a.exr"), "old");
    assert_ok(context, cpm_context_set_progress(context, NULL, NULL));
    assert_ok(context, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
    free_content(read_exr(in_folder("a.exr")));
    assert_int_equal(empty_folder(), 1);
    cpm_image_release(image);
    cpm_context_release(context);
}

static void mode_follows_umask(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 2, 2, 2);
    const mode_t before = umask(027);
    assert_ok(context, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
    umask(before);
    struct stat file;
    assert_int_equal(stat(in_folder("a.exr"), &file), 0);
    assert_int_equal(file.st_mode & 0777, 0640);
    empty_folder();
    cpm_image_release(image);
    cpm_context_release(context);
}

#else

static void says_that_it_cannot(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_image *image = gradient_image(context, 4, 4, 4);
    assert_status(context, CPM_ERROR_UNSUPPORTED, cpm_image_write_exr(context, image, in_folder("a.exr"), NULL));
    assert_non_null(strstr(cpm_context_last_error(context), "CPM_WITH_OPENEXR"));
    assert_int_equal(empty_folder(), 0);
    cpm_image_release(image);
    cpm_context_release(context);
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(image_keeps_what_it_is_given),
        cmocka_unit_test(image_refuses),
        cmocka_unit_test(names_of_channels),
        cmocka_unit_test(colours),
#ifdef CPM_WITH_OPENEXR
        cmocka_unit_test(written_equals_read),
        cmocka_unit_test(callers_rgb_is_written),
        cmocka_unit_test(infrared),
        cmocka_unit_test(bad_paths),
        cmocka_unit_test(full_disk),
        cmocka_unit_test(cancelled_leaves_the_old_file),
        cmocka_unit_test(mode_follows_umask),
#else
        cmocka_unit_test(says_that_it_cannot),
#endif
    };
    return cmocka_run_group_tests_name("exr", tests, make_folder, remove_folder);
}
