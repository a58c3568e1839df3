/* shared/behind.h: what a ray enters where it meets a boundary. CPM_ASK_CURVE(world, curve, end, left, slack, filter,
 * hit) is the first hit of a curve: the walk of walk.h unless the host has defined it before. */
#ifndef CPM_SHARED_BEHIND_H
#define CPM_SHARED_BEHIND_H
#include "region.h"
#ifndef CPM_ASK_CURVE
#include "walk.h"
#define CPM_ASK_CURVE(w, curve, end, left, slack, filter, hit)                                                         \
    do {                                                                                                               \
        (hit)->primitive = -1;                                                                                         \
        if ((w)->tree.nodes) cpm_first_hit(&(w)->tree, curve, end, left, slack, filter, hit);                          \
    } while (0)
#endif

#define CPM_COINCIDE 1e-11 /* of the scene: surfaces closer than this along a ray are one */

/* Fills arrival->behind: what contains the ray once it has passed the boundary that it met and all that coincide with
 * it. A surface that coincides stands before them (what lies on a floor does not let the ray into the floor): then it
 * is what was met. */
CPM_INLINE void world_look_behind(const cpm_world *w, const cpm_flight *flight, cpm_arrival *arrival) {
    cpm_region region = flight->region;
    if (arrival->status == CPM_ARRIVAL_HIT && world_is_boundary(w, arrival->hit.primitive)) {
        cpm_i32 primitive = arrival->hit.primitive;
        for (int i = 0; i < 2 * CPM_MAX_NESTED; i++) {
            if (!world_cross(w, &region, primitive, arrival->hit.position, arrival->direction)) {
                region.count = 0;
                break;
            }
            /* what else is within a hair of the hit, before or behind, and counts */
            cpm_curve line;
            cpm_filter filter;
            cpm_hit other;
            line.degree = 1, line.padding = 0;
            line.c[0] = arrival->hit.position,
            line.c[1] = cpm_scaled(CPM_COINCIDE * w->frame.reach, arrival->direction);
            filter.world = w, filter.region = &region;
            CPM_ASK_CURVE(w, &line, 1.0, primitive, 1.0, &filter, &other);
            if (other.primitive < 0) break;
            if (!world_is_boundary(w, other.primitive)) {
                other.position = arrival->hit.position;
                other.t = arrival->hit.t;
                arrival->hit = other;
                break;
            }
            primitive = other.primitive;
        }
    }
    arrival->behind = region;
}
#endif
