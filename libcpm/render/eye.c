/* render/eye.c: curved eye rays, specular surfaces followed both ways, gathers at the diffuse ends; what a ray sees is
 * cl/shared/shade.h. Each tile is one thread's, whole: pictures do not depend on threads. */
#include "eye.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/bundles.h"
#include "cl/shared/scatter.h"
#include "cl/shared/shade.h"

#define TILE 16
#define SAMPLES_AT_ONCE 4  /* of each pixel: so many branches live together, however many samples are asked for */
#define MAX_DEPTH 64       /* specular surfaces along one branch */
#define LEAST_WEIGHT 1e-4f /* of an eye ray: branches that carry less end */

typedef struct glance { /* one branch of an eye ray */
    cpm_flight flight;
    int32_t pixel; /* in the tile */
    int32_t depth;
    cpm_leeway leeway; /* of its bins, a part of the pixel */
} glance;

typedef struct gaze { /* a tile's live branches */
    glance *all;
    float *weights; /* bins each */
    cpm_flight *flights;
    cpm_arrival *arrivals;
    cpm_leeway *leeways; /* used where bundles may stay together */
    size_t count, capacity;
} gaze;

typedef struct viewer {
    const cpm_pass *pass;
    const cpm_gather *gather;
    cpm_query *queries[CPM_POPULATIONS];
    cpm_vec origin, forward, right, up; /* right and up scaled to half the picture */
    cpm_region region;
    const double *squared_index; /* bins: n_c^2 */
    uint64_t seed;
    int32_t samples, splits;
    double *irradiance, *scratch, *sum; /* bins; bins; tile x bins */
    double pixel;                       /* radians of leeway in the picture's middle */
    gaze now, next;
    cpm_bundles bundles;
    uint64_t rays, segments, gathers;
    double evaluations;
    int failed;
} viewer;

static int gaze_reserve(gaze *g, size_t bins, size_t more) {
    if (g->count + more <= g->capacity) return 1;
    size_t capacity = 2 * (g->count + more);
    void *all = realloc(g->all, capacity * sizeof *g->all);
    if (all) g->all = all;
    void *weights = realloc(g->weights, capacity * bins * sizeof *g->weights);
    if (weights) g->weights = weights;
    void *flights = realloc(g->flights, capacity * sizeof *g->flights);
    if (flights) g->flights = flights;
    void *arrivals = realloc(g->arrivals, capacity * sizeof *g->arrivals);
    if (arrivals) g->arrivals = arrivals;
    void *leeways = realloc(g->leeways, capacity * sizeof *g->leeways);
    if (leeways) g->leeways = leeways;
    if (!all || !weights || !flights || !arrivals || !leeways) return 0;
    g->capacity = capacity;
    return 1;
}

static void gaze_free(gaze *g) {
    free(g->all), free(g->weights), free(g->flights), free(g->arrivals), free(g->leeways);
}

/* Bins that a flight stands for: [*first, *first + count). */
static size_t carried(const viewer *v, const cpm_flight *flight, size_t *first) {
    *first = (size_t)cpm_bins_first(flight->bin);
    return (size_t)cpm_bins_count(flight->bin, (int32_t)v->pass->bins);
}

/* A branch: `weights` times `factor`, times `spectrum` unless NULL. Weights are those of the flight's own bins. */
static void branch(viewer *v, const glance *from, const cpm_flight *flight, const float *weights, double factor,
                   const float *spectrum) {
    const size_t bins = v->pass->bins;
    size_t first;
    const size_t count = carried(v, flight, &first);
    if (from->depth >= MAX_DEPTH) return;
    if (!gaze_reserve(&v->next, bins, 1)) {
        v->failed = 1;
        return;
    }
    float *to = &v->next.weights[v->next.count * bins], most = 0.0f;
    for (size_t b = 0; b < count; b++) {
        to[b] = cpm_shade_branch(weights[b], (float)factor, spectrum ? spectrum[first + b] : 1.0f);
        if (to[b] > most) most = to[b];
    }
    if (most < LEAST_WEIGHT) return;
    glance *g = &v->next.all[v->next.count++];
    *g = *from;
    g->flight = *flight;
    g->depth++;
}

