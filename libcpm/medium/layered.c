/* medium/layered.c: n as a table of height: checks, the natural spline, the guide that finds a layer.
 *
 * Natural cubic spline through (h_i, N_i): with M_i the second derivatives, M_0 = M_last = 0 and
 *   d_{i-1} M_{i-1} + 2 (d_{i-1} + d_i) M_i + d_i M_{i+1} = 6 ((N_{i+1} - N_i)/d_i - (N_i - N_{i-1})/d_{i-1})      (1)
 * for d_i = h_{i+1} - h_i; tridiagonal, solved by elimination. Between: N = N_i + t (slope + t (M_i/2 + t (M_{i+1} -
 * M_i)/(6 d_i))), slope = (N_{i+1} - N_i)/d_i - d_i (2 M_i + M_{i+1})/6. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dispersion.h"

#define MAX_HEIGHTS 1000000
#define GUIDE_MARGIN 1e-3 /* of a bucket: covers the rounding of float heights */

static cpm_status check(cpm_context *context, const cpm_layered_desc *d) {
    int cubic = d->interpolation == CPM_INTERPOLATION_CUBIC, step = d->interpolation == CPM_INTERPOLATION_STEP;
    if (!cubic && !step && d->interpolation != CPM_INTERPOLATION_LINEAR_SQUARED)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "interpolation is %d; layered media take CUBIC (1), LINEAR_SQUARED (2) or STEP (3)",
                        (int)d->interpolation);
    size_t least = step ? 1 : 2;
    if (d->count < least || d->count > MAX_HEIGHTS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is %zu; must be %zu to %d", d->count, least,
                        MAX_HEIGHTS);
    if (!d->heights || !d->n)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL", d->heights ? "n" : "heights");
    for (size_t i = 0; i < d->count; i++) {
        if (!isfinite(d->heights[i]) || (i && !(d->heights[i] > d->heights[i - 1])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "heights[%zu] is %.17g; must be finite and above heights[%zu]", i, d->heights[i],
                            i ? i - 1 : 0);
        if (!isfinite(d->n[i]) || !(d->n[i] > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "n[%zu] is %g; must be finite and > 0", i, d->n[i]);
    }
    if (!(d->radius >= 0.0) || !isfinite(d->radius))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "radius is %g; must be finite and > 0 metres, or 0 for flat layers", d->radius);
    if (d->radius > 0.0 && !(d->heights[0] > -d->radius))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "heights[0] is %.17g; must be above -radius, %.17g, the centre of the sphere", d->heights[0],
                        -d->radius);
    if (d->kink_count && (!cubic || !d->kinks))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "kink_count is %zu; %s", d->kink_count,
                        cubic ? "kinks is NULL" : "only CUBIC takes kinks");
    for (size_t k = 0; k < d->kink_count; k++) {
        size_t least_kink = k ? d->kinks[k - 1] + 1 : 1;
        if (d->kinks[k] < least_kink || d->kinks[k] >= d->count - 1)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "kinks[%zu] is %zu; must be an inner height's index, 1 to %zu, and ascend", k, d->kinks[k],
                            d->count - 2);
    }
    cpm_status status = cpm_check_vector(context, "up", d->up);
    return status == CPM_OK ? cpm_check_vector(context, "origin", d->origin) : status;
}

/* Second derivatives of the natural spline, equation (1). `work` holds 2 count doubles. */
static void natural_spline(const double *h, const double *y, size_t count, double *second, double *work) {
    double *upper = work, *right = work + count;
    second[0] = second[count - 1] = 0.0;
    upper[0] = right[0] = 0.0;
    for (size_t i = 1; i + 1 < count; i++) {
        double below = h[i] - h[i - 1], above = h[i + 1] - h[i];
        double pivot = 2.0 * (below + above) - below * upper[i - 1];
        upper[i] = above / pivot;
        right[i] = (6.0 * ((y[i + 1] - y[i]) / above - (y[i] - y[i - 1]) / below) - below * right[i - 1]) / pivot;
    }
    for (size_t i = count - 1; i-- > 1;) second[i] = right[i] - upper[i] * second[i + 1];
}

/* Natural splines from kink to kink. */
static void splines(const cpm_layered_desc *d, const double *y, double *second, double *work) {
    size_t from = 0;
    for (size_t k = 0; k <= d->kink_count; k++) {
        size_t to = k < d->kink_count ? d->kinks[k] : d->count - 1;
        natural_spline(d->heights + from, y + from, to - from + 1, second + from, work);
        from = to;
    }
}

static void fill_records(const cpm_layered_desc *d, double *records, const double *value, const double *second) {
    size_t count = d->count;
    records[0] = value[0];
    records[4] = d->heights[0];
    for (size_t i = 0; i < count; i++) {
        double *c = records + CPM_RECORD * (i + 1);
        c[0] = value[i];
        c[4] = d->heights[i];
        if (i + 1 == count || d->interpolation == CPM_INTERPOLATION_STEP) continue;
        double width = d->heights[i + 1] - d->heights[i];
        c[1] = (value[i + 1] - value[i]) / width;
        if (d->interpolation == CPM_INTERPOLATION_LINEAR_SQUARED && d->radius > 0.0) /* a metre^2 of rho^2 */
            c[1] /= 2.0 * d->radius + d->heights[i] + d->heights[i + 1];
        if (!second) continue;
        c[1] -= width * (2.0 * second[i] + second[i + 1]) / 6.0;
        c[2] = 0.5 * second[i];
        c[3] = (second[i + 1] - second[i]) / (6.0 * width);
    }
}

/* For each bucket the last layer that starts at or below its bottom. Returns the halvings that the fullest bucket
 * needs. */
