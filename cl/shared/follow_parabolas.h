/* shared/follow_parabolas.h: flights in a medium of linear n^2, lanes abreast: only what most photons are: one
 * parabola, one chord, one hit. Whatever else may be (a cut-off, a start that looks back, nothing met, the extent
 * crossed) is left to follow_exact.h, which asks anew. */
#ifndef CPM_SHARED_FOLLOW_PARABOLAS_H
#define CPM_SHARED_FOLLOW_PARABOLAS_H
#include "follow_exact.h"

typedef struct cpm_parabola_starts {
    real r[3], d[3], a[3]; /* position, direction, gradient of n^2/2: dp/dsigma */
    real n;
} cpm_parabola_starts;

/* sigma at which p t + a t^2/2 = way, the first crossing ahead; *met: there is one. */
CPM_INLINE real cpm_parabola_crossing(real p, real a, real way, mask *met) {
    real d = p * p + R(2.0) * a * way, bent = root(pick(less(splat(0.0), d), d, splat(0.0)));
    *met = at_most(splat(0.0), d);
    return R(2.0) * way / (p + pick(less(splat(0.0), p), bent, -bent));
}

/* How far to go, in sigma: out of the geometry's box, or as far as the scene is large. A parabola that turns before a
 * face goes out at another, or is longer than it need be. NaN: not for here. c1, c2: the curve's coefficients. */
CPM_INLINE real cpm_parabola_reach(const cpm_world *w, const cpm_parabola_starts *s, real c1[3], real c2[3]) {
    const cpm_world_frame *f = &w->frame;
    const real n = s->n, zero = splat(0.0);
    real leave = splat(INFINITY), away2 = zero, pg = zero, gg = zero;
    for (int k = 0; k < 3; k++) {
        const real p = n * s->d[k], a = s->a[k], off = s->r[k] - R(f->center[k]);
        mask met;
        real t = cpm_parabola_crossing(
            p, a, pick(less(zero, p), R(f->box_high[k]) - s->r[k], R(f->box_low[k]) - s->r[k]), &met);
        leave = pick(met & at_most(zero, t) & less(t, leave), t, leave);
        away2 += off * off;
        pg += p * a, gg += a * a;
    }
    const real least = R(1e-6) * n, far2 = splat(f->reach * f->reach);
    const real limit = root(pick(less(far2, away2), away2, far2)) / n, margin = R(1e-6 * f->reach) / n;
    const mask cut = less(pg, zero) & less((n * n - least * least) * gg, pg * pg); /* |p| may fall to 0 */
    const real farthest = leave * R(1.0 + 1e-6) + margin, h = pick(less(limit, farthest), limit, farthest);
    for (int k = 0; k < 3; k++) {
        c1[k] = h * (n * s->d[k]);
        c2[k] = R(0.5) * h * h * s->a[k];
    }
    return pick(less(zero, n) & ~cut, h, splat(NAN));
}

/* Where one that starts outside comes into the box, as theta of [0, h]; 0: not known. */
CPM_INLINE real cpm_parabola_entry(const cpm_world *w, const cpm_parabola_starts *s, real h) {
    const cpm_world_frame *f = &w->frame;
    const real n = s->n, zero = splat(0.0);
    real enter = zero;
    for (int k = 0; k < 3; k++) {
        const real p = n * s->d[k];
        mask met;
        real t = cpm_parabola_crossing(
            p, s->a[k], pick(less(zero, p), R(f->box_low[k]) - s->r[k], R(f->box_high[k]) - s->r[k]), &met);
        enter = pick(met & less(enter, t), t, enter);
    }
    real from = larger(enter * R(1.0 - 1e-6) - R(1e-6 * f->reach) / n, zero) / h;
    return pick(less(from, splat(1.0)), from, zero);
}

CPM_INLINE int world_box_holds(const double low[3], const double high[3], cpm_vec r) {
    return (r.x >= low[0]) & (r.x <= high[0]) & (r.y >= low[1]) & (r.y <= high[1]) & (r.z >= low[2]) & (r.z <= high[2]);
}

/* What the hit (if any) of one parabola, of sigma `h`, makes of its flight. Returns 0 where it is not all told:
 * follow_exact.h has to go on from `on`, with one step more if *stepped. */
