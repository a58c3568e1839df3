/* medium/grid.c: n on a grid of samples: checks, and the prefilter of the interpolating cubic B-spline.
 *
 * Along each axis the coefficients satisfy (c_{i-1} + 4 c_i + c_{i+1})/6 = N_i at every sample, with one more at either
 * end. The ends are not-a-knot (the third derivative is continuous at samples 1 and last - 1), which keeps fourth order
 * up to the edge: the condition's fourth difference of c at sample 1, reduced with the equations there, is
 *   c_1 = (8 N_1 - N_0 - N_2)/6                                                                                    (1)
 * and likewise at the other end; between them a tridiagonal system, outward the equations themselves. Three samples: a
 * parabola, c_i = N_i - (second difference)/6; two: a straight line; one: a constant. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dispersion.h"

#define MAX_SAMPLES ((size_t)1 << 31)

/* Coefficients c[0..padded(count)-1] (c[i + 1] belongs to sample i) from samples f; `work` holds count doubles. */
static void prefilter(const double *f, size_t count, double *c, double *work) {
    if (count == 1) {
        for (int i = 0; i < 4; i++) c[i] = f[0];
        return;
    }
    if (count <= 3) { /* a polynomial through all samples */
        double bend = count == 3 ? f[0] - 2.0 * f[1] + f[2] : 0.0;
        for (size_t i = 0; i < count; i++) c[i + 1] = f[i] - bend / 6.0;
        c[0] = 2.0 * c[1] - c[2] + bend;
        c[count + 1] = 2.0 * c[count] - c[count - 1] + bend;
        return;
    }
    size_t last = count - 1;
    double *at = c + 1; /* at[i]: sample i */
    at[1] = (8.0 * f[1] - f[0] - f[2]) / 6.0;
    at[last - 1] = (8.0 * f[last - 1] - f[last] - f[last - 2]) / 6.0;
    work[1] = 0.0; /* elimination: at[i] = right - work[i] at[i + 1] */
    for (size_t i = 2; i + 1 < last; i++) {
        double pivot = 4.0 - work[i - 1];
        work[i] = 1.0 / pivot;
        at[i] = (6.0 * f[i] - at[i - 1]) / pivot;
    }
    for (size_t i = last - 2; i >= 2; i--) at[i] -= work[i] * at[i + 1];
    at[0] = 6.0 * f[1] - 4.0 * at[1] - at[2];
    at[-1] = 6.0 * f[0] - 4.0 * at[0] - at[1];
    at[last] = 6.0 * f[last - 1] - 4.0 * at[last - 1] - at[last - 2];
    at[last + 1] = 6.0 * f[last] - 4.0 * at[last] - at[last - 1];
}

static size_t padded(size_t count, int cubic) {
    if (!cubic) return count < 2 ? 2 : count;
    return count < 2 ? 4 : count + 2;
}

/* Turns the samples along one axis of a box into values of the table, in place: `size` are the box's samples so far,
 * `stride` the table's. The other axes are walked by their current sizes. */
static void fill_axis(double *table, const size_t size[3], const size_t stride[3], int axis, int cubic, double *line) {
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    size_t count = size[axis], wide = padded(count, cubic);
    double *f = line, *out = line + count, *work = out + wide;
    for (size_t i = 0; i < size[b]; i++)
        for (size_t j = 0; j < size[c]; j++) {
            double *first = table + i * stride[b] + j * stride[c];
            for (size_t k = 0; k < count; k++) f[k] = first[k * stride[axis]];
            if (cubic)
                prefilter(f, count, out, work);
            else
                for (size_t k = 0; k < wide; k++) out[k] = f[k < count ? k : count - 1];
            for (size_t k = 0; k < wide; k++) first[k * stride[axis]] = out[k];
        }
}

static double sample(const cpm_grid_desc *d, const ptrdiff_t stride[3], size_t i, size_t j, size_t k) {
    double value; /* strides are the caller's: the address need not be aligned */
    memcpy(&value,
           (const char *)d->values + (ptrdiff_t)i * stride[0] + (ptrdiff_t)j * stride[1] + (ptrdiff_t)k * stride[2],
           sizeof value);
    return value;
}

/* data->feature: metres over which the field changes, the largest slope over the largest change of slope a metre, at
 * least half a cell. data->kink, jump: the largest jump of slope, times a cell and itself, at the box's faces and,
 * trilinear, at all. `table` still holds the samples. */
