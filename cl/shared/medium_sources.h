/* shared/medium_sources.h: gravity centres and gravity lines: n = 1 + s sum m/d^k, d the distance from a point or from
 * an infinite line (Groeller, Nonlinear ray tracing: visualizing strange worlds. The Visual Computer 11, 1995).
 *
 * With y from the source's nearest point to r, g = n grad n = -n s sum k m y/d^(k+2). d^2 is kept above CPM_LEAST_D2
 * and n below CPM_LARGEST_N, so that a centre itself has a number. */
#ifndef CPM_SHARED_MEDIUM_SOURCES_H
#define CPM_SHARED_MEDIUM_SOURCES_H
#include "elementary.h"
#include "medium_linear.h"

#define CPM_LEAST_D2 (CPM_SINGLE ? 1e-24 : 1e-60) /* metres^2 */
#define CPM_LARGEST_N (CPM_SINGLE ? 1e15 : 1e60)

/* From the source in `record` to r, and the square of the distance. */
CPM_INLINE real3 cpm_from_source(CPM_GLOBAL const double *record, real3 r, real *square) {
    real3 y = triple(r.x - R(record[0]), r.y - R(record[1]), r.z - R(record[2]));
    if (record[4] != 0.0 || record[5] != 0.0 || record[6] != 0.0) {
        real along = y.x * R(record[4]) + y.y * R(record[5]) + y.z * R(record[6]);
        y = triple(y.x - along * R(record[4]), y.y - along * R(record[5]), y.z - along * R(record[6]));
    }
    *square = larger(dot3(y, y), splat(CPM_LEAST_D2));
    return y;
}

/* 1/d^k of d^2: products for whole k up to 8. */
CPM_INLINE real cpm_inverse_power(real square, double k) {
    if (k <= 8.0 && k == (double)(int)k) {
        real per = R(1.0) / square, power = ((int)k & 1) ? root(per) : splat(1.0);
        for (int i = (int)k / 2; i > 0; i--) power *= per;
        return power;
    }
    return exp_lanes(R(-0.5 * k) * log_lanes(square));
}

CPM_INLINE real3 cpm_field_sources(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                   real *n) {
    real sum = splat(0.0), square;
    real3 slope = triple(sum, sum, sum);
    for (int i = 0; i < m->size[0]; i++) {
        CPM_GLOBAL const double *record = table + m->records + CPM_RECORD * i;
        real3 y = cpm_from_source(record, r, &square);
        real part = R(record[3]) * cpm_inverse_power(square, record[7]);
        sum += part;
        slope = add3(slope, R(record[7]) * part / square, y);
    }
    *n = smaller(R(1.0) + scale * sum, splat(CPM_LARGEST_N));
    return scale3(-(scale * *n), slope);
}

/* The distance to the nearest source, metres. */
CPM_INLINE real cpm_nearest_source(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r) {
    real nearest = splat(CPM_SINGLE ? 1e37 : 1e299), square;
    for (int i = 0; i < m->size[0]; i++) {
        (void)cpm_from_source(table + m->records + CPM_RECORD * i, r, &square);
        nearest = smaller(square, nearest);
    }
    return root(nearest);
}
#endif
