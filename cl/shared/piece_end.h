/* shared/piece_end.h: where a piece of a ray ends in a scene: what straight, exact and integrated rays share. */
#ifndef CPM_SHARED_PIECE_END_H
#define CPM_SHARED_PIECE_END_H
#include "../types/lanes.h"
#include "behind.h"
#include "bins.h"
#include "curve.h"

/* An arrival that has not arrived. */
CPM_INLINE void cpm_arrival_begin(const cpm_flight *flight, cpm_arrival *arrival) {
    CPM_CLEAR(*arrival);
    arrival->hit.primitive = -1;
    arrival->hit.position = flight->position;
    arrival->direction = flight->direction;
    arrival->method = CPM_STEP_EXACT;
}

/* Dispersion's factor for a flight in a medium. */
CPM_INLINE double world_scale(const cpm_world *w, const cpm_flight *flight, cpm_i32 medium) {
    return w->scale[medium * w->frame.bins + cpm_bins_middle(flight->bin, w->frame.bins)];
}

/* A surface at the very place where one piece ends and the next begins may be missed by both, by rounding; so may one
 * that coincides with a boundary just passed. Such starts look back a little, metres; `first`: the piece that begins
 * where the flight does. */
CPM_INLINE double world_slack(const cpm_world *w, const cpm_flight *flight, int first) {
    return flight->crossing || !first ? CPM_COINCIDE * w->frame.reach : 0.0;
}

/* theta where the curve first crosses a face of the extent outward, in (0, end]; infinite: it does not. */
CPM_INLINE double world_leaves_extent(const cpm_world *w, const cpm_curve *curve, double end) {
    const double *low = w->frame.low, *high = w->frame.high;
    cpm_vec at = cpm_curve_at(curve, end);
    const double r[3] = {at.x, at.y, at.z};
    int outside = 0;
    for (int k = 0; k < 3; k++) outside |= !(r[k] >= low[k] && r[k] <= high[k]);
    if (!outside) return INFINITY; /* pieces are short beside the extent: out and in again is not looked for */
    double first = INFINITY;
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            double face = side ? high[k] : low[k], sign = side ? 1.0 : -1.0;
            if (!(fabs(face) < INFINITY)) continue;
            cpm_vec normal = cpm_v(k == 0 ? sign : 0.0, k == 1 ? sign : 0.0, k == 2 ? sign : 0.0);
            double roots[5];
            int count = cpm_curve_plane(curve, cpm_scaled(sign * face, normal), normal, 0, 0.0, end, roots);
            for (int i = 0; i < count; i++)
                if (cpm_vdot(cpm_curve_tangent(curve, roots[i]), normal) > 0.0) first = cpm_min(first, roots[i]);
        }
    return first < INFINITY ? first : end; /* it was outside all along */
}

CPM_INLINE void cpm_arrive(cpm_arrival *arrival, const cpm_curve *curve, double theta, cpm_i32 status) {
    arrival->status = status;
    arrival->hit.position = cpm_curve_at(curve, theta);
    arrival->direction = cpm_unit(cpm_curve_tangent(curve, theta));
}

/* Does the piece hit or leave? theta of its end, with the arrival filled in, or a negative number to go on. */
CPM_INLINE double world_end_of_piece(const cpm_world *w, const cpm_flight *flight, const cpm_curve *curve,
                                     cpm_arrival *arrival) {
    /* a layer's face at the start makes a first piece of no length: the next one starts on the surface still */
    int first = cpm_norm(cpm_sub(curve->c[0], flight->position)) <= CPM_COINCIDE * w->frame.reach;
    double speed = cpm_norm(curve->c[1]); /* dr/dtheta */
    /* A wall on the very face of a layer may lie beyond the piece's end by rounding, and the next piece may be thrown
     * back there: so what is that near counts, before the ray turns. */
    double ahead = speed > 0.0 ? CPM_COINCIDE * w->frame.reach / speed : 0.0;
    double out = world_leaves_extent(w, curve, 1.0), end = cpm_min(1.0 + ahead, out);
    cpm_hit hit;
    cpm_filter filter;
    filter.world = w, filter.region = &flight->region;
    CPM_ASK_CURVE(w, curve, end, first ? flight->left : -1, speed > 0.0 ? world_slack(w, flight, first) / speed : 0.0,
                  &filter, &hit);
    if (hit.primitive >= 0) {
        cpm_arrive(arrival, curve, hit.t, CPM_ARRIVAL_HIT);
        hit.position = arrival->hit.position;
        arrival->hit = hit;
        return hit.t;
    }
    if (out < INFINITY) {
        cpm_arrive(arrival, curve, out, CPM_ARRIVAL_LEFT);
        return out;
    }
    return -1.0;
}

/* Beyond a face of the geometry's box, on its way out and drawn no other way, a ray meets nothing any more: what
 * scatters off the outside of a room mostly ends here, at no cost. The gradient has one direction in linear media, and
 * one axis in layers: across it momentum is constant. Refractivity may be scaled by a negative factor only where
 * dispersion crosses 1; then nothing is cut short. */
CPM_INLINE int world_never_returns(const cpm_world *w, const cpm_flight *flight, cpm_i32 medium, cpm_vec position,
                                   cpm_vec direction) {
    CPM_GLOBAL const cpm_medium_data *data = &w->media[medium];
    const double r[3] = {position.x, position.y, position.z}, d[3] = {direction.x, direction.y, direction.z};
    if (!(world_scale(w, flight, medium) > 0.0)) return 0;
    if (data->kind != CPM_MEDIUM_LINEAR_SQUARED && data->kind != CPM_MEDIUM_LINEAR && data->kind != CPM_MEDIUM_LAYERED)
        return 0;
    for (int k = 0; k < 3; k++) {
        double a = data->axis[k]; /* the scale is positive: it changes no sign */
        if (data->kind == CPM_MEDIUM_LAYERED && a != 0.0) continue;
        if ((r[k] <= w->frame.box_low[k] && d[k] < 0.0 && a <= 0.0) ||
            (r[k] >= w->frame.box_high[k] && d[k] > 0.0 && a >= 0.0))
            return 1;
    }
    return 0;
}

/* 1, and the arrival has LEFT, where the flight cannot come back to any surface. */
CPM_INLINE int world_has_left(const cpm_world *w, const cpm_flight *flight, cpm_i32 medium, cpm_arrival *arrival) {
    if (!world_never_returns(w, flight, medium, flight->position, flight->direction)) return 0;
    arrival->status = CPM_ARRIVAL_LEFT;
    return 1;
}

/* The same where a piece without a hit ends. */
CPM_INLINE int world_leaves_after(const cpm_world *w, const cpm_flight *flight, cpm_i32 medium, cpm_vec end,
                                  cpm_vec tangent, cpm_arrival *arrival) {
    if (!world_never_returns(w, flight, medium, end, tangent)) return 0;
    arrival->status = CPM_ARRIVAL_LEFT;
    arrival->hit.position = end;
    arrival->direction = cpm_unit(tangent);
    return 1;
}
#endif
