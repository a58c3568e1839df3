/* shared/step.h: one attempted step of eight rays, accepted or refused lane by lane.
 *
 * Acceptance (adaptive methods). Position error per unit length: the embedded error of a step of length d is at most
 * L (rtol d + atol d/expected), so that errors add up to rtol x length + atol; direction error of a step at most L
 * rtol. Never relative to |r|. L: dopri5 keeps the fifth-order result while the estimate is the fourth's, larger by a
 * factor that grows as rtol^(-1/8) (measured on smooth fields, 1e-3 to 1e-12); L = 0.56 rtol^(-1/8) takes that back.
 * euler: 1.
 *
 * Where the field has kinks or thin layers both estimates are blind, but | |p| - n |/n, whose growth in a step is a
 * true error of momentum along p, is not. An error in the direction of the force, at an angle a to p, shows in it times
 * cos a: a step is refused when it grows by more than 0.5 rtol cos a (cos a >= 0.03), far below the 10 rtol that would
 * only tell that a layer was stepped over. And when n^2 <= 0 was met at any stage the step is cut to a quarter.
 *
 * The next step follows the worst of the three ratios E by a PI controller (Gustafsson 1991); E grows as h^4 (dopri5):
 * h E^(-3/16) E_before^(1/16); as h (euler): h E^(-3/4) E_before^(1/4). Rough logarithms serve.
 *
 * Steps end where grad n jumps (kinks.h), one evaluation more each; fixed steps do not.
 *
 * Float lanes: positions, momenta and lengths are added up in double, r + h p + bend, p + push, with only the small bend
 * and push, and what the field is asked, in float (CPM_SINGLE): rounding grows with what a step bends, not with where it is.
 *
 * A ray ends by status: evaluations exhausted, no step small enough (64 refusals running, or a step that moves
 * nothing), cut-off: n below 1e-6 of its start, or a turn back through p = 0 (normal incidence on n = 0), left: 1e100 m
 * gone. */
#ifndef CPM_SHARED_STEP_H
#define CPM_SHARED_STEP_H
#include "../types/lanes.h"
#include "../types/ray.h"
#include "kinks.h"
#include "step_dopri5.h"
#include "step_euler.h"
#include "step_rk4.h"

#define CPM_FAR (CPM_SINGLE ? 1e15 : 1e100) /* metres */
#define CPM_CUTOFF 1e-6                     /* of n at the start */
#define CPM_MAX_REFUSED 64
#define CPM_LEAST_RTOL (CPM_SINGLE ? 1e-6 : 1e-15) /* below it rounding alone would refuse steps of any size */
#define CPM_PARTS (CPM_LANES / CPM_WIDTH)
#define CPM_INFINITE (CPM_SINGLE ? 1e38 : 1e300) /* stands for infinity in h, limit, target: no NaN from arithmetic */

CPM_INLINE double cpm_step_cost(const cpm_step_control *c) { /* evaluations an attempt */
    return c->method == CPM_STEP_EULER ? 2.0 : c->method == CPM_STEP_RK4 ? 4.0 : 6.0;
}

/* What follows from rtol and the method. */
CPM_INLINE void cpm_step_control_set(cpm_step_control *c) {
    double quarter = cpm_sqrt(cpm_sqrt(c->rtol));
    c->lenient = c->method == CPM_STEP_EULER ? 1.0 : 0.56 / cpm_sqrt(quarter);
    if (c->lenient < 1.0) c->lenient = 1.0;
    c->first = c->method == CPM_STEP_EULER ? 3.0 * c->rtol : 8.0 * quarter;
}

/* Sigma of the first step, from the curvature's radius n^2/|g| and the length over which the field changes. */
CPM_INLINE real cpm_first_step(const cpm_step_control *c, const cpm_medium_data *m, const cpm_point *a, real expected) {
    if (c->step > 0.0) return R(c->step) / a->n;
    real bend = root(dot3(a->g, a->g)) / (a->n * a->n);
    real metres;
    if (c->method == CPM_STEP_EULER)
        metres = splat(c->first) / (bend + R(1e-30));
    else
        metres = splat(c->first) / (bend + R(1.0 / m->feature) + R(1e-30));
    real most = pick(less(splat(0.0), expected), expected, splat(CPM_FAR));
    return smaller(metres, most) / a->n;
}

