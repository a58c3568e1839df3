/* shared/follow_integrated.h: integrated rays of a scene, eight abreast: a lane that has arrived is loaded anew. */
#ifndef CPM_SHARED_FOLLOW_INTEGRATED_H
#define CPM_SHARED_FOLLOW_INTEGRATED_H
#include "step.h"
#include "world_index.h"

/* A flight into a lane, which still needs its momentum: `p` holds its direction. */
CPM_INLINE void world_load_lane(const cpm_world *w, cpm_i32 medium, const cpm_flight *flight, cpm_lane_rays *rays,
                                int lane) {
    rays->r[0][lane] = flight->position.x, rays->r[1][lane] = flight->position.y, rays->r[2][lane] = flight->position.z;
    rays->p[0][lane] = flight->direction.x, rays->p[1][lane] = flight->direction.y;
    rays->p[2][lane] = flight->direction.z;
    rays->scale[lane] = world_scale(w, flight, medium);
    rays->h[lane] = 0.0;
    rays->length[lane] = rays->optical_path[lane] = 0.0;
    rays->accepted[lane] = 0;
}

/* What a lane leaves of its ray. */
CPM_INLINE void cpm_lane_arrives(const cpm_lane_rays *rays, int lane, cpm_i32 method, cpm_arrival *arrival) {
    arrival->evaluations = rays->evaluations[lane];
    arrival->steps = rays->steps[lane];
    arrival->rejected = rays->rejected[lane];
    arrival->drift = rays->drift[lane];
    arrival->error = rays->error[lane];
    arrival->method = method;
}

#ifndef CPM_HOST_LANES /* the host's loop is its own: it is asked whether to stop, and keeps pieces for those who draw \
                        */
/* Momenta of lanes that were loaded with directions. */
CPM_INLINE void cpm_lanes_push(const cpm_medium_data *m, CPM_GLOBAL const double *table, cpm_lane_rays *rays,
                               const cpm_i64 *fresh) {
    for (int part = 0; part < CPM_PARTS; part++) {
        const mask some = ~equal(load_flags(fresh, part), splat_mask(0));
        real n;
        real3 d = load3_doubles(rays->p, part);
        if (!any_lane(some)) continue;
        cpm_field(m, table, load3_doubles(rays->r, part), load_doubles(rays->scale, part), &n);
        store3_doubles(pick3(some & less(splat(0.0), n), scale3(n, d), d), rays->p, part);
    }
}

/* Flights first..last - 1, those of them that start in medium `medium`, which is `m`. */
CPM_INLINE void world_follow_integrated(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                        CPM_GLOBAL const double *table, const cpm_step_control *c,
                                        CPM_GLOBAL const cpm_flight *flights, CPM_GLOBAL cpm_arrival *arrivals,
                                        cpm_i64 first, cpm_i64 last) {
    cpm_lane_rays rays;
    cpm_i64 owner[CPM_LANES], fresh[CPM_LANES];
    int idle = CPM_LANES;
    CPM_CLEAR(rays);
    for (int i = 0; i < CPM_LANES; i++) owner[i] = -1, rays.status[i] = CPM_ENDED_ARRIVED;
    for (;;) {
        int any = 0;
        for (int i = 0; i < CPM_LANES; i++) fresh[i] = 0;
        /* starting lanes costs a whole packet however few they are: not for less than half of them */
        if (idle >= CPM_LANES / 2)
            for (int i = 0; i < CPM_LANES; i++)
                while (owner[i] < 0 && first < last) {
                    cpm_flight flight = flights[first];
                    if (cpm_region_medium(&flight.region) == medium) {
                        cpm_arrival arrival;
                        cpm_arrival_begin(&flight, &arrival);
                        if (world_has_left(w, &flight, medium, &arrival))
                            arrivals[first] = arrival;
                        else {
                            world_load_lane(w, medium, &flight, &rays, i);
                            rays.expected[i] = w->frame.reach;
                            owner[i] = first, fresh[i] = any = 1;
                            idle--;
                        }
                    }
                    first++;
                }
        if (idle == CPM_LANES) return;
        if (any) {
            cpm_lanes_push(m, table, &rays, fresh);
            cpm_lanes_begin(c, m, table, &rays, fresh);
        }
        cpm_lanes_attempt(c, m, table, &rays);
        for (int i = 0; i < CPM_LANES; i++) {
            if (owner[i] < 0 || !(rays.accepted[i] || rays.status[i] >= 0)) continue;
            cpm_flight flight = flights[owner[i]];
            cpm_arrival arrival;
            double theta = -1.0;
            cpm_arrival_begin(&flight, &arrival);
            if (rays.accepted[i]) {
                cpm_piece piece;
                cpm_lanes_piece(&rays, i, &piece);
                cpm_curve curve = cpm_curve_from_piece(&piece, 5);
                theta = world_end_of_piece(w, &flight, &curve, &arrival);
            }
            const int arrived = theta >= 0.0 || arrival.status == CPM_ARRIVAL_HIT;
            if (!arrived && rays.status[i] < 0) continue;
            if (!arrived) {
                arrival.status = (cpm_i32)rays.status[i];
                arrival.hit.position = cpm_v(rays.r[0][i], rays.r[1][i], rays.r[2][i]);
                if (rays.steps[i] > 0.0) arrival.direction = cpm_unit(cpm_v(rays.p[0][i], rays.p[1][i], rays.p[2][i]));
            }
            const double end[3] = {arrival.hit.position.x, arrival.hit.position.y, arrival.hit.position.z};
            cpm_lane_arrives(&rays, i, c->method, &arrival);
            arrival.n = cpm_index_at(m, table, rays.scale[i], end);
            arrivals[owner[i]] = arrival;
            owner[i] = -1;
            rays.status[i] = CPM_ENDED_ARRIVED; /* stands still */
            rays.accepted[i] = 0;
            idle++;
        }
    }
}
#endif
#endif
