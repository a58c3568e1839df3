/* bench/embree.c: straight photon tracing against bare rtcIntersect1 for the same hits; bench/embree.py runs it.
 *
 * embree SCENE [photons] [bins] [repeats]
 *
 * SCENE: text, one thing a line, flat spectra:
 *   triangle REFLECTANCE ax ay az bx by bz cx cy cz
 *   spot     INTENSITY CUTOFF px py pz tx ty tz
 *
 * The linker's --wrap=cpm_follow puts __wrap_cpm_follow between the photon pass and the tracer: in one pass of one
 * thread it keeps every flight and what it hit. Then, at 1 and 2 threads, the fastest of `repeats`:
 *   pass    the photon pass without its maps: emit, trace, scatter, store, and the projection map before it
 *   follow  the tracer alone on the flights that were kept
 *   bare    rtcIntersect1 alone: a ROBUST scene of the same triangles, the same rays in the same order
 * Prints one JSON object. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/isa.h"
#include "geometry/embree.h"
#include "photon/photons.h"

#define CHUNK 512   /* rays that a thread takes at a time, as the photon pass does */
#define START 2e-6f /* tnear of a ray that leaves a surface, metres: beyond float rounding at the room's size */
#define WAVELENGTHS 256

static void give_up(const char *what) {
    fprintf(stderr, "embree: %s\n", what);
    exit(1);
}

static void *room_for(void *old, size_t count, size_t each) {
    void *block = realloc(old, count * each + 1);
    if (!block) give_up("out of memory");
    return block;
}

/* ---------------------------------------------------------------------------------------------- flights kept */

typedef struct record {
    cpm_flight *flights;
    int32_t *hits; /* primitive, -1: none */
    size_t count, capacity;
    int on;
} record;

static record kept;

void __real_cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                       cpm_arrival *arrivals);
void __wrap_cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                       cpm_arrival *arrivals);

void __wrap_cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                       cpm_arrival *arrivals) {
    __real_cpm_follow(pass, flights, count, options, arrivals);
    if (!kept.on) return;
    if (kept.count + count > kept.capacity) {
        kept.capacity = 2 * (kept.count + count);
        kept.flights = room_for(kept.flights, kept.capacity, sizeof *kept.flights);
        kept.hits = room_for(kept.hits, kept.capacity, sizeof *kept.hits);
    }
    memcpy(kept.flights + kept.count, flights, count * sizeof *flights);
    for (size_t i = 0; i < count; i++) kept.hits[kept.count + i] = arrivals[i].hit.primitive;
    kept.count += count;
}

/* -------------------------------------------------------------------------------------------------- the scene */

typedef struct triangles {
    double (*corners)[9];
    size_t count;
} triangles;

static void add_triangle(cpm_scene *scene, triangles *all, double reflectance, const double corners[9]) {
    static const uint32_t face[3] = {0, 1, 2};
    const cpm_material paint = {
        .struct_size = sizeof paint, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = {.values = &reflectance, .count = 1}};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = corners,
                                .vertex_count = 3,
                                .faces = face,
                                .face_count = 1,
                                .material = &paint};
    if (cpm_scene_add_mesh(scene, &mesh, NULL) != CPM_OK) give_up("a triangle was refused");
    all->corners = room_for(all->corners, all->count + 1, sizeof *all->corners);
    memcpy(all->corners[all->count++], corners, 9 * sizeof(double));
}

static void read_scene(const char *name, cpm_scene *scene, triangles *all) {
    FILE *file = fopen(name, "r");
    char kind[16];
    if (!file) give_up(name);
    while (fscanf(file, "%15s", kind) == 1) {
        double v[10];
        const int triangle = !strcmp(kind, "triangle"), wanted = triangle ? 10 : 8;
        for (int i = 0; i < wanted; i++)
            if (fscanf(file, "%lf", &v[i]) != 1) give_up("the scene's file is cut short");
        if (triangle) {
            add_triangle(scene, all, v[0], v + 1);
        } else {
            const cpm_light_desc spot = {.struct_size = sizeof spot,
                                         .kind = CPM_LIGHT_SPOT,
                                         .shape = -1,
                                         .position = {v[2], v[3], v[4]},
                                         .target = {v[5], v[6], v[7]},
                                         .cutoff = v[1],
                                         .emission = {.values = v, .count = 1}};
            if (cpm_scene_add_light(scene, &spot, NULL) != CPM_OK) give_up("the spot was refused");
        }
    }
    fclose(file);
}

