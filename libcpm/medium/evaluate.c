/* medium/evaluate.c: a medium at single points: the shared field with one lane, the same bits as in any packet. */
#define CPM_WIDTH 1
#define CPM_SINGLE 0
#include "cl/shared/exact.h"
#include "cl/shared/medium.h"

#include <math.h>

#include "dispersion.h"

int cpm_medium_is_uniform(const cpm_medium *medium) { return medium->data.uniform; }

static int is_layered(const cpm_medium_data *d) {
    return d->kind == CPM_MEDIUM_LAYERED || d->kind == CPM_MEDIUM_SHELLS;
}

int cpm_medium_has_exact(const cpm_medium *medium) {
    const cpm_medium_data *d = &medium->data;
    return d->uniform || d->kind == CPM_MEDIUM_LINEAR_SQUARED || d->kind == CPM_MEDIUM_LINEAR ||
           (is_layered(d) && d->interpolation != CPM_FIELD_CUBIC);
}

int cpm_medium_needs_exact(const cpm_medium *medium) {
    const cpm_medium_data *d = &medium->data;
    return !d->uniform && is_layered(d) && d->interpolation == CPM_FIELD_STEP;
}

void cpm_medium_field(const cpm_medium *medium, double scale, const double r[3], double *n, double g[3]) {
    real3 half = cpm_field(&medium->data, medium->table, triple(r[0], r[1], r[2]), scale, n);
    if (!(*n > 0.0)) *n = NAN;
    g[0] = half.x, g[1] = half.y, g[2] = half.z;
}

double cpm_medium_n(const cpm_medium *medium, double scale, const double r[3]) {
    double n, g[3];
    cpm_medium_field(medium, scale, r, &n, g);
    return n;
}

double cpm_medium_n_toward(const cpm_medium *medium, double scale, const double r[3], const double direction[3]) {
    if (!cpm_medium_needs_exact(medium)) return cpm_medium_n(medium, scale, r);
    double n = cpm_exact_index(&medium->data, medium->table, scale, r, direction);
    return n > 0.0 ? n : NAN;
}

cpm_status cpm_medium_evaluate(cpm_context *context, const cpm_medium *medium, const double *points, size_t count,
                               double wavelength, double *n, double *gradient) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!medium || !points || !n)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL",
                        !medium   ? "medium"
                        : !points ? "points"
                                  : "n");
    double scale;
    cpm_status status = cpm_medium_scale(context, medium, wavelength, &scale);
    if (status != CPM_OK) return status;
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            if (!isfinite(points[3 * i + (size_t)k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "points[%zu, %d] is %g; must be finite", i, k,
                                points[3 * i + (size_t)k]);
        double g[3];
        cpm_medium_field(medium, scale, points + 3 * i, &n[i], g);
        for (int k = 0; k < 3 && gradient; k++) gradient[3 * i + (size_t)k] = g[k] / n[i];
    }
    return CPM_OK;
}
