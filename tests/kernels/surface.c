/* Single rays of cl/shared/scatter.h and shade.h, as the eye pass and mirrors have them: arrays, by the C compiler. */
#include "cl/shared/scatter.h"
#include "cl/shared/shade.h"

static cpm_vec at(const double *v, size_t i) { return cpm_v(v[3 * i], v[3 * i + 1], v[3 * i + 2]); }

static void put(double *to, size_t i, cpm_vec v) { to[3 * i] = v.x, to[3 * i + 1] = v.y, to[3 * i + 2] = v.z; }

void mirror(size_t count, const double *came, const double *shading, const double *geometric, double *toward) {
    for (size_t i = 0; i < count; i++)
        put(toward, i, scatter_mirror(at(came, i), at(shading, i), scatter_facing(at(geometric, i), at(came, i))));
}

void boundary(size_t count, const double *came, const double *shading, const double *geometric, const double *n1,
              const double *n2, double *reflectance, double *reflected, double *refracted) {
    for (size_t i = 0; i < count; i++) {
        cpm_vec back, on;
        reflectance[i] = scatter_boundary(at(came, i), at(shading, i), at(geometric, i), n1[i], n2[i], &back, &on);
        put(reflected, i, back), put(refracted, i, on);
    }
}

void eye(const double *camera, uint64_t seed, int32_t width, int32_t height, int32_t sample, int32_t samples,
         double *directions) {
    for (int32_t i = 0; i < width * height; i++) {
        double x, y;
        cpm_eye_place(seed, (uint32_t)i, sample, samples, &x, &y);
        put(directions, (size_t)i,
            eye_direction(at(camera, 0), at(camera, 1), at(camera, 2), i % width + x, i / width + y, width, height));
    }
}

void normal(size_t count, const float *normals, const double *u, const double *v, const double *geometric,
            double *out) {
    for (size_t i = 0; i < count; i++) {
        cpm_vec corner[3];
        for (size_t k = 0; k < 3; k++) {
            const float *n = &normals[9 * i + 3 * k];
            corner[k] = cpm_v((double)n[0], (double)n[1], (double)n[2]);
        }
        put(out, i, shade_normal(corner[0], corner[1], corner[2], u[i], v[i], at(geometric, i)));
    }
}

void bins(size_t count, const float *weight, const float *reflectance, const double *radiance, const double *irradiance,
          const double *squared_index, const double *n, double *light, double *diffuse, float *branch) {
    for (size_t i = 0; i < count; i++) {
        light[i] = cpm_shade_light(weight[i], radiance[i], squared_index[i]);
        diffuse[i] = cpm_shade_diffuse(weight[i], reflectance[i], irradiance[i], squared_index[i], n[i]);
        branch[i] = cpm_shade_branch(weight[i], (float)n[i], reflectance[i]);
    }
}
