/* types/medium.h: a refractive index field as both sides see it: one tagged struct and one flat table of doubles.
 *
 * What is stored is refractivity N = n - 1 (linear, grid, layered cubic and step) or susceptibility S = n^2 - 1
 * (linear-squared, layered linear-squared), never n: in air N is 2.8e-4 and 1 + N would lose 4 of its 16 digits.
 * A ray's `scale` s (dispersion at its wavelength over that at the d line) multiplies N or S.
 *
 * Tables, offsets in doubles from the start of the table:
 *   layered  heights   size[0] ascending
 *            guide     size[1]: for each bucket of equal height the last layer that starts at or below its bottom
 *            records   CPM_RECORD a layer, size[0] + 1 layers; layer 0 is below heights[0], layer i starts at
 *                      heights[i - 1]; c0 c1 c2 c3 start: N (or S) = c0 + t (c1 + t (c2 + t c3)), t = height - start
 *   grid     records   linear: N at the samples, z fastest; cubic: B-spline coefficients, (nx + 2)(ny + 2)(nz + 2),
 *                      one more on either side of each axis that has more than one sample (see shared/medium_grid.h)
 *   sources  records   CPM_RECORD a source, size[0] of them: centre, strength, unit direction of a line (0: a point),
 *                      exponent */
#ifndef CPM_TYPES_MEDIUM_H
#define CPM_TYPES_MEDIUM_H
#include "../dialect.h"

#define CPM_MEDIUM_HOMOGENEOUS 0
#define CPM_MEDIUM_LINEAR_SQUARED 1
#define CPM_MEDIUM_LINEAR 2
#define CPM_MEDIUM_LAYERED 3
#define CPM_MEDIUM_GRID 4
#define CPM_MEDIUM_PARABOLIC 5
#define CPM_MEDIUM_LUNEBURG 6
#define CPM_MEDIUM_FISHEYE 7
#define CPM_MEDIUM_EATON 8
#define CPM_MEDIUM_SOURCES 9
#define CPM_MEDIUM_EXPRESSION 10
#define CPM_MEDIUM_SUM 11
#define CPM_MEDIUM_SHELLS 12 /* layered, spherical */

/* CPM_MEDIA says which kinds are compiled in: bit 1 << CPM_MEDIUM_... (all by default). A sum needs its terms' too. */
#ifndef CPM_MEDIA
#define CPM_MEDIA 0x1fff
#endif
#define CPM_IS_KIND(m, k) (((CPM_MEDIA >> (k)) & 1) && (m)->kind == (k))

#define CPM_RECORD 8 /* doubles a layer: a cache line */

/* As in cpm/medium.h. */
#define CPM_FIELD_LINEAR 0
#define CPM_FIELD_CUBIC 1
#define CPM_FIELD_LINEAR_SQUARED 2
#define CPM_FIELD_STEP 3

typedef struct cpm_medium_data {
    cpm_i32 kind;          /* CPM_MEDIUM_ */
    cpm_i32 interpolation; /* CPM_FIELD_, layered and grid */
    cpm_i32 size[3];       /* grid: samples; layered: heights, buckets, halvings that a look-up may need in a bucket;
                              sources: how many; sum: terms, 1: one is singular, 1: one is a table */
    cpm_i32 uniform;       /* 1: n is the same everywhere */
    double origin[3];      /* metres; luneburg, fisheye, eaton: the centre */
    double axis[3];        /* linear: grad n; linear-squared: grad n^2; layered: unit up; grid: 1/spacing; parabolic:
                              unit axis */
    double value;          /* N or S at the origin, or everywhere; parabolic: S on the axis; fisheye: N at the centre */
    double feature;        /* metres over which the field may change its shape; infinite: one polynomial */
    double kink;           /* largest jump of grad n over a cell, relative to n: a looser rtol steps over such kinks */
    double jump;           /* the largest jump of grad n itself, relative to n, 1/m */
    double low, high;      /* layered: first and last height; luneburg, fisheye, eaton: high is the radius;
                              parabolic: high is (n alpha)^2 on the axis */
    double bucket;         /* layered: buckets a metre */
    cpm_i64 heights, guide, records; /* offsets of the tables */
    double radius;                   /* shells: of the sphere where height is 0, metres */
} cpm_medium_data;

CPM_STATIC_ASSERT(sizeof(cpm_medium_data) == 160, cpm_medium_data_size);
CPM_ASSERT_OFFSET(cpm_medium_data, origin, 24);
CPM_ASSERT_OFFSET(cpm_medium_data, value, 72);
CPM_ASSERT_OFFSET(cpm_medium_data, heights, 128);
#endif
