/* io/colour.h: a plain RGB of a spectrum, for viewers that know no better. Internal.
 *
 * Python's colour-science does the colorimetry that is to be trusted; this is the fallback of the C core. */
#ifndef CPM_IO_COLOUR_H
#define CPM_IO_COLOUR_H
#include <stddef.h>

/* Weights of the bins in linear sRGB, so that RGB = sum over bins of weights[bin] x value. Bins reach half-way to their
 * neighbours. A flat spectrum of 1 W/m2/sr/nm over the visible has luminance Y = 1 (and is the equal-energy white, a
 * little pink under sRGB's D65). One bin alone says nothing about colour: it is shown grey. */
void cpm_colour_weights(const double *wavelengths, size_t bins, double (*weights)[3]);

/* `spectra` is pixels x bins, `rgb` pixels x 3; values outside the gamut are negative, none are clipped. */
void cpm_colour_rgb(const float *spectra, size_t pixels, size_t bins, const double (*weights)[3], float *rgb);
#endif
