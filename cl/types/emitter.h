/* types/emitter.h: how the paths of one light start, the same memory on both sides.
 *
 * Beside it, for point and spot lights with a projection map, three tables of its cells (row by row): `cumulative`
 * (cells + 1 doubles: the probability that a cell's photons start below it), `guide` (cells ints: the cell that holds
 * the lower end of each of as many equal parts of probability) and `weight` (cells floats: what keeps the estimate
 * unbiased). A sun or an environment sends its paths into a box: along directions about `axis`, or, of an environment,
 * through cells of directions, rows from `axis` downward, whose cosines' `rows` + 1 edges stand behind `cumulative`; `weight`
 * as above. For an area light of triangles `area` (triangles + 1 doubles, cumulative) and the triangles themselves. */
#ifndef CPM_TYPES_EMITTER_H
#define CPM_TYPES_EMITTER_H
#include "../dialect.h"

typedef struct cpm_emitter_data {
    double position[3]; /*  0  of a point or spot light; centre of a spherical area light; environment: its north, unit */
    double axis[3];     /* 24  of a point or spot light; towards the sun; environment: up */
    double cutoff;      /* 48  1 - cos of its half-angle; up to 2 */
    double radius;      /* 56  of a spherical area light; 0: triangles */
    double count;       /* 64  paths of this light */
    cpm_u32 shift[4];   /* 72  scrambles of the low-discrepancy sequence */
    cpm_i32 rows;       /* 88  of the projection map; 0: none, all directions alike */
    cpm_i32 columns;    /* 92 */
    cpm_i32 primitive;  /* 96  first primitive of an area light */
    cpm_i32 triangles;  /* 100 how many it has */
    double low[3];      /* 104 of the box that a sun or an environment shines into */
    double high[3];     /* 128 */
} cpm_emitter_data;
CPM_ASSERT_OFFSET(cpm_emitter_data, rows, 88);
CPM_ASSERT_OFFSET(cpm_emitter_data, low, 104);
CPM_STATIC_ASSERT(sizeof(cpm_emitter_data) == 152, cpm_emitter_data_size);
#endif
