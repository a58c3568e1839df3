/* shared/straight.h: a straight ray's hit on a primitive that is known, in double. */
#ifndef CPM_SHARED_STRAIGHT_H
#define CPM_SHARED_STRAIGHT_H
#include "../types/tree.h"
#include "curve.h"

CPM_INLINE cpm_curve cpm_line(cpm_vec origin, cpm_vec way) {
    cpm_curve line;
    line.degree = 1, line.padding = 0;
    line.c[0] = origin, line.c[1] = way;
    return line;
}

/* A hit on a triangle's plane, polished; 0: so near an edge, or so odd, that it does not stand. */
CPM_INLINE int cpm_polish_triangle(CPM_GLOBAL const cpm_triangle *t, cpm_vec origin, cpm_vec direction, cpm_hit *hit) {
    const cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
    const cpm_vec corner = cpm_v(t->corner[0], t->corner[1], t->corner[2]);
    hit->t = cpm_vdot(cpm_sub(corner, origin), n) / cpm_vdot(direction, n);
    hit->position = cpm_along(origin, hit->t, direction);
    if (!(hit->t > 0.0) || !(hit->t < INFINITY)) return 0;
    cpm_triangle_contains(t, hit->position, &hit->u, &hit->v);
    return cpm_min(hit->u, cpm_min(hit->v, 1.0 - hit->u - hit->v)) > -t->near_edge;
}

CPM_INLINE int cpm_polish_sphere(CPM_GLOBAL const cpm_sphere *sphere, cpm_vec origin, cpm_vec direction, int leaving,
                                 double far, cpm_hit *hit) {
    const cpm_curve line = cpm_line(origin, direction);
    hit->t = cpm_curve_sphere(&line, sphere, leaving, 0.0, far * 1.001);
    hit->u = hit->v = 0.0;
    hit->position = cpm_along(origin, hit->t, direction);
    return hit->t > 0.0;
}
#endif
