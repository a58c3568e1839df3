/* types/ray.h: method and status numbers, the same on both sides as in cpm/ray.h and cpm/status.h. */
#ifndef CPM_TYPES_RAY_H
#define CPM_TYPES_RAY_H

/* A piece of a curved ray between two accepted points, sigma in [0, h]: position, momentum p = dr/dsigma and
 * acceleration g = (1/2) grad n^2 at both ends. r(theta), theta = sigma/h, is the quintic that takes all six (Hermite):
 * exact for a parabola, error O(h^6) for anything smooth, the same for every method. */
typedef struct cpm_piece {
    double r0[3], p0[3], g0[3];
    double r1[3], p1[3], g1[3];
    double h;                /* in sigma: metres/n */
    double length0, length1; /* arc length at the ends, metres, from the ray's start */
    double n0, n1;
} cpm_piece;
#endif
