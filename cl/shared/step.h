/* shared/step.h: one attempted step of eight rays, accepted or refused lane by lane.
 *
 * Acceptance (adaptive methods). Position error per unit length: the embedded error of a step of length d is at most
 * L (rtol d + atol d/expected), so that errors add up to rtol x length + atol; direction error of a step at most L
 * rtol. Never relative to |r|. L: dopri5 keeps the fifth-order result while the estimate is the fourth's, larger by a
 * factor that grows as rtol^(-1/8) (measured on smooth fields, 1e-3 to 1e-12); L = 0.2 rtol^(-1/8), at least 1, takes a
 * part of that back. euler: 1.
 *
 * Where the field has kinks or thin layers both estimates are blind, but (|p|^2 - n^2)/(2 n^2), whose change in a step
 * is a true error of momentum along p, is not. (Not the growth of | |p| - n |/n: where n falls, that grows by itself.)
 * An error in the direction of the force, at an angle a to p, shows in it times cos a: a step is refused when it
 * changes by more than 0.5 rtol cos a (cos a >= 0.03), far below the 10 rtol that would only tell that a layer was
 * stepped over. Near a place where n has no bound |p|^2 - n^2 itself is held to that: it outlasts the way out to n = 1,
 * where it weighs n^2 times as much. And when n^2 <= 0 was met at any stage the step is cut to a quarter.
 *
 * The next step follows the worst of the three ratios E by a PI controller (Gustafsson 1991); E grows as h^4 (dopri5):
 * h E^(-3/16) E_before^(1/16); as h (euler): h E^(-3/4) E_before^(1/4). Rough logarithms serve. It is no longer than
 * h (h/h_before) (E_before/E^2)^(1/q), q = 4: what the last two steps say of the next (Gustafsson, ACM TOMS 20, 1994).
 *
 * Steps end where grad n jumps (kinks.h), one evaluation more each; fixed steps do not.
 *
 * Float lanes: positions, momenta and lengths are added up in double, r + h p + bend, p + push, with only the small
 * bend and push, and what the field is asked, in float (CPM_SINGLE): rounding grows with what a step bends, not with
 * where it is.
 *
 * A ray ends by status: evaluations exhausted, no step small enough (64 refusals running, or a step that moves
 * nothing), cut-off: n below 1e-6 of its start, or a turn back through p = 0 (normal incidence on n = 0), left: 1e100 m
 * gone, captured: n above 1e6 of its start near a place where it has no bound (or above twice, where no step is small
 * enough any more, or coordinates are too coarse). An adaptive step is never longer than the way to such a place: it
 * cannot leap over one. */
#ifndef CPM_SHARED_STEP_H
#define CPM_SHARED_STEP_H
#include "../types/lanes.h"
#include "../types/ray.h"
#include "kinks.h"
#include "step_adams.h"
#include "step_dopri5.h"
#include "step_euler.h"
#include "step_nystrom.h"
#include "step_rk4.h"
#include "step_symplectic.h"

#define CPM_FAR (CPM_SINGLE ? 1e15 : 1e100) /* metres */
#define CPM_CUTOFF 1e-6                     /* of n at the start */
#define CPM_CAPTURE 1e6                     /* of n at the start */
#define CPM_NOISE 1e-3 /* of |p|^2 - n^2 beside 1, by rounding of coordinates: beyond it nothing is left of a ray */
#define CPM_CENTER_N (CPM_SINGLE ? 1e7 : 1e14) /* a ray that starts where n is above that has not far to go */
#define CPM_MAX_REFUSED 64
#define CPM_LEAST_RTOL (CPM_SINGLE ? 1e-6 : 1e-15) /* below it rounding alone would refuse steps of any size */
/* Which methods are compiled in: bit 1 << CPM_STEP_... (all by default). */
#ifndef CPM_METHODS
#define CPM_METHODS 511
#endif
#define CPM_IS_METHOD(c, k) (((CPM_METHODS >> (k)) & 1) && (CPM_METHODS == 1 << (k) || (c)->method == (k)))
#define CPM_PARTS (CPM_LANES / CPM_WIDTH)
/* nystrom: measured on smooth fields (fibre, fish-eye, Luneburg, linear n, atmosphere), rtol 1e-2 to 1e-12. */
#define CPM_RKN8_FROM 3e-4   /* rtol from which 8(6) is the cheaper */
#define CPM_RKN6_LENIENT 1.0 /* rtol^(-1/4): what the estimate of fourth or sixth order is too large by */
#define CPM_RKN8_LENIENT 1.0
#define CPM_RKN6_FIRST 4.0 /* rtol^(1/8) of the curvature's radius: the first step */
#define CPM_RKN8_FIRST 5.0
/* 12(10), measured on other rays of the same media too */
#define CPM_RKN12_FROM 1e-6 /* rtol below which it is the cheaper on long ways */
#define CPM_RKN8_COST 8.0
#define CPM_RKN12_COST 17.0      /* evaluations an attempt */
#define CPM_RKN12_LONGER 3.0     /* its steps over those of 8(6) */
#define CPM_RKN12_LEFT (2.0 / 3) /* of its step: what is left of a way is 8(6)'s, two steps of it at the most */
#define CPM_RKN12_LENIENT 0.5    /* rtol^(-1/8) */
/* 1/leniency: of the square of h x momentum's estimate over the quintic's (8(6)), or of that itself (12(10)) */
#define CPM_RKN8_ROUGH 100.0
#define CPM_RKN8_ROUGH_TABLE 1e4
#define CPM_RKN12_ROUGH 1e4
#define CPM_RKN_STRICT 30.0
#define CPM_RKN_GROW 2.0                         /* growth of the drift that a step may have, in rtol cos a */
#define CPM_UNKNOWN 100.0                        /* of a ratio's log2: larger than any */
#define CPM_INFINITE (CPM_SINGLE ? 1e38 : 1e300) /* stands for infinity in h, limit, target: no NaN from arithmetic */