/* Fills what a fresh lane needs: its first evaluation and first step. */
CPM_INLINE void cpm_lanes_begin(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                cpm_lane_rays *rays, const cpm_i64 *fresh) {
    const int kinks = cpm_has_kinks(m, c->rtol);
    for (int part = 0; part < CPM_PARTS; part++) {
        mask new_ray = ~equal(load_flags(fresh, part), splat_mask(0));
        if (!any_lane(new_ray)) continue;
        const real zero = splat(0.0);
        cpm_point a;
        a.r = load3_doubles(rays->r, part), a.p = load3_doubles(rays->p, part);
        a.scale = load_doubles(rays->scale, part);
        a.g = cpm_field(m, table, a.r, a.scale, &a.n);
        mask good = less(zero, a.n);
        real size = dot3(a.p, a.p);
        a.p = pick3(new_ray & good & less(zero, size), scale3(a.n / root(size), a.p), a.p);
        real h = load_doubles(rays->h, part), expected = load_doubles(rays->expected, part);
        h = pick(less(zero, h), h, cpm_first_step(c, m, &a, expected));
#define CPM_FRESH(field, value) store_doubles(pick(new_ray, value, load_doubles(rays->field, part)), rays->field, part)
#if CPM_SINGLE
        wide px = load_wide(rays->p[0], part), py = load_wide(rays->p[1], part), pz = load_wide(rays->p[2], part);
        mask keep = ~(new_ray & good & less(zero, size));
        wide unit = to_wide(pick(keep, splat(1.0), a.n)) / root_wide(to_wide(pick(keep, splat(1.0), zero)) +
                    to_wide(pick(keep, zero, splat(1.0))) * (px * px + py * py + pz * pz));
        store_wide(px * unit, rays->p[0], part);
        store_wide(py * unit, rays->p[1], part);
        store_wide(pz * unit, rays->p[2], part);
#else
        store3_doubles(a.p, rays->p, part);
#endif
        store3_doubles(pick3(new_ray, a.g, load3_doubles(rays->g, part)), rays->g, part);
        CPM_FRESH(n, pick(good, a.n, zero));
        CPM_FRESH(n_start, a.n);
        CPM_FRESH(h, h);
        CPM_FRESH(limit, splat(CPM_INFINITE));
        CPM_FRESH(target, splat(CPM_INFINITE));
        CPM_FRESH(evaluations, splat(1.0));
        CPM_FRESH(steps, zero);
        CPM_FRESH(rejected, zero);
        CPM_FRESH(drift, zero);
        CPM_FRESH(drift_now, zero);
        CPM_FRESH(error, zero);
        CPM_FRESH(error_turn, zero);
        CPM_FRESH(previous, zero);
        CPM_FRESH(refused, zero);
#undef CPM_FRESH
        mask near = splat_mask(0);
        if (kinks) (void)cpm_next_kink(m, table, c->rtol, &a, &near);
        store_flags(pick_mask(new_ray, near, load_flags(rays->at_kink, part)), rays->at_kink, part);
        mask status = pick_mask(good, splat_mask(CPM_ENDED_GOING), splat_mask(CPM_ENDED_CUTOFF));
        store_flags(pick_mask(new_ray, status, load_flags(rays->status, part)), rays->status, part);
        store_flags(load_flags(rays->accepted, part) & ~new_ray, rays->accepted, part);
    }
}

/* The sigma that brings the ray to its target length, to second order: l' = n, l'' = g . p/n, so that
 * sigma = 2 d/(n + sqrt(n^2 + 2 d l'')) ~ d/(n + d l''/(2 n)), kept within a factor 2 of d/n. */
CPM_INLINE real cpm_aim(const cpm_point *a, real inverse_n, real remaining) {
    real bent = R(0.5) * remaining * dot3(a->g, a->p) * (inverse_n * inverse_n);
    bent = larger(smaller(bent, a->n), R(-0.5) * a->n);
    return pick(less(remaining, splat(1e-3 * CPM_INFINITE)), remaining / (a->n + bent), splat(CPM_INFINITE));
}

