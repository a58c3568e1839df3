/* shared/walk.h: the first primitive that a curve meets: cut into chords, each taken through the tree, whose boxes and
 * triangles grow by how far the curve is from it.
 *
 * Why nothing leaks. The curve at theta is within `off` of the chord's point of the same theta. Where the curve meets a
 * primitive, that point is inside the primitive's grown box: so the chord enters the box no later than there, and what
 * is nearer than the best so far is never passed over. Boxes are grown by CPM_WALK_ROUNDING more, in units of the
 * scene: float's rounding of the chord (1e-7), of the boxes' planes, of their distances and of the parameters at which
 * they are met. So what is found does not depend on how float rounds: it is the same on every machine.
 *
 * CPM_HIT_COUNTS(query, primitive, theta): does a hit at or about the curve's start count? Only the host has such
 * filters, and defines it before. */
#ifndef CPM_SHARED_WALK_H
#define CPM_SHARED_WALK_H
#include "clip.h"
#include "curve.h"

#ifndef CPM_HIT_COUNTS
typedef struct cpm_filter {
    cpm_i32 unused;
} cpm_filter;
#define CPM_HIT_COUNTS(query, primitive, theta) ((theta) == (theta))
#endif

#define CPM_WALK_ROUNDING 2e-6f
#define CPM_FLOAT_EPSILON 1.1920929e-7f
#define CPM_LEAST_SLOPE 1e-30f /* of a chord's component: its inverse stays finite */
#define CPM_UNTESTED 4         /* primitives that may wait to be tested */
#define CPM_PATIENCE 3         /* nodes that may be looked at meanwhile */
#define CPM_STACK (CPM_TREE_DEPTH * (CPM_TREE_WIDTH - 1))
#define CPM_MAX_CHORDS 100000.0
#define CPM_OVERLAP 1e-12 /* of theta: a root where two chords meet belongs to one of them at least */
#define CPM_NEAR_BOX                                                                                                   \
    0.05 /* of the scene: a chord that ends no farther outside is not cut: float loses nothing by it                   \
          */

/* One curve against one geometry; the chord is the part of the curve that is being asked. */
typedef struct cpm_query {
    const cpm_tree *tree;
    const cpm_curve *curve;
    cpm_chord chord;
    cpm_i32 left;
    double slack;                            /* theta within which CPM_HIT_COUNTS is asked */
    const cpm_filter *filter;                /* what it is asked of; NULL: nothing */
    cpm_hit best;                            /* so far */
    cpm_i32 untested[CPM_UNTESTED], waiting; /* primitives that are still to be tested, and how many */
    cpm_i32 any;                             /* one hit is as good as the first */
} cpm_query;

typedef struct cpm_cast {     /* the chord as the tree sees it */
    float start[3], slope[3]; /* start + t slope, t in [0, 1] */
    float grow[3];
    int near[3], far[3]; /* of a box: the planes met first and last */
    float near_from[3], far_from[3], inverse[3];
} cpm_cast;

