/* shared/gather.h: the arithmetic of one photon in a density estimate, the same on both sides.
 *
 * Positions here are scaled by a power of two (the map's), so that squares neither overflow nor vanish. Every operation
 * is rounded once, in the order written: the k nearest photons are then the same on every machine. */
#ifndef CPM_SHARED_GATHER_H
#define CPM_SHARED_GATHER_H
#include "octahedral.h"

/* Squared distance. This value, not the real number behind it, is what "nearer" means; equal values are ties. */
CPM_INLINE float cpm_distance2(float dx, float dy, float dz) { return (dx * dx + dy * dy) + dz * dz; }

/* How far q is outside [low, high]. Rounding is monotonic: for x in the interval this is at most |x - q| as rounded, so
 * cpm_distance2 of three of them is a lower bound for every photon of a box, without any slack. */
CPM_INLINE float cpm_outside(float q, float low, float high) {
    float below = low - q, above = q - high, outside = below > above ? below : above;
    return outside > 0.0f ? outside : 0.0f;
}

/* Nonzero: the stored normal is within 60 degrees of the unit normal (x, y, z): n . m >= |m|/2, without a root. */
CPM_INLINE int cpm_same_side(unsigned int code, float x, float y, float z) {
    cpm_octahedral p = cpm_octahedral_point(code);
    float mx = (float)p.x, my = (float)p.y, mz = (float)p.z;
    float along = (mx * x + my * y) + mz * z;
    return along > 0.0f && 4.0f * (along * along) >= (mx * mx + my * my) + mz * mz;
}

/* Irradiance of a half-float 1 within the squared radius radius2 (m^2): scale / (pi r^2), `scale` in W/nm. */
CPM_INLINE double cpm_gather_factor(double scale, double radius2) { return scale / (3.14159265358979323846 * radius2); }

/* Ties of distance fall to the smaller of these: (path, bounce, bin). */
CPM_INLINE cpm_u64 cpm_photon_order(unsigned int path, unsigned short bounce, unsigned short bin) {
    return (cpm_u64)path << 32 | (cpm_u64)bounce << 16 | bin;
}
#endif