static void see_surface(viewer *v, const glance *g, const cpm_arrival *a, const float *weights, const shape *s) {
    const cpm_pass *pass = v->pass;
    const size_t bins = pass->bins;
    size_t first;
    const size_t count = carried(v, &g->flight, &first);
    const int32_t medium = cpm_region_medium(&g->flight.region);
    const int together = count > 1 && pass->disperses[medium]; /* one way, but each its own n */
    cpm_vec geometric = cpm_geometric_normal(pass->scene, &a->hit);
    int front = cpm_vdot(geometric, a->direction) < 0.0;
    cpm_vec facing = front ? geometric : cpm_scaled(-1.0, geometric);
    double *sum = &v->sum[(size_t)g->pixel * bins];
    if (s->light >= 0 && front)
        for (size_t b = 0; b < count; b++)
            sum[first + b] += cpm_shade_light(weights[b], pass->emission[(size_t)s->light * bins + first + b],
                                              v->squared_index[first + b]);
    const material *m = &pass->scene->materials[s->material];
    const float *reflectance = &pass->reflectance[(size_t)s->material * bins];
    if (m->kind == CPM_MATERIAL_MIRROR) {
        cpm_vec direction = scatter_mirror(a->direction, cpm_shading_normal(pass->scene, &a->hit, facing), facing);
        cpm_flight flight = cpm_depart(pass, &g->flight, a, direction);
        branch(v, g, &flight, weights, 1.0, reflectance);
        return;
    }
    if (pass->reflectance_max[s->material] <= 0.0f) return;
    cpm_gather_irradiance(v->gather, v->queries, a->hit.position, cpm_shading_normal(pass->scene, &a->hit, facing),
                          v->irradiance, v->scratch);
    v->gathers++;
    for (size_t b = 0; b < count; b++) {
        const double n = together ? cpm_pass_index(pass, medium, (int32_t)(first + b), a->hit.position) : a->n;
        sum[first + b] += cpm_shade_diffuse(weights[b], reflectance[first + b], v->irradiance[first + b],
                                            v->squared_index[first + b], n);
    }
}

static void see_boundary(viewer *v, const glance *g, const cpm_arrival *a, const float *weights) {
    const cpm_pass *pass = v->pass;
    cpm_passage passage;
    if (cpm_bundle_parts(pass, &g->flight, a, g->leeway.angle)) {
        for (int upper = 0; upper < 2; upper++) {
            glance half = *g;
            cpm_arrival at;
            const size_t before = cpm_bundle_half(pass, &g->flight, a, upper, &half.flight, &at);
            see_boundary(v, &half, &at, &weights[before]);
        }
        return;
    }
    if (!cpm_pass_boundary(pass, &g->flight, a, &passage)) return;
    if (passage.jumps) branch(v, g, &passage.reflected, weights, passage.reflectance, NULL);
    if (!passage.total) branch(v, g, &passage.transmitted, weights, 1.0 - passage.reflectance, NULL);
}

/* Suns and environments, in the direction in which the ray left. */
static void see_sky(viewer *v, const glance *g, const cpm_arrival *a, const float *weights) {
    const cpm_pass *pass = v->pass;
    const size_t first = (size_t)cpm_bins_first(g->flight.bin);
    const size_t count = (size_t)cpm_bins_count(g->flight.bin, (int32_t)pass->bins);
    double *sum = &v->sum[(size_t)g->pixel * pass->bins];
    for (size_t l = 0; l < pass->scene->light_count; l++) {
        if (!cpm_sky_radiance(pass, l, a->direction, first, count, v->scratch)) continue;
        for (size_t b = 0; b < count; b++)
            sum[first + b] += cpm_shade_light(weights[b], v->scratch[b], v->squared_index[first + b]);
    }
}

static void see(viewer *v, const glance *g, const cpm_arrival *a, const float *weights) {
    const cpm_scene *scene = v->pass->scene;
    v->evaluations += a->evaluations;
    if (a->status == CPM_RAY_LEFT && v->pass->sky) see_sky(v, g, a, weights);
    if (a->status != CPM_RAY_HIT) return;
    const shape *s = &scene->shapes[cpm_primitive_shape(scene, a->hit.primitive)];
    if (s->material == CPM_NO_MATERIAL || scene->materials[s->material].kind == CPM_MATERIAL_DIELECTRIC)
        see_boundary(v, g, a, weights);
    else
        see_surface(v, g, a, weights, s);
}

