/* geometry/curve.c: the first primitive that a curve meets: cut into chords, each taken through the tree. Compiled once
 * for each instruction set; what is tested, and so what is found, is the same on all. */
#include <float.h>
#include <math.h>

#include "curve_walk.h"

#define MAX_CHORDS 100000.0
#define OVERLAP 1e-12 /* of theta: a root where two chords meet belongs to one of them at least */
#define LOT 64        /* curves asked at once */
#define NEAR_BOX 0.05 /* of the scene: a chord that ends no farther outside is not cut: float loses nothing by it */

static int is_near_box(const cpm_geometry *g, cpm_vec r) {
    const double *low = g->box.low, *high = g->box.high, most = NEAR_BOX * g->scale;
    return r.x >= low[0] - most && r.x <= high[0] + most && r.y >= low[1] - most && r.y <= high[1] + most &&
           r.z >= low[2] - most && r.z <= high[2] + most;
}

/* Also for a start that looks back. */
static inline cpm_vec grown(const cpm_geometry *g, cpm_vec strays) {
    const double more = 1e-9 * g->scale;
    return cpm_v(strays.x + more, strays.y + more, strays.z + more);
}

static inline void begin(cpm_curve_query *q, const cpm_geometry *g, const cpm_curve *curve, int32_t left, double slack,
                         const cpm_filter *filter) {
    q->geometry = g;
    q->curve = curve;
    q->left = left;
    q->slack = slack;
    q->filter = slack > 0.0 ? filter : NULL;
    q->best.primitive = -1;
    q->best.t = INFINITY;
}

static void first_hit(const cpm_geometry *g, const cpm_curve *curve, double theta_end, int32_t left, double slack,
                      const cpm_filter *filter, cpm_hit *hit) {
    cpm_curve_query q;
    begin(&q, g, curve, left, slack, filter);
    const cpm_vec strays = cpm_curve_strays(curve, theta_end);
    double sagitta = cpm_norm(strays), chords = 1.0;
    if (sagitta > g->sagitta) chords = cpm_min(ceil(sqrt(sagitta / g->sagitta)), MAX_CHORDS);
    double grow = sagitta / (chords * chords) + 1e-12 * g->scale;
    cpm_vec start = curve->c[0];
    for (double i = 0.0; i < chords && q.best.primitive < 0; i++) {
        double a = theta_end * i / chords, b = i + 1.0 < chords ? theta_end * (i + 1.0) / chords : theta_end;
        cpm_vec end = cpm_curve_at(curve, b), chord = cpm_sub(end, start);
        double enter = 0.0, leave = 1.0; /* cut to the scene's box: float sees small numbers */
        int whole = is_near_box(g, start) && is_near_box(g, end);
        if (whole || cpm_clip_to_box(g, start, chord, grow, &enter, &leave)) {
            q.chord.a = i == 0.0 && enter == 0.0 ? -slack : a + enter * (b - a) - OVERLAP * theta_end;
            q.chord.b = a + leave * (b - a);
            q.chord.start = whole ? start : cpm_along(start, enter, chord);
            q.chord.end = whole ? end : cpm_along(start, leave, chord);
            q.chord.off = grown(g, cpm_scaled(1.0 / (chords * chords), strays)); /* and of this part of the chord */
            walk(&q, 0);
        }
        start = end;
    }
    *hit = q.best;
    if (hit->primitive >= 0) hit->position = cpm_curve_at(curve, hit->t);
}

/* In two rounds. The first walks every curve's chord, and where one primitive is all that it may meet, leaves that
 * untested; the second tests what was left: nothing to guess between one curve's arithmetic and the next's, so that
 * they overlap. */
static void lot_of_hits(const cpm_geometry *g, const cpm_curve *curves, const double *from, const int32_t *left,
                        size_t count, cpm_hit *hits) {
    double a[LOT];
    size_t untested[LOT], waiting = 0;
    for (size_t i = 0; i < count; i++) {
        const cpm_curve *c = &curves[i];
        const cpm_vec strays = cpm_curve_strays(c, 1.0 - from[i]);
        cpm_curve_query q;
        begin(&q, g, c, left[i], 0.0, NULL);
        q.chord.a = from[i] > 0.0 ? from[i] - OVERLAP : 0.0, q.chord.b = 1.0;
        q.chord.start = from[i] > 0.0 ? cpm_curve_at(c, from[i]) : c->c[0], q.chord.end = cpm_curve_at(c, 1.0);
        q.chord.off = grown(g, strays);
        if (cpm_vdot(strays, strays) > g->sagitta * g->sagitta || !is_near_box(g, q.chord.start) ||
            !is_near_box(g, q.chord.end)) {
            first_hit(g, c, 1.0, left[i], 0.0, NULL, &hits[i]);
            continue;
        }
        const int32_t only = walk(&q, 1);
        hits[i] = q.best;
        if (only < 0) {
            if (q.best.primitive >= 0) hits[i].position = cpm_curve_at(c, q.best.t);
            continue;
        }
        hits[i].primitive = only;
        a[waiting] = q.chord.a;
        untested[waiting++] = i;
    }
    for (size_t w = 0; w < waiting; w++) {
        const size_t i = untested[w];
        cpm_hit *hit = &hits[i];
        hit->u = hit->v = 0.0;
        hit->t = first_root(g, &curves[i], hit->primitive, left[i], a[w], 1.0, &hit->u, &hit->v);
        if (!(hit->t > -1.0)) hit->primitive = -1;
        hit->position = cpm_curve_at(&curves[i], hit->t);
    }
}

static void first_hits(const cpm_geometry *g, const cpm_curve *curves, const double *from, const int32_t *left,
                       size_t count, cpm_hit *hits) {
    for (size_t i = 0; i < count; i += LOT)
        lot_of_hits(g, curves + i, from + i, left + i, count - i < LOT ? count - i : LOT, hits + i);
}

extern const cpm_curve_code CPM_ISA_NAME(cpm_curve_code);
const cpm_curve_code CPM_ISA_NAME(cpm_curve_code) = {first_hit, first_hits};