static void measure(cpm_medium_data *data, const double *table, const size_t stride[3], const double spacing[3]) {
    double steepest = 0.0, bend = 0.0, finest = INFINITY, kink = 0.0, jump = 0.0, least = INFINITY;
    const int linear = data->interpolation == CPM_FIELD_LINEAR;
    for (int a = 0; a < 3; a++) {
        if (data->size[a] < 2) continue;
        finest = fmin(finest, spacing[a]);
        int b = (a + 1) % 3, c = (a + 2) % 3, last = data->size[a] - 2;
        for (int32_t i = 0; i < data->size[b]; i++)
            for (int32_t j = 0; j < data->size[c]; j++) {
                const double *f = table + (size_t)i * stride[b] + (size_t)j * stride[c];
                double before = 0.0;
                for (int32_t k = 0; k <= last; k++) {
                    double here = f[(size_t)k * stride[a]], rise = f[(size_t)(k + 1) * stride[a]] - here;
                    steepest = fmax(steepest, fabs(rise) / spacing[a]);
                    if (k) bend = fmax(bend, fabs(rise - before) / (spacing[a] * spacing[a]));
                    double change = fmax(linear || k == 0 ? fabs(rise - before) : 0.0, k == last ? fabs(rise) : 0.0);
                    kink = fmax(kink, change);
                    jump = fmax(jump, change / spacing[a]);
                    least = fmin(least, here);
                    before = rise;
                }
            }
    }
    data->feature = fmax(bend > 0.0 ? steepest / bend : INFINITY, 0.5 * finest);
    data->kink = kink / (1.0 + fmin(least, data->value));
    data->jump = jump / (1.0 + fmin(least, data->value));
}

static cpm_status check(cpm_context *context, const cpm_grid_desc *d) {
    if (d->interpolation != CPM_INTERPOLATION_LINEAR && d->interpolation != CPM_INTERPOLATION_CUBIC)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "interpolation is %d; grids take LINEAR (0) or CUBIC (1)",
                        (int)d->interpolation);
    if (!d->values) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "values is NULL");
    size_t total = 1;
    for (int k = 0; k < 3; k++) {
        if (d->size[k] < 1 || d->size[k] > MAX_SAMPLES / total)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "size[%d] is %zu; must be >= 1, %zu samples in all at the most", k, d->size[k],
                            MAX_SAMPLES);
        total *= d->size[k];
        if (!isfinite(d->spacing[k]) || !(d->spacing[k] > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "spacing[%d] is %g; must be finite and > 0", k,
                            d->spacing[k]);
    }
    return cpm_check_vector(context, "origin", d->origin);
}

cpm_status cpm_medium_create_grid(cpm_context *context, const cpm_grid_desc *desc, const cpm_dispersion *dispersion,
                                  cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!desc) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "desc is NULL");
    cpm_grid_desc d;
    CPM_TAKE(d, desc);
    cpm_status status = check(context, &d);
    if (status != CPM_OK) return status;
    const int cubic = d.interpolation == CPM_INTERPOLATION_CUBIC;
    ptrdiff_t from[3] = {d.stride[0], d.stride[1], d.stride[2]};
    if (!from[0] && !from[1] && !from[2]) {
        from[2] = (ptrdiff_t)sizeof(double);
        from[1] = from[2] * (ptrdiff_t)d.size[2];
        from[0] = from[1] * (ptrdiff_t)d.size[1];
    }
    size_t wide[3], stride[3], total = 1, longest = 0;
    for (int k = 2; k >= 0; k--) {
        wide[k] = padded(d.size[k], cubic);
        stride[k] = total;
        if (wide[k] > MAX_SAMPLES / total)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "grid of %zu x %zu x %zu samples needs more than %zu coefficients", d.size[0], d.size[1],
                            d.size[2], MAX_SAMPLES);
        total *= wide[k];
        if (wide[k] > longest) longest = wide[k];
    }
    cpm_medium_data data = {.kind = CPM_MEDIUM_GRID, .interpolation = d.interpolation};
    for (int k = 0; k < 3; k++) {
        data.size[k] = (int32_t)d.size[k];
        data.origin[k] = d.origin[k];
        data.axis[k] = 1.0 / d.spacing[k];
    }
    status = cpm_medium_make(context, &data, total, dispersion, medium);
    if (status != CPM_OK) return status;
    cpm_medium *m = *medium;
    double *line = malloc(3 * longest * sizeof *line);
    if (!line) status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for a line of %zu samples", longest);
    double first = sample(&d, from, 0, 0, 0);
    m->data.uniform = 1;
    m->data.value = first - 1.0;
    for (size_t i = 0; i < d.size[0] && status == CPM_OK; i++)
        for (size_t j = 0; j < d.size[1] && status == CPM_OK; j++)
            for (size_t k = 0; k < d.size[2] && status == CPM_OK; k++) {
                double n = sample(&d, from, i, j, k);
                if (!isfinite(n) || !(n > 0.0))
                    status = cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                                      "values[%zu, %zu, %zu] is %g; must be finite and > 0", i, j, k, n);
                m->table[i * stride[0] + j * stride[1] + k * stride[2]] = n - 1.0;
                m->data.uniform &= n == first;
            }
    if (status == CPM_OK) {
        measure(&m->data, m->table, stride, d.spacing);
        size_t size[3] = {d.size[0], d.size[1], d.size[2]};
        for (int axis = 0; axis < 3; axis++) {
            fill_axis(m->table, size, stride, axis, cubic, line);
            size[axis] = wide[axis];
        }
    } else {
        cpm_medium_release(m);
        *medium = NULL;
    }
    free(line);
    return status;
}
