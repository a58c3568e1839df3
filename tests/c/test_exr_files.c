/* test_exr_files.c: never half a file: bad paths, a full disk, a cancel, permissions; a library without OpenEXR says
 * so. */
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "picture_folder.h"
#include "read_exr.h"

#ifdef CPM_WITH_OPENEXR

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
#ifdef CPM_WITH_OPENEXR
        cmocka_unit_test(bad_paths),
        cmocka_unit_test(full_disk),
        cmocka_unit_test(cancelled_leaves_the_old_file),
        cmocka_unit_test(mode_follows_umask),
#else
        cmocka_unit_test(says_that_it_cannot),
#endif
    };
    return cmocka_run_group_tests_name("exr files", tests, make_folder, remove_folder);
}
