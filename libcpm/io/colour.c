/* io/colour.c: spectrum -> CIE 1931 XYZ -> linear sRGB.
 *
 * The colour matching functions are the multi-lobe fit of Wyman, Sloan and Shirley, "Simple analytic approximations to
 * the CIE XYZ color matching functions", Journal of Computer Graphics Techniques 2(2), 2013: sums of Gaussians with a
 * width on either side of each peak. Largest error against the CIE's table, of each function's peak: x 1.4 %, y 0.8 %,
 * z 1.3 %. The matrix is that of IEC 61966-2-1. */
#include "io/colour.h"

#include <math.h>

#define SQRT_HALF_PI 1.2533141373155003 /* the integral of exp(-t^2/2) over t > 0 */
#define SAMPLES 16                      /* midpoints a bin: bins may be wide beside the lobes */

typedef struct lobe {
    double height, peak; /* 1, nm */
    double below, above; /* inverse widths on either side of the peak, 1/nm */
} lobe;

static const lobe X_LOBES[] = {{0.362, 442.0, 0.0624, 0.0374},
                               {1.056, 599.8, 0.0264, 0.0323},
                               {-0.065, 501.1, 0.0490, 0.0382}};
static const lobe Y_LOBES[] = {{0.821, 568.8, 0.0213, 0.0247}, {0.286, 530.9, 0.0613, 0.0322}};
static const lobe Z_LOBES[] = {{1.217, 437.0, 0.0845, 0.0278}, {0.681, 459.0, 0.0385, 0.0725}};

static const double RGB_OF_XYZ[3][3] = {{3.2406, -1.5372, -0.4986},
                                        {-0.9689, 1.8758, 0.0415},
                                        {0.0557, -0.2040, 1.0570}};

static double sum_of_lobes(const lobe *lobes, int count, double wavelength) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        const double t = (wavelength - lobes[i].peak) * (wavelength < lobes[i].peak ? lobes[i].below : lobes[i].above);
        sum += lobes[i].height * exp(-0.5 * t * t);
    }
    return sum;
}

/* The integral of the fit's own y over all wavelengths, nm: 106.95 (the CIE's table: 106.86). */
static double luminance_of_flat(void) {
    double sum = 0.0;
    for (int i = 0; i < 2; i++)
        sum += Y_LOBES[i].height * SQRT_HALF_PI * (1.0 / Y_LOBES[i].below + 1.0 / Y_LOBES[i].above);
    return sum;
}

void cpm_colour_weights(const double *wavelengths, size_t bins, double (*weights)[3]) {
    if (bins == 1) {
        for (int c = 0; c < 3; c++) weights[0][c] = 1.0;
        return;
    }
    const double scale = 1.0 / luminance_of_flat();
    for (size_t i = 0; i < bins; i++) {
        const double below = 0.5 * (i > 0 ? wavelengths[i] - wavelengths[i - 1] : wavelengths[1] - wavelengths[0]);
        const double above =
            0.5 * (i + 1 < bins ? wavelengths[i + 1] - wavelengths[i] : wavelengths[bins - 1] - wavelengths[bins - 2]);
        const double step = (below + above) / SAMPLES;
        double xyz[3] = {0.0, 0.0, 0.0};
        for (int s = 0; s < SAMPLES; s++) {
            const double w = wavelengths[i] - below + (s + 0.5) * step;
            xyz[0] += step * scale * sum_of_lobes(X_LOBES, 3, w);
            xyz[1] += step * scale * sum_of_lobes(Y_LOBES, 2, w);
            xyz[2] += step * scale * sum_of_lobes(Z_LOBES, 2, w);
        }
        for (int c = 0; c < 3; c++)
            weights[i][c] = RGB_OF_XYZ[c][0] * xyz[0] + RGB_OF_XYZ[c][1] * xyz[1] + RGB_OF_XYZ[c][2] * xyz[2];
    }
}

void cpm_colour_rgb(const float *spectra, size_t pixels, size_t bins, const double (*weights)[3], float *rgb) {
    for (size_t p = 0; p < pixels; p++) {
        double sum[3] = {0.0, 0.0, 0.0};
        for (size_t i = 0; i < bins; i++)
            for (int c = 0; c < 3; c++) sum[c] += weights[i][c] * (double)spectra[p * bins + i];
        for (int c = 0; c < 3; c++) rgb[3 * p + (size_t)c] = (float)sum[c];
    }
}