/* The least |p|^2 on the chord from p to q, and where (0..1): a turn back through p = 0 shows there. */
CPM_INLINE real cpm_least_momentum(real3 p, real3 q, real *where) {
    real3 d = sub3(q, p);
    real t = -dot3(p, d) / (dot3(d, d) + R(1e-30));
    t = larger(smaller(t, splat(1.0)), splat(0.0));
    real3 least = add3(p, t, d);
    *where = t;
    return dot3(least, least);
}

/* The factor to the next step from log2 of the ratio E of error to tolerance, now and at the step before. */
CPM_INLINE real cpm_step_factor(const cpm_step_control *c, real ratio, real before, mask accepted, mask again) {
    const int euler = c->method == CPM_STEP_EULER;
    real keep = R(euler ? -0.75 : -0.1875) * ratio + R(euler ? 0.25 : 0.0625) * before - R(0.152); /* 0.9 = 2^-0.152 */
    real shrink = R(euler ? -1.0 : -0.25) * ratio - R(0.152);
    keep = larger(smaller(keep, pick(again, splat(0.0), splat(2.32))), splat(-2.32)); /* 1/5 to 5 */
    shrink = larger(smaller(shrink, splat(-0.152)), splat(-3.32));
    return exp2_rough(pick(accepted, keep, shrink));
}

/* What an attempt starts with: the current point, how far it may go, and whether it ends at a kink. */
typedef struct {
    cpm_point at;
    real own, h, evaluations; /* the controller's sigma, the one that is tried; evaluations so far */
    mask going, to_kink;
} cpm_attempt;

CPM_INLINE cpm_attempt cpm_prepare(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                   const cpm_lane_rays *rays, int part, mask going, real evaluations, int kinks) {
    cpm_attempt a;
    a.at.r = load3_doubles(rays->r, part), a.at.p = load3_doubles(rays->p, part), a.at.g = load3_doubles(rays->g, part);
    a.at.n = load_doubles(rays->n, part), a.at.scale = load_doubles(rays->scale, part);
    a.own = load_doubles(rays->h, part), a.evaluations = evaluations;
    a.going = going, a.to_kink = splat_mask(0);
    const real inverse_n = R(1.0) / a.at.n, length = load_doubles(rays->length, part);
    real bound = cpm_aim(&a.at, inverse_n, load_doubles(rays->target, part) - length);
    bound = smaller(smaller(load_doubles(rays->limit, part), R(c->max_step) * inverse_n), bound);
    if (kinks) {
        mask at_kink = load_flags(rays->at_kink, part) & going, near;
        if (any_lane(at_kink)) {
            real ignored;
            real3 beyond = cpm_beyond_kink(m, table, c->rtol, &a.at);
            a.at.g = pick3(at_kink, cpm_field(m, table, beyond, a.at.scale, &ignored), a.at.g);
            a.evaluations = pick(at_kink, evaluations + R(1.0), evaluations);
        }
        real kink = cpm_next_kink(m, table, c->rtol, &a.at, &near);
        a.to_kink = less(kink, smaller(a.own, bound)) & less(R(1e-7) * a.own, kink); /* or steps would die out */
        bound = pick(a.to_kink, kink, bound);
    }
    a.h = smaller(a.own, bound);
    return a;
}

/* How good a trial is. */
typedef struct {
    real off, turn;     /* estimated errors: metres, radians */
    real drift, growth; /* of |p| from n, relative; growth in this step */
    real ratio;         /* log2 of the worst of error to tolerance */
    real far;           /* |x| + |y| + |z|, metres */
    real where;         /* of the turn, 0..1 of the step */
    mask turned;        /* p goes through 0 */
    mask usable, worth; /* finite, n > 0; within the tolerance */
} cpm_verdict;

