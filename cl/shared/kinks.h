/* shared/kinks.h: where grad n jumps: faces of the cells of a trilinear grid, layers whose n^2 is linear, the ends of
 * every table (beyond them the edge value is held), the spheres of Luneburg's and Eaton's lenses.
 *
 * A step across such a face has an error that no order helps against. So a step ends a hair before the next face along
 * the parabola of its start, and the next one begins with g from a hair beyond it. What the parabola misses of the true
 * path the drift of |p| shows (step.h). Within a hair the wrong g is used: it is as short as makes n wrong by 0.001
 * rtol at the most, but not below what rounding leaves of the coordinate. */
#ifndef CPM_SHARED_KINKS_H
#define CPM_SHARED_KINKS_H
#include "step_trial.h"

#define CPM_ROUNDING (CPM_SINGLE ? 1.2e-7 : 2.3e-16)
#define CPM_NO_KINK (CPM_SINGLE ? 1e37 : 1e299) /* sigma */

/* One coordinate u (in cells) with faces `below` and `above`, as seen a few hairs ahead: sigma to the one in front, or,
 * where the ray turns back before, to the one behind: the root of speed x + pull x^2/2 = distance. */
CPM_INLINE real cpm_kink_along(real u, real hair, real forward, real speed, real pull, real below, real above) {
    const real zero = splat(0.0), none = splat(CPM_NO_KINK);
    mask up = less(zero, forward);
    real front = pick(up, above, below), behind = pick(up, below, above), square = speed * speed;
    pull = forward * pull;
    real d = larger(forward * (front - u) - hair, zero), e = larger(forward * (u - behind) - hair, zero);
    real reach = square + R(2.0) * pull * d;
    mask turns = less(reach, zero); /* then pull < 0 */
    real root_of = root(pick(turns, square - R(2.0) * pull * e, reach));
    real sigma = pick(turns, (speed + root_of) / -pull, R(2.0) * d / (speed + root_of + R(1e-37)));
    mask there = less(magnitude(pick(turns, behind, front)), none);
    return pick(there, smaller(sigma, none), none);
}

CPM_INLINE scalar cpm_hair(const cpm_medium_data *m, double rtol) {
    return R(fmin(1e-3 * rtol / m->jump, 1e-3 * m->feature));
}
CPM_INLINE real cpm_hair_of_axis(const cpm_medium_data *m, scalar hair, int axis, real x) { /* metres, as all hairs */
    return hair + R(8.0 * CPM_ROUNDING) * (magnitude(x) + splat(fabs(m->origin[axis])));
}
CPM_INLINE real cpm_hair_of_layers(const cpm_medium_data *m, scalar hair, real3 r) {
    return hair + R(8.0 * CPM_ROUNDING) * (magnitude(r.x) + magnitude(r.y) + magnitude(r.z) +
                                           splat(fabs(m->origin[0]) + fabs(m->origin[1]) + fabs(m->origin[2])));
}
CPM_INLINE real cpm_forward(real p) { return pick(less(p, splat(0.0)), splat(-1.0), splat(1.0)); }
CPM_INLINE real cpm_clip(real x, real low, real high) { return larger(smaller(x, high), low); }

/* Sigma to the next face across one axis of a grid; *near |= a face is within 3 hairs. */
CPM_INLINE real cpm_kink_of_axis(const cpm_medium_data *m, scalar thin, int axis, real x, real p, real g, mask *near) {
    const real none = splat(CPM_NO_KINK), zero = splat(0.0), one = splat(1.0), last = splat(m->size[axis] - 1);
    const scalar per = R(m->axis[axis]);
    if (m->size[axis] < 2) return none;
    real forward = cpm_forward(p), hair = cpm_hair_of_axis(m, thin, axis, x) * per, u = (x - R(m->origin[axis])) * per;
    real ahead = u + R(3.0) * hair * forward, behind = u - R(3.0) * hair * forward;
    real above = pick(less(ahead, zero), zero, last), below = pick(less(last, ahead), last, zero);
    mask crossed = less(ahead * behind, zero) | less((ahead - last) * (behind - last), zero);
    if (m->interpolation == CPM_FIELD_LINEAR) { /* clipped: floor_lanes takes no huge numbers */
        real cell = floor_lanes(cpm_clip(ahead, -one, last));
        above = cell + one;
        below = -one - floor_lanes(-cpm_clip(ahead, zero, last + one));
        crossed = ~equal(cell, floor_lanes(cpm_clip(behind, -one, last)));
    }
    above = pick(at_most(last, ahead), none, above);
    below = pick(at_most(ahead, zero), -none, below);
    *near |= crossed;
    return cpm_kink_along(u, hair, forward, magnitude(p) * per, g * per, below, above);
}

