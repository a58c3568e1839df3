/* shared/kinks.h: where grad n jumps: faces of the cells of a trilinear grid, layers whose n^2 is linear, the ends of every
 * table (beyond them the edge value is held).
 *
 * A step across such a face has an error that no order helps against. So a step ends a hair before the next face along
 * the parabola of its start, and the next one begins with g from a hair beyond it. What the parabola misses of the true
 * path the drift of |p| shows (step.h). A hair is 1e-9 of a cell, or what rounding leaves of the coordinate. */
#ifndef CPM_SHARED_KINKS_H
#define CPM_SHARED_KINKS_H
#include "step_trial.h"

#define CPM_HAIR 1e-9
#define CPM_NO_KINK (CPM_SINGLE ? 1e37 : 1e299) /* sigma */

typedef struct {
    real sigma;  /* to the next face */
    real3 nudge; /* metres: a few hairs along the ray */
    mask near;   /* a face is within a few hairs */
} cpm_kink;

/* Sigma to reach `d` (> 0, in cells) at a speed and an acceleration towards it; where it turns back before, to the turn. */
CPM_INLINE real cpm_reach(real d, real speed, real pull) {
    real square = speed * speed + R(2.0) * pull * d;
    mask turns = less(square, splat(0.0));
    real divisor = pick(turns, -pull, R(0.5) * (speed + root(larger(square, splat(0.0))))) + R(1e-37);
    return pick(turns, speed, d) / divisor;
}

/* One coordinate u (in cells) of a ray with faces `below` < u + 3 hairs < `above`; CPM_NO_KINK away: none. */
CPM_INLINE real cpm_kink_along(real u, real hair, real forward, real speed, real pull, real below, real above) {
    real face = pick(less(splat(0.0), forward), above, below);
    real d = forward * (face - u) - hair;
    mask there = less(splat(0.0), d) & less(magnitude(face), splat(CPM_NO_KINK));
    return pick(there, cpm_reach(d, speed, forward * pull), splat(CPM_NO_KINK));
}

CPM_INLINE void cpm_kink_of_axis(const cpm_medium_data *m, int axis, real x, real p, real g, cpm_kink *k, real *nudge) {
    const real none = splat(CPM_NO_KINK), zero = splat(0.0), last = splat(m->size[axis] - 1);
    const scalar per = R(m->axis[axis]), origin = R(m->origin[axis]);
    *nudge = zero;
    if (m->size[axis] < 2) return;
    real forward = pick(less(p, zero), splat(-1.0), splat(1.0));
    real hair = R(CPM_HAIR) + R(8.0 * (CPM_SINGLE ? 1.2e-7 : 2.3e-16)) * (magnitude(x) + splat(fabs(m->origin[axis]))) * per;
    real u = (x - origin) * per, ahead = u + R(3.0) * hair * forward, behind = u - R(3.0) * hair * forward;
    real above = pick(less(ahead, zero), zero, last), below = pick(less(last, ahead), last, zero);
    if (m->interpolation == CPM_FIELD_LINEAR) {
        real inside = smaller(larger(ahead, splat(-1.0)), last); /* floor_lanes takes no huge numbers */
        above = larger(floor_lanes(inside) + R(1.0), zero);
        inside = smaller(larger(ahead, zero), last + R(1.0));
        below = smaller(R(-1.0) - floor_lanes(-inside), last);
        k->near |= less(floor_lanes(smaller(larger(larger(u, ahead), behind), last)), floor_lanes(larger(smaller(smaller(u, ahead), behind), splat(-1.0)))) | 
                   ~equal(floor_lanes(smaller(larger(ahead, splat(-1.0)), last)), floor_lanes(smaller(larger(behind, splat(-1.0)), last)));
    }
    above = pick(less(last, ahead), none, above);
    below = pick(less(ahead, zero), -none, below);
    k->near |= less(ahead * behind, zero) | less((ahead - last) * (behind - last), zero);
    k->sigma = smaller(k->sigma, cpm_kink_along(u, hair, forward, magnitude(p) * per, g * per, below, above));
    *nudge = R(4.0) * forward * hair / per;
}

CPM_INLINE void cpm_kink_of_layers(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real3 p, real3 g,
                                   cpm_kink *k) {
    const real none = splat(CPM_NO_KINK), zero = splat(0.0), last = splat(m->size[0]);
    const scalar x = R(m->axis[0]), y = R(m->axis[1]), z = R(m->axis[2]);
    real speed = p.x * x + p.y * y + p.z * z, pull = g.x * x + g.y * y + g.z * z;
    real forward = pick(less(speed, zero), splat(-1.0), splat(1.0)), u = cpm_along_axis(m, r);
    real size = magnitude(r.x) + magnitude(r.y) + magnitude(r.z) +
                splat(fabs(m->origin[0]) + fabs(m->origin[1]) + fabs(m->origin[2]));
    real hair = splat(1e-3 * CPM_HAIR * (m->high - m->low)) + R(8.0 * (CPM_SINGLE ? 1.2e-7 : 2.3e-16)) * size;
    real ahead = u + R(3.0) * hair * forward, behind = u - R(3.0) * hair * forward;
    real low = splat(m->low), high = splat(m->high), above = pick(less(ahead, low), low, high);
    real below = pick(less(high, ahead), high, low);
    k->near |= less((ahead - low) * (behind - low), zero) | less((ahead - high) * (behind - high), zero);
    if (m->interpolation == CPM_FIELD_LINEAR_SQUARED) {
        mask layer = cpm_layer_of(m, table, ahead);
        real number = to_reals(layer);
        cpm_rows rows = rows_at(table, to_integers(smaller(number, last - R(1.0))) + splat_mask(m->heights));
        above = fetch(&rows, 0);
        rows = rows_at(table, to_integers(larger(number - R(1.0), zero)) + splat_mask(m->heights));
        below = fetch(&rows, 0);
        k->near |= ~equal(layer, cpm_layer_of(m, table, behind));
    }
    above = pick(less(high, ahead), none, above);
    below = pick(less(ahead, low), -none, below);
    k->sigma = cpm_kink_along(u, hair, forward, magnitude(speed), pull, below, above);
    k->nudge = cpm_times_axis(m, R(4.0) * forward * hair);
}

CPM_INLINE int cpm_has_kinks(const cpm_medium_data *m) {
    return CPM_IS_KIND(m, CPM_MEDIUM_LAYERED) || CPM_IS_KIND(m, CPM_MEDIUM_GRID);
}
CPM_INLINE cpm_kink cpm_next_kink(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_point *a) {
    cpm_kink k;
    k.sigma = splat(CPM_NO_KINK);
    k.nudge = triple(splat(0.0), splat(0.0), splat(0.0));
    k.near = splat_mask(0);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) cpm_kink_of_layers(m, table, a->r, a->p, a->g, &k);
    if (CPM_IS_KIND(m, CPM_MEDIUM_GRID)) {
        cpm_kink_of_axis(m, 0, a->r.x, a->p.x, a->g.x, &k, &k.nudge.x);
        cpm_kink_of_axis(m, 1, a->r.y, a->p.y, a->g.y, &k, &k.nudge.y);
        cpm_kink_of_axis(m, 2, a->r.z, a->p.z, a->g.z, &k, &k.nudge.z);
    }
    return k;
}
#endif