/* What follows from rtol and the method. */
CPM_INLINE void cpm_step_control_set(cpm_step_control *c) {
    const double quarter = cpm_sqrt(cpm_sqrt(c->rtol)), eighth = cpm_sqrt(quarter);
    c->order = c->method == CPM_STEP_NYSTROM ? (c->rtol > CPM_RKN8_FROM ? 6 : 8) : 0;
    c->high = 0;
    if (!CPM_SINGLE) c->high = c->order == 8 && c->rtol < CPM_RKN12_FROM && !c->dense && !(c->step > 0.0);
    c->cost = 6.0, c->exponent = 0.25, c->lenient = 0.2 / eighth, c->first = 8.0 * quarter; /* dopri5 */
    if (c->method == CPM_STEP_EULER) c->cost = 2.0, c->exponent = 1.0, c->lenient = 1.0, c->first = 3.0 * c->rtol;
    if (c->method == CPM_STEP_RK4) c->cost = 4.0;
    if (c->method == CPM_STEP_LEAPFROG) c->cost = 1.0;
    if (c->method == CPM_STEP_YOSHIDA6) c->cost = 7.0;
    if (c->method == CPM_STEP_ADAMS) c->cost = 2.0, c->first = 3.0 * cpm_sqrt(c->rtol);
    if (c->order == 6) c->cost = 5.0, c->lenient = CPM_RKN6_LENIENT / quarter, c->first = CPM_RKN6_FIRST * eighth;
    if (c->order == 8)
        c->cost = CPM_RKN8_COST, c->exponent = 1.0 / 6.0, c->lenient = CPM_RKN8_LENIENT / quarter,
        c->first = CPM_RKN8_FIRST * eighth;
    c->grow = c->method == CPM_STEP_NYSTROM ? CPM_RKN_GROW : 0.5;
    if (c->lenient < 1.0) c->lenient = 1.0;
    if (c->method == CPM_STEP_ADAMS) c->lenient = 0.3; /* its estimate is the error, and adds up over many steps */
}

