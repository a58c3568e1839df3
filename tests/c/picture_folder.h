/* picture_folder.h: a folder for a test's files, and a picture to write there. */
#ifndef CPM_TESTS_PICTURE_FOLDER_H
#define CPM_TESTS_PICTURE_FOLDER_H
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "check.h"

static char folder[64];

static inline const char *in_folder(const char *name) {
    static char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/cpm-test-exr-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

/* Counts what is in the folder, and empties it. */
static inline int empty_folder(void) {
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

static inline int remove_folder(void **state) {
    (void)state;
    empty_folder();
    return rmdir(folder);
}

/* 16 bins over 400..700 nm, and values that tell every pixel and bin apart. */
static inline cpm_image *gradient_image(cpm_context *context, int32_t width, int32_t height, size_t bins) {
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
#endif
