/* OpenCL devices: found, opened, refused; rays alone in a medium with the bits of the native backend; programs kept in
 * memory and on disk, whatever state the disk is in. PoCL is among the packages that the tests install. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "abuse.h"
#include "backend/opencl/device.h"
#include "backend/opencl/source.h"

#define RAYS 3000

typedef struct traced {
    double position[3 * RAYS], direction[3 * RAYS], path[3 * RAYS * 4], optical_path[RAYS];
    int64_t evaluations[RAYS];
    int32_t status[RAYS];
} traced;

static char cache[64];

static int make_cache(void **state) {
    (void)state;
    strcpy(cache, "/tmp/cpm-cache-XXXXXX");
    if (!mkdtemp(cache)) return 1;
    return setenv("CPM_CACHE_DIR", cache, 1) || setenv("POCL_KERNEL_CACHE", "0", 1);
}

static cpm_medium *bent(cpm_context *context) {
    const double gradient[3] = {0.02, -0.05, 0.0};
    cpm_medium *medium = NULL;
    assert_ok(context, cpm_medium_create_linear(context, 1.3, gradient, origin, NULL, &medium));
    return medium;
}

static cpm_status trace(cpm_context *context, const cpm_medium *medium, traced *out) {
    static double from[3 * RAYS], toward[3 * RAYS], lengths[RAYS];
    const double wavelength = 550.0;
    srand(1);
    for (int i = 0; i < 3 * RAYS; i++) from[i] = rand() / (RAND_MAX + 1.0), toward[i] = rand() / (RAND_MAX + 1.0) - 0.4;
    for (int i = 0; i < RAYS; i++) lengths[i] = 3.0 * rand() / RAND_MAX;
    const cpm_rays_request request = {.struct_size = sizeof request,
                                      .count = RAYS,
                                      .origins = from,
                                      .directions = toward,
                                      .wavelengths = &wavelength,
                                      .lengths = lengths,
                                      .length_stride = 1,
                                      .method = CPM_METHOD_DOPRI5,
                                      .rtol = 1e-8,
                                      .path_samples = 4};
    cpm_rays_result result = {.struct_size = sizeof result,
                              .position = out->position,
                              .direction = out->direction,
                              .optical_path = out->optical_path,
                              .evaluations = out->evaluations,
                              .status = out->status,
                              .paths = out->path};
    memset(out, 0, sizeof *out);
    return cpm_rays_trace(context, medium, NULL, &request, &result);
}

static void use(cpm_context *context) {
    const cpm_device_options options = {.struct_size = sizeof options};
    assert_ok(context, cpm_context_set_device(context, &options));
}

static cpm_device_stats stats_of(cpm_context *context) {
    cpm_device_stats stats = {.struct_size = sizeof stats};
    assert_ok(context, cpm_context_device_stats(context, &stats));
    return stats;
}

static void devices_are_described(void **state) {
    (void)state;
    cpm_context *context = new_context();
    size_t count = 0;
    assert_ok(context, cpm_device_count(context, &count));
    assert_true(count > 0);
    cpm_device_info info = {.struct_size = sizeof info};
    for (size_t i = 0; i < count; i++) {
        assert_ok(context, cpm_device_describe(context, i, &info));
        assert_true(strlen(info.name) > 0 && strlen(info.platform) > 0 && strlen(info.version) > 0);
        assert_true(info.units > 0 && info.memory > 0);
    }
    assert_status(context, REFUSED, cpm_device_describe(context, count, &info));
    cpm_device_info old = {.struct_size = sizeof(size_t) + 4}; /* a caller who knows four letters of the name */
    memset(old.platform, 'x', 8);
    assert_ok(context, cpm_device_describe(context, 0, &old));
    assert_memory_equal(old.platform, "xxxxxxxx", 8);
    cpm_context_release(context);
}

static void nonsense_is_refused(void **state) {
    (void)state;
    cpm_context *context = new_context();
    size_t count = 0;
    cpm_device_info info = {.struct_size = sizeof info};
    cpm_device_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(cpm_device_count(NULL, &count), REFUSED);
    assert_status(context, REFUSED, cpm_device_count(context, NULL));
    assert_int_equal(cpm_device_describe(NULL, 0, &info), REFUSED);
    assert_status(context, REFUSED, cpm_device_describe(context, 0, NULL));
    assert_int_equal(cpm_context_set_device(NULL, NULL), REFUSED);
    assert_int_equal(cpm_context_device_stats(NULL, &stats), REFUSED);
    assert_status(context, REFUSED, cpm_context_device_stats(context, NULL));
    static const int32_t nowhere[] = {-1, 1000, INT32_MIN, INT32_MAX};
    for (size_t i = 0; i < COUNT_OF(nowhere); i++) {
        const cpm_device_options options = {.struct_size = sizeof options, .device = nowhere[i]};
        assert_status(context, REFUSED, cpm_context_set_device(context, &options));
        assert_non_null(strstr(cpm_context_last_error(context), "device is"));
    }
    cpm_context_release(context);
}

