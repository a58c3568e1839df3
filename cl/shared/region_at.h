/* shared/region_at.h: which bounded media contain a point. */
#ifndef CPM_SHARED_REGION_AT_H
#define CPM_SHARED_REGION_AT_H
#include "curve.h"
#include "region.h"

/* Crossings of the half line from `point` along `direction` with the mesh that bounds a medium, odd: inside. */
CPM_INLINE int world_crossings_odd(const cpm_world *w, CPM_GLOBAL const cpm_place *place, cpm_vec point,
                                   cpm_vec direction) {
    int odd = 0;
    for (cpm_i32 i = 0; i < place->count; i++) {
        CPM_GLOBAL const cpm_triangle *t = &w->tree.triangles[place->first + i];
        cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
        double distance =
            cpm_vdot(cpm_sub(cpm_v(t->corner[0], t->corner[1], t->corner[2]), point), n) / cpm_vdot(direction, n);
        double u, v;
        if (distance > 0.0 && distance < INFINITY &&
            cpm_triangle_contains(t, cpm_along(point, distance, direction), &u, &v))
            odd ^= 1;
    }
    return odd;
}

CPM_INLINE int world_place_contains(const cpm_world *w, CPM_GLOBAL const cpm_place *place, cpm_vec p) {
    const double r[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; k++)
        if (r[k] < place->low[k] || r[k] > place->high[k]) return 0;
    if (place->is_sphere) {
        CPM_GLOBAL const cpm_sphere *ball = &w->tree.spheres[place->first];
        return cpm_norm(cpm_sub(p, cpm_v(ball->center[0], ball->center[1], ball->center[2]))) < ball->radius;
    }
    /* three directions in general position outvote a hit on an edge */
    int votes = world_crossings_odd(w, place, p, cpm_v(0.5377, 0.8339, -0.1249)) +
                world_crossings_odd(w, place, p, cpm_v(-0.8622, 0.3188, 0.3939));
    if (votes == 1) votes += world_crossings_odd(w, place, p, cpm_v(0.3252, -0.7549, 0.5696));
    return votes >= 2;
}

/* What contains a point; on a boundary, what `direction` enters. */
CPM_APART cpm_region world_region_at(const cpm_world *w, cpm_vec point, cpm_vec direction) {
    cpm_region region;
    CPM_CLEAR(region);
    region.count = 1;
    if (w->frame.media == 1) return region;
    double length = cpm_norm(direction);
    cpm_vec inside = length > 0.0 ? cpm_along(point, w->frame.nudge / length, direction) : point;
    for (cpm_i32 m = 1; m < w->frame.media; m++)
        if (world_place_contains(w, &w->places[m], inside)) cpm_region_cross(&region, m, 1);
    return region;
}
#endif