CPM_INLINE cpm_cast cpm_cast_of(const cpm_query *q) {
    const cpm_chord *c = &q->chord;
    const double *center = q->tree->frame.center;
    const double start[3] = {c->start.x - center[0], c->start.y - center[1], c->start.z - center[2]};
    const double slope[3] = {c->end.x - c->start.x, c->end.y - c->start.y, c->end.z - c->start.z};
    const double unit = q->tree->frame.unit;
    cpm_cast s;
    const double off[3] = {c->off.x, c->off.y, c->off.z};
    for (int k = 0; k < 3; k++) {
        float from = (float)(start[k] * unit), along = (float)(slope[k] * unit);
        const float grow = (float)(off[k] * unit) * (1.0f + CPM_FLOAT_EPSILON) + CPM_WALK_ROUNDING;
        int forward = along >= 0.0f;
        if (!(fabs(along) > CPM_LEAST_SLOPE)) along = forward ? CPM_LEAST_SLOPE : -CPM_LEAST_SLOPE;
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
CPM_INLINE cpm_u32 cpm_boxes_met(CPM_GLOBAL const cpm_tree_node *node, const cpm_cast *s, float limit,
                                 float enter[CPM_TREE_WIDTH]) {
    wide in = wide_all(0.0f), out = wide_all(limit);
    for (int k = 0; k < 3; k++) {
        in = wide_max(in, (wide_load(node->box[s->near[k]]) - s->near_from[k]) * s->inverse[k]);
        out = wide_min(out, (wide_load(node->box[s->far[k]]) - s->far_from[k]) * s->inverse[k]);
    }
    wide_store(in, enter);
    return wide_bits(in <= out);
}

/* An affine function along the chord, and how far it is from that along the curve. */
typedef struct cpm_along_line {
    wide start, slope, stray;
} cpm_along_line;

CPM_INLINE cpm_along_line cpm_along_chord(CPM_GLOBAL const float (*row)[CPM_TREE_WIDTH], const cpm_cast *s) {
    cpm_along_line a;
    a.start = wide_load(row[3]), a.slope = wide_all(0.0f), a.stray = wide_all(0.0f);
    for (int k = 0; k < 3; k++) {
        const wide gradient = wide_load(row[k]);
        a.start = wide_along(gradient, wide_all(s->start[k]), a.start);
        a.slope = wide_along(gradient, wide_all(s->slope[k]), a.slope);
        a.stray = wide_along(wide_abs(gradient), wide_all(s->grow[k]), a.stray);
    }
    return a;
}

/* Which children may the curve meet before `limit`? A triangle's plane is met only while the chord is so near that the
 * curve may be on it; somewhere in that part of the chord u, v and 1 - u - v have to be so near to not being negative.
 * Whatever is NaN passes. */
CPM_INLINE cpm_u32 cpm_faces_met(CPM_GLOBAL const cpm_tree_node *node, const cpm_cast *s, float limit) {
    const cpm_along_line plane = cpm_along_chord(&node->face[CPM_FACE_PLANE], s),
                         u = cpm_along_chord(&node->face[CPM_FACE_U], s);
    const cpm_along_line v = cpm_along_chord(&node->face[CPM_FACE_V], s);
    const wide inverse = wide_all(1.0f) / plane.slope;
    const wide one = (-plane.stray - plane.start) * inverse, other = (plane.stray - plane.start) * inverse;
    const wide in = wide_max(wide_min(one, other), wide_all(0.0f));
    const wide out = wide_min(wide_max(one, other), wide_all(limit));
    const wide u_in = wide_along(in, u.slope, u.start), u_out = wide_along(out, u.slope, u.start);
    const wide v_in = wide_along(in, v.slope, v.start), v_out = wide_along(out, v.slope, v.start);
    const wide least_w = wide_min(u_in + v_in, u_out + v_out) - (u.stray + v.stray);
    return ~wide_bits((out < in) | (wide_max(u_in, u_out) + u.stray < 0.0f) | (wide_max(v_in, v_out) + v.stray < 0.0f) |
                      (least_w > 1.0f));
}

/* The curve's first root on a primitive in (a, b], whether it is there that the curve starts or not; below -1: none. */
CPM_INLINE double cpm_first_root(const cpm_tree *tree, const cpm_curve *curve, cpm_i32 primitive, cpm_i32 left,
                                 double a, double b, double *u, double *v) {
    const cpm_i32 number = primitive;
    const int leaving = primitive == left;
    if (number >= tree->frame.triangle_count)
        return cpm_curve_sphere(curve, &tree->spheres[number - tree->frame.triangle_count], leaving, a, b);
    if (curve->degree == 2) return cpm_parabola_triangle(curve, &tree->triangles[number], leaving, a, b, u, v);
    return cpm_curve_triangle(curve, &tree->triangles[number], leaving, a, b, u, v);
}

/* May a curve fall back on the triangle that it starts on? Not where its slope keeps its side: no need to ask more. */
CPM_INLINE int cpm_falls_back(const cpm_query *q) {
    if (q->left < 0 || q->left >= q->tree->frame.triangle_count || q->curve->degree != 2) return 1;
    CPM_GLOBAL const double *normal = q->tree->triangles[q->left].normal;
    const cpm_vec n = cpm_v(normal[0], normal[1], normal[2]);
    const double f1 = cpm_vdot(q->curve->c[1], n), fb = f1 + q->chord.b * cpm_vdot(q->curve->c[2], n);
    return !((f1 > 0.0 && fb > 0.0) || (f1 < 0.0 && fb < 0.0));
}

/* Is the curve's first root on this primitive the best so far? */
CPM_INLINE int cpm_test_primitive(cpm_query *q, cpm_i32 primitive) {
    const cpm_chord *c = &q->chord;
    /* parabolas to the chord's end: their roots are the same whatever was met before */
    double end = q->best.primitive >= 0 && q->best.t < c->b && q->curve->degree != 2 ? q->best.t : c->b;
    double u = 0.0, v = 0.0;
    double t = q->curve->degree > 2 && primitive != q->left && primitive < q->tree->frame.triangle_count
                   ? cpm_chord_triangle(q->curve, c, &q->tree->triangles[primitive], end, &u, &v)
                   : cpm_first_root(q->tree, q->curve, primitive, q->left, c->a, end, &u, &v);
    if (!(t > -1.0)) return 0;
    if (q->filter && t <= q->slack && !CPM_HIT_COUNTS(q, primitive, t)) return 0;
    if (q->best.primitive >= 0 && (t > q->best.t || (t == q->best.t && primitive >= q->best.primitive))) return 0;
    q->best.primitive = primitive;
    q->best.t = t, q->best.u = u, q->best.v = v;
    return 1;
}

/* The best so far as a part of the chord, a little beyond it: an equal hit of a lower number is still seen. */
CPM_INLINE float cpm_limit_of(const cpm_query *q) {
    const cpm_chord *c = &q->chord;
    return (float)((q->best.t - c->a) / (c->b - c->a)) * (1.0f + 4.0f * CPM_FLOAT_EPSILON) + CPM_WALK_ROUNDING;
}

/* All that wait; is one of them the best so far? */
CPM_INLINE int cpm_test_waiting(cpm_query *q) {
    int found = 0;
    for (int i = 0; i < q->waiting; i++) found |= cpm_test_primitive(q, q->untested[i]);
    q->waiting = 0;
    return found;
}

/* The chord's first hit, in q->best. With `defer` a few primitives may be left untested, of which one may be hit
 * earlier: where there are so few, the caller's own loop over many curves tests them faster. */
CPM_INLINE void cpm_walk(cpm_query *q, int defer) {
    float stack_enter[CPM_STACK];
    cpm_i32 stack_node[CPM_STACK];
    CPM_GLOBAL const cpm_tree_node *nodes = q->tree->nodes;
    const cpm_cast s = cpm_cast_of(q);
    const cpm_i32 never = cpm_falls_back(q) ? -1 : q->left;
    float limit = 1.0f + CPM_WALK_ROUNDING;
    int height = 0, patience = CPM_PATIENCE;
    cpm_i32 at = 0;
    for (;;) {
        CPM_GLOBAL const cpm_tree_node *node = &nodes[at];
        float enter[CPM_TREE_WIDTH];
        int base = height, found = 0;
        cpm_u32 met = cpm_boxes_met(node, &s, limit, enter), leaves = met & node->leaves;
        if (leaves)
            for (leaves &= cpm_faces_met(node, &s, limit); leaves; leaves &= leaves - 1) {
                const cpm_i32 primitive = ~node->child[cpm_lowest_bit(leaves)];
                if (primitive == never) continue;
                if (defer && q->waiting == CPM_UNTESTED) {
                    found |= cpm_test_waiting(q);
                    defer = 0;
                }
                if (defer)
                    q->untested[q->waiting++] = primitive;
                else
                    found |= cpm_test_primitive(q, primitive);
            }
        if (found && q->any) return;
        for (met &= ~node->leaves; met; met &= met - 1) {
            int i = cpm_lowest_bit(met), slot = height++; /* the nearest on top */
            for (; slot > base && stack_enter[slot - 1] < enter[i]; slot--)
                stack_enter[slot] = stack_enter[slot - 1], stack_node[slot] = stack_node[slot - 1];
            stack_enter[slot] = enter[i], stack_node[slot] = node->child[i];
        }
        if (height == 0) return;
        if (q->waiting && --patience == 0) { /* a long way still: it had better be cut short */
            found |= cpm_test_waiting(q);
            defer = 0;
        }
        if (found) limit = cpm_limit_of(q);
        do {
            if (height == 0) return;
        } while (stack_enter[--height] > limit);
        at = stack_node[height];
    }
}

CPM_INLINE int cpm_is_near_box(const cpm_tree *tree, cpm_vec r) {
    const double *low = tree->frame.low, *high = tree->frame.high, most = CPM_NEAR_BOX * tree->frame.scale;
    return r.x >= low[0] - most && r.x <= high[0] + most && r.y >= low[1] - most && r.y <= high[1] + most &&
           r.z >= low[2] - most && r.z <= high[2] + most;
}

/* Also for a start that looks back. */
CPM_INLINE cpm_vec cpm_grown(const cpm_tree *tree, cpm_vec strays) {
    const double more = 1e-9 * tree->frame.scale;
    return cpm_v(strays.x + more, strays.y + more, strays.z + more);
}

CPM_INLINE void cpm_query_begin(cpm_query *q, const cpm_tree *tree, const cpm_curve *curve, cpm_i32 left, double slack,
                                const cpm_filter *filter) {
    q->tree = tree;
    q->curve = curve;
    q->left = left;
    q->slack = slack;
    q->filter = slack > 0.0 ? filter : (const cpm_filter *)0;
    q->best.primitive = -1;
    q->best.t = INFINITY, q->best.u = q->best.v = 0.0, q->best.padding = 0;
    q->best.position = curve->c[0];
    q->waiting = 0, q->any = 0;
}

/* Does a straight line meet anything for theta in (0, 1]? */
CPM_INLINE int cpm_meets_any(const cpm_tree *tree, const cpm_curve *line) {
    cpm_query q;
    double enter = 0.0, leave = 1.0;
    if (!tree->nodes) return 0;
    cpm_query_begin(&q, tree, line, -1, 0.0, (const cpm_filter *)0);
    q.any = 1;
    q.chord.start = line->c[0], q.chord.end = cpm_add(line->c[0], line->c[1]);
    if (!cpm_is_near_box(tree, q.chord.start) || !cpm_is_near_box(tree, q.chord.end)) {
        if (!cpm_clip_to_box(tree, line->c[0], line->c[1], 1e-12 * tree->frame.scale, &enter, &leave)) return 0;
        q.chord.start = cpm_along(line->c[0], enter, line->c[1]);
        q.chord.end = cpm_along(line->c[0], leave, line->c[1]);
    }
    q.chord.a = enter == 0.0 ? 0.0 : enter - CPM_OVERLAP, q.chord.b = leave;
    q.chord.off = cpm_grown(tree, cpm_v(0.0, 0.0, 0.0));
    cpm_walk(&q, 0);
    return q.best.primitive >= 0;
}

CPM_INLINE void cpm_first_hit(const cpm_tree *tree, const cpm_curve *curve, double theta_end, cpm_i32 left,
                              double slack, const cpm_filter *filter, cpm_hit *hit) {
    cpm_query q;
    cpm_query_begin(&q, tree, curve, left, slack, filter);
    const cpm_vec strays = cpm_curve_strays(curve, theta_end);
    double sagitta = cpm_norm(strays), chords = 1.0;
    if (sagitta > tree->frame.sagitta) chords = cpm_min(ceil(sqrt(sagitta / tree->frame.sagitta)), CPM_MAX_CHORDS);
    double grow = sagitta / (chords * chords) + 1e-12 * tree->frame.scale;
    cpm_vec start = curve->c[0];
    for (double i = 0.0; i < chords && q.best.primitive < 0; i++) {
        double a = theta_end * i / chords, b = i + 1.0 < chords ? theta_end * (i + 1.0) / chords : theta_end;
        cpm_vec end = cpm_curve_at(curve, b), chord = cpm_sub(end, start);
        double enter = 0.0, leave = 1.0; /* cut to the scene's box: float sees small numbers */
        int whole = cpm_is_near_box(tree, start) && cpm_is_near_box(tree, end);
        if (whole || cpm_clip_to_box(tree, start, chord, grow, &enter, &leave)) {
            q.chord.a = i == 0.0 && enter == 0.0 ? -slack : a + enter * (b - a) - CPM_OVERLAP * theta_end;
            q.chord.b = a + leave * (b - a);
            q.chord.start = whole ? start : cpm_along(start, enter, chord);
            q.chord.end = whole ? end : cpm_along(start, leave, chord);
            q.chord.off =
                cpm_grown(tree, cpm_scaled(1.0 / (chords * chords), strays)); /* and of this part of the chord */
            cpm_walk(&q, 0);
        }
        start = end;
    }
    *hit = q.best;
    if (hit->primitive >= 0) hit->position = cpm_curve_at(curve, hit->t);
}
#endif
