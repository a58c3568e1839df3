/* geometry/curve_walk.h: a chord through the tree, its boxes grown by how far the curve is from it; part of curve.c.
 *
 * Why nothing leaks. The curve at theta is within `off` of the chord's point of the same theta. Where the curve meets a
 * primitive, that point is inside the primitive's grown box: so the chord enters the box no later than there, and what
 * is nearer than the best so far is never passed over. Boxes are grown by ROUNDING more, in units of the scene: float's
 * rounding of the chord (1e-7), of the boxes' planes, of their distances and of the parameters at which they are met.
 */
#ifndef CPM_GEOMETRY_CURVE_WALK_H
#define CPM_GEOMETRY_CURVE_WALK_H
#include "parts.h"
#include "wide.h"
#include <float.h>
#include <math.h>

#define ROUNDING 2e-6f
#define LEAST_SLOPE 1e-30f /* of a chord's component: its inverse stays finite */
#define PATIENCE 3         /* nodes that may be looked at before a primitive found is tested */
#define STACK (CPM_BVH_DEPTH * (CPM_BVH_WIDTH - 1))

/* One curve against one geometry; the chord is the part of the curve that is being asked. */
typedef struct cpm_curve_query {
    const cpm_geometry *geometry;
    const cpm_curve *curve;
    cpm_chord chord;
    int32_t left;
    double slack; /* theta within which the filter is asked */
    const cpm_filter *filter;
    cpm_hit best; /* so far */
} cpm_curve_query;

typedef struct cast {         /* the chord as the tree sees it */
    float start[3], slope[3]; /* start + t slope, t in [0, 1] */
    float grow[3];
    int near[3], far[3]; /* of a box: the planes met first and last */
    float near_from[3], far_from[3], inverse[3];
} cast;

static inline cast cast_of(const cpm_curve_query *q) {
    const cpm_chord *c = &q->chord;
    const cpm_vec center = q->geometry->center;
    const double start[3] = {c->start.x - center.x, c->start.y - center.y, c->start.z - center.z};
    const double slope[3] = {c->end.x - c->start.x, c->end.y - c->start.y, c->end.z - c->start.z};
    const double unit = q->geometry->unit;
    cast s;
    const double off[3] = {c->off.x, c->off.y, c->off.z};
    for (int k = 0; k < 3; k++) {
        float from = (float)(start[k] * unit), along = (float)(slope[k] * unit);
        const float grow = (float)(off[k] * unit) * (1.0f + FLT_EPSILON) + ROUNDING;
        int forward = along >= 0.0f;
        if (!(fabsf(along) > LEAST_SLOPE)) along = forward ? LEAST_SLOPE : -LEAST_SLOPE;
        s.start[k] = from, s.slope[k] = along;
        s.near[k] = forward ? k : 3 + k, s.far[k] = forward ? 3 + k : k;
        s.grow[k] = grow;
        s.near_from[k] = forward ? from + grow : from - grow;
        s.far_from[k] = forward ? from - grow : from + grow;
        s.inverse[k] = 1.0f / along;
    }
    return s;
}

/* Which children's grown boxes does the chord meet before `limit`? Bits; `enter`: where. */
static inline unsigned boxes_met(const cpm_bvh_node *node, const cast *s, float limit, float enter[CPM_BVH_WIDTH]) {
    wide in = wide_all(0.0f), out = wide_all(limit);
    for (int k = 0; k < 3; k++) {
        in = wide_max(in, (wide_load(node->box[s->near[k]]) - s->near_from[k]) * s->inverse[k]);
        out = wide_min(out, (wide_load(node->box[s->far[k]]) - s->far_from[k]) * s->inverse[k]);
    }
    memcpy(enter, &in, sizeof in);
    return wide_bits(in <= out);
}

/* An affine function along the chord, and how far it is from that along the curve. */
typedef struct along {
    wide start, slope, stray;
} along;

static inline along along_chord(const float (*row)[CPM_BVH_WIDTH], const cast *s) {
    along a = {wide_load(row[3]), wide_all(0.0f), wide_all(0.0f)};
    for (int k = 0; k < 3; k++) {
        const wide gradient = wide_load(row[k]);
        a.start = wide_along(gradient, s->start[k], a.start);
        a.slope = wide_along(gradient, s->slope[k], a.slope);
        a.stray = wide_along(wide_abs(gradient), s->grow[k], a.stray);
    }
    return a;
}

/* Which children may the curve meet before `limit`? A triangle's plane is met only while the chord is so near that the
 * curve may be on it; somewhere in that part of the chord u, v and 1 - u - v have to be so near to not being negative.
 * Whatever is NaN passes. */
static inline unsigned faces_met(const cpm_bvh_node *node, const cast *s, float limit) {
    const along plane = along_chord(&node->face[CPM_FACE_PLANE], s), u = along_chord(&node->face[CPM_FACE_U], s);
    const along v = along_chord(&node->face[CPM_FACE_V], s);
    const wide inverse = wide_all(1.0f) / plane.slope;
    const wide one = (-plane.stray - plane.start) * inverse, other = (plane.stray - plane.start) * inverse;
    const wide in = wide_max(wide_min(one, other), wide_all(0.0f));
    const wide out = wide_min(wide_max(one, other), wide_all(limit));
    const wide u_in = wide_fused(in, u.slope, u.start), u_out = wide_fused(out, u.slope, u.start);
    const wide v_in = wide_fused(in, v.slope, v.start), v_out = wide_fused(out, v.slope, v.start);
    const wide least_w = wide_min(u_in + v_in, u_out + v_out) - (u.stray + v.stray);
    return ~wide_bits((out < in) | (wide_max(u_in, u_out) + u.stray < 0.0f) | (wide_max(v_in, v_out) + v.stray < 0.0f) |
                      (least_w > 1.0f));
}