/* Eye rays of a pixel: samples [first, end). */
static void look(viewer *v, int32_t column, int32_t row, int32_t pixel, const cpm_image *image, int32_t first,
                 int32_t end) {
    const size_t bins = v->pass->bins;
    float ones[CPM_MAX_BINS];
    for (size_t b = 0; b < bins; b++) ones[b] = 1.0f;
    for (int32_t s = first; s < end; s++) {
        double x, y;
        cpm_eye_place(v->seed, (uint32_t)(row * image->width + column), s, v->samples, &x, &y);
        glance g = {.pixel = pixel, .depth = -1};
        g.flight.position = v->origin;
        g.flight.direction =
            eye_direction(v->forward, v->right, v->up, column + x, row + y, image->width, image->height);
        g.flight.region = v->region;
        g.flight.left = -1;
        const double cosine = cpm_vdot(g.flight.direction, v->forward); /* a pixel off the middle is smaller */
        g.leeway.angle = v->pixel * cosine * cosine;
        v->rays++;
        for (size_t bin = 0; bin < (v->splits ? bins : 1); bin++) {
            g.flight.bin = v->splits ? (int32_t)bin : -1;
            branch(v, &g, &g.flight, ones, 1.0, NULL);
        }
    }
}

/* Rays that may see the sky are followed until they leave, not only until they cannot come back: light still bends; and
 * where air dims, how much of it was on the way is measured. */
static const cpm_follow_options to_the_extent = {.far = INFINITY};
static const cpm_follow_options *options_of(const cpm_pass *pass) {
    return pass->sky || pass->extinction ? &to_the_extent : NULL;
}

/* What air takes on the way, from the weights of the bins that a flight carries. */
static void dim(const viewer *v, const cpm_flight *f, const cpm_arrival *a, float *weights) {
    if (!v->pass->extinction) return;
    const size_t first = (size_t)cpm_bins_first(f->bin);
    const size_t count = (size_t)cpm_bins_count(f->bin, (int32_t)v->pass->bins);
    for (size_t b = 0; b < count; b++) weights[b] *= (float)cpm_transmittance(v->pass, f, a, first + b);
}

/* All live branches to their next surface, and what they see there. */
static void follow_now(viewer *v) {
    const size_t bins = v->pass->bins;
    cpm_follow(v->pass, v->now.flights, v->now.count, options_of(v->pass), v->now.arrivals);
    v->segments += v->now.count;
    for (size_t i = 0; i < v->now.count && !v->failed && !cpm_poll(v->pass->context); i++) {
        dim(v, &v->now.flights[i], &v->now.arrivals[i], &v->now.weights[i * bins]);
        see(v, &v->now.all[i], &v->now.arrivals[i], &v->now.weights[i * bins]);
    }
}

/* The same where bins of one ray may stay together in a medium that disperses. */
static void follow_now_in_bundles(viewer *v) {
    const size_t bins = v->pass->bins;
    cpm_bundles *b = &v->bundles;
    for (size_t i = 0; i < v->now.count; i++) v->now.leeways[i] = v->now.all[i].leeway;
    if (!cpm_follow_bundles(b, v->pass, CPM_BUNDLES_OF_EYE, v->now.flights, v->now.leeways, v->now.count,
                            options_of(v->pass))) {
        v->failed = 1;
        return;
    }
    v->segments += b->followed;
    for (size_t i = 0; i < b->count && !v->failed && !cpm_poll(v->pass->context); i++) {
        const cpm_parted *p = &b->parted[i];
        glance g = v->now.all[p->from];
        const size_t before = (size_t)(cpm_bins_first(p->bin) - cpm_bins_first(g.flight.bin));
        g.leeway = cpm_leeway_after(&g.leeway, &g.flight, &p->arrival);
        g.flight.bin = p->bin;
        float *weights = &v->now.weights[p->from * bins + before];
        dim(v, &g.flight, &p->arrival, weights);
        see(v, &g, &p->arrival, weights);
    }
}

