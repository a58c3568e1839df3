/* render/eye.c: the eye pass on the processor's threads: curved eye rays, specular surfaces followed both ways, gathers
 * at the diffuse ends; what a ray sees is cl/shared/eye.h. Each tile is one thread's, whole: pictures do not depend on
 * threads. */
#include "eye.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/follow.h"
#include "backend/native/host.h"
/* after the host's */
#include "cl/shared/eye_branch.h"

#define TILE 16

typedef struct gaze { /* a tile's live branches */
    cpm_flight *flights;
    int32_t *pixels; /* in the tile */
    float *weights;  /* bins each */
    cpm_arrival *arrivals;
    size_t count, capacity;
} gaze;

typedef struct viewer {
    const cpm_pass *pass;
    const cpm_gather *gather;
    const cpm_eye *eye;
    cpm_map_query *queries[CPM_POPULATIONS];
    double *irradiance, *sum; /* bins; tile x bins */
    gaze now, next;
    uint64_t rays, segments, gathers;
    double evaluations;
    int failed;
} viewer;

static int gaze_reserve(gaze *g, size_t bins, size_t more) {
    if (g->count + more <= g->capacity) return 1;
    size_t capacity = 2 * (g->count + more);
    void *flights = realloc(g->flights, capacity * sizeof *g->flights);
    if (flights) g->flights = flights;
    void *pixels = realloc(g->pixels, capacity * sizeof *g->pixels);
    if (pixels) g->pixels = pixels;
    void *weights = realloc(g->weights, capacity * bins * sizeof *g->weights);
    if (weights) g->weights = weights;
    void *arrivals = realloc(g->arrivals, capacity * sizeof *g->arrivals);
    if (arrivals) g->arrivals = arrivals;
    if (!flights || !pixels || !weights || !arrivals) return 0;
    g->capacity = capacity;
    return 1;
}

static void gaze_free(gaze *g) { free(g->flights), free(g->pixels), free(g->weights), free(g->arrivals); }

/* One branch, `i` of those that live now, has arrived. */
static void see(viewer *v, size_t i, int32_t depth) {
    const cpm_world *w = &v->pass->world;
    const size_t bins = v->pass->bins;
    const cpm_flight *flight = &v->now.flights[i];
    const cpm_arrival *a = &v->now.arrivals[i];
    const float *weights = &v->now.weights[i * bins];
    const int32_t seen = eye_seen(w, v->eye, a), pixel = v->now.pixels[i];
    v->segments++;
    v->evaluations += a->evaluations;
    if (seen == CPM_SEEN_DIFFUSE) {
        cpm_gather_seen(v->gather, w, v->queries, a, v->irradiance);
        v->gathers++;
    }
    eye_add(w, v->eye, flight, a, seen, weights, v->irradiance, &v->sum[(size_t)pixel * bins]);
    if (seen < CPM_SEEN_MIRROR) return;
    if (!gaze_reserve(&v->next, bins, 2 * bins)) {
        v->failed = 1;
        return;
    }
    cpm_branches to = {&v->next.flights[v->next.count], &v->next.weights[v->next.count * bins], 0};
    eye_branches(w, v->eye, flight, a, seen, weights, depth, &to);
    for (int32_t k = 0; k < to.count; k++) v->next.pixels[v->next.count++] = pixel;
}

/* Eye rays of a pixel: samples [first, end). */
static void look(viewer *v, int32_t column, int32_t row, int32_t pixel, int32_t first, int32_t end) {
    const int32_t bins = v->eye->is.bins, each = v->eye->is.splits ? bins : 1;
    gaze *to = &v->next;
    if (!gaze_reserve(to, (size_t)bins, (size_t)(each * (end - first)))) {
        v->failed = 1;
        return;
    }
    for (int32_t s = first; s < end; s++) {
        v->rays++;
        for (int32_t bin = 0; bin < each; bin++, to->count++) {
            to->flights[to->count] =
                eye_start(v->eye, row * v->eye->is.width + column, s, v->eye->is.splits ? bin : -1);
            to->pixels[to->count] = pixel;
            for (int32_t b = 0; b < bins; b++) to->weights[to->count * (size_t)bins + (size_t)b] = 1.0f;
        }
    }
}

