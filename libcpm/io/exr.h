/* io/exr.h: spectral OpenEXR in the layout of Fichet, Pacanowski and Wilkie, "An OpenEXR layout for spectral images",
 * Journal of Computer Graphics Techniques 10(3), 2021. Internal; the public call is cpm_image_write_exr. */
#ifndef CPM_IO_EXR_H
#define CPM_IO_EXR_H
#include <stddef.h>

/* Channel names of more than 31 bytes need a newer file version; ours never do. */
#define CPM_EXR_NAME_SIZE 32

/* "S0.409,375nm": Stokes component 0 at a wavelength in nm with a decimal comma (a point would open a layer), at least
 * three decimals and as many as it takes to read the same double back; "S0.1,0000000000000001e+09nm" where that would
 * not fit. Does not depend on the locale. */
void cpm_exr_channel_name(double wavelength, char name[CPM_EXR_NAME_SIZE]);
#endif
