/* shared/step_nystrom_body.h: one step of the pair CPM_RKN, whose tables are CPM_RKN_c, _A, _b (weights of the
 * momentum), _e and _d (errors of position and momentum); equations (1) and (2) of step_nystrom.h. Included once a
 * pair, so that the loops unroll over constants. */
#define CPM_RKN_NAME(part) CPM_GLUE(CPM_RKN, part)
CPM_INLINE cpm_trial CPM_RKN_NAME(_step)(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_point *a,
                                         real h) {
    const real zero = splat(0.0), hh = h * h;
    real3 g[CPM_RKN_STAGES], none = triple(zero, zero, zero), turn = none, miss = none, slip = none;
    real n[CPM_RKN_STAGES], way = zero, path = zero, way_error = zero;
    cpm_trial t;
    g[0] = a->g, n[0] = a->n;
    t.good = at_most(zero, hh);
    for (int i = 1; i < CPM_RKN_STAGES; i++) {
        real3 move = none;
        for (int j = 0; j < i; j++)
            if (CPM_RKN_NAME(_A)[i][j] != 0.0) move = add3(move, splat(CPM_RKN_NAME(_A)[i][j]), g[j]);
        t.end.r = add3(add3(a->r, h * R(CPM_RKN_NAME(_c)[i]), a->p), hh, move);
        g[i] = cpm_field(m, table, t.end.r, a->scale, &n[i]);
        t.good &= less(zero, n[i]);
    }
    for (int i = 0; i < CPM_RKN_STAGES; i++) {
        if (CPM_RKN_NAME(_b)[i] != 0.0) {
            turn = add3(turn, splat(CPM_RKN_NAME(_b)[i]), g[i]);
            way += R(CPM_RKN_NAME(_b)[i]) * n[i];
            path += R(CPM_RKN_NAME(_b)[i]) * (n[i] * n[i]);
        }
        if (CPM_RKN_NAME(_d)[i] != 0.0) {
            slip = add3(slip, splat(CPM_RKN_NAME(_d)[i]), g[i]);
            way_error += R(CPM_RKN_NAME(_d)[i]) * n[i];
        }
        if (CPM_RKN_NAME(_e)[i] != 0.0) miss = add3(miss, splat(CPM_RKN_NAME(_e)[i]), g[i]);
    }
    t.end.p = add3(a->p, h, turn);
    t.end.g = g[CPM_RKN_STAGES - 1];
    t.end.n = n[CPM_RKN_STAGES - 1];
    t.end.scale = a->scale;
    t.way = h * way;
    t.path = h * path;
    t.error_position2 = hh * hh * dot3(miss, miss);
    t.error_way = h * way_error;
    t.error_momentum2 = hh * dot3(slip, slip);
    t.curve = cpm_dense_of_stage(a, &t.end, h, R(CPM_RKN_NAME(_c)[CPM_RKN_MIDDLE]), g[CPM_RKN_MIDDLE]);
    t.dense = larger(t.curve, cpm_dense_of_length(a, &t, h, R(CPM_RKN_NAME(_c)[CPM_RKN_ASIDE]), n[CPM_RKN_ASIDE]));
    return t;
}
#undef CPM_RKN_NAME
