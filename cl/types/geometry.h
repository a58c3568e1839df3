/* types/geometry.h: primitives in double, the same on both sides; offsets in the comments are bytes. */
#ifndef CPM_TYPES_GEOMETRY_H
#define CPM_TYPES_GEOMETRY_H

typedef struct cpm_triangle {
    double corner[3];     /*   0 */
    double edge1[3];      /*  24  corner 1 - corner 0 */
    double edge2[3];      /*  48  corner 2 - corner 0 */
    double normal[3];     /*  72  edge1 x edge2, not unit */
    double inverse_area2; /*  96  1/|normal|^2 */
    double tolerance;     /* 104  rounding of a barycentric coordinate */
    double near_edge;     /* 112  barycentric distance within which float arithmetic is not trusted */
    double normal_length; /* 120  |normal| */
} cpm_triangle;           /* 128 */

typedef struct cpm_sphere {
    double center[3];
    double radius;
} cpm_sphere;
#endif
