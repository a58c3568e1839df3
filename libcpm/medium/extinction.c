/* medium/extinction.c: what dims light on its way, in proportion to n - 1. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "medium.h"

cpm_status cpm_medium_set_extinction(cpm_context *context, cpm_medium *medium, const double *wavelengths,
                                     const double *values, size_t count) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!medium || !wavelengths || !values)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium, wavelengths and values must not be NULL");
    if (medium->extinction)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "the medium has an extinction already");
    if (!count || count > 1000000)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "extinction: count is %zu; allowed: 1 to 1000000", count);
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(wavelengths[i]) || !(wavelengths[i] > 0.0) || (i && !(wavelengths[i] > wavelengths[i - 1])))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "extinction: wavelength %zu is %g nm; allowed: positive, increasing", i, wavelengths[i]);
        if (!isfinite(values[i]) || !(values[i] >= 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "extinction: value %zu is %g; allowed: finite, not negative", i, values[i]);
    }
    double *own = malloc(2 * count * sizeof *own);
    if (!own) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an extinction");
    memcpy(own, wavelengths, count * sizeof *own);
    memcpy(own + count, values, count * sizeof *own);
    medium->extinction = own;
    medium->extinction_count = count;
    return CPM_OK;
}

double cpm_medium_extinction(const cpm_medium *medium, double wavelength) {
    const size_t count = medium->extinction_count;
    const double *w = medium->extinction, *v = w + count;
    if (!count) return 0.0;
    if (wavelength <= w[0]) return v[0];
    size_t low = 0, high = count - 1;
    if (wavelength >= w[high]) return v[high];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (w[middle] <= wavelength)
            low = middle;
        else
            high = middle;
    }
    return v[low] + (v[high] - v[low]) * (wavelength - w[low]) / (w[high] - w[low]);
}
