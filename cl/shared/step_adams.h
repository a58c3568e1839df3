/* shared/step_adams.h: Adams-Bashforth-Moulton of variable step and order, PECE, 2 evaluations a step.
 *
 * Of g at the current point and up to 12 before it, x_0 = 0 > x_1 > ... in units of the step h, Newton's polynomial has
 * the divided differences D_j. As r'' = g and p' = g,
 *
 *   predicted   p + h sum_j D_j F_j1,   r + h p + h^2 sum_j D_j F_j2,   j < k                                      (1)
 *   F_jq = int_0^1 (1 - x)^(q-1)/(q-1)! prod_{i<j} (x - x_i) dx,   F_0q = 1/q!
 *   F_{j+1,q} = (1 - x_j) F_jq - q F_{j,q+1}                                                                       (2)
 *
 * g there adds the node x = 1: E = (g - sum_j D_j prod_{i<j} (1 - x_i)) / prod_{i<k} (1 - x_i), and the correction is
 * h E F_k1 and h^2 E F_k2, of order k + 1. The same without the oldest node differs by
 *
 *   h E (F_k1 + (x_{k-1} - 1) F_{k-1,1})                                                                           (3)
 *
 * (h^2, F_.2 for the position): the embedded error, of order k. Differences of other orders from the same table tell
 * whether one order less or more would allow a longer step. Arc length (n) and optical path (n^2) are two more
 * components. A kink of grad n forgets the past. Shampine & Gordon, Computer solution of ordinary differential
 * equations (1975), gives the strategy; the double integral is Stormer's. */
#ifndef CPM_SHARED_STEP_ADAMS_H
#define CPM_SHARED_STEP_ADAMS_H
#include "../types/lanes.h"
#include "step_trial.h"

#define CPM_ADAMS_PARTS 5 /* components: g, n, n^2 */

CPM_INLINE void cpm_adams_load(const cpm_lane_rays *rays, int part, int j, real v[CPM_ADAMS_PARTS]) {
    for (int k = 0; k < 4; k++) v[k] = load_doubles(rays->past[j][k], part);
    v[4] = v[3] * v[3];
}