/* The live branches to their ends: all of them to their next surface, then those that go on. */
static void follow_branches(viewer *v) {
    cpm_context *context = v->pass->context;
    for (int32_t depth = 0; v->next.count && !v->failed && !cpm_poll(context); depth++) {
        gaze swap = v->now;
        v->now = v->next;
        v->next = swap;
        v->next.count = 0;
        cpm_follow(v->pass, v->now.flights, v->now.count, NULL, v->now.arrivals);
        for (size_t i = 0; i < v->now.count && !v->failed && !cpm_poll(context); i++) see(v, i, depth);
    }
}

static void paint_tile(viewer *v, int32_t tile, int32_t across, cpm_image *image) {
    const size_t bins = v->pass->bins;
    const int32_t samples = v->eye->is.samples;
    int32_t x0 = tile % across * TILE, y0 = tile / across * TILE;
    int32_t x1 = x0 + TILE < image->width ? x0 + TILE : image->width;
    int32_t y1 = y0 + TILE < image->height ? y0 + TILE : image->height;
    memset(v->sum, 0, TILE * TILE * bins * sizeof *v->sum);
    for (int32_t s = 0; s < samples && !v->failed && !cpm_cancelled(v->pass->context); s += CPM_EYE_SAMPLES_AT_ONCE) {
        const int32_t end = samples - s < CPM_EYE_SAMPLES_AT_ONCE ? samples : s + CPM_EYE_SAMPLES_AT_ONCE;
        v->next.count = 0;
        for (int32_t y = y0; y < y1; y++)
            for (int32_t x = x0; x < x1; x++) look(v, x, y, (y - y0) * TILE + x - x0, s, end);
        follow_branches(v);
    }
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++)
            for (size_t b = 0; b < bins; b++)
                image->data[((size_t)y * (size_t)image->width + (size_t)x) * bins + b] =
                    (float)(v->sum[(size_t)((y - y0) * TILE + x - x0) * bins + b] / samples);
}

static cpm_status paint(const cpm_pass *pass, const cpm_gather *gather, const cpm_eye *eye, cpm_image *image) {
    cpm_context *context = pass->context;
    const size_t bins = pass->bins;
    const int32_t across = (image->width + TILE - 1) / TILE, tiles = across * ((image->height + TILE - 1) / TILE);
    const viewer model = {.pass = pass, .gather = gather, .eye = eye};
    int failed = 0, done = 0;
    double *evaluations = calloc((size_t)tiles, sizeof *evaluations);
    if (!evaluations) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass");
#pragma omp parallel num_threads(context->threads)
    {
        viewer v = model;
        v.irradiance = malloc(bins * sizeof(double));
        v.sum = malloc(TILE * TILE * bins * sizeof(double));
        v.failed = !cpm_gather_queries(gather, v.queries) || !v.irradiance || !v.sum;
#pragma omp for schedule(dynamic, 1) nowait
        for (int32_t t = 0; t < tiles; t++) {
            v.evaluations = 0.0;
            if (!v.failed && !cpm_cancelled(context)) paint_tile(&v, t, across, image);
            evaluations[t] = v.evaluations;
            int so_far;
#pragma omp atomic capture
            so_far = ++done;
            if (omp_get_thread_num() == 0) cpm_progress(context, "gather", (double)so_far / tiles);
        }
        if (omp_get_thread_num() == 0) cpm_wait(context, &done, tiles);
        cpm_gather_queries_free(v.queries);
        gaze_free(&v.now), gaze_free(&v.next);
        free(v.irradiance), free(v.sum);
#pragma omp critical(cpm_collect)
        {
            failed |= v.failed;
            image->stats.eye_rays += v.rays;
            image->stats.eye_segments += v.segments;
            image->stats.gathers += v.gathers;
        }
    }
    double sum = 0.0;
    for (int32_t t = 0; t < tiles; t++) sum += evaluations[t];
    free(evaluations);
    image->stats.eye_evaluations = (uint64_t)sum;
    return failed ? cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass") : CPM_OK;
}

cpm_status cpm_eye_pass(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                        cpm_image *image) {
    cpm_eye_tables tables;
    cpm_progress(pass->context, "gather", 0.0);
    cpm_status status = cpm_eye_begin(pass, gather, seed, samples, image, &tables);
    if (!status) status = paint(pass, gather, &tables.eye, image);
    cpm_eye_end(&tables);
    if (!status && cpm_progress(pass->context, "gather", 1.0))
        status = cpm_fail(pass->context, CPM_ERROR_CANCELLED, "cancelled while gathering");
    return status;
}
