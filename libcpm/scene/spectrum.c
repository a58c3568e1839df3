/* scene/spectrum.c: spectra as given by the user: linear between samples, held beyond. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

cpm_status cpm_spectrum_copy(cpm_context *context, const cpm_spectrum *from, const char *what, double low, double high,
                             spectrum *to) {
    memset(to, 0, sizeof *to);
    size_t count = from->values ? from->count : 0;
    if (from->values && !count)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s has values but count 0; at least 1 is needed", what);
    if (count > 1 && !from->wavelengths)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s has %zu values but no wavelengths", what, count);
    for (size_t i = 0; i < count; i++) {
        if (!(from->values[i] >= low && from->values[i] <= high) || !isfinite(from->values[i]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s, value %zu, is %g; allowed: %g to %g", what, i,
                            from->values[i], low, high);
        if (from->wavelengths && (!isfinite(from->wavelengths[i]) || !(from->wavelengths[i] > 0.0) ||
                                  (i && !(from->wavelengths[i] > from->wavelengths[i - 1]))))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "%s, wavelength %zu, is %g nm; allowed: positive and increasing", what, i,
                            from->wavelengths[i]);
    }
    to->values = calloc(2 * (count ? count : 1), sizeof(double));
    if (!to->values) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for %s", what);
    to->count = count ? count : 1;
    if (count) memcpy(to->values, from->values, count * sizeof(double));
    if (count && from->wavelengths) {
        to->wavelengths = to->values + count;
        memcpy(to->wavelengths, from->wavelengths, count * sizeof(double));
    }
    return CPM_OK;
}

double cpm_spectrum_at(const spectrum *s, double wavelength) {
    if (!s->values) return 0.0;
    if (!s->wavelengths || wavelength <= s->wavelengths[0]) return s->values[0];
    size_t i = 1;
    while (i < s->count && s->wavelengths[i] < wavelength) i++;
    if (i == s->count) return s->values[s->count - 1];
    double t = (wavelength - s->wavelengths[i - 1]) / (s->wavelengths[i] - s->wavelengths[i - 1]);
    return s->values[i - 1] + t * (s->values[i] - s->values[i - 1]);
}

void cpm_spectrum_free(spectrum *s) {
    free(s->values);
    memset(s, 0, sizeof *s);
}