CPM_INLINE cpm_verdict cpm_judge(const cpm_step_control *c, const cpm_lane_rays *rays, int part, const cpm_attempt *a,
                                 const cpm_trial *t) {
    const real zero = splat(0.0), one = splat(1.0), n_start = load_doubles(rays->n_start, part);
    const real3 p = t->end.p, push = sub3(p, a->at.p);
    const real per_square = one / (t->end.n * t->end.n), size = dot3(p, p);
    cpm_verdict v;
    v.where = zero;
    v.turned = less(dot3(a->at.p, p), zero); /* only then can the chord of p pass near 0 */
    real way_error = t->error_way, least = R(CPM_CUTOFF) * n_start;
    if (any_lane(v.turned)) {
        v.turned &= less(cpm_least_momentum(a->at.p, p, &v.where), least * least);
        way_error = pick(v.turned, zero, way_error); /* |p| has a kink there, n's quadrature is meaningless */
    }
    v.off = root(t->error_position2 + way_error * way_error);
    v.turn = root(t->error_momentum2) * (t->end.n * per_square);
    real excess = (size - t->end.n * t->end.n) * per_square;                /* |p|^2/n^2 - 1 */
    v.drift = magnitude(excess) / (R(2.0) + R(0.5) * larger(excess, -one)); /* sqrt(1 + x) - 1 to x^3/32 */
    v.growth = pick(v.turned, zero, v.drift - load_doubles(rays->drift_now, part));
    v.far = magnitude(t->end.r.x) + magnitude(t->end.r.y) + magnitude(t->end.r.z);

    /* What the tolerance and rounding allow. */
    real steep = magnitude(t->end.g.x) + magnitude(t->end.g.y) + magnitude(t->end.g.z);
    real noise = R(10.0 * CPM_ROUNDING) * (one + (larger(n_start * n_start, one) + v.far * steep) * per_square);
    real along = dot3(push, p); /* no push at all: a = 90 degrees, the strictest */
    real slant = log2_rough(along * along) - log2_rough(dot3(push, push) * size + R(1e-30));
    slant = exp2_rough(smaller(larger(R(0.5) * slant, splat(-5.0)), zero)); /* cos a, 0.03 to 1 */
    const double rtol = fmax(c->rtol, CPM_LEAST_RTOL);
    real may_off = R(c->lenient * rtol) * t->way, may_grow = R(0.5 * rtol) * slant + noise;
    if (c->atol > 0.0) {
        real expected = load_doubles(rays->expected, part);
        real share = pick(less(zero, expected), smaller(t->way / larger(expected, splat(1e-30)), one), splat(0.1));
        may_off += R(c->lenient * c->atol) * share;
    }
    real ratio = larger(v.off * may_grow, v.growth * may_off) / (may_off * may_grow);
    ratio = larger(ratio, v.turn * R(1.0 / (c->lenient * rtol)));
    v.usable = t->good & (less(zero, t->way) | v.turned) & less(v.far, splat(CPM_FAR)) & at_most(ratio, splat(1e12));
    v.worth = c->step > 0.0 ? ~splat_mask(0) : at_most(ratio, one);
    v.ratio = log2_rough(larger(pick(v.usable, ratio, splat(1e12)), splat(1e-8)));
    return v;
}

/* The sigma to try next, into rays->h. */
CPM_INLINE void cpm_plan(const cpm_step_control *c, cpm_lane_rays *rays, int part, const cpm_attempt *a,
                         const cpm_verdict *v, mask accepted) {
    const real before = load_doubles(rays->previous, part);
    mask again = less(splat(0.0), load_doubles(rays->refused, part));
    real next = a->h * cpm_step_factor(c, v->ratio, before, accepted, again);
    next = pick(accepted & less(a->h, a->own), larger(next, a->own), next);
    next = pick(v->usable, next, R(0.25) * a->h);
    if (c->step > 0.0) next = pick(v->usable, R(c->step) / load_doubles(rays->n_start, part), next);
    store_doubles(pick(a->going, next, a->own), rays->h, part);
    store_doubles(pick(accepted, larger(v->ratio, splat(-13.0)), before), rays->previous, part);
}

/* A turn back through p = 0 ends there: along the parabola of the start's g, where n^2 falls linearly to 0. */
CPM_INLINE void cpm_end_at_turn(const cpm_attempt *a, mask backward, real h, real where, cpm_trial *t) {
    real3 r = add3(add3(a->at.r, h, a->at.p), R(0.5) * h * h, a->at.g), went = sub3(r, a->at.r);
    t->end.r = pick3(backward, r, t->end.r);
    t->end.p = pick3(backward, add3(a->at.p, where, sub3(t->end.p, a->at.p)), t->end.p);
    t->end.g = pick3(backward, add3(a->at.g, where, sub3(t->end.g, a->at.g)), t->end.g);
    t->end.n = pick(backward, root(dot3(t->end.p, t->end.p)), t->end.n);
    t->way = pick(backward, root(dot3(went, went)), t->way);
    t->path = pick(backward, R(2.0 / 3.0) * a->at.n * t->way, t->path);
    if (CPM_SINGLE) {
        t->bend = pick3(backward, scale3(R(0.5) * h * h, a->at.g), t->bend);
        t->push = pick3(backward, sub3(t->end.p, a->at.p), t->push);
    }
}

