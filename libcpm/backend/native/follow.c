/* backend/native/follow.c: the ways of a ray: straight, by closed form (parabolas many at a time), integrated eight
 * abreast.
 *
 * A curved ray comes as pieces (position, momentum and acceleration at both ends). Each piece is asked for its first
 * hit on the curve itself, then whether it crosses the scene's extent; what is first ends the ray. */
#include "follow.h"

#include <math.h>
#include <string.h>

#include "parabolas.h"
#include "piece_end.h"

static void follow_straight(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options,
                            size_t number, cpm_arrival *arrival) {
    int32_t medium = cpm_region_medium(&flight->region);
    cpm_arrival_begin(flight, arrival);
    arrival->n = pass->index[(size_t)medium * pass->bins + (size_t)(flight->bin < 0 ? pass->middle : flight->bin)];
    cpm_start from = {pass, flight};
    const cpm_filter filter = {cpm_start_counts, &from};
    cpm_geometry_straight(pass->geometry, flight->position, flight->direction, flight->left,
                          cpm_slack_of(pass, flight, 1), &filter, flight->exact, &arrival->hit);
    double length = arrival->hit.t, out = options ? options->far : INFINITY;
    if (pass->bounded) {
        const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
        const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
        for (int k = 0; k < 3; k++) {
            double t = ((d[k] > 0.0 ? pass->extent.high[k] : pass->extent.low[k]) - r[k]) / d[k];
            if (d[k] != 0.0) out = cpm_min(out, cpm_max(t, 0.0));
        }
    }

    arrival->status = CPM_RAY_HIT;
    if (arrival->hit.primitive < 0 || arrival->hit.t > out) {
        arrival->status = CPM_RAY_LEFT;
        arrival->hit.primitive = -1;
        length = isfinite(out) ? out : 0.0;
        arrival->hit.position = cpm_along(flight->position, length, flight->direction);
    }
    arrival->length = length;
    arrival->optical_path = arrival->n * length;
    if (options && options->sink) {
        cpm_piece piece = {.h = length / arrival->n, .length1 = length, .n0 = arrival->n, .n1 = arrival->n};
        const cpm_vec r = flight->position, p = cpm_scaled(arrival->n, flight->direction), e = arrival->hit.position;
        memcpy(piece.r0, (const double[3]){r.x, r.y, r.z}, sizeof piece.r0);
        memcpy(piece.p0, (const double[3]){p.x, p.y, p.z}, sizeof piece.p0);
        memcpy(piece.r1, (const double[3]){e.x, e.y, e.z}, sizeof piece.r1);
        memcpy(piece.p1, piece.p0, sizeof piece.p1);
        options->sink(options->user, number, &piece, 1, 1.0);
    }
}

static int is_parabolic(const cpm_pass *pass, int32_t medium) {
    return pass->scene->media[medium].medium->data.kind == CPM_MEDIUM_LINEAR_SQUARED;
}

void cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                cpm_arrival *arrivals) {
    for (size_t i = 0; i < count; i++) {
        uint8_t way = pass->way[cpm_region_medium(&flights[i].region)];
        if (way == CPM_WAY_STRAIGHT)
            follow_straight(pass, &flights[i], options, i, &arrivals[i]);
        else if (way == CPM_WAY_EXACT && (options || !is_parabolic(pass, cpm_region_medium(&flights[i].region))))
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