/* ------------------------------------------------------------------------------------------------- the pass */

static cpm_context *context_of(int threads) {
    const cpm_context_options options = {.struct_size = sizeof options, .threads = threads};
    cpm_context *context = NULL;
    if (cpm_context_create(&options, &context) != CPM_OK) give_up("no context");
    return context;
}

/* Seconds of a photon pass without building its maps. */
static double pass_seconds(cpm_context *context, cpm_scene *scene, uint64_t photons, const double *wavelengths,
                           size_t bins, cpm_stats *stats) {
    const cpm_photons_options options = {
        .struct_size = sizeof options, .photons = photons, .wavelengths = wavelengths, .wavelength_count = bins};
    cpm_photons *traced = NULL;
    if (cpm_photons_trace(context, scene, &options, &traced) != CPM_OK) give_up(cpm_context_last_error(context));
    stats->struct_size = sizeof *stats;
    cpm_photons_stats(traced, stats);
    cpm_photons_release(traced);
    return stats->seconds_project + stats->seconds_trace;
}

/* The tracer on what was kept, by the same batches. */
static double follow_seconds(const cpm_pass *pass, int threads) {
    const double start = cpm_seconds();
#pragma omp parallel num_threads(threads)
    {
        cpm_arrival arrivals[CHUNK];
#pragma omp for schedule(dynamic, 1)
        for (size_t first = 0; first < kept.count; first += CHUNK) {
            const size_t count = kept.count - first < CHUNK ? kept.count - first : CHUNK;
            __real_cpm_follow(pass, kept.flights + first, count, NULL, arrivals);
        }
    }
    return cpm_seconds() - start;
}

/* --------------------------------------------------------------------------------------------------- Embree */

static RTCScene embree_scene(RTCDevice device, const triangles *all) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * all->count);
    unsigned *faces = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, all->count);
    if (!vertices || !faces) give_up("Embree has no memory");
    for (size_t i = 0; i < 9 * all->count; i++) vertices[i] = (float)all->corners[i / 9][i % 9];
    for (size_t i = 0; i < 3 * all->count; i++) faces[i] = (unsigned)i;
    rtcCommitGeometry(mesh);
    rtcAttachGeometryByID(scene, mesh, 0);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    return scene;
}

/* Origin, direction, tnear: what a caller of Embree would hold. */
typedef struct bare_ray {
    float origin[3], direction[3], near;
} bare_ray;

static bare_ray *bare_rays(void) {
    bare_ray *rays = room_for(NULL, kept.count, sizeof *rays);
    for (size_t i = 0; i < kept.count; i++) {
        const cpm_flight *f = &kept.flights[i];
        rays[i] = (bare_ray){{(float)f->position.x, (float)f->position.y, (float)f->position.z},
                             {(float)f->direction.x, (float)f->direction.y, (float)f->direction.z},
                             f->left >= 0 ? START : 0.0f};
    }
    return rays;
}

