/* medium/sources.c: gravity centres and lines, a record each (types/medium.h). */
#include <math.h>
#include <string.h>

#include "dispersion.h"

#define MAX_SOURCES 1000000
#define MAX_EXPONENT 64.0

static cpm_status check_source(cpm_context *context, const cpm_sources_desc *d, size_t i) {
    for (int k = 0; k < 3; k++) {
        const double c = d->centers[3 * i + (size_t)k], a = d->directions ? d->directions[3 * i + (size_t)k] : 0.0;
        if (!isfinite(c) || !isfinite(a))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s[%zu, %d] is %g; must be finite",
                            isfinite(c) ? "directions" : "centers", i, k, isfinite(c) ? a : c);
    }
    if (!isfinite(d->strengths[i]))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "strengths[%zu] is %g; must be finite", i,
                        d->strengths[i]);
    if (!(d->exponents[i] > 0.0 && d->exponents[i] <= MAX_EXPONENT))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "exponent[%zu] is %g; must be in (0, %g]", i,
                        d->exponents[i], MAX_EXPONENT);
    return CPM_OK;
}

static cpm_status check(cpm_context *context, const cpm_sources_desc *d) {
    if (!d->count || d->count > MAX_SOURCES)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is %zu; must be 1 to %d", d->count, MAX_SOURCES);
    if (!d->centers || !d->strengths || !d->exponents)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL",
                        !d->centers     ? "centers"
                        : !d->strengths ? "strengths"
                                        : "exponents");
    for (size_t i = 0; i < d->count; i++) {
        cpm_status status = check_source(context, d, i);
        if (status != CPM_OK) return status;
    }
    return CPM_OK;
}

static void unit_of(const double *direction, double unit[3]) {
    double largest = fmax(fabs(direction[0]), fmax(fabs(direction[1]), fabs(direction[2]))), size = 0.0;
    for (int k = 0; k < 3; k++) unit[k] = largest > 0.0 ? direction[k] / largest : 0.0, size += unit[k] * unit[k];
    for (int k = 0; k < 3 && size > 0.0; k++) unit[k] /= sqrt(size);
}

cpm_status cpm_medium_create_sources(cpm_context *context, const cpm_sources_desc *desc,
                                     const cpm_dispersion *dispersion, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!desc) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "desc is NULL");
    cpm_sources_desc d;
    CPM_TAKE(d, desc);
    cpm_status status = check(context, &d);
    if (status != CPM_OK) return status;
    cpm_medium_data data = {.kind = CPM_MEDIUM_SOURCES, .uniform = 1, .feature = INFINITY};
    data.size[0] = (int32_t)d.count;
    for (size_t i = 0; i < d.count; i++) { /* where one source alone makes n - 1 = 1 */
        if (d.strengths[i] == 0.0) continue;
        data.uniform = 0;
        data.feature = fmin(data.feature, fmax(pow(fabs(d.strengths[i]), 1.0 / d.exponents[i]), 1e-30));
    }
    status = cpm_medium_make(context, &data, d.count * CPM_RECORD, dispersion, medium);
    for (size_t i = 0; i < d.count && status == CPM_OK; i++) {
        double *record = (*medium)->table + CPM_RECORD * i;
        memcpy(record, d.centers + 3 * i, 3 * sizeof *record);
        record[3] = d.strengths[i];
        if (d.directions) unit_of(d.directions + 3 * i, record + 4);
        record[7] = d.exponents[i];
    }
    return status;
}