/* The same for layers. */
CPM_INLINE real cpm_kink_of_layers(const cpm_medium_data *m, CPM_GLOBAL const double *table, scalar thin,
                                   const cpm_point *a, mask *near) {
    const real none = splat(CPM_NO_KINK), low = splat(m->low), high = splat(m->high), one = splat(1.0);
    real3 up = cpm_times_axis(m, one);
    real speed = dot3(a->p, up), forward = cpm_forward(speed), hair = cpm_hair_of_layers(m, thin, a->r);
    real u = cpm_along_axis(m, a->r), ahead = u + R(3.0) * hair * forward, behind = u - R(3.0) * hair * forward;
    real above = pick(less(ahead, low), low, high), below = pick(less(high, ahead), high, low);
    mask crossed =
        less((ahead - low) * (behind - low), splat(0.0)) | less((ahead - high) * (behind - high), splat(0.0));
    if (m->interpolation == CPM_FIELD_LINEAR_SQUARED) {
        mask layer = cpm_layer_of(m, table, ahead);
        real number = to_reals(layer), last = splat(m->size[0] - 1);
        cpm_rows rows = rows_at(table, to_integers(smaller(number, last)) + splat_mask(m->heights));
        above = fetch(&rows, 0);
        rows = rows_at(table, to_integers(larger(number - one, splat(0.0))) + splat_mask(m->heights));
        below = fetch(&rows, 0);
        crossed = ~equal(layer, cpm_layer_of(m, table, behind));
    }
    above = pick(at_most(high, ahead), none, above);
    below = pick(at_most(ahead, low), -none, below);
    *near |= crossed;
    return cpm_kink_along(u, hair, forward, magnitude(speed), dot3(a->g, up), below, above);
}

/* The same for spherical layers, along q = rho^2 - R^2, which is a parabola in sigma where the path is one: q' = 2 p .
 * D, q'' = 2 (|p|^2 + g . D), D = r - centre. A hair of height is 2 rho of it. */
CPM_INLINE real cpm_kink_of_shells(const cpm_medium_data *m, CPM_GLOBAL const double *table, scalar thin,
                                   const cpm_point *a, mask *near) {
    const real none = splat(CPM_NO_KINK), low = splat(m->low), high = splat(m->high), one = splat(1.0);
    const scalar twice = R(2.0 * m->radius);
    cpm_shell_place s = cpm_shell_at(m, a->r);
    real speed = dot3(a->p, s.out), forward = cpm_forward(speed), hair = cpm_hair_of_layers(m, thin, a->r);
    real ahead = s.height + R(3.0) * hair * forward, behind = s.height - R(3.0) * hair * forward;
    real above = pick(less(ahead, low), low, high), below = pick(less(high, ahead), high, low);
    mask crossed =
        less((ahead - low) * (behind - low), splat(0.0)) | less((ahead - high) * (behind - high), splat(0.0));
    if (m->interpolation == CPM_FIELD_LINEAR_SQUARED) {
        mask layer = cpm_layer_of(m, table, ahead);
        real number = to_reals(layer), last = splat(m->size[0] - 1);
        cpm_rows rows = rows_at(table, to_integers(smaller(number, last)) + splat_mask(m->heights));
        above = fetch(&rows, 0);
        rows = rows_at(table, to_integers(larger(number - one, splat(0.0))) + splat_mask(m->heights));
        below = fetch(&rows, 0);
        crossed = ~equal(layer, cpm_layer_of(m, table, behind));
    }
    above = pick(at_most(high, ahead), none, above * (twice + above));
    below = pick(at_most(ahead, low), -none, below * (twice + below));
    *near |= crossed;
    return cpm_kink_along(s.q, hair * (R(2.0) * s.rho), forward, R(2.0) * magnitude(speed),
                          R(2.0) * (dot3(a->p, a->p) + dot3(a->g, s.out)), below, above);
}