/* Seconds; `same` counts the rays that hit what the photon pass hit. */
static double bare_seconds(RTCScene scene, const bare_ray *rays, int threads, size_t *same) {
    size_t equal = 0;
    const double start = cpm_seconds();
#pragma omp parallel for num_threads(threads) schedule(dynamic, CHUNK) reduction(+ : equal)
    for (size_t i = 0; i < kept.count; i++) {
        const bare_ray *r = &rays[i];
        cpm_embree_context context;
        cpm_embree_context_init(&context);
        struct RTCRayHit ray = {.ray = {.org_x = r->origin[0],
                                        .org_y = r->origin[1],
                                        .org_z = r->origin[2],
                                        .tnear = r->near,
                                        .dir_x = r->direction[0],
                                        .dir_y = r->direction[1],
                                        .dir_z = r->direction[2],
                                        .tfar = INFINITY,
                                        .mask = 0xFFFFFFFFu}};
        ray.hit.geomID = ray.hit.primID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        cpm_embree_intersect(scene, &context, &ray);
        equal += (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : (int32_t)ray.hit.primID) == kept.hits[i];
    }
    *same = equal;
    return cpm_seconds() - start;
}

int main(int argc, char **argv) {
    if (argc < 2) give_up("usage: embree SCENE [photons] [bins] [repeats]");
    const uint64_t photons = argc > 2 ? strtoull(argv[2], NULL, 10) : 1000000;
    const size_t bins = argc > 3 ? strtoull(argv[3], NULL, 10) : 1;
    const int repeats = argc > 4 ? atoi(argv[4]) : 5;
    if (photons < 1 || bins < 1 || bins > WAVELENGTHS || repeats < 1) give_up("a number is out of range");
    double wavelengths[WAVELENGTHS];
    for (size_t b = 0; b < bins; b++) wavelengths[b] = 400.0 + 300.0 * ((double)b + 0.5) / (double)bins;

    cpm_context *contexts[2] = {context_of(1), context_of(2)};
    cpm_scene *scene = NULL;
    const cpm_scene_options options = {.struct_size = sizeof options};
    if (cpm_scene_create(contexts[0], &options, &scene) != CPM_OK) give_up("no scene");
    triangles all = {0};
    read_scene(argv[1], scene, &all);

    cpm_stats stats = {0};
    kept.on = 1;
    pass_seconds(contexts[0], scene, photons, wavelengths, bins, &stats);
    kept.on = 0;

    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene bare = embree_scene(device, &all);
    bare_ray *rays = bare_rays();
    double best[2][3]; /* threads; pass, follow, bare */
    size_t same = 0;
    for (int t = 0; t < 2; t++) {
        for (int what = 0; what < 3; what++) best[t][what] = HUGE_VAL;
        for (int i = 0; i < repeats; i++) { /* in turn: the machine's drift meets all three alike */
            cpm_pass pass;
            best[t][0] = fmin(best[t][0], pass_seconds(contexts[t], scene, photons, wavelengths, bins, &stats));
            if (cpm_pass_begin(contexts[t], scene, wavelengths, bins, &pass) != CPM_OK) give_up("no pass");
            best[t][1] = fmin(best[t][1], follow_seconds(&pass, t + 1));
            cpm_pass_end(&pass);
            best[t][2] = fmin(best[t][2], bare_seconds(bare, rays, t + 1, &same));
        }
    }
    printf("{\"photons\": %llu, \"bins\": %zu, \"rays\": %zu, \"same_hits\": %zu, \"isa\": \"%s\", \"embree\": \"%s\", "
           "\"stored\": %llu, \"runs\": [",
           (unsigned long long)photons, bins, kept.count, same, cpm_isa_text(cpm_isa_chosen()),
           cpm_geometry_embree_version(),
           (unsigned long long)(stats.photons_stored_direct + stats.photons_stored_later));
    for (int t = 0; t < 2; t++)
        printf("%s{\"threads\": %d, \"pass_seconds\": %.6f, \"follow_seconds\": %.6f, \"bare_seconds\": %.6f}",
               t ? ", " : "", t + 1, best[t][0], best[t][1], best[t][2]);
    printf("]}\n");
    rtcReleaseScene(bare);
    rtcReleaseDevice(device);
    cpm_scene_release(scene);
    cpm_context_release(contexts[0]), cpm_context_release(contexts[1]);
    free(rays), free(kept.flights), free(kept.hits), free(all.corners);
    return 0;
}
