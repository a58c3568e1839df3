/* render/eye.c: the eye pass on the processor's threads: curved eye rays, specular surfaces followed both ways, gathers
 * at the diffuse ends; what a ray sees is cl/shared/eye.h. Each tile is one thread's, whole: pictures do not depend on
 * threads. */
#include "eye.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/bundles.h"
#include "backend/native/host.h"

static double index_of(const cpm_world *w, const cpm_flight *flight, const cpm_arrival *a, int32_t bin);
#define CPM_EYE_INDEX(w, flight, arrival, bin) index_of(w, flight, arrival, bin)
/* after the host's */
#include "cl/shared/eye_branch.h"

#define TILE 16

typedef struct gaze { /* a tile's live branches */
    cpm_flight *flights;
    int32_t *pixels; /* in the tile */
    float *weights;  /* bins each */
    cpm_arrival *arrivals;
    cpm_leeway *leeways; /* of their bins, a part of the pixel */
    size_t count, capacity;
} gaze;

typedef struct viewer {
    const cpm_pass *pass;
    const cpm_gather *gather;
    const cpm_eye *eye;
    cpm_map_query *queries[CPM_POPULATIONS];
    double *irradiance, *sum; /* bins; tile x bins */
    cpm_vec forward;
    double pixel; /* radians of leeway in the picture's middle */
    gaze now, next;
    cpm_bundles bundles;
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
    void *leeways = realloc(g->leeways, capacity * sizeof *g->leeways);
    if (leeways) g->leeways = leeways;
    if (!flights || !pixels || !weights || !arrivals || !leeways) return 0;
    g->capacity = capacity;
    return 1;
}

static void gaze_free(gaze *g) {
    free(g->flights), free(g->pixels), free(g->weights), free(g->arrivals), free(g->leeways);
}

/* Bins that go one way in a medium that disperses have each their own n. */
static double index_of(const cpm_world *w, const cpm_flight *flight, const cpm_arrival *a, int32_t bin) {
    const int32_t medium = cpm_region_medium(&flight->region);
    const int together = w->places[medium].disperses && cpm_bins_count(flight->bin, w->frame.bins) > 1;
    return together ? world_index(w, medium, bin, a->hit.position) : a->n;
}

/* A branch that has arrived, of the pixel and with the leeway given. */
typedef struct glance {
    const cpm_flight *flight;
    const cpm_arrival *arrival;
    float *weights;
    int32_t pixel, depth;
    cpm_leeway leeway;
} glance;

static void cross(const viewer *v, const cpm_flight *flight, const cpm_arrival *a, const float *weights, double angle,
                  cpm_branches *to) {
    if (!cpm_bundle_parts(v->pass, flight, a, angle)) {
        eye_branch_boundary(&v->pass->world, v->eye, flight, a, weights, to);
        return;
    }
    for (int upper = 0; upper < 2; upper++) {
        cpm_flight half = *flight;
        cpm_arrival at;
        const size_t before = cpm_bundle_half(v->pass, flight, a, upper, &half, &at);
        cross(v, &half, &at, &weights[before], angle, to);
    }
}

/* Rays that may see the sky are followed until they leave, not only until they cannot come back: light still bends; and
 * where air dims, how much of it was on the way is measured. */
static const cpm_follow_options to_the_extent = {.far = INFINITY};
static const cpm_follow_options *options_of(const cpm_pass *pass) {
    return pass->sky || pass->extinction ? &to_the_extent : NULL;
}

/* What air takes on the way, from the weights of the bins that a flight carries. */
static void dim(const viewer *v, const glance *g) {
    if (!v->pass->extinction) return;
    const size_t first = (size_t)eye_first_bin(g->flight), count = (size_t)eye_bins(v->eye, g->flight);
    for (size_t b = 0; b < count; b++)
        g->weights[b] *= (float)cpm_transmittance(v->pass, g->flight, g->arrival, first + b);
}

/* Suns and environments, in the direction in which the ray left. */
static void see_sky(viewer *v, const glance *g) {
    const cpm_pass *pass = v->pass;
    const size_t first = (size_t)eye_first_bin(g->flight), count = (size_t)eye_bins(v->eye, g->flight);
    double *sum = &v->sum[(size_t)g->pixel * pass->bins], *radiance = v->irradiance;
    for (size_t l = 0; l < pass->scene->light_count; l++) {
        if (!cpm_sky_radiance(pass, l, g->arrival->direction, first, count, radiance)) continue;
        for (size_t b = 0; b < count; b++)
            sum[first + b] += cpm_shade_light(g->weights[b], radiance[b], v->eye->squared_index[first + b]);
    }
}

