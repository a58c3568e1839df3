/* Single rays of cl/shared/scatter.h for test_scatter.py: arrays of them, by the C compiler. */
#include "cl/shared/scatter.h"

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
