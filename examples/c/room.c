/* room.c: the cross room of Gutierrez et al., through the C interface alone.
 *
 *     room [--curved] [--photons N] [--size WxH] [--nearest K] [--seed N] [--threads N] [-o FILE.exr]
 *
 * A closed room whose left wall has a cross-shaped hole, lit by a spot outside. With --curved the air in it is replaced
 * by a medium of n^2 = 1.69 - 0.10 y: light bends, and the lit cross on the floor moves and changes its shape.
 * Writes a spectral OpenEXR and prints the seconds of each stage. */
#include <cpm/cpm.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BINS 16

/* Any failure ends the program with the library's own words. */
#define CHECK(call)                                                                                                    \
    do {                                                                                                               \
        const cpm_status status_ = (call);                                                                             \
        if (status_ != CPM_OK) {                                                                                       \
            fprintf(stderr, "room: %s: %s\n", cpm_status_string(status_), cpm_context_last_error(context));            \
            exit(EXIT_FAILURE);                                                                                        \
        }                                                                                                              \
    } while (0)

static cpm_context *context;

/* Smooth reflectances: 0.75 white, 0.60 red and 0.15 green at 620 nm. */
static const double white_nm[] = {400, 620, 700}, white_r[] = {0.70, 0.75, 0.76};
static const double red_nm[] = {400, 560, 620, 700}, red_r[] = {0.05, 0.08, 0.60, 0.64};
static const double green_nm[] = {400, 480, 530, 620, 700}, green_r[] = {0.08, 0.20, 0.45, 0.15, 0.12};

static const cpm_spectrum white = {white_nm, white_r, 3};
static const cpm_spectrum red = {red_nm, red_r, 4};
static const cpm_spectrum green = {green_nm, green_r, 5};

/* A parallelogram: a corner and its two edges, metres. */
typedef struct quad {
    double corner[3], a[3], b[3];
} quad;

/* The left wall x = -2 is tiled around its hole: upright |z| <= 0.3, y in [0.8, 3.2]; bar |z| <= 1.2, y in [1.7, 2.3].
 */
static const quad white_quads[] = {
    {{-2, 0, -2}, {0, 0, 4}, {4, 0, 0}},        /* floor */
    {{-2, 4, -2}, {4, 0, 0}, {0, 0, 4}},        /* ceiling */
    {{2, 0, -2}, {0, 0, 4}, {0, 4, 0}},         /* right wall */
    {{-2, 0, -2}, {0, 0.8, 0}, {0, 0, 4}},      /* left wall, below the cross */
    {{-2, 0.8, -2}, {0, 0.9, 0}, {0, 0, 1.7}},  /* beside the lower upright */
    {{-2, 0.8, 0.3}, {0, 0.9, 0}, {0, 0, 1.7}}, /**/
    {{-2, 1.7, -2}, {0, 0.6, 0}, {0, 0, 0.8}},  /* beside the bar */
    {{-2, 1.7, 1.2}, {0, 0.6, 0}, {0, 0, 0.8}}, /**/
    {{-2, 2.3, -2}, {0, 0.9, 0}, {0, 0, 1.7}},  /* beside the upper upright */
    {{-2, 2.3, 0.3}, {0, 0.9, 0}, {0, 0, 1.7}}, /**/
    {{-2, 3.2, -2}, {0, 0.8, 0}, {0, 0, 4}},    /* above the cross */
};
static const quad red_quads[] = {{{-2, 0, -2}, {4, 0, 0}, {0, 4, 0}}};  /* back */
static const quad green_quads[] = {{{-2, 0, 2}, {0, 4, 0}, {4, 0, 0}}}; /* front */

static void add_quads(cpm_scene *scene, const char *name, const quad *quads, size_t count, cpm_spectrum reflectance) {
    double vertices[64][3];
    uint32_t faces[32][3];
    for (size_t i = 0; i < count; i++) {
        const uint32_t first = (uint32_t)(4 * i);
        for (int k = 0; k < 3; k++) {
            const double c = quads[i].corner[k], a = quads[i].a[k], b = quads[i].b[k];
            vertices[first][k] = c;
            vertices[first + 1][k] = c + a;
            vertices[first + 2][k] = c + a + b;
            vertices[first + 3][k] = c + b;
        }
        const uint32_t two[2][3] = {{first, first + 1, first + 2}, {first, first + 2, first + 3}};
        memcpy(faces[2 * i], two, sizeof two);
    }
    const cpm_material material = {
        .struct_size = sizeof material, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = reflectance};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = vertices[0],
                                .vertex_count = 4 * count,
                                .faces = faces[0],
                                .face_count = 2 * count,
                                .material = &material,
                                .name = name};
    CHECK(cpm_scene_add_mesh(scene, &mesh, NULL));
}

static cpm_scene *make_room(int curved) {
    cpm_medium *medium = NULL;
    if (curved) {
        const double gradient[3] = {0, -0.10, 0}, origin[3] = {0, 0, 0};
        CHECK(cpm_medium_create_linear_squared(context, 1.69, gradient, origin, NULL, &medium));
    }
    cpm_scene *scene = NULL;
    const cpm_scene_options options = {.struct_size = sizeof options, .medium = medium};
    CHECK(cpm_scene_create(context, &options, &scene));
    cpm_medium_release(medium); /* the scene keeps it */

    add_quads(scene, "white walls", white_quads, sizeof white_quads / sizeof *white_quads, white);
    add_quads(scene, "red wall", red_quads, 1, red);
    add_quads(scene, "green wall", green_quads, 1, green);

    const double intensity = 100.0; /* W/sr/nm, the same at every wavelength */
    const cpm_light_desc spot = {.struct_size = sizeof spot,
                                 .kind = CPM_LIGHT_SPOT,
                                 .position = {-5, 6.5, 0},
                                 .target = {-2, 2.35, 0},
                                 .cutoff = 14.0,
                                 .emission = {.values = &intensity, .count = 1}};
    CHECK(cpm_scene_add_light(scene, &spot, NULL));

    const cpm_camera camera = {.struct_size = sizeof camera,
                               .origin = {1.85, 3.0, 1.85},
                               .target = {-1.2, 0.6, -0.9},
                               .up = {0, 1, 0},
                               .fov = 70.0};
    CHECK(cpm_scene_set_camera(scene, &camera));
    return scene;
}

