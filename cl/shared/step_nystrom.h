/* shared/step_nystrom.h: Runge-Kutta-Nystrom pairs of Dormand, El-Mikkawy and Prince: 6(4), 5 evaluations a step, 8(6),
 * 8 evaluations, and 12(10), 17 evaluations; the last is the next step's first.
 *
 * As r'' = g(r) has no velocity on its right-hand side, stages need positions only:
 *
 *   r_i = r + c_i h p + h^2 sum_j A_ij g_j                                                                        (1)
 *   end: r + h p + h^2 sum_j b_j g_j (the last row of A),  p + h sum_j b'_j g_j                                    (2)
 *
 * Embedded error: h^2 sum_j e_j g_j of the position, h sum_j e'_j g_j of the momentum. l' = n(r) and L' = n^2(r) have
 * the form of p' = g(r), so arc length and optical path take the weights b' at full order.
 *
 * The quintic between the ends (piece.h) is off by u^3 f6 h^6/720, u = theta (1 - theta). Its second derivative is off
 * by D(u) f6 h^4/720, D = 6 u (1 - 2 theta)^2 - 6 u^2, which the stage nearest the middle shows: trial.dense.
 *
 * Dormand, El-Mikkawy & Prince, Families of Runge-Kutta-Nystrom formulae, IMA J. Num. Anal. 7 (1987): RKN6(4)6FM;
 * High-order embedded Runge-Kutta-Nystrom formulae, ibid.: RKN8(6)9FM. The numbers are those of SciML's
 * OrdinaryDiffEqRKN (rkn_tableaus.jl); tests/analytic/test_tableaus.py checks their order conditions. */
#ifndef CPM_SHARED_STEP_NYSTROM_H
#define CPM_SHARED_STEP_NYSTROM_H
#include "step_trial.h"

CPM_CONSTANT_TABLE double cpm_rkn6_c[6] = {0.0, 1.0 / 10, 3.0 / 10, 7.0 / 10, 17.0 / 25, 1.0};
CPM_CONSTANT_TABLE double cpm_rkn6_A[6][6] = {
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 200, 0.0, 0.0, 0.0, 0.0, 0.0},
    {-1.0 / 2200, 1.0 / 22, 0.0, 0.0, 0.0, 0.0},
    {637.0 / 6600, -7.0 / 110, 7.0 / 33, 0.0, 0.0, 0.0},
    {225437.0 / 1968750, -30073.0 / 281250, 65569.0 / 281250, -9367.0 / 984375, 0.0, 0.0},
    {151.0 / 2142, 5.0 / 116, 385.0 / 1368, 55.0 / 168, -6250.0 / 28101, 0.0}};
CPM_CONSTANT_TABLE double cpm_rkn6_b[6] = {151.0 / 2142, 25.0 / 522,        275.0 / 684,
                                           275.0 / 252,  -78125.0 / 112404, 1.0 / 12};
CPM_CONSTANT_TABLE double cpm_rkn6_e[6] = {151.0 / 2142 - 1349.0 / 157500,   5.0 / 116 - 7873.0 / 50000,
                                           385.0 / 1368 - 192199.0 / 900000, 55.0 / 168 - 521683.0 / 2100000,
                                           -6250.0 / 28101 + 16.0 / 125,     0.0};
CPM_CONSTANT_TABLE double cpm_rkn6_d[6] = {151.0 / 2142 - 1349.0 / 157500, 25.0 / 522 - 7873.0 / 45000,
                                           275.0 / 684 - 27457.0 / 90000,  275.0 / 252 - 521683.0 / 630000,
                                           -78125.0 / 112404 + 2.0 / 5,    0.0};