/* The curve's first root on a primitive in (a, b], whether it is there that the curve starts or not; below -1: none. */
static inline double first_root(const cpm_geometry *g, const cpm_curve *curve, int32_t primitive, int32_t left,
                                double a, double b, double *u, double *v) {
    const size_t number = (size_t)primitive;
    const int leaving = primitive == left;
    if (number >= g->triangle_count)
        return cpm_curve_sphere(curve, &g->spheres[number - g->triangle_count], leaving, a, b);
    if (curve->degree == 2) return cpm_parabola_triangle(curve, &g->triangles[number], leaving, a, b, u, v);
    return cpm_curve_triangle(curve, &g->triangles[number], leaving, a, b, u, v);
}

/* May a curve fall back on the triangle that it starts on? Not where its slope keeps its side: no need to ask more. */
static inline int falls_back(const cpm_curve_query *q) {
    if (q->left < 0 || (size_t)q->left >= q->geometry->triangle_count || q->curve->degree != 2) return 1;
    const double *normal = q->geometry->triangles[q->left].normal;
    const cpm_vec n = cpm_v(normal[0], normal[1], normal[2]);
    const double f1 = cpm_vdot(q->curve->c[1], n), fb = f1 + q->chord.b * cpm_vdot(q->curve->c[2], n);
    return !((f1 > 0.0 && fb > 0.0) || (f1 < 0.0 && fb < 0.0));
}

/* Is the curve's first root on this primitive the best so far? */
static inline int test_primitive(cpm_curve_query *q, int32_t primitive) {
    const cpm_chord *c = &q->chord;
    double end = q->best.primitive >= 0 && q->best.t < c->b ? q->best.t : c->b, u = 0.0, v = 0.0;
    double t = q->curve->degree > 2 && primitive != q->left && (size_t)primitive < q->geometry->triangle_count
                   ? cpm_chord_triangle(q->curve, c, &q->geometry->triangles[primitive], end, &u, &v)
                   : first_root(q->geometry, q->curve, primitive, q->left, c->a, end, &u, &v);
    if (!(t > -1.0)) return 0;
    if (q->filter && t <= q->slack &&
        !q->filter->counts(q->filter->user, primitive, cpm_curve_at(q->curve, t), cpm_curve_tangent(q->curve, t)))
        return 0;
    if (q->best.primitive >= 0 && (t > q->best.t || (t == q->best.t && primitive >= q->best.primitive))) return 0;
    q->best.primitive = primitive;
    q->best.t = t, q->best.u = u, q->best.v = v;
    return 1;
}

/* The best so far as a part of the chord, a little beyond it: an equal hit of a lower number is still seen. */
static inline float limit_of(const cpm_curve_query *q) {
    const cpm_chord *c = &q->chord;
    return (float)((q->best.t - c->a) / (c->b - c->a)) * (1.0f + 4.0f * FLT_EPSILON) + ROUNDING;
}

/* The chord's first hit, in q->best. With `defer`: where there is but one primitive to test, it is returned untested;
 * else -1. */
static int32_t walk(cpm_curve_query *q, int defer) {
    struct {
        float enter;
        int32_t node;
    } stack[STACK];
    const cpm_bvh_node *nodes = q->geometry->curved.nodes;
    const cast s = cast_of(q);
    const int32_t never = falls_back(q) ? -1 : q->left;
    float limit = 1.0f + ROUNDING;
    int height = 0, patience = PATIENCE;
    int32_t at = 0, untested = -1;
    for (;;) {
        const cpm_bvh_node *node = &nodes[at];
        float enter[CPM_BVH_WIDTH];
        int base = height, found = 0;
        unsigned met = boxes_met(node, &s, limit, enter), leaves = met & node->leaves;
        if (leaves)
            for (leaves &= faces_met(node, &s, limit); leaves; leaves &= leaves - 1) {
                const int32_t primitive = ~node->child[__builtin_ctz(leaves)];
                if (primitive == never) continue;
                if (defer) {
                    if (untested < 0) {
                        untested = primitive;
                        continue;
                    }
                    found |= test_primitive(q, untested);
                    untested = -1, defer = 0;
                }
                found |= test_primitive(q, primitive);
            }
        for (met &= ~node->leaves; met; met &= met - 1) {
            int i = __builtin_ctz(met), slot = height++; /* the nearest on top */
            for (; slot > base && stack[slot - 1].enter < enter[i]; slot--) stack[slot] = stack[slot - 1];
            stack[slot].enter = enter[i], stack[slot].node = node->child[i];
        }
        if (height == 0) return untested;
        if (untested >= 0 && --patience == 0) { /* a long way still: it had better be cut short */
            found |= test_primitive(q, untested);
            untested = -1, defer = 0;
        }
        if (found) limit = limit_of(q);
        do {
            if (height == 0) return untested;
        } while (stack[--height].enter > limit);
        at = stack[height].node;
    }
}
#endif