static void rays_end_with_the_same_bits(void **state) {
    (void)state;
    static traced native, device;
    cpm_context *context = new_context();
    cpm_medium *medium = bent(context);
    assert_ok(context, trace(context, medium, &native));
    use(context);
    assert_ok(context, trace(context, medium, &device));
    assert_memory_equal(&native, &device, sizeof native);
    assert_ok(context, cpm_context_set_device(context, NULL)); /* and back */
    assert_int_equal(stats_of(context).compiled, 0);
    assert_ok(context, trace(context, medium, &device));
    assert_memory_equal(&native, &device, sizeof native);
    cpm_medium_release(medium);
    cpm_context_release(context);
}

/* Spoils the one file of the cache: `at` < 0 cuts it, else flips a bit there. */
static void spoil(long at) {
    char command[256], path[256];
    snprintf(command, sizeof command, "ls %s/*.bin", cache);
    FILE *list = popen(command, "r");
    assert_non_null(list);
    assert_int_equal(fscanf(list, "%255s", path), 1);
    pclose(list);
    if (at < 0) {
        assert_int_equal(truncate(path, 100), 0);
        return;
    }
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    int byte = fgetc(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    fputc(byte ^ 16, file);
    fclose(file);
}

static void programs_are_compiled_once(void **state) {
    (void)state;
    static traced first, again;
    static const long spoiled[] = {0, 9, 40, 2000, -1}; /* magic, a size, the key, the binary, cut short */
    char command[256];
    snprintf(command, sizeof command, "rm -f %s/*.bin", cache);
    assert_int_equal(system(command), 0);
    for (int round = 0; round < 2 + (int)COUNT_OF(spoiled); round++) {
        cpm_context *context = new_context();
        cpm_medium *medium = bent(context);
        if (round > 1) spoil(spoiled[round - 2]);
        use(context);
        assert_ok(context, trace(context, medium, round ? &again : &first));
        assert_ok(context, trace(context, medium, &again));
        cpm_device_stats stats = stats_of(context);
        assert_int_equal(stats.compiled, round != 1);
        assert_int_equal(stats.cached, round == 1);
        assert_true((stats.source_bytes > 10000) == (round != 1));
        assert_memory_equal(&first, &again, sizeof first);
        cpm_medium_release(medium);
        cpm_context_release(context);
    }
}

static void a_callers_queue_serves(void **state) {
    (void)state;
    static traced native, device;
    const cpm_cl_functions *cl = cpm_cl();
    assert_non_null(cl);
    cl_platform_id platform;
    cl_device_id id;
    cl_int code;
    assert_int_equal(cl->GetPlatformIDs(1, &platform, NULL), CL_SUCCESS);
    assert_int_equal(cl->GetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &id, NULL), CL_SUCCESS);
    cl_context theirs = cl->CreateContext(NULL, 1, &id, NULL, NULL, &code);
    cl_command_queue queue = cl->CreateCommandQueue(theirs, id, 0, &code);
    cpm_context *context = new_context();
    cpm_medium *medium = bent(context);
    assert_ok(context, trace(context, medium, &native));
    const cpm_device_options both = {.struct_size = sizeof both, .opencl_context = theirs, .opencl_queue = queue};
    const cpm_device_options one = {.struct_size = sizeof one, .opencl_context = theirs};
    assert_ok(context, cpm_context_set_device(context, &both));
    assert_ok(context, trace(context, medium, &device));
    assert_memory_equal(&native, &device, sizeof native);
    assert_ok(context, cpm_context_set_device(context, &one));
    assert_ok(context, trace(context, medium, &device));
    assert_memory_equal(&native, &device, sizeof native);
    cpm_medium_release(medium);
    cpm_context_release(context);
    assert_int_equal(cl->ReleaseCommandQueue(queue), CL_SUCCESS); /* still theirs */
    assert_int_equal(cl->ReleaseContext(theirs), CL_SUCCESS);
}

static int32_t no_more(void *user, const char *stage, double fraction) {
    (void)stage, (void)fraction;
    return ++*(int *)user > 0;
}

static void a_device_stops_when_told(void **state) {
    (void)state;
    static traced device;
    int calls = 0;
    cpm_context *context = new_context();
    cpm_medium *medium = bent(context);
    use(context);
    assert_ok(context, cpm_context_set_progress(context, no_more, &calls));
    assert_status(context, CPM_ERROR_CANCELLED, trace(context, medium, &device));
    assert_true(calls > 0);
    cpm_medium_release(medium);
    cpm_context_release(context);
}

