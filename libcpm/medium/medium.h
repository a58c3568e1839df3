/* medium/medium.h: a medium's inside, and what the rest of the library asks of it. */
#ifndef CPM_MEDIUM_MEDIUM_H
#define CPM_MEDIUM_MEDIUM_H
#include <stdatomic.h>

#include "api/context.h"
#include "cl/types/medium.h"

#define CPM_D_LINE 587.5618 /* nm: where a medium's own numbers hold */

struct cpm_medium {
    atomic_int references;
    int32_t dispersive; /* 1: n depends on wavelength */
    cpm_medium_data data;
    double *table; /* aligned to 64 bytes; NULL: none */
    size_t table_count;
    cpm_dispersion dispersion;
    int32_t by_wavelength; /* 1: the field takes the wavelength itself (nm) for its scale: formulas and sums */
    double *extinction; /* extinction_count wavelengths, then as many values; NULL: none */
    size_t extinction_count;
    double reference;      /* what the dispersion gives at the d line: n - 1, or n^2 - 1 for a medium defined by n^2 */
};

/* The factor s of a wavelength (nm). Out of the dispersion's range: CPM_ERROR_INVALID_ARGUMENT. 1 where nothing
 * disperses. */
cpm_status cpm_medium_scale(cpm_context *context, const cpm_medium *medium, double wavelength, double *scale);

/* Extinction over n - 1 at a wavelength (nm), 1/m; 0 without any. */
double cpm_medium_extinction(const cpm_medium *medium, double wavelength);

/* n the same everywhere (at one wavelength): paths are straight, no integrator runs. */
int cpm_medium_is_uniform(const cpm_medium *medium);
/* A closed form of the path exists. Uniform media count. */
int cpm_medium_has_exact(const cpm_medium *medium);
/* Only the closed form exists: discrete layers have no gradient to integrate. */
int cpm_medium_needs_exact(const cpm_medium *medium);

/* Bits 1 << CPM_MEDIUM_ of what code needs for it (CPM_MEDIA): its kind, and a sum's terms'. */
uint32_t cpm_medium_kinds(const cpm_medium *medium);

/* At one point r (metres) and scale s. NaN where n^2 <= 0. g = (1/2) grad n^2 = n grad n. */
double cpm_medium_n(const cpm_medium *medium, double scale, const double r[3]);
void cpm_medium_field(const cpm_medium *medium, double scale, const double r[3], double *n, double g[3]);
/* n on the side that `direction` enters, where r lies on an interface of discrete layers; else cpm_medium_n. Use it
 * where a ray starts. */
double cpm_medium_n_toward(const cpm_medium *medium, double scale, const double r[3], const double direction[3]);
#endif
