/* geometry/curve.c: cl/shared/walk.h on this machine. Compiled once for each instruction set; what is tested, and so
 * what is found, is the same on all. */
#include <math.h>
#include <string.h>

#include "cl/shared/region.h" /* before the walk, which asks it */
#include "geometry.h"

#include "cl/shared/walk.h"
#include "few.h"
#include "parts.h"

static void first_hit(const cpm_tree *tree, const cpm_curve *curve, double theta_end, int32_t left, double slack,
                      const cpm_filter *filter, cpm_hit *hit) {
    cpm_first_hit(tree, curve, theta_end, left, slack, filter, hit);
}

typedef struct pair {
    uint32_t curve;
    int32_t primitive;
} pair;

/* In two rounds. The first walks every curve's chord, and where there are few primitives that it may meet, leaves them
 * untested; the second tests what was left: nothing to guess between one curve's arithmetic and the next's, so that
 * they overlap. */
static void lot_of_hits(const cpm_tree *tree, const cpm_bvh_leaf *few, const cpm_curve *curves, const double *from,
                        const int32_t *left, size_t count, cpm_hit *hits) {
    pair untested[LOT * CPM_FEW];
    double a[LOT];
    uint64_t not_back[LOT]; /* the bit of the triangle that a curve starts on, where it cannot fall back on it */
    chords lot;
    uint64_t asked = 0; /* bits: curves of the lot */
    size_t waiting = 0;
    if (few) memset(&lot, 0, sizeof lot); /* lanes that nobody uses */
    for (size_t i = 0; i < count; i++) {
        const cpm_curve *c = &curves[i];
        const cpm_vec strays = cpm_curve_strays(c, 1.0 - from[i]);
        cpm_query q;
        cpm_query_begin(&q, tree, c, left[i], 0.0, NULL);
        q.chord.a = from[i] > 0.0 ? from[i] - CPM_OVERLAP : 0.0, q.chord.b = 1.0;
        q.chord.start = from[i] > 0.0 ? cpm_curve_at(c, from[i]) : c->c[0], q.chord.end = cpm_curve_at(c, 1.0);
        q.chord.off = cpm_grown(tree, strays);
        a[i] = q.chord.a;
        if (cpm_vdot(strays, strays) > tree->frame.sagitta * tree->frame.sagitta ||
            !cpm_is_near_box(tree, q.chord.start) || !cpm_is_near_box(tree, q.chord.end)) {
            cpm_first_hit(tree, c, 1.0, left[i], 0.0, NULL, &hits[i]);
            continue;
        }
        hits[i] = q.best;
        if (few) {
            set_chord(&lot, i, &q);
            not_back[i] = left[i] >= 0 && !cpm_falls_back(&q) ? UINT64_C(1) << left[i] : 0;
            asked |= UINT64_C(1) << i;
            continue;
        }
        cpm_walk(&q, 1);
        hits[i] = q.best;
        for (int w = 0; w < q.waiting; w++) untested[waiting++] = (pair){(uint32_t)i, q.untested[w]};
    }
    if (few && asked) {
        const size_t triangles = (size_t)tree->frame.triangle_count;
        ask_few(&lot, few, triangles, triangles + (size_t)tree->frame.sphere_count);
        for (; asked; asked &= asked - 1) {
            const uint32_t i = (uint32_t)__builtin_ctzll(asked);
            uint64_t met = ((uint64_t)lot.high[i] << 32 | lot.low[i]) & ~not_back[i];
            for (; met; met &= met - 1) untested[waiting++] = (pair){i, (int32_t)__builtin_ctzll(met)};
        }
    }
    for (size_t w = 0; w < waiting; w++) {
        const size_t i = untested[w].curve;
        const int32_t primitive = untested[w].primitive;
        cpm_hit *hit = &hits[i];
        double u = 0.0, v = 0.0, t = cpm_first_root(tree, &curves[i], primitive, left[i], a[i], 1.0, &u, &v);
        const int nearer = (hit->primitive < 0) | (t < hit->t) | ((t == hit->t) & (primitive < hit->primitive));
        if ((t > -1.0) & nearer) hit->primitive = primitive, hit->t = t, hit->u = u, hit->v = v;
    }
    for (size_t i = 0; i < count; i++)
        if (hits[i].primitive >= 0) hits[i].position = cpm_curve_at(&curves[i], hits[i].t);
}

static void first_hits(const cpm_tree *tree, const cpm_bvh_leaf *few, const cpm_curve *curves, const double *from,
                       const int32_t *left, size_t count, cpm_hit *hits) {
    for (size_t i = 0; i < count; i += LOT)
        lot_of_hits(tree, few, curves + i, from + i, left + i, count - i < LOT ? count - i : LOT, hits + i);
}

extern const cpm_curve_code CPM_ISA_NAME(cpm_curve_code);
const cpm_curve_code CPM_ISA_NAME(cpm_curve_code) = {first_hit, first_hits};