/* The live branches to their ends: all of them to their next surface, then those that go on. */
static void follow_branches(viewer *v) {
    cpm_context *context = v->pass->context;
    while (v->next.count && !v->failed && !cpm_poll(context)) {
        gaze swap = v->now;
        v->now = v->next;
        v->next = swap;
        v->next.count = 0;
        for (size_t i = 0; i < v->now.count; i++) v->now.flights[i] = v->now.all[i].flight;
        if (cpm_pass_bundles(v->pass))
            follow_now_in_bundles(v);
        else
            follow_now(v);
    }
}

static void paint_tile(viewer *v, int32_t tile, int32_t across, cpm_image *image) {
    const size_t bins = v->pass->bins;
    int32_t x0 = tile % across * TILE, y0 = tile / across * TILE;
    int32_t x1 = x0 + TILE < image->width ? x0 + TILE : image->width;
    int32_t y1 = y0 + TILE < image->height ? y0 + TILE : image->height;
    memset(v->sum, 0, TILE * TILE * bins * sizeof *v->sum);
    for (int32_t s = 0; s < v->samples && !v->failed && !cpm_cancelled(v->pass->context); s += SAMPLES_AT_ONCE) {
        const int32_t end = v->samples - s < SAMPLES_AT_ONCE ? v->samples : s + SAMPLES_AT_ONCE;
        v->next.count = 0;
        for (int32_t y = y0; y < y1; y++)
            for (int32_t x = x0; x < x1; x++) look(v, x, y, (y - y0) * TILE + x - x0, image, s, end);
        follow_branches(v);
    }
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++)
            for (size_t b = 0; b < bins; b++)
                image->data[((size_t)y * (size_t)image->width + (size_t)x) * bins + b] =
                    (float)(v->sum[(size_t)((y - y0) * TILE + x - x0) * bins + b] / v->samples);
}

static void set_camera(viewer *v, const cpm_camera *c, const cpm_image *image) {
    cpm_vec up = cpm_unit(cpm_v(c->up[0], c->up[1], c->up[2]));
    v->origin = cpm_v(c->origin[0], c->origin[1], c->origin[2]);
    v->forward = cpm_unit(cpm_sub(cpm_v(c->target[0], c->target[1], c->target[2]), v->origin));
    double half = tan(c->fov * (CPM_PI / 360.0));
    cpm_vec right = cpm_unit(cpm_cross(v->forward, up));
    v->up = cpm_scaled(half * image->height / image->width, cpm_cross(right, v->forward));
    v->right = cpm_scaled(half, right);
    v->pixel = v->pass->bundle_tolerance * 2.0 * half / image->width;
    v->region = cpm_region_at(v->pass, v->origin, v->forward);
}

cpm_status cpm_eye_pass(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                        cpm_image *image) {
    cpm_context *context = pass->context;
    const size_t bins = pass->bins;
    const int32_t across = (image->width + TILE - 1) / TILE, tiles = across * ((image->height + TILE - 1) / TILE);
    double squared_index[CPM_MAX_BINS];
    viewer model = {.pass = pass, .gather = gather, .seed = seed, .samples = samples, .squared_index = squared_index};
    set_camera(&model, &pass->scene->camera, image);
    int32_t medium = cpm_region_medium(&model.region);
    model.splits = pass->disperses[medium] && !cpm_pass_bundles(pass);
    for (size_t b = 0; b < bins; b++) {
        double n = cpm_pass_index(pass, medium, (int32_t)b, model.origin);
        if (!(n > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "camera: n^2 is not positive at its origin");
        squared_index[b] = n * n;
    }
    cpm_progress(context, "gather", 0.0);
    int failed = 0, done = 0;
    double *evaluations = calloc((size_t)tiles, sizeof *evaluations);
    if (!evaluations) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass");
#pragma omp parallel num_threads(context->threads)
    {
        viewer v = model;
        v.irradiance = malloc(bins * sizeof(double));
        v.scratch = malloc(bins * sizeof(double));
        v.sum = malloc(TILE * TILE * bins * sizeof(double));
        v.failed = !cpm_gather_queries(gather, v.queries) || !v.irradiance || !v.scratch || !v.sum;
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
        free(v.irradiance), free(v.scratch), free(v.sum);
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
    if (failed) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the eye pass");
    if (cpm_progress(context, "gather", 1.0))
        return cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while gathering");
    return CPM_OK;
}