static int32_t show_progress(void *user, const char *stage, double fraction) {
    (void)user;
    fprintf(stderr, "\r%-8s %3.0f %%", stage, 100.0 * fraction);
    return 0; /* anything else cancels */
}

static void print_stages(const cpm_stats *s) {
    printf("prepare  %8.3f s\n", s->seconds_prepare);
    printf("project  %8.3f s   %" PRIu64 " of %" PRIu64 " cells active\n", s->seconds_project, s->projection_active,
           s->projection_cells);
    printf("trace    %8.3f s   %" PRIu64 " photons emitted, %" PRIu64 " + %" PRIu64 " + %" PRIu64
           " stored (direct, later, caustic), %" PRIu64 " gradient evaluations\n",
           s->seconds_trace, s->photons_emitted, s->photons_stored_direct, s->photons_stored_later,
           s->photons_stored_caustic, s->photon_evaluations);
    printf("map      %8.3f s   %.1f MB\n", s->seconds_map, (double)(s->bytes_diffuse + s->bytes_caustic) * 1e-6);
    printf("gather   %8.3f s   %" PRIu64 " eye rays, %" PRIu64 " gradient evaluations\n", s->seconds_gather,
           s->eye_rays, s->eye_evaluations);
    printf("total    %8.3f s\n", s->seconds_total);
}

static void usage(void) {
    fputs("usage: room [--curved] [--photons N] [--size WxH] [--nearest K] [--seed N] [--threads N] [-o FILE.exr]\n",
          stderr);
    exit(2);
}

static uint64_t number(const char *text, uint64_t low, uint64_t high) {
    char *end = NULL;
    const unsigned long long value = strtoull(text, &end, 10);
    if (end == text || *end || *text == '-' || value < low || value > high) {
        fprintf(stderr, "room: '%s' is not a whole number from %" PRIu64 " to %" PRIu64 "\n", text, low, high);
        exit(2);
    }
    return value;
}

int main(int argc, char **argv) {
    double wavelengths[BINS];
    for (int i = 0; i < BINS; i++) wavelengths[i] = 400.0 + 300.0 * (i + 0.5) / BINS; /* bin centres, nm */

    int curved = 0;
    const char *path = "room.exr";
    cpm_context_options context_options = {.struct_size = sizeof context_options};
    cpm_render_options options = {.struct_size = sizeof options,
                                  .width = 400,
                                  .height = 300,
                                  .photons = 3000000,
                                  .wavelengths = wavelengths,
                                  .wavelength_count = BINS,
                                  .nearest = 150,
                                  .samples = 1};
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i];
        if (strcmp(name, "--curved") == 0) {
            curved = 1;
            continue;
        }
        if (++i >= argc) usage();
        if (strcmp(name, "--photons") == 0) {
            options.photons = number(argv[i], 0, UINT32_MAX);
        } else if (strcmp(name, "--nearest") == 0) {
            options.nearest = (int32_t)number(argv[i], 2, 1000000);
        } else if (strcmp(name, "--seed") == 0) {
            options.seed = number(argv[i], 0, UINT64_MAX);
        } else if (strcmp(name, "--threads") == 0) {
            context_options.threads = (int32_t)number(argv[i], 1, 1024);
        } else if (strcmp(name, "--size") == 0) {
            char *x = strchr(argv[i], 'x');
            if (!x) usage();
            *x = 0;
            options.width = (int32_t)number(argv[i], 1, 65536);
            options.height = (int32_t)number(x + 1, 1, 65536);
        } else if (strcmp(name, "-o") == 0) {
            path = argv[i];
        } else {
            usage();
        }
    }

    if (cpm_context_create(&context_options, &context) != CPM_OK) return EXIT_FAILURE;
    CHECK(cpm_context_set_progress(context, show_progress, NULL));
    cpm_scene *scene = make_room(curved);
    cpm_image *image = NULL;
    CHECK(cpm_image_render(context, scene, &options, &image));
    const cpm_status written = cpm_image_write_exr(context, image, path, NULL);
    fputs("\r               \r", stderr);
    if (written == CPM_ERROR_UNSUPPORTED) /* a library built without OpenEXR still renders */
        fprintf(stderr, "room: %s\n", cpm_context_last_error(context));
    else
        CHECK(written);

    cpm_stats stats = {.struct_size = sizeof stats};
    CHECK(cpm_image_stats(image, &stats));
    printf("libcpm %s (%s), %" PRId32 " threads\n", cpm_version(), cpm_build_info(), cpm_context_threads(context));
    printf("%s room, %" PRId32 " x %" PRId32 ", %d bins -> %s\n", curved ? "curved" : "homogeneous", options.width,
           options.height, BINS, written == CPM_OK ? path : "nowhere");
    print_stages(&stats);

    cpm_image_release(image);
    cpm_scene_release(scene);
    cpm_context_release(context);
    return EXIT_SUCCESS;
}