CPM_INLINE int world_end_of_parabola(const cpm_world *w, cpm_i32 medium, const cpm_flight *flight, const cpm_curve *c,
                                     double h, const cpm_hit *hit, cpm_arrival *arrival, cpm_flight *on, int *stepped) {
    const cpm_vec end = cpm_add(c->c[0], cpm_add(c->c[1], c->c[2]));
    const int hits = hit->primitive >= 0, stays = world_box_holds(w->frame.low, w->frame.high, end);
    const double t = hits ? hit->t : 1.0;
    const cpm_vec tangent = cpm_along(c->c[1], 2.0 * t, c->c[2]);
    const double speed = cpm_norm(tangent);
    cpm_arrival_begin(flight, arrival);
    arrival->n = speed / h; /* |p| */
    arrival->steps = 1.0;
    if (hits && stays) {
        arrival->status = CPM_ARRIVAL_HIT;
        arrival->hit = *hit;
        arrival->direction = cpm_scaled(1.0 / speed, tangent);
        return 1;
    }
    *on = *flight, *stepped = 0;
    if (!stays) return 0;
    if (world_leaves_after(w, flight, medium, end, tangent, arrival)) return 1;
    on->position = end,
    on->direction = cpm_scaled(1.0 / speed, tangent); /* nothing met: on, with a look back at the seam */
    on->left = -1, on->crossing = 1;
    *stepped = 1;
    return 0;
}

/* Flights that are to be followed together, in lanes. */
typedef struct cpm_parabola_lot {
    double r[3][CPM_WIDTH], d[3][CPM_WIDTH], a[3][CPM_WIDTH], n[CPM_WIDTH];
    double h[CPM_WIDTH], from[CPM_WIDTH], c1[3][CPM_WIDTH], c2[3][CPM_WIDTH];
    cpm_i64 which[CPM_WIDTH];
    int count, outside; /* does any start outside of the geometry's box? */
} cpm_parabola_lot;

/* A flight into the lot; `n_squared` there comes back. */
CPM_INLINE double world_add_parabola(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                     const cpm_flight *flight, cpm_parabola_lot *l) {
    const int i = l->count;
    const double scale = world_scale(w, flight, medium);
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    double susceptibility = m->value;
    for (int k = 0; k < 3; k++) {
        l->r[k][i] = r[k], l->d[k][i] = d[k];
        l->a[k][i] = 0.5 * scale * m->axis[k];
        susceptibility += m->axis[k] * (r[k] - m->origin[k]);
    }
    l->n[i] = 1.0 + scale * susceptibility;
    return l->n[i];
}

/* Sigma of each parabola, where it may first be met, and its coefficients. */
CPM_INLINE void world_start_parabolas(const cpm_world *w, cpm_parabola_lot *l) {
    cpm_parabola_starts s;
    real c1[3], c2[3];
    for (int i = l->count; i < CPM_WIDTH; i++) { /* lanes that nobody uses: as the first */
        for (int k = 0; k < 3; k++) l->r[k][i] = l->r[k][0], l->d[k][i] = l->d[k][0], l->a[k][i] = l->a[k][0];
        l->n[i] = l->n[0];
    }
    for (int k = 0; k < 3; k++)
        s.r[k] = load_doubles(l->r[k], 0), s.d[k] = load_doubles(l->d[k], 0), s.a[k] = load_doubles(l->a[k], 0);
    s.n = root(load_doubles(l->n, 0)); /* it was n^2 */
    const real h = cpm_parabola_reach(w, &s, c1, c2);
    store_doubles(h, l->h, 0);
    store_doubles(l->outside ? cpm_parabola_entry(w, &s, h) : splat(0.0), l->from, 0);
    for (int k = 0; k < 3; k++) store_doubles(c1[k], l->c1[k], 0), store_doubles(c2[k], l->c2[k], 0);
}

CPM_INLINE cpm_curve cpm_parabola_curve(const cpm_parabola_lot *l, int i) {
    cpm_curve c;
    c.degree = 2, c.padding = 0;
    c.c[0] = cpm_v(l->r[0][i], l->r[1][i], l->r[2][i]);
    c.c[1] = cpm_v(l->c1[0][i], l->c1[1][i], l->c1[2][i]);
    c.c[2] = cpm_v(l->c2[0][i], l->c2[1][i], l->c2[2][i]);
    return c;
}

#ifndef CPM_HOST_LANES /* the host's loop asks all curves of a larger lot at once */
typedef struct cpm_untested {
    cpm_i32 curve, primitive;
} cpm_untested;

/* The first hit of a parabola for theta in (0, 1], but that of a few primitives, added to `untested`; `from`: theta
 * before which it is outside of the geometry's box. */
CPM_INLINE void world_walk_parabola(const cpm_world *w, cpm_i32 number, const cpm_curve *c, double from, cpm_i32 left,
                                    cpm_hit *hit, cpm_untested *untested, int *waiting) {
    const cpm_tree *tree = &w->tree;
    const cpm_vec strays = cpm_curve_strays(c, 1.0 - from);
    cpm_query q;
    hit->primitive = -1;
    if (!tree->nodes) return;
    cpm_query_begin(&q, tree, c, left, 0.0, (const cpm_filter *)0);
    q.chord.a = from > 0.0 ? from - CPM_OVERLAP : 0.0, q.chord.b = 1.0;
    q.chord.start = from > 0.0 ? cpm_curve_at(c, from) : c->c[0], q.chord.end = cpm_curve_at(c, 1.0);
    q.chord.off = cpm_grown(tree, strays);
    if (cpm_vdot(strays, strays) > tree->frame.sagitta * tree->frame.sagitta || !cpm_is_near_box(tree, q.chord.start) ||
        !cpm_is_near_box(tree, q.chord.end)) {
        cpm_first_hit(tree, c, 1.0, left, 0.0, (const cpm_filter *)0, hit);
        return;
    }
    cpm_walk(&q, 1);
    *hit = q.best;
    for (int i = 0; i < q.waiting; i++, ++*waiting)
        untested[*waiting].curve = number, untested[*waiting].primitive = q.untested[i];
}

