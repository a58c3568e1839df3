/* shared/follow_straight.h: rays in media of one n. */
#ifndef CPM_SHARED_FOLLOW_STRAIGHT_H
#define CPM_SHARED_FOLLOW_STRAIGHT_H
#include "clip.h"
#include "piece_end.h"
#include "straight.h"

/* Where a straight ray leaves the extent, if that is not farther than `out`, metres. */
CPM_INLINE double world_leaves_at(const cpm_world *w, const cpm_flight *flight, double out) {
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    for (int k = 0; k < 3; k++) {
        double t = ((d[k] > 0.0 ? w->frame.high[k] : w->frame.low[k]) - r[k]) / d[k];
        if (d[k] != 0.0) out = cpm_min(out, cpm_max(t, 0.0));
    }
    return out;
}

CPM_INLINE int cpm_is_inside(double low, double high, double from, double to) {
    const double margin = 1e-12 * (fabs(from) + fabs(to));
    return to >= low + margin && to <= high - margin;
}

/* Surely not beyond the extent, which is convex: beyond all rounding of its point, so that the distances need not be
 * compared. */
CPM_INLINE int world_surely_inside(const cpm_world *w, cpm_vec a, cpm_vec b) {
    const double *low = w->frame.low, *high = w->frame.high;
    return cpm_is_inside(low[0], high[0], a.x, b.x) && cpm_is_inside(low[1], high[1], a.y, b.y) &&
           cpm_is_inside(low[2], high[2], a.z, b.z);
}

/* A straight ray's end, once its hit is known; `far`: metres beyond which it is of no interest. */
CPM_INLINE void world_end_straight(const cpm_world *w, const cpm_flight *flight, double far, cpm_arrival *arrival) {
    const cpm_i32 medium = flight->region.media[flight->region.count - 1];
    const int hits = arrival->hit.primitive >= 0;
    arrival->status = CPM_ARRIVAL_HIT;
    arrival->direction = flight->direction;
    arrival->n = w->index[medium * w->frame.bins + cpm_bins_middle(flight->bin, w->frame.bins)];
    arrival->behind.count = 0;
    arrival->drift = arrival->error = arrival->evaluations = arrival->steps = arrival->rejected = 0.0;
    arrival->method = CPM_STEP_EXACT;
    arrival->length = arrival->hit.t;
    double out = far;
    if (w->frame.bounded && !(hits && world_surely_inside(w, flight->position, arrival->hit.position)))
        out = world_leaves_at(w, flight, out);
    if (!hits || arrival->hit.t > out) {
        arrival->status = CPM_ARRIVAL_LEFT;
        arrival->hit.primitive = -1;
        arrival->length = out < INFINITY ? out : 0.0;
        arrival->hit.position = cpm_along(flight->position, arrival->length, flight->direction);
    }
    arrival->optical_path = arrival->n * arrival->length;
}

/* The first hit in double throughout, by the curves' way; `slack` in metres. */
CPM_INLINE void world_straight_exactly(const cpm_world *w, const cpm_flight *flight, double slack, cpm_hit *hit) {
    double enter = -slack, leave = INFINITY;
    cpm_filter filter;
    hit->primitive = -1;
    if (!w->tree.nodes ||
        !cpm_clip_to_box(&w->tree, flight->position, flight->direction, 1e-12 * w->tree.frame.scale, &enter, &leave) ||
        !(leave > 0.0))
        return;
    const double reach = leave + 1e-9 * (leave + w->tree.frame.scale);
    cpm_curve line = cpm_line(flight->position, cpm_scaled(reach, flight->direction));
    filter.world = w, filter.region = &flight->region;
    CPM_ASK_CURVE(w, &line, 1.0, flight->left, slack / reach, &filter, hit);
    hit->t *= reach;
}

/* A straight flight without Embree: the tree says what is met, and where there is no edge near, it is met at the same
 * place as by Embree's word: that of the polished hit. */
CPM_INLINE void world_follow_straight(const cpm_world *w, const cpm_flight *flight, cpm_arrival *arrival) {
    const cpm_i32 triangles = w->tree.frame.triangle_count;
    const double slack = flight->crossing ? world_slack(w, flight, 1) : 0.0;
    cpm_hit *hit = &arrival->hit;
    world_straight_exactly(w, flight, slack, hit);
    if (hit->primitive >= 0 && !flight->exact && !(slack > 0.0) && !w->frame.coarse) {
        cpm_hit polished = *hit;
        const int leaving = hit->primitive == flight->left;
        if (hit->primitive < triangles
                ? !leaving && cpm_polish_triangle(&w->tree.triangles[hit->primitive], flight->position,
                                                  flight->direction, &polished)
                : cpm_polish_sphere(&w->tree.spheres[hit->primitive - triangles], flight->position, flight->direction,
                                    leaving, hit->t, &polished))
            *hit = polished;
    }
    world_end_straight(w, flight, INFINITY, arrival);
}
#endif
