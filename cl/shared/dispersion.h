/* shared/dispersion.h: n of a wavelength. The formulas take w in micrometres, the interface nanometres.
 *
 *   constant   n = c0                                            tabulated   linear between (c[2i] nm, c[2i + 1]),
 *   Cauchy     n = c0 + c1/w^2 + c2/w^4 + ...                                held beyond its ends
 *   Sellmeier  n^2 = 1 + sum c[2i] w^2/(w^2 - c[2i + 1]), c[2i + 1] in um^2                                        (1)
 *   gas        n - 1 = c0 + c1 k + c2 k^2 + c3 k^3 + sum c[4 + 2i]/(c[5 + 2i] - k), k = w^-2 in um^-2              (2)
 *              (Edlen, Ciddor: the sum is dry air's, the polynomial water vapour's)
 *
 * NaN where n^2 <= 0 (a resonance of Sellmeier's terms). */
#ifndef CPM_SHARED_DISPERSION_H
#define CPM_SHARED_DISPERSION_H
#include "../dialect.h"

/* cpm_dispersion_kind of cpm/medium.h. */
#define CPM_NO_DISPERSION 0
#define CPM_CONSTANT 1
#define CPM_CAUCHY 2
#define CPM_SELLMEIER 3
#define CPM_TABULATED 4
#define CPM_GAS 5

CPM_INLINE double cpm_dispersion_n(int kind, int count, CPM_GLOBAL const double *c, double wavelength) {
    double w = 1e-3 * wavelength, w2 = w * w;
    if (kind == CPM_CAUCHY) {
        double n = 0.0;
        for (int i = count - 1; i >= 0; i--) n = n / w2 + c[i];
        return n;
    }
    if (kind == CPM_SELLMEIER) {
        double squared = 1.0;
        for (int i = 0; i + 1 < count; i += 2) squared += c[i] * w2 / (w2 - c[i + 1]);
        return cpm_sqrt(squared);
    }
    if (kind == CPM_GAS) {
        double k = 1.0 / w2, refractivity = c[0] + k * (c[1] + k * (c[2] + k * c[3]));
        for (int i = 4; i + 1 < count; i += 2) refractivity += c[i] / (c[i + 1] - k);
        return 1.0 + refractivity;
    }
    if (kind == CPM_TABULATED) {
        int i = 0;
        while (i + 4 < count && c[i + 2] <= wavelength) i += 2;
        if (count < 4) return c[1];
        double t = (wavelength - c[i]) / (c[i + 2] - c[i]);
        t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
        return c[i + 1] + t * (c[i + 3] - c[i + 1]);
    }
    return kind == CPM_CONSTANT ? c[0] : 1.0;
}
#endif