/* A lens's sphere, by u = |r - centre|^2: u' = 2 y . p, u'' = 2 (p^2 + y . g); outside, where paths are straight, that
 * is all of it. A hair's distance is 2 R times as far in u. */
CPM_INLINE real3 cpm_lens_radius(const cpm_medium_data *m, real3 r, real *radius) {
    real3 y = triple(r.x - R(m->origin[0]), r.y - R(m->origin[1]), r.z - R(m->origin[2]));
    *radius = root(dot3(y, y));
    return y;
}
/* Short: what n changes by over it adds to the drift of |p|, and must stay within rounding (step.h) where g jumps as
 * much as here. */
CPM_INLINE real cpm_hair_of_sphere(const cpm_medium_data *m, scalar hair, real3 r) {
    return hair + R(3.0 * CPM_ROUNDING) * (magnitude(r.x) + magnitude(r.y) + magnitude(r.z) +
                                           splat(fabs(m->origin[0]) + fabs(m->origin[1]) + fabs(m->origin[2])));
}
CPM_INLINE real cpm_kink_of_sphere(const cpm_medium_data *m, scalar thin, const cpm_point *a, mask *near) {
    const real none = splat(CPM_NO_KINK), at = splat(m->high);
    real radius, hair = cpm_hair_of_sphere(m, thin, a->r);
    real3 y = cpm_lens_radius(m, a->r, &radius);
    real speed = R(2.0) * dot3(y, a->p), pull = R(2.0) * (dot3(a->p, a->p) + dot3(y, a->g)),
         forward = cpm_forward(speed);
    real ahead = radius + R(3.0) * hair * forward, behind = radius - R(3.0) * hair * forward;
    mask inside = less(ahead, at);
    *near |= less((ahead - at) * (behind - at), splat(0.0));
    return cpm_kink_along(radius * radius, R(2.0 * m->high) * hair, forward, magnitude(speed), pull,
                          pick(inside, -none, at * at), pick(inside, at * at, none));
}

CPM_INLINE real3 cpm_beyond_sphere(const cpm_medium_data *m, scalar thin, const cpm_point *a) {
    real radius;
    real3 y = cpm_lens_radius(m, a->r, &radius);
    return add3(a->r, R(4.0) * cpm_forward(dot3(y, a->p)) * cpm_hair_of_sphere(m, thin, a->r) / radius, y);
}

/* Kinks that matter at this tolerance: in every cell a step over one of relative size k has an error of about k/20;
 * those at the ends of a smooth table are few and always worth it, but for slopes of rounding. */
CPM_INLINE int cpm_has_kinks(const cpm_medium_data *m, double rtol) {
    return m->interpolation == CPM_FIELD_CUBIC ? m->jump * m->feature > 0.1 * rtol : m->kink > 20.0 * rtol;
}

/* What n may change by between the place where a step ends before a lens's sphere and the sphere, of n. */
CPM_INLINE real cpm_kink_noise_of(const cpm_medium_data *m, double rtol, real3 r) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON))
        return R(3.0 * m->jump) * cpm_hair_of_sphere(m, cpm_hair(m, rtol), r);
    return splat(0.0);
}
CPM_APART real cpm_kink_noise_of_sum(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol, real3 r) {
    real noise = splat(0.0);
    for (int i = 0; i < m->size[0]; i++) {
        const cpm_term t = cpm_term_at(m, table, i);
        noise += cpm_kink_noise_of(&t.data, rtol, r);
    }
    return noise;
}
CPM_INLINE real cpm_kink_noise(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol, real3 r) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_kink_noise_of_sum(m, table, rtol, r);
    return cpm_kink_noise_of(m, rtol, r);
}