CPM_CONSTANT_TABLE double cpm_rkn8_c[9] = {0.0, 1.0 / 20, 1.0 / 10, 3.0 / 10, 1.0 / 2, 7.0 / 10, 9.0 / 10, 1.0, 1.0};
CPM_CONSTANT_TABLE double cpm_rkn8_A[9][9] = {
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 800, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 600, 1.0 / 300, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {9.0 / 200, -9.0 / 100, 9.0 / 100, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {-66701.0 / 197352, 28325.0 / 32892, -2665.0 / 5482, 2170.0 / 24669, 0.0, 0.0, 0.0, 0.0, 0.0},
    {227015747.0 / 304251000, -54897451.0 / 30425100, 12942349.0 / 10141700, -9499.0 / 304251, 539.0 / 9250, 0.0, 0.0,
     0.0, 0.0},
    {-1131891597.0 / 901789000, 41964921.0 / 12882700, -6663147.0 / 3220675, 270954.0 / 644135, -108.0 / 5875,
     114.0 / 1645, 0.0, 0.0, 0.0},
    {13836959.0 / 3667458, -17731450.0 / 1833729, 1063919505.0 / 156478208, -33213845.0 / 39119552, 13335.0 / 28544,
     -705.0 / 14272, 1645.0 / 57088, 0.0, 0.0},
    {223.0 / 7938, 0.0, 1175.0 / 8064, 925.0 / 6048, 41.0 / 448, 925.0 / 14112, 1175.0 / 72576, 0.0, 0.0}};
CPM_CONSTANT_TABLE double cpm_rkn8_b[9] = {
    223.0 / 7938, 0.0, 5875.0 / 36288, 4625.0 / 21168, 41.0 / 224, 4625.0 / 21168, 5875.0 / 36288, 223.0 / 7938, 0.0};
CPM_CONSTANT_TABLE double cpm_rkn8_e[9] = {223.0 / 7938 - 7987313.0 / 109941300,
                                           0.0,
                                           1175.0 / 8064 - 1610737.0 / 44674560,
                                           925.0 / 6048 - 10023263.0 / 33505920,
                                           41.0 / 448 + 497221.0 / 12409600,
                                           925.0 / 14112 - 10023263.0 / 78180480,
                                           1175.0 / 72576 - 1610737.0 / 402071040,
                                           0.0,
                                           0.0};
CPM_CONSTANT_TABLE double cpm_rkn8_d[9] = {223.0 / 7938 - 7987313.0 / 109941300,
                                           0.0,
                                           5875.0 / 36288 - 1610737.0 / 40207104,
                                           4625.0 / 21168 - 10023263.0 / 23454144,
                                           41.0 / 224 + 497221.0 / 6204800,
                                           4625.0 / 21168 - 10023263.0 / 23454144,
                                           5875.0 / 36288 - 1610737.0 / 40207104,
                                           223.0 / 7938 + 4251941.0 / 54970650,
                                           -3.0 / 20};

#include "step_nystrom12.h"

/* f6 h^6/720 from g and its place theta in the step, metres; see above. */
CPM_INLINE real cpm_dense_of_stage(const cpm_point *a, const cpm_point *end, real h, scalar theta, real3 g) {
    const scalar u = theta * (R(1.0) - theta), v = R(1.0) - R(2.0) * theta, weight = R(6.0) * u * (v * v - u);
    real3 rise = add3(sub3(sub3(end->r, a->r), scale3(h, a->p)), R(-0.5) * h * h, a->g);
    real3 turn = add3(sub3(end->p, a->p), -h, a->g), bend = sub3(end->g, a->g);
    /* c3, c4, c5 of piece.h; Q'' = (2 c2 + 6 c3 t + 12 c4 t^2 + 20 c5 t^3)/h^2 */
    const scalar t = theta, t2 = t * t, t3 = t2 * t;
    real3 q = scale3(splat(R(60.0) * t - R(180.0) * t2 + R(120.0) * t3), rise);
    q = add3(q, (R(-24.0) * t + R(84.0) * t2 - R(60.0) * t3) * h, turn);
    q = add3(q, (R(3.0) * t - R(12.0) * t2 + R(10.0) * t3) * h * h, bend);
    q = sub3(q, scale3(h * h, sub3(g, a->g)));
    return root(dot3(q, q)) * splat(R(1.0) / (weight < R(0.0) ? -weight : weight));
}

/* The same of the arc length, whose quintic has the slope n: off by 3 u^2 (1 - 2 theta) of it at theta. A parabola has
 * no error in position, but one in length. */
CPM_INLINE real cpm_dense_of_length(const cpm_point *a, const cpm_trial *t, real h, scalar theta, real n) {
    const scalar u = theta * (R(1.0) - theta), weight = R(3.0) * u * u * (R(1.0) - R(2.0) * theta);
    const scalar t2 = theta * theta, t3 = t2 * theta, t4 = t2 * t2;
    const real s0 = dot3(a->g, a->p) / a->n, s1 = dot3(t->end.g, t->end.p) / t->end.n;
    real rise = t->way - h * (a->n + R(0.5) * h * s0), turn = h * (t->end.n - a->n - h * s0), bend = h * h * (s1 - s0);
    real q = h * (a->n - n + theta * h * s0) + (R(30.0) * t2 - R(60.0) * t3 + R(30.0) * t4) * rise +
             (R(28.0) * t3 - R(12.0) * t2 - R(15.0) * t4) * turn + (R(1.5) * t2 - R(4.0) * t3 + R(2.5) * t4) * bend;
    return magnitude(q) * splat(R(1.0) / weight);
}

#define CPM_RKN cpm_rkn6
#define CPM_RKN_STAGES 6
#define CPM_RKN_MIDDLE 2 /* the stage nearest it */
#define CPM_RKN_ASIDE 2  /* and one that is not in it */
#include "step_nystrom_body.h"
#undef CPM_RKN
#undef CPM_RKN_STAGES
#undef CPM_RKN_MIDDLE
#undef CPM_RKN_ASIDE
#define CPM_RKN cpm_rkn8
#define CPM_RKN_STAGES 9
#define CPM_RKN_MIDDLE 4
#define CPM_RKN_ASIDE 3
#include "step_nystrom_body.h"
#undef CPM_RKN
#undef CPM_RKN_STAGES
#undef CPM_RKN_MIDDLE
#undef CPM_RKN_ASIDE
#if !CPM_SINGLE /* below a float's rounding there is nothing for it to do */
#define CPM_RKN cpm_rkn12
#define CPM_RKN_STAGES 18
#define CPM_RKN_MIDDLE 10
#define CPM_RKN_ASIDE 9
#include "step_nystrom_body.h"
#undef CPM_RKN
#undef CPM_RKN_STAGES
#undef CPM_RKN_MIDDLE
#undef CPM_RKN_ASIDE
#endif
#endif
