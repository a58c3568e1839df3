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

/* Any program, mostly one that reads what has been written. */
static cpm_status take_expression(bytes *b, cpm_context *context, const cpm_dispersion *dispersion,
                                  cpm_medium **medium) {
    cpm_instruction code[SAMPLES];
    cpm_expression_desc d = {.struct_size = sizeof d, .instructions = code, .count = take_below(b, SAMPLES)};
    for (size_t i = 0; i < d.count; i++) {
        const uint32_t known = 5 + (uint32_t)i, wild = take_below(b, 64) == 0 ? 256 : 0;
        code[i] = (cpm_instruction){.operation = (int32_t)take_below(b, 38 + wild),
                                    .target = (int32_t)(wild ? take_below(b, 200) : known),
                                    .a = (int32_t)take_below(b, known + wild),
                                    .b = (int32_t)take_below(b, known + wild),
                                    .c = (int32_t)take_below(b, known + wild),
                                    .k = take_number(b),
                                    .l = take_number(b)};
        if (code[i].operation > 9 && code[i].operation < 20) code[i].operation += 18;
        if (code[i].operation == 0) code[i].operation = CPM_OPERATION_MULTIPLY;
    }
    for (int k = 0; k < 4; k++) d.results[k] = (int32_t)take_below(b, 5 + (uint32_t)d.count);
    d.feature = take_below(b, 2) ? 0.0 : take_number(b);
    return cpm_medium_create_expression(context, &d, dispersion, medium);
}

static cpm_status take_medium(bytes *b, cpm_context *context, int depth, cpm_medium **medium);

static cpm_status take_sum(bytes *b, cpm_context *context, int depth, cpm_medium **medium) {
    cpm_medium *terms[4] = {NULL, NULL, NULL, NULL};
    size_t count = 1 + take_below(b, 4), made = 0;
    for (size_t i = 0; i < count; i++)
        if (take_medium(b, context, depth + 1, &terms[made]) == CPM_OK) made++;
    const cpm_status status = cpm_medium_create_sum(context, terms, made, medium);
    for (size_t i = 0; i < made; i++) cpm_medium_release(terms[i]);
    return status;
}

static cpm_status take_medium(bytes *b, cpm_context *context, int depth, cpm_medium **medium) {
    cpm_dispersion space;
    cpm_dispersion *dispersion = take_dispersion(b, &space);
    double vector[3], origin[3], heights[SAMPLES], values[SAMPLES];
    const uint32_t kind = take_below(b, depth < 3 ? 13 : 12);
    take_point(b, vector);
    take_point(b, origin);
    if (kind == 0) return cpm_medium_create_homogeneous(context, take_index(b), dispersion, medium);
    if (kind == 1) return cpm_medium_create_dispersive(context, dispersion, medium);
    if (kind == 2) return cpm_medium_create_linear(context, take_index(b), vector, origin, dispersion, medium);
    if (kind == 3) return cpm_medium_create_linear_squared(context, take_index(b), vector, origin, dispersion, medium);
    if (kind == 6)
        return cpm_medium_create_parabolic(context, take_index(b), take_number(b), vector, origin, dispersion, medium);
    if (kind == 7) return cpm_medium_create_luneburg(context, take_number(b), origin, dispersion, medium);
    if (kind == 8) return cpm_medium_create_fisheye(context, take_index(b), take_number(b), origin, dispersion, medium);
    if (kind == 9) return cpm_medium_create_eaton(context, take_number(b), origin, dispersion, medium);
    if (kind == 10) {
        const double centers[6] = {origin[0], origin[1], origin[2], 0.5, 0.5, 0.5},
                     line[6] = {vector[0], vector[1], vector[2]};
        const double strengths[2] = {take_number(b), take_number(b)},
                     exponents[2] = {take_number(b), 0.25 * take_byte(b)};
        const cpm_sources_desc d = {.struct_size = sizeof d,
                                    .count = 1 + take_below(b, 2),
                                    .centers = centers,
                                    .directions = take_below(b, 2) ? line : NULL,
                                    .strengths = strengths,
                                    .exponents = exponents};
        return cpm_medium_create_sources(context, &d, dispersion, medium);
    }
    if (kind == 11) return take_expression(b, context, dispersion, medium);
    if (kind == 12) return take_sum(b, context, depth, medium);
    for (size_t i = 0; i < SAMPLES; i++) values[i] = take_index(b);
    if (kind == 4) {
        cpm_layered_desc d = {.struct_size = sizeof d,
                              .heights = heights,
                              .n = values,
                              .count = take_below(b, SAMPLES),
                              .interpolation = (int32_t)take_below(b, 5),
                              .radius = take_below(b, 2) ? fabs(take_number(b)) : 0.0};
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
    if (take_medium(&b, context, 0, &medium) == CPM_OK) {
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
