/* types/photon.h: a stored photon, 32 bytes, the same on both sides.
 *
 *   0  position   3 x float, metres from the map's origin
 *  12  direction  of travel, octahedral, 2 x 16 bits
 *  16  normal     of the side that was hit, octahedral, 2 x 16 bits
 *  20  spectrum   index of its first half-float power in the map's spectra
 *  24  path       number of the emitted path: ties of distance are broken by (path, bounce, bin)
 *  28  bin        the run of bins that a split photon carries (shared/bins.h); CPM_ALL_BINS: all of them
 *  30  bounce     surfaces hit before this one, held at 65535
 *
 * The spectrum beside it: one 16-bit float a bin carried, relative to the map's power scale: all bins on an unsplit
 * path, those of its run after a split. */
#ifndef CPM_TYPES_PHOTON_H
#define CPM_TYPES_PHOTON_H
#define CPM_ALL_BINS 65535u
typedef struct cpm_photon {
    float position[3];
    unsigned int direction, normal, spectrum, path;
    unsigned short bin, bounce;
} cpm_photon;
#endif
