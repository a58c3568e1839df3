/* kernels/shade.cl: eye rays and what they see; one item each, so CPM_WIDTH 1 or lanes of equal rays. */
#include "shared/shade.h"

/* Directions (count x 3) of sample `sample` of each pixel; camera: forward, right, up, 3 each. */
__kernel void cpm_shade_eye(__global const double *camera, ulong seed, int width, int height, int sample, int samples,
                            __global double *directions) {
    uint pixel = (uint)get_global_id(0);
    double x, y, out[3][CPM_WIDTH];
    cpm_eye_place(seed, pixel, sample, samples, &x, &y);
    real3 forward = triple(splat(camera[0]), splat(camera[1]), splat(camera[2]));
    real3 right = triple(splat(camera[3]), splat(camera[4]), splat(camera[5]));
    real3 up = triple(splat(camera[6]), splat(camera[7]), splat(camera[8]));
    real3 d = eye_direction(forward, right, up, splat(pixel % width + x), splat(pixel / width + y), width, height);
    store_doubles(d.x, out[0], 0), store_doubles(d.y, out[1], 0), store_doubles(d.z, out[2], 0);
    for (int k = 0; k < 3; k++) directions[3 * pixel + k] = out[k][0];
}

/* Interpolated normals (count x 3). normals: count x 9, three corners. */
__kernel void cpm_shade_normal(__global const float *normals, __global const double *u, __global const double *v,
                               __global const double *geometric, __global double *out) {
    size_t i = get_global_id(0);
    double column[3][CPM_WIDTH];
    real3 corner[3], g = triple(splat(geometric[3 * i]), splat(geometric[3 * i + 1]), splat(geometric[3 * i + 2]));
    for (int c = 0; c < 3; c++)
        corner[c] =
            triple(splat(normals[9 * i + 3 * c]), splat(normals[9 * i + 3 * c + 1]), splat(normals[9 * i + 3 * c + 2]));
    real3 n = shade_normal(corner[0], corner[1], corner[2], splat(u[i]), splat(v[i]), g);
    store_doubles(n.x, column[0], 0), store_doubles(n.y, column[1], 0), store_doubles(n.z, column[2], 0);
    for (int k = 0; k < 3; k++) out[3 * i + k] = column[k][0];
}

/* Radiance from a light and from a diffuse surface, and the weight of a branch, one bin an item. */
__kernel void cpm_shade_bins(__global const float *weight, __global const float *reflectance,
                             __global const double *radiance, __global const double *irradiance,
                             __global const double *squared_index, __global const double *n, __global double *light,
                             __global double *diffuse, __global float *branch) {
    size_t i = get_global_id(0);
    light[i] = cpm_shade_light(weight[i], radiance[i], squared_index[i]);
    diffuse[i] = cpm_shade_diffuse(weight[i], reflectance[i], irradiance[i], squared_index[i], n[i]);
    branch[i] = cpm_shade_branch(weight[i], (float)n[i], reflectance[i]);
}