#if CPM_SINGLE
/* Moves one coordinate on in double: the piece's start, then r += h p + bend, p += push where accepted. */
CPM_INLINE void cpm_keep_axis(double *r0, double *p0, double *r, double *p, int part, wide h, real bend, real push) {
    wide at = load_wide(r, part), momentum = load_wide(p, part);
    store_wide(at, r0, part);
    store_wide(momentum, p0, part);
    store_wide(at + (h * momentum + to_wide(bend)), r, part);
    store_wide(momentum + to_wide(push), p, part);
}
CPM_INLINE void cpm_keep_wide(cpm_lane_rays *rays, int part, const cpm_trial *t, mask accepted, real piece_h) {
    const real zero = splat(0.0);
    const real3 none = triple(zero, zero, zero), bend = pick3(accepted, t->bend, none), push = pick3(accepted, t->push, none);
    const wide h = to_wide(pick(accepted, piece_h, zero));
    cpm_keep_axis(rays->r0[0], rays->p0[0], rays->r[0], rays->p[0], part, h, bend.x, push.x);
    cpm_keep_axis(rays->r0[1], rays->p0[1], rays->r[1], rays->p[1], part, h, bend.y, push.y);
    cpm_keep_axis(rays->r0[2], rays->p0[2], rays->r[2], rays->p[2], part, h, bend.z, push.z);
    const wide length = load_wide(rays->length, part), path = load_wide(rays->optical_path, part);
    store_wide(length, rays->length0, part);
    store_wide(path, rays->optical_path0, part);
    store_wide(length + to_wide(pick(accepted, t->way, zero)), rays->length, part);
    store_wide(path + to_wide(pick(accepted, t->path, zero)), rays->optical_path, part);
}
#endif

/* Moves the accepted lanes on, and leaves their piece behind. */
CPM_INLINE void cpm_keep(cpm_lane_rays *rays, int part, const cpm_attempt *a, const cpm_trial *t, const cpm_verdict *v,
                         mask accepted, real piece_h) {
    const real error_turn = load_doubles(rays->error_turn, part);
#if CPM_SINGLE
    cpm_keep_wide(rays, part, t, accepted, piece_h);
#else
    const real length = load_doubles(rays->length, part), path = load_doubles(rays->optical_path, part);
    store3_doubles(pick3(accepted, a->at.r, load3_doubles(rays->r0, part)), rays->r0, part);
    store3_doubles(pick3(accepted, a->at.p, load3_doubles(rays->p0, part)), rays->p0, part);
    store3_doubles(pick3(accepted, t->end.r, a->at.r), rays->r, part);
    store3_doubles(pick3(accepted, t->end.p, a->at.p), rays->p, part);
#endif
    store3_doubles(pick3(accepted, a->at.g, load3_doubles(rays->g0, part)), rays->g0, part);
    store3_doubles(pick3(accepted, t->end.g, a->at.g), rays->g, part);
    store_doubles(pick(accepted, t->end.n, a->at.n), rays->n, part);
#define CPM_KEEP(field, value) store_doubles(pick(accepted, value, load_doubles(rays->field, part)), rays->field, part)
    CPM_KEEP(n0, a->at.n);
    CPM_KEEP(piece_h, piece_h);
#if !CPM_SINGLE
    CPM_KEEP(length0, length);
    CPM_KEEP(optical_path0, path);
    CPM_KEEP(length, length + t->way);
    CPM_KEEP(optical_path, path + t->path);
#endif
    CPM_KEEP(steps, load_doubles(rays->steps, part) + R(1.0));
    CPM_KEEP(drift_now, v->drift);
    CPM_KEEP(drift, larger(load_doubles(rays->drift, part), v->drift));
    CPM_KEEP(error, load_doubles(rays->error, part) + v->off + error_turn * t->way);
    CPM_KEEP(error_turn, error_turn + v->turn);
#undef CPM_KEEP
    store_flags(a->to_kink & accepted, rays->at_kink, part);
    store_flags(accepted, rays->accepted, part);
}