/* Sigma to a hair before the next face; *near: one is within a few hairs already. Of a medium that is no sum. */
CPM_INLINE real cpm_next_kink_of(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol,
                                 const cpm_point *a, mask *near) {
    const scalar thin = cpm_hair(m, rtol);
    *near = splat_mask(0);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) return cpm_kink_of_layers(m, table, thin, a, near);
    if (CPM_IS_KIND(m, CPM_MEDIUM_SHELLS)) return cpm_kink_of_shells(m, table, thin, a, near);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON))
        return cpm_kink_of_sphere(m, thin, a, near);
    real x = cpm_kink_of_axis(m, thin, 0, a->r.x, a->p.x, a->g.x, near);
    real y = cpm_kink_of_axis(m, thin, 1, a->r.y, a->p.y, a->g.y, near);
    return smaller(smaller(x, y), cpm_kink_of_axis(m, thin, 2, a->r.z, a->p.z, a->g.z, near));
}

/* A place a few hairs along the ray, on the other side of a face that is that near. */
CPM_INLINE real3 cpm_beyond_kink_of(const cpm_medium_data *m, double rtol, const cpm_point *a) {
    const scalar thin = cpm_hair(m, rtol), few = R(4.0);
    if (CPM_IS_KIND(m, CPM_MEDIUM_LAYERED)) {
        real3 up = cpm_times_axis(m, splat(1.0));
        return add3(a->r, few * cpm_forward(dot3(a->p, up)) * cpm_hair_of_layers(m, thin, a->r), up);
    }
    if (CPM_IS_KIND(m, CPM_MEDIUM_SHELLS)) {
        cpm_shell_place s = cpm_shell_at(m, a->r);
        real hairs = few * cpm_forward(dot3(a->p, s.out)) * cpm_hair_of_layers(m, thin, a->r);
        return add3(a->r, hairs / (s.rho + R(1e-30)), s.out);
    }
    if (CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON)) return cpm_beyond_sphere(m, thin, a);
    real3 r = a->r;
    r.x += few * cpm_forward(a->p.x) * cpm_hair_of_axis(m, thin, 0, r.x);
    r.y += few * cpm_forward(a->p.y) * cpm_hair_of_axis(m, thin, 1, r.y);
    r.z += few * cpm_forward(a->p.z) * cpm_hair_of_axis(m, thin, 2, r.z);
    return r;
}

/* Of any medium: a sum has the kinks of its terms. */
CPM_APART real cpm_next_kink_of_sum(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol,
                                    const cpm_point *a, mask *near) {
    real next = splat(CPM_NO_KINK);
    mask any = splat_mask(0);
    for (int i = 0; i < m->size[0]; i++) {
        const cpm_term t = cpm_term_at(m, table, i);
        if (!cpm_has_kinks(&t.data, rtol)) continue;
        next = smaller(next, cpm_next_kink_of(&t.data, table + t.table, rtol, a, near));
        any |= *near;
    }
    *near = any;
    return next;
}
CPM_APART real3 cpm_beyond_kink_of_sum(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol,
                                       const cpm_point *a) {
    cpm_point beyond = *a;
    for (int i = 0; i < m->size[0]; i++) {
        const cpm_term t = cpm_term_at(m, table, i);
        if (cpm_has_kinks(&t.data, rtol)) beyond.r = cpm_beyond_kink_of(&t.data, rtol, &beyond);
    }
    return beyond.r;
}
CPM_INLINE real cpm_next_kink(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol, const cpm_point *a,
                              mask *near) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_next_kink_of_sum(m, table, rtol, a, near);
    return cpm_next_kink_of(m, table, rtol, a, near);
}
CPM_INLINE real3 cpm_beyond_kink(const cpm_medium_data *m, CPM_GLOBAL const double *table, double rtol,
                                 const cpm_point *a) {
    if (CPM_IS_KIND(m, CPM_MEDIUM_SUM)) return cpm_beyond_kink_of_sum(m, table, rtol, a);
    return cpm_beyond_kink_of(m, rtol, a);
}
#endif