static void see(viewer *v, const glance *g) {
    const cpm_world *w = &v->pass->world;
    const size_t bins = v->pass->bins;
    const cpm_arrival *a = g->arrival;
    const int32_t seen = eye_seen(w, v->eye, a);
    v->evaluations += a->evaluations;
    dim(v, g);
    if (a->status == CPM_RAY_LEFT && v->pass->sky) see_sky(v, g);
    if (seen == CPM_SEEN_DIFFUSE) {
        cpm_gather_seen(v->gather, w, v->queries, a, v->irradiance);
        v->gathers++;
    }
    eye_add(w, v->eye, g->flight, a, seen, g->weights, v->irradiance, &v->sum[(size_t)g->pixel * bins]);
    if (seen < CPM_SEEN_MIRROR) return;
    if (!gaze_reserve(&v->next, bins, 2 * bins)) {
        v->failed = 1;
        return;
    }
    cpm_branches to = {&v->next.flights[v->next.count], &v->next.weights[v->next.count * bins], 0};
    if (seen == CPM_SEEN_MIRROR)
        eye_branches(w, v->eye, g->flight, a, seen, g->weights, g->depth, &to);
    else if (g->depth < CPM_EYE_DEPTH)
        cross(v, g->flight, a, g->weights, g->leeway.angle, &to);
    for (int32_t k = 0; k < to.count; k++, v->next.count++) {
        v->next.pixels[v->next.count] = g->pixel;
        v->next.leeways[v->next.count] = g->leeway;
    }
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
            /* a pixel off the middle is smaller */
            const double cosine = cpm_vdot(to->flights[to->count].direction, v->forward);
            to->leeways[to->count] = (cpm_leeway){0.0, v->pixel * cosine * cosine};
            for (int32_t b = 0; b < bins; b++) to->weights[to->count * (size_t)bins + (size_t)b] = 1.0f;
        }
    }
}

/* All live branches to their next surface, and what they see there. */
static void follow_now(viewer *v, int32_t depth) {
    const gaze *now = &v->now;
    cpm_follow(v->pass, now->flights, now->count, options_of(v->pass), now->arrivals);
    v->segments += now->count;
    for (size_t i = 0; i < now->count && !v->failed && !cpm_poll(v->pass->context); i++) {
        const glance g = {&now->flights[i], &now->arrivals[i], &now->weights[i * v->pass->bins], now->pixels[i], depth,
                          now->leeways[i]};
        see(v, &g);
    }
}

/* The same where bins of one ray may stay together in a medium that disperses. */
static void follow_now_in_bundles(viewer *v, int32_t depth) {
    const gaze *now = &v->now;
    cpm_bundles *b = &v->bundles;
    if (!cpm_follow_bundles(b, v->pass, CPM_BUNDLES_OF_EYE, now->flights, now->leeways, now->count,
                            options_of(v->pass))) {
        v->failed = 1;
        return;
    }
    v->segments += b->followed;
    for (size_t i = 0; i < b->count && !v->failed && !cpm_poll(v->pass->context); i++) {
        const cpm_parted *p = &b->parted[i];
        cpm_flight flight = now->flights[p->from];
        const size_t before = (size_t)(cpm_bins_first(p->bin) - cpm_bins_first(flight.bin));
        const cpm_leeway leeway = cpm_leeway_after(&now->leeways[p->from], &flight, &p->arrival);
        flight.bin = p->bin;
        const glance g = {&flight, &p->arrival, &now->weights[p->from * v->pass->bins + before], now->pixels[p->from],
                          depth,   leeway};
        see(v, &g);
    }
}

/* The live branches to their ends: all of them to their next surface, then those that go on. */
static void follow_branches(viewer *v) {
    for (int32_t depth = 0; v->next.count && !v->failed && !cpm_poll(v->pass->context); depth++) {
        gaze swap = v->now;
        v->now = v->next;
        v->next = swap;
        v->next.count = 0;
        if (cpm_pass_bundles(v->pass))
            follow_now_in_bundles(v, depth);
        else
            follow_now(v, depth);
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
    const double *forward = eye->is.forward, *right = eye->is.right;
    const viewer model = {.pass = pass,
                          .gather = gather,
                          .eye = eye,
                          .forward = cpm_v(forward[0], forward[1], forward[2]),
                          .pixel = pass->bundle_tolerance * 2.0 * cpm_norm(cpm_v(right[0], right[1], right[2])) /
                                   image->width};
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
        gaze_free(&v.now), gaze_free(&v.next), cpm_bundles_free(&v.bundles);
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
