/* fuzz_media.c: any medium that can be made can be evaluated and traced; rays end with a status and finite numbers. */
#include "bytes.h"
#include "cpm/cpm.h"

#define SAMPLES 64
#define RAYS 4

static cpm_dispersion *take_dispersion(bytes *b, cpm_dispersion *d) {
    if (take_below(b, 2)) return NULL;
    *d = (cpm_dispersion){
        .struct_size = sizeof *d, .kind = (int32_t)take_below(b, 7), .count = (int32_t)take_below(b, 10)};
    for (int i = 0; i < 10; i++) d->coefficients[i] = i == 0 ? take_index(b) : take_number(b);
    if (d->kind == CPM_DISPERSION_TABULATED)
        for (int i = 0; i < 5; i++) d->coefficients[2 * i] = 300.0 + 100.0 * i;
    return d;
}

static cpm_status take_medium(bytes *b, cpm_context *context, cpm_medium **medium) {
    cpm_dispersion space;
    cpm_dispersion *dispersion = take_dispersion(b, &space);
    double vector[3], origin[3], heights[SAMPLES], values[SAMPLES];
    const uint32_t kind = take_below(b, 6);
    take_point(b, vector);
    take_point(b, origin);
    if (kind == 0) return cpm_medium_create_homogeneous(context, take_index(b), dispersion, medium);
    if (kind == 1) return cpm_medium_create_dispersive(context, dispersion, medium);
    if (kind == 2) return cpm_medium_create_linear(context, take_index(b), vector, origin, dispersion, medium);
    if (kind == 3) return cpm_medium_create_linear_squared(context, take_index(b), vector, origin, dispersion, medium);
    for (size_t i = 0; i < SAMPLES; i++) values[i] = take_index(b);
    if (kind == 4) {
        cpm_layered_desc d = {.struct_size = sizeof d,
                              .heights = heights,
                              .n = values,
                              .count = take_below(b, SAMPLES),
                              .interpolation = (int32_t)take_below(b, 5)};
        double height = take_number(b);
        for (size_t i = 0; i < SAMPLES; i++) heights[i] = height += fabs(take_number(b));
        memcpy(d.up, vector, sizeof d.up);
        memcpy(d.origin, origin, sizeof d.origin);
        return cpm_medium_create_layered(context, &d, dispersion, medium);
    }
    cpm_grid_desc d = {.struct_size = sizeof d,
                       .values = values,
                       .size = {take_below(b, 5), take_below(b, 5), take_below(b, 5)},
                       .interpolation = (int32_t)take_below(b, 3)};
    for (int k = 0; k < 3; k++) d.spacing[k] = fabs(take_number(b));
    memcpy(d.origin, origin, sizeof d.origin);
    return cpm_medium_create_grid(context, &d, dispersion, medium);
}

static void trace(bytes *b, cpm_context *context, cpm_medium *medium) {
    double origins[RAYS][3], directions[RAYS][3], position[RAYS][3], path[RAYS];
    int32_t status[RAYS];
    const double wavelength = 400.0 + 300.0 * take_below(b, 11) / 10.0, length = fabs(take_number(b));
    for (int i = 0; i < RAYS; i++) {
        take_point(b, origins[i]);
        take_point(b, directions[i]);
    }
    const cpm_rays_request request = {.struct_size = sizeof request,
                                      .count = RAYS,
                                      .origins = origins[0],
                                      .directions = directions[0],
                                      .wavelengths = &wavelength,
                                      .lengths = &length,
                                      .method = (int32_t)take_below(b, 6),
                                      .rtol = take_below(b, 2) ? 0.0 : fabs(take_number(b)),
                                      .max_evaluations = 2000};
    cpm_rays_result result = {
        .struct_size = sizeof result, .position = position[0], .optical_path = path, .status = status};
    const cpm_status called = cpm_rays_trace(context, medium, NULL, &request, &result);
    if (called != CPM_OK) {
        require(cpm_context_last_error(context)[0] != 0);
        return;
    }
    for (int i = 0; i < RAYS; i++) {
        require(cpm_ray_status_string((cpm_ray_status)status[i])[0] != 'u'); /* "unknown status" */
        for (int k = 0; k < 3; k++) require(b->wild || !isnan(position[i][k]));
        require(b->wild || !isnan(path[i]));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    bytes b = {data, data + size, 0};
    const cpm_context_options options = {.struct_size = sizeof options, .threads = 1};
    cpm_context *context = NULL;
    require(cpm_context_create(&options, &context) == CPM_OK);
    cpm_medium *medium = NULL;
    if (take_medium(&b, context, &medium) == CPM_OK) {
        double point[3], n, gradient[3];
        take_point(&b, point);
        /* NaN is an answer: a linear field has n^2 <= 0 somewhere. */
        if (cpm_medium_evaluate(context, medium, point, 1, 550.0, &n, gradient) == CPM_OK) require(!(n < 0.0));
        trace(&b, context, medium);
        cpm_medium_release(medium);
    } else {
        require(medium == NULL && cpm_context_last_error(context)[0] != 0);
    }
    cpm_context_release(context);
    return 0;
}