CPM_INLINE cpm_trial cpm_step_adams(const cpm_medium_data *m, CPM_GLOBAL const double *table, cpm_lane_rays *rays,
                                    int part, const cpm_point *a, real h, mask forget) {
    const real zero = splat(0.0), one = splat(1.0);
    const real kept = pick(forget, zero, load_doubles(rays->kept, part)); /* points before the current one */
    real order = smaller(larger(load_doubles(rays->order, part), one), kept + one);
    store_doubles(order, rays->order, part);
    store_doubles(kept, rays->kept, part);
    int most = 0; /* table to build: the highest order of the lanes, and one more to look at */
    double column[CPM_LANES];
    store_doubles(order, column, 0);
    for (int i = 0; i < CPM_WIDTH; i++) most = (int)column[i] > most ? (int)column[i] : most;
    if (most > CPM_ADAMS_ORDER - 1) most = CPM_ADAMS_ORDER - 1;
    const int rows = most + 1; /* nodes 0..most */

    real x[CPM_ADAMS_ORDER], d[CPM_ADAMS_ORDER][CPM_ADAMS_PARTS], f[CPM_ADAMS_ORDER + 3];
    const real per_h = one / larger(h, splat(1e-30));
    x[0] = zero;
    d[0][0] = a->g.x, d[0][1] = a->g.y, d[0][2] = a->g.z, d[0][3] = a->n, d[0][4] = a->n * a->n;
    for (int j = 1; j < rows; j++) {
        mask there = at_most(splat(j), kept);
        x[j] = pick(there, load_doubles(rays->past_sigma[j - 1], part) * per_h, splat(-j));
        cpm_adams_load(rays, part, j - 1, d[j]);
        for (int k = 0; k < CPM_ADAMS_PARTS; k++) d[j][k] = pick(there, d[j][k], zero);
    }
    for (int level = 1; level < rows; level++)
        for (int j = rows - 1; j >= level; j--) {
            real per = one / (x[j] - x[j - level]);
            for (int k = 0; k < CPM_ADAMS_PARTS; k++) d[j][k] = (d[j][k] - d[j - 1][k]) * per;
        }

    /* Predictor (1), and what the corrector needs of the lane's own order k. */
    real sum1[CPM_ADAMS_PARTS], sum2[3], value[CPM_ADAMS_PARTS], product = one;
    real own_f1 = zero, own_f2 = zero, own_product = one, own_x = zero, before_f1 = zero, before_f2 = zero;
    real lower_f1 = zero, higher_f1 = zero, lower_x = zero, higher_x = zero, last_f1 = zero, last_f2 = zero,
         last2_f1 = zero;
    real last_d[4], higher_d[4];
    for (int k = 0; k < 3; k++) sum2[k] = zero;
    for (int k = 0; k < 4; k++) last_d[k] = higher_d[k] = zero;
    for (int k = 0; k < CPM_ADAMS_PARTS; k++) sum1[k] = value[k] = zero;
    f[0] = one; /* f[q - 1] = F_jq, j = 0 */
    for (int q = 2; q <= rows + 2; q++) f[q - 1] = f[q - 2] * splat(1.0 / q);
    for (int j = 0; j <= rows; j++) {
        mask used = less(splat(j), order), now = equal(splat(j), order), above = equal(splat(j - 1), order);
        own_f1 = pick(now, f[0], own_f1), own_f2 = pick(now, f[1], own_f2), own_product = pick(now, product, own_product);
        before_f1 = pick(now, last_f1, before_f1), before_f2 = pick(now, last_f2, before_f2);
        lower_f1 = pick(now, last2_f1, lower_f1);
        higher_f1 = pick(above, f[0], higher_f1);
        if (j > 0) own_x = pick(now, x[j - 1], own_x), higher_x = pick(above, x[j - 1], higher_x);
        if (j > 1) lower_x = pick(now, x[j - 2], lower_x);
        if (j == rows) break;
        for (int k = 0; k < 3; k++) sum2[k] += pick(used, d[j][k] * f[1], zero);
        for (int k = 0; k < 4; k++) {
            last_d[k] = pick(used, d[j][k], last_d[k]);
            higher_d[k] = pick(now, d[j][k], higher_d[k]);
        }
        for (int k = 0; k < CPM_ADAMS_PARTS; k++) {
            sum1[k] += pick(used, d[j][k] * f[0], zero);
            value[k] += pick(used, d[j][k] * product, zero);
        }
        last2_f1 = last_f1, last_f1 = f[0], last_f2 = f[1];
        product *= one - x[j];
        for (int q = 1; q <= rows + 1 - j; q++) f[q - 1] = (one - x[j]) * f[q - 1] - splat(q) * f[q]; /* (2) */
    }

    /* Evaluate, correct, evaluate. */
    cpm_trial t;
    const real hh = h * h;
    real n, e[CPM_ADAMS_PARTS];
    real3 r = add3(add3(a->r, h, a->p), hh, triple(sum2[0], sum2[1], sum2[2]));
    real3 g = cpm_field(m, table, r, a->scale, &n);
    t.good = less(zero, n) & at_most(zero, hh);
    e[0] = g.x, e[1] = g.y, e[2] = g.z, e[3] = n, e[4] = n * n;
    const real per_product = one / own_product;
    for (int k = 0; k < CPM_ADAMS_PARTS; k++) e[k] = (e[k] - value[k]) * per_product;
    const real3 change = triple(e[0], e[1], e[2]);
    t.end.r = add3(r, hh * own_f2, change);
    t.end.p = add3(add3(a->p, h, triple(sum1[0], sum1[1], sum1[2])), h * own_f1, change);
    t.way = h * (sum1[3] + own_f1 * e[3]);
    t.path = h * (sum1[4] + own_f1 * e[4]);
    t.end.g = cpm_field(m, table, t.end.r, a->scale, &t.end.n);
    t.end.scale = a->scale;
    t.good &= less(zero, t.end.n);

    /* Errors: (3), and the same at one order less and more. */
    const real own = own_f1 + (own_x - one) * before_f1, own2 = own_f2 + (own_x - one) * before_f2;
    const real size2 = dot3(change, change);
    t.error_position2 = hh * hh * own2 * own2 * size2;
    t.error_momentum2 = hh * own * own * size2;
    t.error_way = h * own * e[3];
    real same2 = zero, less2 = zero, more2 = zero, per_more = one / (one - higher_x);
    for (int k = 0; k < 4; k++) { /* (h g, n): on a parabola only n has an error */
        real weight = k < 3 ? hh : one, less_d = last_d[k] + (one - own_x) * e[k], more_d = (e[k] - higher_d[k]) * per_more;
        same2 += weight * e[k] * e[k], less2 += weight * less_d * less_d, more2 += weight * more_d * more_d;
    }
    const real lower = before_f1 + (lower_x - one) * lower_f1, higher = higher_f1 + (higher_x - one) * own_f1;
    const real tiny = splat(1e-30), here = log2_rough(own * own * same2 + tiny);
    real down = R(0.5) * (log2_rough(lower * lower * less2 + tiny) - here);
    real up = R(0.5) * (log2_rough(higher * higher * more2 + tiny) - here);
    store_doubles(pick(less(one, order), down, splat(100.0)), rays->lower, part);
    store_doubles(pick(at_most(order, smaller(kept, splat(CPM_ADAMS_ORDER - 1.0))), up, splat(100.0)), rays->higher, part);
    /* r'''''' = g'''': the quintic lacks 24 D_4 h^6/720, where the table reaches so far */
    t.dense = zero; /* a lane's own order and past decide: the table is as long as the longest beside it wants */
    if (rows > 4)
        t.dense = pick(at_most(splat(4.0), smaller(order, kept)),
                       hh * root(d[4][0] * d[4][0] + d[4][1] * d[4][1] + d[4][2] * d[4][2]) * R(1.0 / 30), zero);
    t.curve = splat(0.0);
    t.dense = larger(t.dense, R(64.0) * root(t.error_position2));
    return t;
}

