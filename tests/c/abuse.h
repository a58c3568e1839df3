/* abuse.h: what the tests of abuse share. Every public function is given NULL and nonsense; each returns a status, sets
 * its output handle to NULL, leaves a message that says something, and never crashes. Sanitizer builds run them too.
 * A file a public header: test_null.c (contexts, and NULL everywhere), test_null_medium.c, _scene.c, _image.c. */
#ifndef CPM_TESTS_ABUSE_H
#define CPM_TESTS_ABUSE_H
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "check.h"

#define REFUSED CPM_ERROR_INVALID_ARGUMENT
#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

__attribute__((unused)) static const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0}, one[3] = {1, 1, 1};
__attribute__((unused)) static const double not_numbers[] = {NAN, INFINITY, -INFINITY};
__attribute__((unused)) static const double not_positive[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0};
__attribute__((unused)) static char somewhere; /* a handle that must be overwritten with NULL */

/* The call fails with `status`, clears the handle and says why. */
#define assert_refused_as(context, status, handle, call)                                                               \
    do {                                                                                                               \
        *(void **)&(handle) = &somewhere;                                                                              \
        assert_status(context, status, call);                                                                          \
        assert_null(handle);                                                                                           \
        assert_true(strlen(cpm_context_last_error(context)) > 3);                                                      \
    } while (0)
#define assert_refused(context, handle, call) assert_refused_as(context, REFUSED, handle, call)

static inline cpm_medium *plain_medium(cpm_context *context) {
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_homogeneous(context, 1.5, NULL, &medium));
    return medium;
}

static inline cpm_spectrum flat(const double *value) { return (cpm_spectrum){.values = value, .count = 1}; }

/* A floor, a point light, a camera: enough to render. */
static inline cpm_scene *plain_scene(cpm_context *context) {
    static const double half = 0.5, ten = 10.0;
    static const double vertices[4][3] = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    static const uint32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    cpm_scene *scene = NULL;
    const cpm_scene_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_scene_create(context, &options, &scene));
    const cpm_material material = {
        .struct_size = sizeof material, .kind = CPM_MATERIAL_DIFFUSE, .reflectance = flat(&half)};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = vertices[0],
                                .vertex_count = 4,
                                .faces = faces[0],
                                .face_count = 2,
                                .material = &material,
                                .name = "floor"};
    int32_t index = -1;
    assert_ok(context, cpm_scene_add_mesh(scene, &mesh, &index));
    assert_true(index >= 0);
    const cpm_light_desc light = {
        .struct_size = sizeof light, .kind = CPM_LIGHT_POINT, .position = {0, 1, 0}, .emission = flat(&ten)};
    assert_ok(context, cpm_scene_add_light(scene, &light, &index));
    const cpm_camera camera = {
        .struct_size = sizeof camera, .origin = {0, 2, 2}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov = 40.0};
    assert_ok(context, cpm_scene_set_camera(scene, &camera));
    return scene;
}
#endif
