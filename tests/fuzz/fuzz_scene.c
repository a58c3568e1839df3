/* fuzz_scene.c: scenes of any numbers: what is taken can be traced and rendered, without a NaN or a negative value. */
#include "bytes.h"
#include "cpm/cpm.h"

#define VERTICES 8
#define FACES 12

static cpm_material take_material(bytes *b, const double *value, cpm_medium *glass) {
    return (cpm_material){.struct_size = sizeof(cpm_material),
                          .kind = (int32_t)take_below(b, 5),
                          .reflectance = {.values = value, .count = 1},
                          .interior = take_below(b, 2) ? glass : NULL};
}

static void take_shapes(bytes *b, cpm_scene *scene, cpm_medium *glass) {
    const uint32_t count = take_below(b, 4);
    for (uint32_t shape = 0; shape < count; shape++) {
        const double reflectance = take_number(b) * 0.25;
        const cpm_material material = take_material(b, &reflectance, glass);
        double vertices[VERTICES][3];
        uint32_t faces[FACES][3];
        if (take_below(b, 2)) {
            take_point(b, vertices[0]);
            cpm_scene_add_sphere(scene, vertices[0], fabs(take_number(b)), &material, NULL, NULL);
            continue;
        }
        for (int i = 0; i < VERTICES; i++) take_point(b, vertices[i]);
        for (int i = 0; i < FACES; i++)
            for (int k = 0; k < 3; k++) faces[i][k] = take_below(b, VERTICES + 1);
        const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                    .vertices = vertices[0],
                                    .vertex_count = VERTICES,
                                    .faces = faces[0],
                                    .face_count = take_below(b, FACES + 1),
                                    .material = &material};
        cpm_scene_add_mesh(scene, &mesh, NULL);
    }
}

static void take_lights(bytes *b, cpm_scene *scene) {
    const uint32_t count = take_below(b, 3);
    for (uint32_t light = 0; light < count; light++) {
        const double power = fabs(take_number(b));
        cpm_light_desc desc = {.struct_size = sizeof desc,
                               .kind = (int32_t)take_below(b, 5),
                               .shape = (int32_t)take_below(b, 4),
                               .cutoff = 40.0 * take_number(b),
                               .emission = {.values = &power, .count = 1}};
        take_point(b, desc.position);
        take_point(b, desc.target);
        cpm_scene_add_light(scene, &desc, NULL);
    }
}

static void take_bounded(bytes *b, cpm_scene *scene, cpm_medium *glass) {
    if (take_below(b, 2)) return;
    cpm_bounds bounds = {.struct_size = sizeof bounds,
                         .kind = (int32_t)take_below(b, 5),
                         .shape = (int32_t)take_below(b, 4),
                         .radius = fabs(take_number(b))};
    take_point(b, bounds.center);
    take_point(b, bounds.box.low);
    for (int k = 0; k < 3; k++) bounds.box.high[k] = bounds.box.low[k] + fabs(take_number(b));
    cpm_scene_add_medium(scene, glass, &bounds, NULL);
}

static void render(bytes *b, cpm_context *context, cpm_scene *scene) {
    const double wavelengths[2] = {450.0, 600.0};
    const cpm_render_options options = {.struct_size = sizeof options,
                                        .width = 4,
                                        .height = 3,
                                        .photons = 200,
                                        .seed = take_byte(b),
                                        .wavelengths = wavelengths,
                                        .wavelength_count = 1 + take_below(b, 2),
                                        .nearest = 2 + (int32_t)take_below(b, 20),
                                        .samples = 1};
    cpm_image *image = NULL;
    if (cpm_image_render(context, scene, &options, &image) != CPM_OK) {
        require(image == NULL && cpm_context_last_error(context)[0] != 0);
        return;
    }
    const float *values = cpm_image_data(image);
    for (size_t i = 0; i < 12 * options.wavelength_count; i++) require(b->wild || values[i] >= 0.0f);
    cpm_image_release(image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    bytes b = {data, data + size, 0};
    const cpm_context_options one_thread = {.struct_size = sizeof one_thread, .threads = 1};
    cpm_context *context = NULL;
    require(cpm_context_create(&one_thread, &context) == CPM_OK);
    cpm_medium *around = NULL, *glass = NULL;
    cpm_scene *scene = NULL;
    double gradient[3], origin[3] = {0.0, 0.0, 0.0};
    take_point(&b, gradient);
    for (int k = 0; k < 3; k++) gradient[k] = fabs(gradient[k]) <= 4.0 ? 0.05 * gradient[k] : 0.0;
    if (take_below(&b, 2)) cpm_medium_create_linear_squared(context, 1.7, gradient, origin, NULL, &around);
    require(cpm_medium_create_homogeneous(context, 1.5, NULL, &glass) == CPM_OK);
    const cpm_scene_options options = {
        .struct_size = sizeof options, .medium = around, .method = (int32_t)take_below(&b, 6)};
    if (cpm_scene_create(context, &options, &scene) == CPM_OK) {
        take_shapes(&b, scene, glass);
        take_lights(&b, scene);
        take_bounded(&b, scene, glass);
        cpm_camera camera = {.struct_size = sizeof camera, .up = {0, 1, 0}, .fov = 60.0};
        take_point(&b, camera.origin);
        take_point(&b, camera.target);
        cpm_scene_set_camera(scene, &camera);
        render(&b, context, scene);
    } else {
        require(scene == NULL);
    }
    cpm_scene_release(scene);
    cpm_medium_release(around);
    cpm_medium_release(glass);
    cpm_context_release(context);
    return 0;
}
