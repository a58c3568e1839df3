/* shared/boundary.h: ways on from where a ray has arrived: thrown back, or across the boundary of a medium by Snell and
 * Fresnel. Single rays in double only. */
#ifndef CPM_SHARED_BOUNDARY_H
#define CPM_SHARED_BOUNDARY_H
#include "scatter.h"
#include "shading.h"
#include "world_index.h"

#define CPM_EQUAL_INDEX 1e-9 /* a jump of n below this is none */

/* Does a bundle part here, because the medium behind disperses? */
CPM_INLINE int world_splits(const cpm_world *w, const cpm_flight *flight, const cpm_arrival *arrival) {
    return flight->bin < 0 && arrival->behind.count && w->places[cpm_region_medium(&arrival->behind)].disperses;
}

#if CPM_WIDTH == 1 && !CPM_SINGLE
/* A flight thrown back into the medium where another has arrived. */
CPM_INLINE cpm_flight world_depart(const cpm_world *w, const cpm_flight *flight, const cpm_arrival *arrival,
                                   cpm_vec direction) {
    cpm_flight next = *flight;
    next.position = scatter_step_back(arrival->hit.position, flight->position, arrival->direction, w->tree.frame.scale);
    next.direction = direction;
    next.left = arrival->hit.primitive;
    next.exact = cpm_is_near_edge(&w->tree, &arrival->hit);
    next.crossing = 0;
    return next;
}

/* Both ways on from a boundary. Returns 0 where more than CPM_MAX_NESTED media would overlap. */
CPM_INLINE int world_pass_boundary(const cpm_world *w, const cpm_flight *flight, const cpm_arrival *arrival,
                                   cpm_passage *passage) {
    cpm_vec geometric = world_normal(w, arrival->hit.primitive, arrival->hit.position);
    const cpm_region region = arrival->behind;
    if (!region.count) return 0;
    passage->jumps = passage->total = 0;
    passage->reflectance = 0.0;
    passage->transmitted = world_depart(w, flight, arrival, arrival->direction);
    passage->transmitted.position = arrival->hit.position;
    passage->transmitted.region = region;
    passage->transmitted.crossing = 1;
    cpm_i32 before = cpm_region_medium(&flight->region), behind = cpm_region_medium(&region);
    if (before == behind) return 1;
    double n = world_index(w, behind, flight->bin, arrival->hit.position);
    if (!(fabs(n - arrival->n) > CPM_EQUAL_INDEX)) return 1;

    cpm_vec normal = world_shading_normal(w, &arrival->hit, geometric), reflected, refracted;
    passage->jumps = 1;
    passage->reflectance =
        scatter_boundary(arrival->direction, normal, geometric, arrival->n, n, &reflected, &refracted);
    passage->total = passage->reflectance >= 1.0;
    passage->reflected = world_depart(w, flight, arrival, reflected);
    if (!passage->total) passage->transmitted.direction = refracted;
    return 1;
}
#endif
#endif
