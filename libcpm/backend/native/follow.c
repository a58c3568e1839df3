/* backend/native/follow.c: the ways of a ray: straight, by closed form (parabolas many at a time), integrated eight
 * abreast.
 *
 * A curved ray comes as pieces (position, momentum and acceleration at both ends). Each piece is asked for its first
 * hit on the curve itself, then whether it crosses the scene's extent; what is first ends the ray. */
#include "follow.h"

#include <math.h>
#include <string.h>

#include "host.h"
/* after the host's */
#include "cl/shared/follow_straight.h"
#include "parabolas.h"
#include "piece_end.h"

#define STRAIGHT 32 /* rays asked for at a time */

static void keep_line(const cpm_flight *flight, const cpm_follow_options *options, size_t number,
                      const cpm_arrival *arrival) {
    cpm_piece piece = {
        .h = arrival->length / arrival->n, .length1 = arrival->length, .n0 = arrival->n, .n1 = arrival->n};
    const cpm_vec r = flight->position, p = cpm_scaled(arrival->n, flight->direction), e = arrival->hit.position;
    memcpy(piece.r0, (const double[3]){r.x, r.y, r.z}, sizeof piece.r0);
    memcpy(piece.p0, (const double[3]){p.x, p.y, p.z}, sizeof piece.p0);
    memcpy(piece.r1, (const double[3]){e.x, e.y, e.z}, sizeof piece.r1);
    memcpy(piece.p1, piece.p0, sizeof piece.p1);
    options->sink(options->user, number, &piece, 1, 1.0);
}

/* A straight ray's end, once its hit is known. */
static void end_straight(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options,
                         size_t number, cpm_arrival *arrival) {
    world_end_straight(&pass->world, flight, options ? options->far : INFINITY, arrival);
    if (options && options->sink) keep_line(flight, options, number, arrival);
}

/* Straight rays of a call, some at a time; other flights in between are left alone. */
static void follow_straight(const cpm_pass *pass, const cpm_flight *flights, size_t count,
                            const cpm_follow_options *options, cpm_arrival *arrivals) {
    cpm_straight_ray rays[STRAIGHT];
    cpm_filter filters[STRAIGHT];
    size_t number[STRAIGHT];
    for (size_t next = 0; next < count;) {
        size_t n = 0;
        for (; next < count && n < STRAIGHT; next++) {
            const cpm_flight *f = &flights[next];
            if (pass->way[cpm_region_medium(&f->region)] != CPM_WAY_STRAIGHT) continue;
            cpm_straight_ray *ray = &rays[n];
            ray->origin = &f->position, ray->direction = &f->direction;
            ray->left = f->left, ray->exact = f->exact;
            ray->slack = 0.0;
            ray->filter = NULL;
            ray->hit = &arrivals[next].hit;
            if (f->crossing) {
                filters[n] = (cpm_filter){&pass->world, &f->region};
                ray->slack = world_slack(&pass->world, f, 1);
                ray->filter = &filters[n];
            }
            number[n++] = next;
        }
        cpm_geometry_straight_many(pass->geometry, rays, n);
        for (size_t i = 0; i < n; i++)
            end_straight(pass, &flights[number[i]], options, number[i], &arrivals[number[i]]);
    }
}

static int is_parabolic(const cpm_pass *pass, int32_t medium) {
    return pass->scene->media[medium].medium->data.kind == CPM_MEDIUM_LINEAR_SQUARED;
}

void cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                cpm_arrival *arrivals) {
    follow_straight(pass, flights, count, options, arrivals);
    if (pass->features & CPM_FEATURE_EXACT)
        for (size_t i = 0; i < count; i++) {
            const int32_t medium = cpm_region_medium(&flights[i].region);
            if (pass->way[medium] == CPM_WAY_EXACT && (options || !is_parabolic(pass, medium)))
                cpm_follow_exact(pass, &flights[i], options, i, &arrivals[i]);
        }
    if ((pass->features & CPM_FEATURE_EXACT) && !options)
        for (size_t m = 0; m < pass->scene->medium_count; m++)
            if (pass->way[m] == CPM_WAY_EXACT && is_parabolic(pass, (int32_t)m))
                cpm_parabolas_chosen()(pass, flights, count, (int32_t)m, arrivals);
    if (pass->features & CPM_FEATURE_INTEGRATOR)
        for (size_t m = 0; m < pass->scene->medium_count; m++)
            if (pass->way[m] == CPM_WAY_INTEGRATED)
                cpm_follow_integrated(pass, flights, count, (int32_t)m, options, arrivals);
    if (pass->features & CPM_FEATURE_BOUNDARIES)
        for (size_t i = 0; i < count; i++) cpm_look_behind(pass, &flights[i], &arrivals[i]);
}
