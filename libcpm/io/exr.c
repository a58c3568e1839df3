/* io/exr.c: writing the spectral film, through OpenEXRCore alone. */
#include "io/exr.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "api/version.h"
#include "io/atomic_file.h"
#include "io/colour.h"
#include "render/image.h"

#ifdef CPM_WITH_OPENEXR
#include <openexr.h>

#define RGB_CHANNELS 3

/* Where the samples of one channel lie: a spectral bin of the image, or R, G, B of the preview. */
typedef struct channel {
    char name[CPM_EXR_NAME_SIZE];
    size_t index; /* bin, or 0..2 */
    int preview;
} channel;

typedef struct writer {
    cpm_context *context;
    const cpm_image *image;
    const float *rgb; /* height x width x 3, or NULL: made here */
    cpm_atomic_file file;
    exr_context_t exr;
    size_t channel_count;
    channel channels[CPM_MAX_BINS + RGB_CHANNELS];
    float *rows; /* lines x width x 3: the preview of one chunk, where rgb is NULL */
    double weights[CPM_MAX_BINS][3];
} writer;

/* Without a handler OpenEXR prints on stderr. This one only keeps it quiet: it may be called with the context's lock
 * held, and then any call on the context, exr_get_user_data included, waits for ever (3.1.5). */
static void on_error(exr_const_context_t exr, exr_result_t code, const char *message) {
    (void)exr;
    (void)code;
    (void)message;
}

static int64_t on_write(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error) {
    (void)exr;
    (void)error;
    writer *w = user;
    return cpm_atomic_file_write(&w->file, bytes, size, offset) == 0 ? (int64_t)size : -1;
}

/* The system's word for it where there is one, else OpenEXR's. */
static cpm_status failed(writer *w, exr_result_t code) {
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return cpm_fail(w->context, CPM_ERROR_OUT_OF_MEMORY, "no memory to write '%s'", w->file.path);
    const char *why = w->file.error ? strerror(w->file.error) : exr_get_default_error_message(code);
    return cpm_fail(w->context, CPM_ERROR_IO, "'%s' could not be written: %s", w->file.path, why);
}

static int by_name(const void *a, const void *b) {
    return strcmp(((const channel *)a)->name, ((const channel *)b)->name);
}

/* The format wants channels in the order of their names: 1000 nm stands before 400 nm. */
static void list_channels(writer *w) {
    static const char *const rgb[RGB_CHANNELS] = {"R", "G", "B"};
    for (size_t i = 0; i < w->image->bins; i++) {
        channel *c = &w->channels[w->channel_count++];
        cpm_exr_channel_name(w->image->wavelengths[i], c->name);
        c->index = i;
    }
    for (size_t i = 0; i < RGB_CHANNELS; i++) {
        channel *c = &w->channels[w->channel_count++];
        memcpy(c->name, rgb[i], 2);
        c->index = i;
        c->preview = 1;
    }
    qsort(w->channels, w->channel_count, sizeof *w->channels, by_name);
}