/* Photons of the plain scene on a device that may use so many bytes; NULL where that is refused, as `status` says. */
static cpm_photons *few_photons(cpm_context *context, cpm_scene *scene, uint64_t memory, cpm_status status) {
    const cpm_device_options device = {.struct_size = sizeof device, .memory = memory};
    const double wavelength = 550.0;
    const cpm_photons_options options = {
        .struct_size = sizeof options, .photons = 5000, .wavelengths = &wavelength, .wavelength_count = 1};
    cpm_photons *photons = NULL;
    assert_ok(context, cpm_context_set_device(context, &device));
    assert_status(context, status, cpm_photons_trace(context, scene, &options, &photons));
    return photons;
}

static void photons_come_in_parts_where_memory_is_small(void **state) {
    (void)state;
    cpm_context *context = new_context();
    cpm_scene *scene = plain_scene(context);
    cpm_photons *many = few_photons(context, scene, 0, CPM_OK), *few = few_photons(context, scene, 100000, CPM_OK);
    const size_t count = cpm_photons_count(many, CPM_MAP_DIFFUSE);
    assert_true(count > 1000);
    assert_int_equal(cpm_photons_count(few, CPM_MAP_DIFFUSE), count);
    double absorbed[2];
    assert_ok(context, cpm_photons_energy(many, NULL, NULL, &absorbed[0], NULL, NULL));
    assert_ok(context, cpm_photons_energy(few, NULL, NULL, &absorbed[1], NULL, NULL));
    assert_true(fabs(absorbed[0] - absorbed[1]) <= 1e-12 * absorbed[0]);
    cpm_photons_release(many), cpm_photons_release(few);
    assert_null(few_photons(context, scene, 1000, CPM_ERROR_OUT_OF_MEMORY));
    assert_true(strstr(cpm_context_last_error(context), "allow more memory") != NULL);
    cpm_scene_release(scene);
    cpm_context_release(context);
}

/* A room of one n with diffuse walls needs at most 40 % of the source of all kernels of the pass. */
static void a_plain_scene_needs_little_source(void **state) {
    (void)state;
    static const char *const all[] = {"follow_straight",   "follow_exact", "follow_parabolas",
                                      "follow_integrated", "behind",       "start_delta",
                                      "start_area",        "meet",         "specular"};
    size_t whole = 0;
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        size_t size = 0;
        char *text = cpm_kernel_source(all[i], &size);
        assert_non_null(text);
        whole += size;
        free(text);
    }
    const char *kept = getenv("CPM_CACHE_DIR");
    char folder[512] = "";
    if (kept) snprintf(folder, sizeof folder, "%s", kept);
    setenv("CPM_CACHE_DIR", "", 1);
    cpm_context *context = new_context();
    cpm_scene *scene = plain_scene(context);
    cpm_photons_release(few_photons(context, scene, 0, CPM_OK));
    cpm_device_stats stats = {.struct_size = sizeof stats};
    assert_ok(context, cpm_context_device_stats(context, &stats));
    assert_int_equal(stats.compiled, 3); /* start, follow, meet */
    assert_true(stats.source_bytes > 100000 && stats.source_bytes < 2 * whole / 5);
    cpm_scene_release(scene);
    cpm_context_release(context);
    if (kept) setenv("CPM_CACHE_DIR", folder, 1);
}

static void photons_stop_when_told(void **state) {
    (void)state;
    int calls = 0;
    cpm_context *context = new_context();
    cpm_scene *scene = plain_scene(context);
    assert_ok(context, cpm_context_set_progress(context, no_more, &calls));
    assert_null(few_photons(context, scene, 0, CPM_ERROR_CANCELLED));
    assert_true(calls > 0);
    cpm_scene_release(scene);
    cpm_context_release(context);
}

static void a_source_is_one_text(void **state) {
    (void)state;
    size_t size = 0;
    char *text = cpm_kernel_source("trace", &size);
    assert_non_null(text);
    assert_int_equal(strlen(text), size);
    assert_non_null(strstr(text, "__kernel void cpm_trace"));
    assert_null(strstr(text, "#include \""));
    free(text);
    assert_null(cpm_kernel_source("nothing", &size));
    assert_null(cpm_kernel_source("../shared/vec.h", &size));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(devices_are_described),
        cmocka_unit_test(nonsense_is_refused),
        cmocka_unit_test(rays_end_with_the_same_bits),
        cmocka_unit_test(programs_are_compiled_once),
        cmocka_unit_test(a_callers_queue_serves),
        cmocka_unit_test(a_device_stops_when_told),
        cmocka_unit_test(photons_come_in_parts_where_memory_is_small),
        cmocka_unit_test(photons_stop_when_told),
        cmocka_unit_test(a_plain_scene_needs_little_source),
        cmocka_unit_test(a_source_is_one_text),
    };
    return cmocka_run_group_tests(tests, make_cache, NULL);
}