/* What was left untested, then every hit's place. */
CPM_INLINE void world_test_parabolas(const cpm_world *w, const cpm_curve *curves, const double *from,
                                     const cpm_i32 *left, int count, const cpm_untested *untested, int waiting,
                                     cpm_hit *hits) {
    for (int k = 0; k < waiting; k++) {
        const cpm_i32 i = untested[k].curve, primitive = untested[k].primitive;
        const double a = from[i] > 0.0 ? from[i] - CPM_OVERLAP : 0.0;
        cpm_hit *hit = &hits[i];
        double u = 0.0, v = 0.0, t = cpm_first_root(&w->tree, &curves[i], primitive, left[i], a, 1.0, &u, &v);
        const int nearer = (hit->primitive < 0) | (t < hit->t) | ((t == hit->t) & (primitive < hit->primitive));
        if ((t > -1.0) & nearer) hit->primitive = primitive, hit->t = t, hit->u = u, hit->v = v;
    }
    for (int i = 0; i < count; i++)
        if (hits[i].primitive >= 0) hits[i].position = cpm_curve_at(&curves[i], hits[i].t);
}

CPM_INLINE void world_follow_lot(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                 CPM_GLOBAL const double *table, CPM_GLOBAL const cpm_flight *flights,
                                 CPM_GLOBAL cpm_arrival *arrivals, cpm_parabola_lot *l) {
    cpm_curve curves[CPM_WIDTH];
    cpm_hit hits[CPM_WIDTH];
    cpm_i32 left[CPM_WIDTH];
    cpm_untested untested[CPM_WIDTH * CPM_UNTESTED];
    int waiting = 0;
    if (!l->count) return;
    world_start_parabolas(w, l);
    for (int i = 0; i < l->count; i++) {
        left[i] = flights[l->which[i]].left;
        hits[i].primitive = -1;
        curves[i] = cpm_parabola_curve(l, i);
        if (l->h[i] > 0.0) world_walk_parabola(w, i, &curves[i], l->from[i], left[i], &hits[i], untested, &waiting);
    }
    world_test_parabolas(w, curves, l->from, left, l->count, untested, waiting, hits);
    for (int i = 0; i < l->count; i++) {
        cpm_flight flight = flights[l->which[i]], on = flight;
        cpm_arrival arrival;
        int stepped = 0;
        const int told = l->h[i] > 0.0 && world_end_of_parabola(w, medium, &flight, &curves[i], l->h[i], &hits[i],
                                                                &arrival, &on, &stepped);
        if (!told) {
            world_follow_exact(w, medium, m, table, &on, &arrival);
            arrival.steps += stepped ? 1.0 : 0.0;
        }
        arrivals[l->which[i]] = arrival;
    }
    l->count = 0, l->outside = 0;
}

/* Flights first..last - 1, those of them that start in medium `medium`, which is `m`. */
CPM_INLINE void world_follow_parabolas(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                       CPM_GLOBAL const double *table, CPM_GLOBAL const cpm_flight *flights,
                                       CPM_GLOBAL cpm_arrival *arrivals, cpm_i64 first, cpm_i64 last) {
    cpm_parabola_lot l;
    l.count = l.outside = 0;
    for (cpm_i64 i = first; i < last; i++) {
        cpm_flight flight = flights[i];
        cpm_arrival arrival;
        if (cpm_region_medium(&flight.region) != medium) continue;
        if (flight.crossing) { /* looks back */
            world_follow_exact(w, medium, m, table, &flight, &arrival);
            arrivals[i] = arrival;
            continue;
        }
        const double n_squared = world_add_parabola(w, medium, m, &flight, &l);
        cpm_arrival_begin(&flight, &arrival);
        if (world_has_left(w, &flight, medium, &arrival)) {
            arrival.n = sqrt(n_squared);
            arrivals[i] = arrival;
            continue;
        }
        l.outside |= !world_box_holds(w->frame.box_low, w->frame.box_high, flight.position);
        l.which[l.count] = i;
        if (++l.count == CPM_WIDTH) world_follow_lot(w, medium, m, table, flights, arrivals, &l);
    }
    world_follow_lot(w, medium, m, table, flights, arrivals, &l);
}
#endif
#endif
