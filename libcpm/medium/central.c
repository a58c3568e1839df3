/* medium/central.c: media about an axis or a centre: fibre, Luneburg lens, fish-eye, Eaton lens. */
#include <math.h>
#include <string.h>

#include "dispersion.h"

/* Squares and cubes of sizes, and of their inverses, must stay in double precision's range. */
#define LEAST_SIZE 1e-60
#define LARGEST_SIZE 1e60

static cpm_status check_output(cpm_context *context, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    return context ? CPM_OK : CPM_ERROR_INVALID_ARGUMENT;
}

static cpm_status check_size(cpm_context *context, const char *name, double value) {
    if (value >= LEAST_SIZE && value <= LARGEST_SIZE) return CPM_OK;
    return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is %g; must be in [%g, %g]", name, value, LEAST_SIZE,
                    LARGEST_SIZE);
}

static cpm_status take_place(cpm_context *context, const char *name, const double *given, double place[3]) {
    memset(place, 0, 3 * sizeof *place);
    if (!given) return CPM_OK;
    memcpy(place, given, 3 * sizeof *place);
    return cpm_check_vector(context, name, place);
}

static cpm_status take_axis(cpm_context *context, const double *given, double axis[3]) {
    static const double z[3] = {0.0, 0.0, 1.0};
    cpm_status status = take_place(context, "axis", given ? given : z, axis);
    if (status != CPM_OK) return status;
    double largest = fmax(fabs(axis[0]), fmax(fabs(axis[1]), fabs(axis[2]))), size = 0.0;
    if (largest == 0.0) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "axis is zero; must have a direction");
    for (int k = 0; k < 3; k++) axis[k] /= largest, size += axis[k] * axis[k];
    for (int k = 0; k < 3; k++) axis[k] /= sqrt(size);
    return CPM_OK;
}

cpm_status cpm_medium_create_parabolic(cpm_context *context, double n, double alpha, const double *axis,
                                       const double *origin, const cpm_dispersion *dispersion, cpm_medium **medium) {
    cpm_medium_data data = {.kind = CPM_MEDIUM_PARABOLIC, .value = (n - 1.0) * (n + 1.0)};
    cpm_status status = check_output(context, medium);
    if (status == CPM_OK) status = cpm_check_positive(context, "n", n);
    if (status == CPM_OK && !(alpha == 0.0 || (alpha >= LEAST_SIZE && alpha <= LARGEST_SIZE)))
        status = cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "alpha is %g 1/m; must be 0 or in [%g, %g]", alpha,
                          LEAST_SIZE, LARGEST_SIZE);
    if (status == CPM_OK) status = take_axis(context, axis, data.axis);
    if (status == CPM_OK) status = take_place(context, "origin", origin, data.origin);
    if (status != CPM_OK) return status;
    data.high = (n * alpha) * (n * alpha);
    data.uniform = !(data.high > 0.0);
    data.feature = data.uniform ? INFINITY : 1.0 / alpha;
    return cpm_medium_make(context, &data, 0, dispersion, medium);
}

/* A field of one length about a centre; `kinked`: grad n jumps by 1/radius on the sphere. */
static cpm_status create_ball(cpm_context *context, cpm_medium_data *data, double radius, const double *center,
                              int kinked, const cpm_dispersion *dispersion, cpm_medium **medium) {
    cpm_status status = check_size(context, "radius", radius);
    if (status == CPM_OK) status = take_place(context, "center", center, data->origin);
    if (status != CPM_OK) return status;
    data->high = data->feature = radius;
    if (kinked) data->kink = 1.0, data->jump = 1.0 / radius;
    return cpm_medium_make(context, data, 0, dispersion, medium);
}

cpm_status cpm_medium_create_luneburg(cpm_context *context, double radius, const double *center,
                                      const cpm_dispersion *dispersion, cpm_medium **medium) {
    cpm_medium_data data = {.kind = CPM_MEDIUM_LUNEBURG, .value = 1.0};
    cpm_status status = check_output(context, medium);
    return status != CPM_OK ? status : create_ball(context, &data, radius, center, 1, dispersion, medium);
}

cpm_status cpm_medium_create_fisheye(cpm_context *context, double n, double radius, const double *center,
                                     const cpm_dispersion *dispersion, cpm_medium **medium) {
    cpm_medium_data data = {.kind = CPM_MEDIUM_FISHEYE, .value = n - 1.0};
    cpm_status status = check_output(context, medium);
    if (status == CPM_OK) status = cpm_check_positive(context, "n", n);
    return status != CPM_OK ? status : create_ball(context, &data, radius, center, 0, dispersion, medium);
}

cpm_status cpm_medium_create_eaton(cpm_context *context, double radius, const double *center,
                                   const cpm_dispersion *dispersion, cpm_medium **medium) {
    cpm_medium_data data = {.kind = CPM_MEDIUM_EATON};
    cpm_status status = check_output(context, medium);
    return status != CPM_OK ? status : create_ball(context, &data, radius, center, 1, dispersion, medium);
}