CPM_INLINE void cpm_lanes_attempt_part(const cpm_step_control *c, const cpm_medium_data *m,
                                       CPM_GLOBAL const double *table, cpm_lane_rays *rays, int part) {
    const real zero = splat(0.0), one = splat(1.0);
    const int kinks = cpm_has_kinks(m, c->rtol) && !(c->step > 0.0);
    mask status = load_flags(rays->status, part), going = less(status, splat_mask(0));
    store_flags(splat_mask(0), rays->accepted, part);
    if (!any_lane(going)) return;
    real evaluations = load_doubles(rays->evaluations, part);
    mask spent = going & less(splat(c->max_evaluations - cpm_step_cost(c) - kinks), evaluations);
    status = pick_mask(spent, splat_mask(CPM_ENDED_EXHAUSTED), status);
    going &= ~spent;

    const cpm_attempt a = cpm_prepare(c, m, table, rays, part, going, evaluations, kinks);
    cpm_trial t;
    if (c->method == CPM_STEP_EULER)
        t = cpm_step_euler(m, table, &a.at, a.h);
    else if (c->method == CPM_STEP_RK4)
        t = cpm_step_rk4(m, table, &a.at, a.h);
    else
        t = cpm_step_dopri5(m, table, &a.at, a.h);
    cpm_verdict v = cpm_judge(c, rays, part, &a, &t);
    mask accepted = going & v.usable & v.worth, refused = going & ~accepted;
    cpm_plan(c, rays, part, &a, &v, accepted);

    mask cut = accepted & (v.turned | less(t.end.n, R(CPM_CUTOFF) * load_doubles(rays->n_start, part)));
    mask backward = cut & v.turned;
    real piece_h = pick(backward, v.where * a.h, a.h);
    if (any_lane(backward)) {
        cpm_end_at_turn(&a, backward, piece_h, v.where, &t);
        v.drift = pick(backward, zero, v.drift);
    }
    if (c->method == CPM_STEP_RK4) v.turn = magnitude(v.growth); /* no estimate of its own */
    cpm_keep(rays, part, &a, &t, &v, accepted, piece_h);
    real running = pick(accepted, zero, load_doubles(rays->refused, part) + one);
    real rejected = load_doubles(rays->rejected, part);
    store_doubles(running, rays->refused, part);
    store_doubles(pick(refused, rejected + one, rejected), rays->rejected, part);
    store_doubles(pick(going, a.evaluations + R(cpm_step_cost(c)), a.evaluations), rays->evaluations, part);

    /* Does it end? */
    real3 moved = sub3(t.end.r, a.at.r);
    mask still = accepted & equal(moved.x, zero) & equal(moved.y, zero) & equal(moved.z, zero);
    if (CPM_SINGLE) still = accepted & ~less(zero, t.way); /* the double sum may move where a float does not */
    mask stuck = (refused & less(splat(CPM_MAX_REFUSED), running)) | still;
    mask why = pick_mask(t.good, splat_mask(CPM_ENDED_UNDERFLOW), splat_mask(CPM_ENDED_CUTOFF));
    status = pick_mask(stuck, why, status);
    status = pick_mask(accepted & less(splat(0.1 * CPM_FAR), v.far), splat_mask(CPM_ENDED_LEFT), status);
    status = pick_mask(cut, splat_mask(CPM_ENDED_CUTOFF), status);
    store_flags(status, rays->status, part);
}

CPM_INLINE void cpm_lanes_attempt(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                  cpm_lane_rays *rays) {
    for (int part = 0; part < CPM_PARTS; part++) cpm_lanes_attempt_part(c, m, table, rays, part);
}

CPM_INLINE void cpm_lanes_piece(const cpm_lane_rays *rays, int i, cpm_piece *piece) {
    for (int k = 0; k < 3; k++) {
        piece->r0[k] = rays->r0[k][i], piece->p0[k] = rays->p0[k][i], piece->g0[k] = rays->g0[k][i];
        piece->r1[k] = rays->r[k][i], piece->p1[k] = rays->p[k][i], piece->g1[k] = rays->g[k][i];
    }
    piece->h = rays->piece_h[i];
    piece->length0 = rays->length0[i], piece->length1 = rays->length[i];
    piece->n0 = rays->n0[i], piece->n1 = rays->n[i];
}
#endif