/* The order and the factor of the next step; `ratio`: log2 of error to tolerance. The order that allows the longest
 * step; without a past of order + 1 points the step doubles and the order grows. */
CPM_INLINE real cpm_adams_plan(cpm_lane_rays *rays, int part, real ratio, mask accepted, real refused) {
    const real one = splat(1.0), order = load_doubles(rays->order, part), kept = load_doubles(rays->kept, part);
    real margin = ratio + R(1.0); /* half the tolerance is aimed at */
    real same = -margin / order, best = same, chosen = order;
    real down = -(margin + load_doubles(rays->lower, part)) / larger(order - one, one);
    real up = -(margin + load_doubles(rays->higher, part)) / (order + one);
    mask lower = less(one, order) & less(best + R(0.05), down);
    best = pick(lower, down, best), chosen = pick(lower, order - one, chosen);
    mask higher = accepted & less(best, up) & at_most(order + one, splat(CPM_ADAMS_ORDER));
    best = pick(higher, up, best), chosen = pick(higher, order + one, chosen);
    mask young = accepted & at_most(kept + one, order) & less(margin, splat(1.0)) & less(order, splat(CPM_ADAMS_ORDER));
    chosen = pick(young, order + one, chosen);
    best = pick(young, larger(best, splat(0.5)), best);
    mask lost = ~accepted & less(splat(2.0), refused); /* the past misleads */
    chosen = pick(lost, one, chosen);
    store_doubles(chosen, rays->order, part);
    best = pick(accepted, larger(smaller(best, one), splat(-1.0)), larger(smaller(best, splat(-0.4)), splat(-3.32)));
    return exp2_rough(best);
}

/* Moves the past of the accepted lanes on: the point that the step started from joins it. */
CPM_INLINE void cpm_adams_keep(cpm_lane_rays *rays, int part, const cpm_point *a, real h, mask accepted) {
    const real kept = load_doubles(rays->kept, part);
    for (int j = CPM_ADAMS_ORDER - 2; j >= 0; j--) {
        real before = j ? load_doubles(rays->past_sigma[j ? j - 1 : 0], part) : splat(0.0);
        store_doubles(pick(accepted, before - h, load_doubles(rays->past_sigma[j], part)), rays->past_sigma[j], part);
        for (int k = 0; k < 4; k++) {
            real now = k == 0 ? a->g.x : k == 1 ? a->g.y : k == 2 ? a->g.z : a->n;
            if (j) now = load_doubles(rays->past[j - 1][k], part);
            store_doubles(pick(accepted, now, load_doubles(rays->past[j][k], part)), rays->past[j][k], part);
        }
    }
    store_doubles(pick(accepted, smaller(kept + R(1.0), splat(CPM_ADAMS_ORDER - 1.0)), kept), rays->kept, part);
}
#endif