static int32_t fill_guide(const cpm_medium_data *data, const double *heights, double *guide) {
    size_t count = (size_t)data->size[0], most = 0, low = 0, high = 0;
    for (int32_t b = 0; b < data->size[1]; b++) {
        double bottom = data->low + (b - GUIDE_MARGIN) / data->bucket,
               top = data->low + (b + 1 + GUIDE_MARGIN) / data->bucket;
        while (low < count && heights[low] <= bottom) low++;
        while (high < count && heights[high] <= top) high++;
        if (b == data->size[1] - 1) high = count; /* also for all heights above the table */
        guide[b] = (double)(b ? low : 0);         /* bucket 0: also for all heights below */
        if (high - (b ? low : 0) > most) most = high - (b ? low : 0);
    }
    int32_t halvings = 0;
    while (most > 0) halvings++, most /= 2;
    return halvings;
}

/* data->feature: metres over which the field changes, the largest slope over the largest change of slope a metre, at
 * least half of the thinnest layer; on spheres no more than their radius, over which `up` turns. data->kink, jump: the
 * largest jump of slope, times a layer and itself, at the table's ends and, n^2 linear, at every height; where it is
 * linear in rho^2 the slope by height differs at a layer's ends, by rho/(mean rho). */
static void measure(cpm_medium_data *data, const cpm_layered_desc *d, const double *value) {
    double steepest = 0.0, bend = 0.0, thinnest = INFINITY, kink = 0.0, jump = 0.0, before = 0.0;
    const double *h = d->heights;
    const size_t count = d->count;
    for (size_t i = 0, k = 0; i + 1 < count; i++) {
        double width = h[i + 1] - h[i], slope = (value[i + 1] - value[i]) / width;
        double reach = i ? 0.5 * (h[i + 1] - h[i - 1]) : width;
        thinnest = fmin(thinnest, width);
        steepest = fmax(steepest, fabs(slope));
        const int jumps = k < d->kink_count && d->kinks[k] == i; /* which is no bend */
        k += (size_t)jumps;
        if (i && !jumps) bend = fmax(bend, fabs(slope - before) / reach);
        const int inner = i == 0 || data->interpolation == CPM_FIELD_LINEAR_SQUARED;
        double foot = slope, top = slope;
        if (data->radius > 0.0 && data->interpolation == CPM_FIELD_LINEAR_SQUARED) {
            double mean = data->radius + 0.5 * (h[i] + h[i + 1]);
            foot *= (data->radius + h[i]) / mean, top *= (data->radius + h[i + 1]) / mean;
        }
        double change = fmax(inner ? fabs(foot - before) : 0.0, i + 2 == count ? fabs(top) : 0.0);
        kink = fmax(kink, change * reach);
        jump = fmax(jump, change);
        before = top;
    }
    data->feature = fmax(bend > 0.0 ? steepest / bend : INFINITY, 0.5 * thinnest);
    if (data->radius > 0.0) data->feature = fmin(data->feature, data->radius + data->low);
    data->kink = data->interpolation == CPM_FIELD_STEP ? 0.0 : kink;
    data->jump = jump;
}

cpm_status cpm_medium_create_layered(cpm_context *context, const cpm_layered_desc *desc,
                                     const cpm_dispersion *dispersion, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!desc) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "desc is NULL");
    cpm_layered_desc d;
    CPM_TAKE(d, desc);
    cpm_status status = check(context, &d);
    if (status != CPM_OK) return status;

    size_t count = d.count, buckets = count < 2 ? 1 : 2 * count;
    cpm_medium_data data = {.kind = d.radius > 0.0 ? CPM_MEDIUM_SHELLS : CPM_MEDIUM_LAYERED,
                            .interpolation = d.interpolation,
                            .radius = d.radius};
    data.low = d.heights[0], data.high = d.heights[count - 1];
    data.size[0] = (int32_t)count, data.size[1] = (int32_t)buckets;
    data.bucket = count > 1 ? (double)buckets / (data.high - data.low) : 1.0;
    data.guide = (int64_t)count;
    data.records = (int64_t)((count + buckets + CPM_RECORD - 1) / CPM_RECORD * CPM_RECORD); /* whole cache lines */
    double length = sqrt(d.up[0] * d.up[0] + d.up[1] * d.up[1] + d.up[2] * d.up[2]);
    for (int k = 0; k < 3; k++) data.axis[k] = length > 0.0 ? d.up[k] / length : (k == 1);
    memcpy(data.origin, d.origin, sizeof data.origin);

    double *work = calloc(4 * count, sizeof *work);
    if (!work) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for %zu layers", count);
    double *value = work, *second = work + count;
    data.uniform = 1;
    for (size_t i = 0; i < count; i++) {
        value[i] = cpm_medium_by_square(&data) ? (d.n[i] - 1.0) * (d.n[i] + 1.0) : d.n[i] - 1.0;
        data.uniform &= d.n[i] == d.n[0];
    }
    data.value = value[0];
    measure(&data, &d, value);
    status = cpm_medium_make(context, &data, (size_t)data.records + CPM_RECORD * (count + 1), dispersion, medium);
    if (status == CPM_OK) {
        double *table = (*medium)->table;
        int cubic = d.interpolation == CPM_INTERPOLATION_CUBIC;
        memcpy(table, d.heights, count * sizeof *table);
        if (cubic) splines(&d, value, second, work + 2 * count);
        fill_records(&d, table + data.records, value, cubic ? second : NULL);
        (*medium)->data.size[2] = fill_guide(&data, d.heights, table + data.guide);
    }
    free(work);
    return status;
}
