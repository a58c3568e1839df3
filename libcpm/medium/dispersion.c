/* medium/dispersion.c: checking a dispersion, and the factor that a wavelength gives a medium.
 *
 * A medium's own numbers hold at the d line. One defined by n has s = (D(w) - 1)/(D(d) - 1), one defined by n^2 has
 * s = (D(w)^2 - 1)/(D(d)^2 - 1); a lens keeps its shape only while s is not too small. A homogeneous medium made from a
 * dispersion alone stores N = 1, so s = D(w) - 1 and the d line need not be in range. */
#include "cl/shared/dispersion.h"

#include "dispersion.h"

#include <math.h>
#include <string.h>

double cpm_dispersion_at(const cpm_dispersion *d, double wavelength) {
    return cpm_dispersion_n(d->kind, d->count, d->coefficients, wavelength);
}

int cpm_dispersion_varies(const cpm_dispersion *d) {
    const double *c = d->coefficients;
    if (d->kind == CPM_DISPERSION_CAUCHY)
        for (int i = 1; i < d->count; i++)
            if (c[i] != 0.0) return 1;
    if (d->kind == CPM_DISPERSION_SELLMEIER)
        for (int i = 0; i < d->count; i += 2)
            if (c[i] != 0.0 && c[i + 1] != 0.0) return 1;
    if (d->kind == CPM_DISPERSION_GAS)
        for (int i = 1; i < d->count; i += i < 4 ? 1 : 2)
            if (c[i] != 0.0) return 1;
    if (d->kind == CPM_DISPERSION_TABULATED)
        for (int i = 3; i < d->count; i += 2)
            if (c[i] != c[1]) return 1;
    return 0;
}

static cpm_status check_table(cpm_context *context, const cpm_dispersion *d) {
    for (int i = 0; i < d->count; i += 2) {
        if (!(d->coefficients[i] > 0.0) || (i && !(d->coefficients[i] > d->coefficients[i - 2])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "dispersion: wavelength %d of the table is %g nm; must be > 0 and increase", i / 2,
                            d->coefficients[i]);
        if (!(d->coefficients[i + 1] > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion: n %d of the table is %g; must be > 0",
                            i / 2, d->coefficients[i + 1]);
    }
    return CPM_OK;
}

cpm_status cpm_dispersion_take(cpm_context *context, const cpm_dispersion *given, cpm_dispersion *ours) {
    memset(ours, 0, sizeof *ours);
    ours->struct_size = sizeof *ours;
    if (!given) return CPM_OK;
    if (given->struct_size < offsetof(cpm_dispersion, coefficients))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion.struct_size is %zu; set it to sizeof(cpm_dispersion)", given->struct_size);
    CPM_TAKE(*ours, given);
    if (ours->kind == CPM_DISPERSION_NONE) return CPM_OK;
    if (ours->kind < CPM_DISPERSION_NONE || ours->kind > CPM_DISPERSION_GAS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion.kind is %d; must be 0 to 5 (cpm_dispersion_kind)", (int)ours->kind);
    int pairs = ours->kind == CPM_DISPERSION_SELLMEIER || ours->kind == CPM_DISPERSION_TABULATED ||
                ours->kind == CPM_DISPERSION_GAS;
    int least = ours->kind == CPM_DISPERSION_GAS ? 4 : 1;
    if (ours->count < least || ours->count > CPM_DISPERSION_MAX_COEFFICIENTS || (pairs && ours->count % 2))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion.count is %d; must be %d to %d%s",
                        (int)ours->count, least, CPM_DISPERSION_MAX_COEFFICIENTS, pairs ? " and even (pairs)" : "");
    for (int i = 0; i < ours->count; i++)
        if (!isfinite(ours->coefficients[i]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion.coefficients[%d] is %g; must be finite", i,
                            ours->coefficients[i]);
    if (!isfinite(ours->low) || !isfinite(ours->high) || ours->low < 0.0 || ours->low > ours->high)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion range is [%g, %g] nm; must be 0 <= low <= high (0, 0: no limit)", ours->low,
                        ours->high);
    if (ours->kind == CPM_DISPERSION_CONSTANT && !(ours->coefficients[0] > 0.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion: constant n is %g; must be > 0",
                        ours->coefficients[0]);
    return ours->kind == CPM_DISPERSION_TABULATED ? check_table(context, ours) : CPM_OK;
}

cpm_status cpm_dispersion_check(cpm_context *context, const cpm_dispersion *d, double wavelength, double *n) {
    if (!(wavelength > 0.0) || !isfinite(wavelength))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelength is %g nm; must be finite and > 0", wavelength);
    if (d->high > 0.0 && (wavelength < d->low || wavelength > d->high))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "wavelength is %g nm; the medium's dispersion is valid in [%g, %g] nm", wavelength, d->low,
                        d->high);
    *n = cpm_dispersion_at(d, wavelength);
    if (!(*n > 0.0) || !isfinite(*n))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "dispersion gives n = %g at %g nm; must be finite and > 0",
                        *n, wavelength);
    return CPM_OK;
}

/* The scale above which rays in a medium are of the kind that they are at the d line: ellipses in fibre and lenses (an
 * Eaton lens below 1/2 has hyperbolas), n > 0 in a fish-eye. */
static double least_scale(const cpm_medium_data *data) {
    if (data->uniform) return -INFINITY;
    if (data->kind == CPM_MEDIUM_EATON) return 0.5;
    if (data->kind == CPM_MEDIUM_PARABOLIC || data->kind == CPM_MEDIUM_LUNEBURG) return 0.0;
    if (data->kind == CPM_MEDIUM_FISHEYE && data->value > 0.0) return -1.0 / data->value;
    return -INFINITY;
}
static double largest_scale(const cpm_medium_data *data) {
    return data->kind == CPM_MEDIUM_FISHEYE && data->value < 0.0 ? -1.0 / data->value : INFINITY;
}

cpm_status cpm_medium_scale(cpm_context *context, const cpm_medium *medium, double wavelength, double *scale) {
    *scale = medium->by_wavelength ? wavelength : 1.0;
    if (!medium->dispersive || medium->by_wavelength) {
        if (!(wavelength > 0.0) || !isfinite(wavelength))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelength is %g nm; must be finite and > 0",
                            wavelength);
        return medium->by_wavelength ? cpm_sum_check(context, medium, wavelength) : CPM_OK;
    }
    double n = 1.0;
    cpm_status status = cpm_dispersion_check(context, &medium->dispersion, wavelength, &n);
    if (status != CPM_OK) return status;
    *scale = (cpm_medium_by_square(&medium->data) ? (n - 1.0) * (n + 1.0) : n - 1.0) / medium->reference;
    const double low = least_scale(&medium->data), high = largest_scale(&medium->data);
    if (!(*scale > low && *scale < high))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion scales the medium by %g at %g nm (1 at %g nm); must be in (%g, %g) for this medium",
                        *scale, wavelength, CPM_D_LINE, low, high);
    return CPM_OK;
}