/* Sigma of the first step, from the curvature's radius n^2/|g| and the length over which the field changes. */
CPM_INLINE real cpm_first_step(const cpm_step_control *c, const cpm_medium_data *m, const cpm_point *a, real expected) {
    if (c->step > 0.0) return R(c->step) / a->n;
    real bend = root(dot3(a->g, a->g)) / (a->n * a->n);
    real metres;
    if (c->method == CPM_STEP_EULER || (c->method == CPM_STEP_NYSTROM && !cpm_is_singular(m)))
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
        broad px = load_broad(rays->p[0], part), py = load_broad(rays->p[1], part), pz = load_broad(rays->p[2], part);
        mask keep = ~(new_ray & good & less(zero, size));
        broad unit = to_broad(pick(keep, splat(1.0), a.n)) /
                     root_broad(to_broad(pick(keep, splat(1.0), zero)) +
                                to_broad(pick(keep, zero, splat(1.0))) * (px * px + py * py + pz * pz));
        store_broad(px * unit, rays->p[0], part);
        store_broad(py * unit, rays->p[1], part);
        store_broad(pz * unit, rays->p[2], part);
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
        CPM_FRESH(previous, splat(CPM_UNKNOWN));
        CPM_FRESH(refused, zero);
        CPM_FRESH(dense, zero);
        CPM_FRESH(kept, zero);
        CPM_FRESH(order, zero);
        for (int k = 0; k < 6; k++) CPM_FRESH(low[k], zero);
#undef CPM_FRESH
        mask near = splat_mask(0);
        if (kinks) (void)cpm_next_kink(m, table, c->rtol, &a, &near);
        store_flags(pick_mask(new_ray, near, load_flags(rays->at_kink, part)), rays->at_kink, part);
        mask status = pick_mask(good, splat_mask(CPM_ENDED_GOING), splat_mask(CPM_ENDED_CUTOFF));
        if (cpm_is_singular(m))
            status = pick_mask(good & less(splat(CPM_CENTER_N), a.n), splat_mask(CPM_ENDED_CAPTURED), status);
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

/* A function of sigma at both ends of a piece: what it rises by, its slopes and second derivatives. */
typedef struct {
    real rise, d0, s0, d1, s1;
} cpm_ends;

/* Sigma beyond the piece's end where the function has risen by `wanted` more: its quintic continued, where `first`, a
 * guess, is within twice the piece; within a factor 2 of `first`. With x in pieces beyond the end, f - f1 = c1 x - c2
 * x^2
 * + c3 x^3 - c4 x^4 + c5 x^5, c as in (2) of piece.h for the piece run through backwards; three steps of Newton's. */
CPM_INLINE real cpm_go_on(const cpm_ends *e, real h, real wanted, real first) {
    const real c1 = e->d1 * h, c2 = R(-0.5) * h * h * e->s1;
    const real rise = e->rise - c1 - c2, turn = e->d0 * h - c1 - R(2.0) * c2, bend = -h * h * e->s0 - R(2.0) * c2;
    const real c3 = R(10.0) * rise - R(4.0) * turn + R(0.5) * bend;
    const real c4 = R(-15.0) * rise + R(7.0) * turn - bend, c5 = R(6.0) * rise - R(3.0) * turn + R(0.5) * bend;
    const real guess = first / larger(h, splat(1e-30)), least = R(1e-3) * magnitude(wanted);
    real x = guess;
    for (int i = 0; i < 3; i++) {
        real f = x * (c1 + x * (x * (c3 + x * (x * c5 - c4)) - c2)) - wanted;
        real slope = c1 + x * (x * (R(3.0) * c3 + x * (R(5.0) * c5 * x - R(4.0) * c4)) - R(2.0) * c2);
        x = pick(less(least, slope * x), x - f / pick(less(least, slope * x), slope, splat(1.0)), guess);
        x = larger(smaller(x, R(2.0) * guess), R(0.5) * guess);
    }
    return x * h;
}

/* cpm_aim by the piece behind the current point, where there is one and `first`, cpm_aim's, is not far from it. */
CPM_INLINE real cpm_aim_on(const cpm_lane_rays *rays, int part, const cpm_point *a, real remaining, real first) {
    const real h = load_doubles(rays->piece_h, part), n0 = load_doubles(rays->n0, part);
    mask good = less(splat(0.0), load_doubles(rays->steps, part)) & less(first, R(2.0) * h);
    if (!any_lane(good)) return first;
    cpm_ends e;
    e.rise = load_doubles(rays->length, part) - load_doubles(rays->length0, part);
    e.d0 = n0, e.s0 = dot3(load3_doubles(rays->g0, part), load3_doubles(rays->p0, part)) / n0;
    e.d1 = a->n, e.s1 = dot3(a->g, a->p) / a->n;
    return pick(good, cpm_go_on(&e, h, remaining, first), first);
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

/* The factor to the next step from log2 of the ratio E of error to tolerance, now and at the step before, and `longer`,
 * log2 of this step over that one. Where steps become harder, what they became harder by is expected of the next too.
 */
CPM_INLINE real cpm_step_factor(real exponent, real ratio, real before, real longer, mask accepted, mask again) {
    const mask known = less(before, splat(0.5 * CPM_UNKNOWN)); /* else `longer` is of another ray or pair */
    before = pick(known, before, ratio);
    longer = pick(known, longer, splat(0.0));
    real shrink = -exponent * ratio - R(0.152); /* 0.9 = 2^-0.152 */
    real keep = exponent * (R(0.25) * before - R(0.75) * ratio) - R(0.152);
    keep = smaller(keep, longer + exponent * (before - R(2.0) * ratio) - R(0.152));
    keep = larger(smaller(keep, pick(again, splat(0.0), splat(2.32))), splat(-2.32)); /* 1/5 to 5 */
    shrink = larger(smaller(shrink, splat(-0.152)), splat(-3.32));
    return exp2_rough(pick(accepted, keep, shrink));
}

/* What an attempt starts with: the current point, how far it may go, and whether it ends or starts at a kink. */
typedef struct {
    cpm_point at;
    real own, h;            /* the controller's sigma, the one that is tried */
    real cost;              /* evaluations, one beyond a kink among them */
    real exponent, lenient; /* of the pair that the lane takes (cpm_step_control) */
    real before;            /* log2 of the ratio at the step before; CPM_UNKNOWN */
    mask high;              /* that pair is 12(10) */
    mask going, to_kink, at_kink;
} cpm_attempt;

/* 8(6) or 12(10), lane by lane: long ways go by the latter, whose steps are CPM_RKN12_LONGER as long; what is left of a
 * way by fewer evaluations of the former. */
CPM_INLINE void cpm_choose_pair(cpm_lane_rays *rays, int part, real bound, cpm_attempt *a) {
    const real longer = splat(CPM_RKN12_LONGER);
    mask was = ~equal(load_doubles(rays->order, part), splat(0.0));
    a->high = less(pick(was, splat(CPM_RKN12_LEFT) * a->own, longer * a->own), bound);
    mask change = a->high ^ was;
    a->own = pick(change, pick(a->high, longer, R(1.0) / longer) * a->own, a->own);
    a->before = pick(change, splat(CPM_UNKNOWN), a->before);
    a->cost = pick(a->high, a->cost + R(CPM_RKN12_COST - CPM_RKN8_COST), a->cost),
    a->exponent = pick(a->high, splat(0.1), a->exponent);
    a->lenient = pick(a->high, splat(CPM_RKN12_LENIENT) * root(a->lenient), a->lenient);
    store_doubles(pick(a->going, pick(a->high, splat(1.0), splat(0.0)), load_doubles(rays->order, part)), rays->order,
                  part);
}

/* The same for the way to a lens's sphere: |r - centre|^2 of the piece behind, continued. */
CPM_INLINE real cpm_kink_on(const cpm_medium_data *m, const cpm_lane_rays *rays, int part, double rtol,
                            const cpm_point *a, real first) {
    if (!(CPM_IS_KIND(m, CPM_MEDIUM_LUNEBURG) || CPM_IS_KIND(m, CPM_MEDIUM_EATON))) return first;
    const real h = load_doubles(rays->piece_h, part);
    mask good = less(splat(0.0), load_doubles(rays->steps, part)) & less(first, R(2.0) * h);
    if (!any_lane(good)) return first;
    real radius0, radius1;
    const real3 p0 = load3_doubles(rays->p0, part), g0 = load3_doubles(rays->g0, part);
    real3 y0 = cpm_lens_radius(m, load3_doubles(rays->r0, part), &radius0), y1 = cpm_lens_radius(m, a->r, &radius1);
    cpm_ends e;
    e.d0 = R(2.0) * dot3(y0, p0), e.s0 = R(2.0) * (dot3(p0, p0) + dot3(y0, g0));
    e.d1 = R(2.0) * dot3(y1, a->p), e.s1 = R(2.0) * (dot3(a->p, a->p) + dot3(y1, a->g));
    e.rise = (radius1 - radius0) * (radius1 + radius0);
    /* to a hair before it, the sphere being where the ray leaves it (it moves outward there): */
    const real edge = R(m->high) - cpm_hair_of_sphere(m, cpm_hair(m, rtol), a->r);
    real there = cpm_go_on(&e, h, (edge - radius1) * (edge + radius1), first);
    return pick(good & less(radius1, edge), there, first);
}

CPM_INLINE cpm_attempt cpm_prepare(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                   cpm_lane_rays *rays, int part, mask going, int kinks) {
    cpm_attempt a;
    a.at.r = load3_doubles(rays->r, part), a.at.p = load3_doubles(rays->p, part), a.at.g = load3_doubles(rays->g, part);
    a.at.n = load_doubles(rays->n, part), a.at.scale = load_doubles(rays->scale, part);
    a.own = load_doubles(rays->h, part);
    a.going = going, a.to_kink = a.at_kink = splat_mask(0);
    a.cost = splat(c->cost);
    const real inverse_n = R(1.0) / a.at.n, length = load_doubles(rays->length, part);
    const real remaining = load_doubles(rays->target, part) - length;
    real bound = cpm_aim(&a.at, inverse_n, remaining);
    const mask aims = going & less(bound, R(2.0) * a.own) & ~load_flags(rays->at_kink, part); /* lane by lane */
    if (any_lane(aims)) bound = pick(aims, cpm_aim_on(rays, part, &a.at, remaining, bound), bound);
    bound = smaller(smaller(load_doubles(rays->limit, part), R(c->max_step) * inverse_n), bound);
    if (cpm_is_singular(m) && !(c->step > 0.0))
        bound = smaller(cpm_singular_distance(m, table, a.at.r) * inverse_n, bound);
    if (kinks) {
        mask at_kink = load_flags(rays->at_kink, part) & going, near;
        a.at_kink = at_kink;
        if (any_lane(at_kink)) {
            real ignored;
            real3 beyond = cpm_beyond_kink(m, table, c->rtol, &a.at);
            a.at.g = pick3(at_kink, cpm_field(m, table, beyond, a.at.scale, &ignored), a.at.g);
            a.cost = pick(at_kink, a.cost + R(1.0), a.cost);
        }
        real kink = cpm_next_kink(m, table, c->rtol, &a.at, &near);
        kink = pick(at_kink, kink, cpm_kink_on(m, rays, part, c->rtol, &a.at, kink));
        a.to_kink = less(kink, smaller(a.own, bound)) & less(R(1e-7) * a.own, kink); /* or steps would die out */
        bound = pick(a.to_kink, kink, bound);
    }
    a.exponent = splat(c->exponent), a.lenient = splat(c->lenient);
    a.before = load_doubles(rays->previous, part);
    a.high = splat_mask(0);
    if (c->high && !cpm_is_singular(m) && !cpm_is_table(m)) cpm_choose_pair(rays, part, bound, &a);
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
    mask blurred;       /* rounding of coordinates makes |p|^2 - n^2 worth little */
    mask usable, worth; /* finite, n > 0; within the tolerance */
} cpm_verdict;

/* How much larger than the tolerance nystrom's estimate may be, lane by lane. The embedded result of 8(6) and 12(10) is
 * far worse than the other in smooth fields only: across a knot, where the third derivative of n jumps, both have
 * errors of one size. There the estimate of the momentum, h p, comes near what the quintic lacks (trial.curve): 0.05 to
 * 0.08 of it with 8(6), 0.005 to 0.009 with 12(10), against 4e-3 (falling as h^2) and 1e-7 in smooth fields, by
 * experiment on both. So leniency ends there. In tables, whose knots are everywhere, it is less than 1: their errors
 * add up at random. Near a centre high orders are far from their asymptotes: the estimate is taken at its word. */
CPM_INLINE real cpm_nystrom_lenient(const cpm_step_control *c, const cpm_medium_data *m, const cpm_attempt *a,
                                    const cpm_trial *t) {
    if (c->order != 8) return a->lenient;
    const int table = cpm_is_table(m);
    /* below a thousandth of the tolerance nothing is rough (and floats too small may be 0 on one side, not the other)
     */
    real rough = a->h * root(t->error_momentum2) / (t->curve + R(1e-3 * fmax(c->rtol, CPM_LEAST_RTOL)) * t->way);
    rough = rough * pick(a->high, splat(CPM_RKN12_ROUGH), R(table ? CPM_RKN8_ROUGH_TABLE : CPM_RKN8_ROUGH) * rough);
    return a->lenient / larger(splat(1.0), a->lenient * smaller(rough, splat(table ? CPM_RKN_STRICT : 1.0)));
}

CPM_INLINE cpm_verdict cpm_judge(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                 const cpm_lane_rays *rays, int part, const cpm_attempt *a, const cpm_trial *t) {
    const real zero = splat(0.0), one = splat(1.0), n_start = load_doubles(rays->n_start, part);
    const real3 p = t->end.p, push = sub3(p, a->at.p);
    const real per_square = one / (t->end.n * t->end.n), size = dot3(p, p);
    cpm_verdict v;
    v.where = zero;
    v.turned = less(dot3(a->at.p, p), zero); /* only then can the chord of p pass near 0 */
    real way_error = t->error_way, least = R(CPM_CUTOFF) * n_start;
    if (any_lane(v.turned)) {
        v.turned &= less(cpm_least_momentum(a->at.p, p, &v.where), least * least);
        v.turned &= less(t->end.n, R(2.0) * larger(n_start, a->at.n)); /* a cut-off has n fall: not a centre met */
        way_error = pick(v.turned, zero, way_error); /* |p| has a kink there, n's quadrature is meaningless */
    }
    v.off = root(t->error_position2 + way_error * way_error);
    v.turn = root(t->error_momentum2) * (t->end.n * per_square);
    real excess = (size - t->end.n * t->end.n) * per_square;                /* |p|^2/n^2 - 1 */
    v.drift = magnitude(excess) / (R(2.0) + R(0.5) * larger(excess, -one)); /* sqrt(1 + x) - 1 to x^3/32 */
    const real weight = cpm_is_singular(m) ? larger(per_square, one) : per_square;
    const real carried = dot3(a->at.p, a->at.p) - a->at.n * a->at.n; /* was there before: no new error */
    v.growth = pick(v.turned, zero, R(0.5) * magnitude((size - t->end.n * t->end.n) - carried) * weight);
    v.far = magnitude(t->end.r.x) + magnitude(t->end.r.y) + magnitude(t->end.r.z);

    /* What the tolerance and rounding allow. */
    real slope =
        magnitude(t->end.r.x * t->end.g.x) + magnitude(t->end.r.y * t->end.g.y) + magnitude(t->end.r.z * t->end.g.z);
    real noise = R(10.0 * CPM_ROUNDING) * (one + (larger(n_start * n_start, one) + slope) * weight);
    v.blurred = less(splat(CPM_NOISE), noise);
    noise += cpm_kink_noise(m, table, c->rtol, t->end.r);
    real along = dot3(push, p); /* no push at all: a = 90 degrees, the strictest */
    real slant = log2_rough(along * along) - log2_rough(dot3(push, push) * size + R(1e-30));
    /* cos a, 0.03 to 1; of layers, where the force has one direction and no error another, as it is */
    const int layers = CPM_IS_KIND(m, CPM_MEDIUM_LAYERED) || CPM_IS_KIND(m, CPM_MEDIUM_SHELLS);
    slant = exp2_rough(smaller(larger(R(0.5) * slant, splat(layers ? -8.0 : -5.0)), zero));
    const double rtol = fmax(c->rtol, CPM_LEAST_RTOL);
    /* what rounding of n makes arc length and direction unsure of; bounded, or a step could leap over a place where n =
     * 0 */
    const real round_off = smaller(R(0.1) * noise, splat(CPM_SINGLE ? 1e-3 : 1e-6));
    real lenient = c->method == CPM_STEP_NYSTROM ? cpm_nystrom_lenient(c, m, a, t) : a->lenient;
    if (cpm_is_singular(m))
        lenient = smaller(lenient, one); /* high orders are far from their asymptotes near a centre */
    real may_off = (lenient * R(rtol) + round_off) * t->way, may_grow = R(c->grow * rtol) * slant + noise;
    if (c->atol > 0.0) {
        real expected = load_doubles(rays->expected, part);
        real share = pick(less(zero, expected), smaller(t->way / larger(expected, splat(1e-30)), one), splat(0.1));
        may_off += lenient * R(c->atol) * share;
    }
    real ratio = larger(v.off * may_grow, v.growth * may_off) / (may_off * may_grow);
    ratio = larger(ratio, v.turn / (lenient * R(rtol) + round_off));
    /* a change of n that no force of the step accounts for: a layer was leapt over that may turn by sqrt(2 dn) */
    real unseen = v.growth - noise - (R(2.0) * magnitude(along) + dot3(push, push)) * per_square;
    if (cpm_has_kinks(m, c->rtol)) unseen -= R(0.004 * rtol); /* what n changes by in a hair before a kink and beyond */
    if (!cpm_is_singular(m)) ratio = larger(ratio, root(R(2.0) * larger(unseen, zero)) * R(0.5 / rtol));
    if (c->dense) ratio = larger(ratio, R(1.0 / 64) * t->dense * lenient / may_off);
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
    const real longer = log2_rough(a->h / larger(load_doubles(rays->piece_h, part), R(1e-30) * a->h + R(1e-37)));
    real next = a->h * (CPM_IS_METHOD(c, CPM_STEP_ADAMS)
                            ? cpm_adams_plan(rays, part, v->ratio, accepted, load_doubles(rays->refused, part))
                            : cpm_step_factor(a->exponent, v->ratio, a->before, longer, accepted, again));
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

/* Lane by lane one trial or another. */
CPM_INLINE void cpm_trial_take(cpm_trial *t, const cpm_trial *other, mask from) {
    t->end.r = pick3(from, other->end.r, t->end.r), t->end.p = pick3(from, other->end.p, t->end.p);
    t->end.g = pick3(from, other->end.g, t->end.g), t->end.n = pick(from, other->end.n, t->end.n);
    t->way = pick(from, other->way, t->way), t->path = pick(from, other->path, t->path);
    t->error_position2 = pick(from, other->error_position2, t->error_position2);
    t->error_way = pick(from, other->error_way, t->error_way);
    t->error_momentum2 = pick(from, other->error_momentum2, t->error_momentum2);
    t->dense = pick(from, other->dense, t->dense), t->curve = pick(from, other->curve, t->curve);
    t->good = pick_mask(from, other->good, t->good);
}

#if CPM_SINGLE
/* Moves one coordinate on in double: the piece's start, then r += h p + bend, p += push where accepted. */
CPM_INLINE void cpm_keep_axis(double *r0, double *p0, double *r, double *p, int part, broad h, real bend, real push) {
    broad at = load_broad(r, part), momentum = load_broad(p, part);
    store_broad(at, r0, part);
    store_broad(momentum, p0, part);
    store_broad(at + (h * momentum + to_broad(bend)), r, part);
    store_broad(momentum + to_broad(push), p, part);
}
CPM_INLINE void cpm_keep_broad(cpm_lane_rays *rays, int part, const cpm_trial *t, mask accepted, real piece_h) {
    const real zero = splat(0.0);
    const real3 none = triple(zero, zero, zero), bend = pick3(accepted, t->bend, none),
                push = pick3(accepted, t->push, none);
    const broad h = to_broad(pick(accepted, piece_h, zero));
    cpm_keep_axis(rays->r0[0], rays->p0[0], rays->r[0], rays->p[0], part, h, bend.x, push.x);
    cpm_keep_axis(rays->r0[1], rays->p0[1], rays->r[1], rays->p[1], part, h, bend.y, push.y);
    cpm_keep_axis(rays->r0[2], rays->p0[2], rays->r[2], rays->p[2], part, h, bend.z, push.z);
    const broad length = load_broad(rays->length, part), path = load_broad(rays->optical_path, part);
    store_broad(length, rays->length0, part);
    store_broad(path, rays->optical_path0, part);
    store_broad(length + to_broad(pick(accepted, t->way, zero)), rays->length, part);
    store_broad(path + to_broad(pick(accepted, t->path, zero)), rays->optical_path, part);
}
#endif

/* Moves the accepted lanes on, and leaves their piece behind. */
CPM_INLINE void cpm_keep(cpm_lane_rays *rays, int part, int method, const cpm_attempt *a, const cpm_trial *t,
                         const cpm_verdict *v, mask accepted, real piece_h) {
    const real error_turn = load_doubles(rays->error_turn, part);
#if CPM_SINGLE
    cpm_keep_broad(rays, part, t, accepted, piece_h);
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
    CPM_KEEP(drift_now, v->drift);
    CPM_KEEP(drift, larger(load_doubles(rays->drift, part), v->drift));
    CPM_KEEP(error, load_doubles(rays->error, part) + v->off + error_turn * t->way);
    CPM_KEEP(error_turn, error_turn + v->turn);
    if (method >= CPM_STEP_NYSTROM) CPM_KEEP(dense, t->dense);
    if (method >= CPM_STEP_LEAPFROG)
        for (int k = 0; k < 6; k++) CPM_KEEP(low[k], load_doubles(rays->low_next[k], part));
    if (((CPM_METHODS >> CPM_STEP_ADAMS) & 1) && method == CPM_STEP_ADAMS)
        cpm_adams_keep(rays, part, &a->at, a->h, accepted);
#undef CPM_KEEP
    store_flags(a->to_kink & accepted, rays->at_kink, part);
    store_flags(accepted, rays->accepted, part);
}

/* Adds to a count: in double, for floats stop at 2^24. */
CPM_INLINE void cpm_count(double *count, int part, real more) {
#if CPM_SINGLE
    store_broad(load_broad(count, part) + to_broad(more), count, part);
#else
    store_doubles(load_doubles(count, part) + more, count, part);
#endif
}

/* The methods beside which the others' code is not to grow. */
CPM_APART cpm_trial cpm_step_apart(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                   cpm_lane_rays *rays, int part, const cpm_attempt *a) {
    if (CPM_IS_METHOD(c, CPM_STEP_ADAMS)) return cpm_step_adams(m, table, rays, part, &a->at, a->h, a->at_kink);
    if (CPM_IS_METHOD(c, CPM_STEP_LEAPFROG)) return cpm_step_symplectic(m, table, rays, part, &a->at, a->h, 0);
    if (CPM_IS_METHOD(c, CPM_STEP_YOSHIDA6)) return cpm_step_symplectic(m, table, rays, part, &a->at, a->h, 1);
#if (CPM_METHODS >> CPM_STEP_NYSTROM) & 1
    if (c->order == 6) return cpm_rkn6_step(m, table, &a->at, a->h);
#if !CPM_SINGLE
    if (any_lane(a->high & a->going)) {
        cpm_trial far = cpm_rkn12_step(m, table, &a->at, a->h);
        if (!any_lane(~a->high & a->going)) return far;
        cpm_trial t = cpm_rkn8_step(m, table, &a->at, a->h);
        cpm_trial_take(&t, &far, a->high);
        return t;
    }
#endif
    return cpm_rkn8_step(m, table, &a->at, a->h);
#else
    return cpm_step_symplectic(m, table, rays, part, &a->at, a->h, 0); /* not reached */
#endif
}

CPM_INLINE void cpm_lanes_attempt_part(const cpm_step_control *c, const cpm_medium_data *m,
                                       CPM_GLOBAL const double *table, cpm_lane_rays *rays, int part) {
    const real zero = splat(0.0), one = splat(1.0);
    const int kinks = cpm_has_kinks(m, c->rtol) && !(c->step > 0.0);
    mask status = load_flags(rays->status, part), going = less(status, splat_mask(0));
    store_flags(splat_mask(0), rays->accepted, part);
    if (!any_lane(going)) return;
    const real evaluations = load_doubles(rays->evaluations, part);
    mask spent = going & less(splat(c->max_evaluations - (c->high ? CPM_RKN12_COST : c->cost) - kinks), evaluations);
    status = pick_mask(spent, splat_mask(CPM_ENDED_EXHAUSTED), status);
    going &= ~spent;

    const cpm_attempt a = cpm_prepare(c, m, table, rays, part, going, kinks);
    cpm_trial t;
    if (CPM_IS_METHOD(c, CPM_STEP_EULER))
        t = cpm_step_euler(m, table, &a.at, a.h);
    else if (CPM_IS_METHOD(c, CPM_STEP_RK4))
        t = cpm_step_rk4(m, table, &a.at, a.h);
    else if (CPM_IS_METHOD(c, CPM_STEP_DOPRI5))
        t = cpm_step_dopri5(m, table, &a.at, a.h);
    else
        t = cpm_step_apart(c, m, table, rays, part, &a);
    if (CPM_SINGLE && c->method != CPM_STEP_EULER && c->method != CPM_STEP_RK4 && c->method != CPM_STEP_DOPRI5) {
        t.bend =
            sub3(sub3(t.end.r, a.at.r), scale3(a.h, a.at.p)); /* these say where they end, not how they get there */
        t.push = sub3(t.end.p, a.at.p);
    }
    cpm_verdict v = cpm_judge(c, m, table, rays, part, &a, &t);
    mask accepted = going & v.usable & v.worth, refused = going & ~accepted;
    cpm_plan(c, rays, part, &a, &v, accepted);

    mask cut = accepted & (v.turned | less(t.end.n, R(CPM_CUTOFF) * load_doubles(rays->n_start, part)));
    mask backward = cut & v.turned;
    real piece_h = pick(backward, v.where * a.h, a.h);
    if (any_lane(backward)) {
        cpm_end_at_turn(&a, backward, piece_h, v.where, &t);
        v.drift = pick(backward, zero, v.drift);
    }
    if (c->method == CPM_STEP_RK4 || c->method >= CPM_STEP_LEAPFROG)
        v.turn = magnitude(v.growth); /* no estimate of its own */
    cpm_keep(rays, part, c->method, &a, &t, &v, accepted, piece_h);
    cpm_count(rays->steps, part, pick(accepted, one, zero));
    cpm_count(rays->rejected, part, pick(refused, one, zero));
    cpm_count(rays->evaluations, part, pick(going, a.cost, zero));
    real running = pick(accepted, zero, load_doubles(rays->refused, part) + one);
    store_doubles(running, rays->refused, part);

    /* Does it end? */
    real3 moved = sub3(t.end.r, a.at.r);
    mask still = accepted & equal(moved.x, zero) & equal(moved.y, zero) & equal(moved.z, zero);
    if (CPM_SINGLE) still = accepted & ~less(zero, t.way); /* the double sum may move where a float does not */
    mask stuck = (refused & less(splat(CPM_MAX_REFUSED), running)) | still;
    mask why = pick_mask(t.good, splat_mask(CPM_ENDED_UNDERFLOW), splat_mask(CPM_ENDED_CUTOFF));
    mask caught = splat_mask(0);
    if (cpm_is_singular(m)) {
        real n_start = load_doubles(rays->n_start, part);
        caught = accepted & (less(R(CPM_CAPTURE) * n_start, t.end.n) | (v.blurred & less(n_start, t.end.n)));
        why = pick_mask(t.good & less(R(2.0) * n_start, a.at.n), splat_mask(CPM_ENDED_CAPTURED), why);
    }
    status = pick_mask(stuck, why, status);
    status = pick_mask(accepted & less(splat(0.1 * CPM_FAR), v.far), splat_mask(CPM_ENDED_LEFT), status);
    status = pick_mask(cut, splat_mask(CPM_ENDED_CUTOFF), status);
    status = pick_mask(caught, splat_mask(CPM_ENDED_CAPTURED), status);
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