static exr_result_t write_header(writer *w) {
    static const exr_attr_chromaticities_t srgb = {0.6400f, 0.3300f, 0.3000f, 0.6000f,
                                                   0.1500f, 0.0600f, 0.3127f, 0.3290f};
    int part = 0;
    exr_result_t r = exr_add_part(w->exr, "spectral", EXR_STORAGE_SCANLINE, &part);
    if (r == EXR_ERR_SUCCESS)
        r = exr_initialize_required_attr_simple(w->exr, part, w->image->width, w->image->height, EXR_COMPRESSION_ZIP);
    for (size_t i = 0; i < w->channel_count && r == EXR_ERR_SUCCESS; i++)
        r = exr_add_channel(w->exr, part, w->channels[i].name, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_string(w->exr, part, "spectralLayoutVersion", "1.0");
    /* Per nanometre, whatever the bins: the layout's examples say W.m^-2.sr^-1, which would be a bin's integral. */
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_string(w->exr, part, "emissiveUnits", "W.m^-2.sr^-1.nm^-1");
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_chromaticities(w->exr, part, "chromaticities", &srgb);
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_string(w->exr, part, "software", "libcpm " CPM_VERSION_TEXT);
    if (r == EXR_ERR_SUCCESS) r = exr_write_header(w->exr);
    return r;
}

static void point_at(writer *w, const exr_chunk_info_t *chunk, exr_encode_pipeline_t *pipeline) {
    const size_t width = (size_t)w->image->width, bins = w->image->bins;
    const size_t first = (size_t)chunk->start_y * width;
    const float *spectra = w->image->data + first * bins;
    const float *rgb = w->rgb ? w->rgb + first * RGB_CHANNELS : w->rows;
    if (!w->rgb) cpm_colour_rgb(spectra, (size_t)chunk->height * width, bins, (const double(*)[3])w->weights, w->rows);
    for (size_t i = 0; i < w->channel_count; i++) {
        const channel *c = &w->channels[i];
        const size_t stride = c->preview ? RGB_CHANNELS : bins;
        exr_coding_channel_info_t *to = &pipeline->channels[i];
        to->encode_from_ptr = (const uint8_t *)((c->preview ? rgb : spectra) + c->index);
        to->user_pixel_stride = (int32_t)(stride * sizeof(float));
        to->user_line_stride = (int32_t)(width * stride * sizeof(float));
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
    }
}

static cpm_status write_pixels(writer *w) {
    int32_t lines = 1;
    exr_result_t r = exr_get_scanlines_per_chunk(w->exr, 0, &lines);
    if (r != EXR_ERR_SUCCESS) return failed(w, r);
    if (!w->rgb) {
        w->rows = malloc((size_t)lines * (size_t)w->image->width * RGB_CHANNELS * sizeof *w->rows);
        if (!w->rows) return failed(w, EXR_ERR_OUT_OF_MEMORY);
        cpm_colour_weights(w->image->wavelengths, w->image->bins, w->weights);
    }
    exr_encode_pipeline_t pipeline;
    memset(&pipeline, 0, sizeof pipeline);
    int cancelled = 0;
    for (int32_t y = 0; y < w->image->height && r == EXR_ERR_SUCCESS && !cancelled; y += lines) {
        exr_chunk_info_t chunk;
        r = exr_write_scanline_chunk_info(w->exr, 0, y, &chunk);
        if (r == EXR_ERR_SUCCESS)
            r = y == 0 ? exr_encoding_initialize(w->exr, 0, &chunk, &pipeline)
                       : exr_encoding_update(w->exr, 0, &chunk, &pipeline);
        if (r == EXR_ERR_SUCCESS) {
            point_at(w, &chunk, &pipeline);
            if (y == 0) r = exr_encoding_choose_default_routines(w->exr, 0, &pipeline);
        }
        if (r == EXR_ERR_SUCCESS) r = exr_encoding_run(w->exr, 0, &pipeline);
        cancelled = cpm_progress(w->context, "write", (double)y / (double)w->image->height);
    }
    exr_encoding_destroy(w->exr, &pipeline);
    if (r != EXR_ERR_SUCCESS) return failed(w, r);
    return cancelled ? cpm_fail(w->context, CPM_ERROR_CANCELLED, "writing '%s' was cancelled", w->file.path) : CPM_OK;
}

static cpm_status write_exr(writer *w) {
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_error;
    options.user_data = w;
    options.write_fn = on_write;
    exr_result_t r = exr_start_write(&w->exr, w->file.path, EXR_WRITE_FILE_DIRECTLY, &options);
    if (r != EXR_ERR_SUCCESS) return failed(w, r);
    list_channels(w);
    r = write_header(w);
    cpm_status status = r == EXR_ERR_SUCCESS ? write_pixels(w) : failed(w, r);
    r = exr_finish(&w->exr);
    if (status == CPM_OK && (r != EXR_ERR_SUCCESS || w->file.error)) status = failed(w, r);
    free(w->rows);
    return status;
}

cpm_status cpm_image_write_exr(cpm_context *context, const cpm_image *image, const char *path, const float *rgb) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!image) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "image is NULL");
    if (!path || !*path) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "path is %s", path ? "empty" : "NULL");
    cpm_progress_begin(context);
    writer *w = calloc(1, sizeof *w);
    if (!w) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to write '%s'", path);
    w->context = context;
    w->image = image;
    w->rgb = rgb;
    int error = cpm_atomic_file_open(&w->file, path);
    cpm_status status = CPM_OK;
    if (!error) {
        status = write_exr(w);
        if (status != CPM_OK)
            cpm_atomic_file_abandon(&w->file);
        else
            error = cpm_atomic_file_commit(&w->file);
    }
    free(w);
    if (error == EEXIST) return cpm_fail(context, CPM_ERROR_IO, "'%s' could not be written: not a regular file", path);
    if (error) return cpm_fail(context, CPM_ERROR_IO, "'%s' could not be written: %s", path, strerror(error));
    return status;
}

#else

cpm_status cpm_image_write_exr(cpm_context *context, const cpm_image *image, const char *path, const float *rgb) {
    (void)rgb;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!image) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "image is NULL");
    if (!path || !*path) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "path is %s", path ? "empty" : "NULL");
    return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                    "'%s' was not written: this library was built without OpenEXR (CPM_WITH_OPENEXR=OFF)", path);
}

#endif
