/* medium/create.c: media of a few numbers, and what all media share. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dispersion.h"

cpm_status cpm_check_vector(cpm_context *context, const char *name, const double *vector) {
    for (int k = 0; k < 3; k++)
        if (!isfinite(vector[k]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s[%d] is %g; must be finite", name, k, vector[k]);
    return CPM_OK;
}

/* The dispersion's value at the d line, which the medium's numbers are divided by. */
static cpm_status set_reference(cpm_context *context, cpm_medium *m) {
    m->reference = 1.0;
    m->dispersive = cpm_dispersion_varies(&m->dispersion);
    if (!m->dispersive) return CPM_OK;
    double n = 1.0;
    cpm_status status = cpm_dispersion_check(context, &m->dispersion, CPM_D_LINE, &n);
    if (status != CPM_OK) return status;
    m->reference = cpm_medium_by_square(&m->data) ? (n - 1.0) * (n + 1.0) : n - 1.0;
    if (fabs(m->reference) < 1e-12)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion gives n = 1 at %g nm, where the medium's own numbers hold: nothing to scale",
                        CPM_D_LINE);
    return CPM_OK;
}

cpm_status cpm_medium_make(cpm_context *context, const cpm_medium_data *data, size_t table_count,
                           const cpm_dispersion *dispersion, cpm_medium **medium) {
    *medium = NULL;
    cpm_dispersion ours;
    cpm_status status = cpm_dispersion_take(context, dispersion, &ours);
    if (status != CPM_OK) return status;
    cpm_medium *m = calloc(1, sizeof *m);
    if (!m) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a medium");
    atomic_init(&m->references, 1);
    m->data = *data;
    m->dispersion = ours;
    if (table_count) {
        size_t bytes = (table_count * sizeof(double) + 63) / 64 * 64;
        m->table = aligned_alloc(64, bytes);
        if (!m->table) {
            free(m);
            return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a medium's table of %zu doubles",
                            table_count);
        }
        memset(m->table, 0, bytes);
        m->table_count = table_count;
    }
    status = set_reference(context, m);
    if (status != CPM_OK) {
        cpm_medium_release(m);
        return status;
    }
    *medium = m;
    return CPM_OK;
}

void cpm_medium_retain(cpm_medium *medium) {
    if (medium) atomic_fetch_add(&medium->references, 1);
}

void cpm_medium_release(cpm_medium *medium) {
    if (!medium || atomic_fetch_sub(&medium->references, 1) != 1) return;
    free(medium->table), free(medium->extinction);
    free(medium);
}

cpm_status cpm_check_positive(cpm_context *context, const char *name, double value) {
    if (isfinite(value) && value > 0.0) return CPM_OK;
    return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is %g; must be finite and > 0", name, value);
}

cpm_status cpm_medium_create_homogeneous(cpm_context *context, double n, const cpm_dispersion *dispersion,
                                         cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_status status = cpm_check_positive(context, "n", n);
    if (status != CPM_OK) return status;
    cpm_medium_data data = {.kind = CPM_MEDIUM_HOMOGENEOUS, .uniform = 1, .value = n - 1.0, .feature = INFINITY};
    return cpm_medium_make(context, &data, 0, dispersion, medium);
}

cpm_status cpm_medium_create_dispersive(cpm_context *context, const cpm_dispersion *dispersion, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!dispersion || dispersion->kind == CPM_DISPERSION_NONE)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion is %s; a dispersive medium is made from one",
                        dispersion ? "of kind NONE" : "NULL");
    cpm_dispersion ours;
    cpm_status status = cpm_dispersion_take(context, dispersion, &ours);
    if (status != CPM_OK) return status;
    if (!cpm_dispersion_varies(&ours))
        return cpm_medium_create_homogeneous(context, cpm_dispersion_at(&ours, CPM_D_LINE), NULL, medium);
    cpm_medium_data data = {.kind = CPM_MEDIUM_HOMOGENEOUS, .uniform = 1, .value = 1.0, .feature = INFINITY};
    status = cpm_medium_make(context, &data, 0, NULL, medium); /* N = 1: the scale is n - 1 itself */
    if (status != CPM_OK) return status;
    (*medium)->dispersion = ours;
    (*medium)->dispersive = 1;
    return CPM_OK;
}

static int is_zero(const double *v) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }

/* `value` is N or S at the origin. */
static cpm_status create_linear(cpm_context *context, int32_t kind, double value, const double *gradient,
                                const double *origin, const cpm_dispersion *dispersion, cpm_medium **medium) {
    static const double zero[3] = {0.0, 0.0, 0.0};
    if (!gradient) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "gradient is NULL; must be 3 numbers");
    cpm_status status = cpm_check_vector(context, "gradient", gradient);
    if (status == CPM_OK && origin) status = cpm_check_vector(context, "origin", origin);
    if (status != CPM_OK) return status;
    cpm_medium_data data = {.kind = kind, .uniform = is_zero(gradient), .value = value, .feature = INFINITY};
    memcpy(data.axis, gradient, sizeof data.axis);
    memcpy(data.origin, origin ? origin : zero, sizeof data.origin);
    return cpm_medium_make(context, &data, 0, dispersion, medium);
}

cpm_status cpm_medium_create_linear_squared(cpm_context *context, double n_squared, const double *gradient,
                                            const double *origin, const cpm_dispersion *dispersion,
                                            cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_status status = cpm_check_positive(context, "n_squared", n_squared);
    if (status != CPM_OK) return status;
    return create_linear(context, CPM_MEDIUM_LINEAR_SQUARED, n_squared - 1.0, gradient, origin, dispersion, medium);
}

cpm_status cpm_medium_create_linear(cpm_context *context, double n, const double *gradient, const double *origin,
                                    const cpm_dispersion *dispersion, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_status status = cpm_check_positive(context, "n", n);
    if (status != CPM_OK) return status;
    return create_linear(context, CPM_MEDIUM_LINEAR, n - 1.0, gradient, origin, dispersion, medium);
}
