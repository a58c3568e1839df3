/* types/term.h: a term of a sum of media, as it lies in the sum's table (CPM_TERM doubles). */
#ifndef CPM_TYPES_TERM_H
#define CPM_TYPES_TERM_H
#include "medium.h"

/* What a ray's `scale` is to a term. */
#define CPM_SCALE_NONE 0       /* nothing: the term does not disperse */
#define CPM_SCALE_GIVEN 1      /* its own */
#define CPM_SCALE_WAVELENGTH 2 /* the wavelength: the term's factor follows from its dispersion */

typedef struct cpm_term {
    cpm_medium_data data;
    cpm_i64 table;        /* where the term's own table begins in the sum's */
    cpm_i64 coefficients; /* of its dispersion, in the sum's table */
    cpm_i64 table_count;  /* doubles of its own table */
    double low, high;     /* nm: where its dispersion is valid; 0, 0: everywhere */
    double reference;     /* what the dispersion gives at the d line: n - 1, or n^2 - 1 */
    cpm_i32 scaling;      /* CPM_SCALE_ */
    cpm_i32 square;       /* 1: n^2 - 1 is scaled */
    cpm_i32 dispersion, count;
} cpm_term;

#define CPM_TERM 28
CPM_STATIC_ASSERT(sizeof(cpm_term) == 8 * CPM_TERM, cpm_term_size);
#endif
