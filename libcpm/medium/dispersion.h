/* medium/dispersion.h: dispersions as media use them. */
#ifndef CPM_MEDIUM_DISPERSION_H
#define CPM_MEDIUM_DISPERSION_H
#include "medium.h"

/* Copies and checks what the caller gave; NULL: none. */
cpm_status cpm_dispersion_take(cpm_context *context, const cpm_dispersion *given, cpm_dispersion *ours);
double cpm_dispersion_at(const cpm_dispersion *dispersion, double wavelength);
int cpm_dispersion_varies(const cpm_dispersion *dispersion);
/* n at a wavelength (nm) in range, finite and > 0; else a message. */
cpm_status cpm_dispersion_check(cpm_context *context, const cpm_dispersion *dispersion, double wavelength, double *n);

/* Does every term of a sum have a dispersion that is valid at this wavelength? Of other media: nothing to say. */
cpm_status cpm_sum_check(cpm_context *context, const cpm_medium *medium, double wavelength);

/* Defined by n^2: the dispersion scales n^2 - 1. */
static inline int cpm_medium_by_square(const cpm_medium_data *data) {
    return data->kind == CPM_MEDIUM_LINEAR_SQUARED ||
           ((data->kind == CPM_MEDIUM_LAYERED || data->kind == CPM_MEDIUM_SHELLS) &&
            data->interpolation == CPM_FIELD_LINEAR_SQUARED);
}

/* create.c. A medium of one reference with this dispersion and a zeroed table of table_count doubles (64-byte aligned).
 * `data` decides whether n or n^2 is scaled. */
cpm_status cpm_medium_make(cpm_context *context, const cpm_medium_data *data, size_t table_count,
                           const cpm_dispersion *dispersion, cpm_medium **medium);
/* Refuses vectors with a component that is not finite. */
cpm_status cpm_check_vector(cpm_context *context, const char *name, const double *vector);
#endif
