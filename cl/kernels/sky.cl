/* kernels/sky.cl: what is seen in a direction beyond a scene's extent. */
#include "shared/sky.h"

/* A sun's disc over its mean in one bin (limb: 6 doubles), or an image's bin (pixels): count directions, x 3. */
__kernel void cpm_sky(__global const cpm_sky_data *sky, __global const double *limb, __global const float *pixels,
                      int bin, __global const double *directions, __global double *radiance) {
    const size_t i = get_global_id(0);
    const cpm_sky_data s = *sky;
    const double x = directions[3 * i], y = directions[3 * i + 1], z = directions[3 * i + 2];
    if (s.kind == CPM_SKY_SUN) {
        const double mu = cpm_sun_mu(&s, x, y, z);
        radiance[i] = mu < 0.0 ? 0.0 : cpm_sun_limb(limb, mu);
    } else {
        cpm_i64 at[4];
        double share[4];
        cpm_sky_place(&s, x, y, z, at, share);
        radiance[i] = cpm_sky_pixel(pixels, at, share, bin);
    }
}
