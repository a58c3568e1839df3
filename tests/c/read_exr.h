/* read_exr.h: an OpenEXR file read whole, by OpenEXR's own reader. */
#ifndef CPM_TESTS_READ_EXR_H
#define CPM_TESTS_READ_EXR_H
#ifdef CPM_WITH_OPENEXR
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "io/exr.h"

/* Reads every channel of a file whole: channels[i] is height x width, in the file's order. */
typedef struct exr_content {
    int32_t width, height;
    int count;
    char names[CPM_MAX_BINS + 3][CPM_EXR_NAME_SIZE];
    float *values[CPM_MAX_BINS + 3];
    char layout[16], units[32];
    exr_compression_t compression;
} exr_content;

static inline void copy_string(exr_context_t exr, const char *name, char *to, size_t size) {
    int32_t length = 0;
    const char *text = NULL;
    assert_int_equal(exr_attr_get_string(exr, 0, name, &length, &text), EXR_ERR_SUCCESS);
    snprintf(to, size, "%.*s", (int)length, text);
}

static inline exr_content *read_exr(const char *path) {
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

static inline void free_content(exr_content *content) {
    for (int i = 0; i < content->count; i++) free(content->values[i]);
    free(content);
}

static inline const float *find_channel(const exr_content *content, const char *name) {
    for (int i = 0; i < content->count; i++)
        if (strcmp(content->names[i], name) == 0) return content->values[i];
    fail_msg("no channel %s", name);
    return NULL;
}
#endif
#endif
