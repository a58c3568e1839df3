/* shared/step_dopri5.h: Dormand-Prince 5(4), 6 evaluations a step (the last is the next step's first).
 *
 * r'' = g(r) has no velocity on its right-hand side, so the stages' momenta drop out: with A the method's matrix and
 * B = A A, the same steps to rounding are
 *
 *   r_i = r + c_i h p + h^2 sum_j B_ij g_j,   p_i = p + h sum_j A_ij g_j                                           (1)
 *
 * with half the arithmetic; row 7 of A and B is the step's end. Embedded error: h^2 sum_j (e A)_j g_j of the position,
 * h sum_j e_j g_j of the momentum. Arc length and optical path are quadratures of n and n^2 with the same weights.
 * Dormand & Prince, J. Comp. Appl. Math. 6 (1980). */
#ifndef CPM_SHARED_STEP_DOPRI5_H
#define CPM_SHARED_STEP_DOPRI5_H
#include "step_trial.h"

CPM_CONSTANT_TABLE double cpm_dopri5_c[7] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
CPM_CONSTANT_TABLE double cpm_dopri5_B[7][6] = {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                                                {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                                                {9.0 / 200, 0.0, 0.0, 0.0, 0.0, 0.0},
                                                {-12.0 / 25, 4.0 / 5, 0.0, 0.0, 0.0, 0.0},
                                                {-12248.0 / 6561, 7208.0 / 2187, -6784.0 / 6561, 0.0, 0.0, 0.0},
                                                {-533.0 / 264, 91.0 / 22, -56.0 / 33, 7.0 / 88, 0.0, 0.0},
                                                {35.0 / 384, 0.0, 50.0 / 159, 25.0 / 192, -243.0 / 6784, 0.0}};
CPM_CONSTANT_TABLE double cpm_dopri5_b[7] = {35.0 / 384,     0.0,       500.0 / 1113, 125.0 / 192,
                                             -2187.0 / 6784, 11.0 / 84, 0.0};
CPM_CONSTANT_TABLE double cpm_dopri5_e[7] = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                                             -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
CPM_CONSTANT_TABLE double cpm_dopri5_eA[7] = {611.0 / 230400, 0.0, -514.0 / 83475, 391.0 / 38400, -4617.0 / 1356800,
                                              -11.0 / 3360,   0.0};

CPM_INLINE cpm_trial cpm_step_dopri5(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_point *a,
                                     real h) {
    real3 g[7], move = triple(splat(0.0), splat(0.0), splat(0.0)), turn = move, miss = move, slip = move;
    real n[7], way = splat(0.0), path = splat(0.0), way_error = splat(0.0), hh = h * h;
    cpm_trial t;
    g[0] = a->g, n[0] = a->n;
    t.good = at_most(splat(0.0), hh);
    for (int i = 1; i < 7; i++) {
        move = triple(splat(0.0), splat(0.0), splat(0.0));
        for (int j = 0; j < i; j++)
            if (cpm_dopri5_B[i][j] != 0.0) move = add3(move, splat(cpm_dopri5_B[i][j]), g[j]);
        t.end.r = add3(add3(a->r, h * R(cpm_dopri5_c[i]), a->p), hh, move);
        g[i] = cpm_field(m, table, t.end.r, a->scale, &n[i]);
        t.good &= less(splat(0.0), n[i]);
    }
    for (int i = 0; i < 7; i++) {
        if (cpm_dopri5_b[i] != 0.0) {
            turn = add3(turn, splat(cpm_dopri5_b[i]), g[i]);
            way += R(cpm_dopri5_b[i]) * n[i];
            path += R(cpm_dopri5_b[i]) * (n[i] * n[i]);
        }
        if (cpm_dopri5_e[i] != 0.0) {
            slip = add3(slip, splat(cpm_dopri5_e[i]), g[i]);
            way_error += R(cpm_dopri5_e[i]) * n[i];
            miss = add3(miss, splat(cpm_dopri5_eA[i]), g[i]);
        }
    }
    t.end.p = add3(a->p, h, turn);
    if (CPM_SINGLE) t.bend = scale3(hh, move), t.push = scale3(h, turn);
    t.end.g = g[6];
    t.end.n = n[6];
    t.end.scale = a->scale;
    t.way = h * way;
    t.path = h * path;
    t.error_position2 = hh * hh * dot3(miss, miss);
    t.error_way = h * way_error;
    t.error_momentum2 = hh * dot3(slip, slip);
    t.dense = t.curve = splat(0.0);
    return t;
}
#endif
