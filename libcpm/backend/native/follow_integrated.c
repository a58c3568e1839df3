/* backend/native/follow_integrated.c: integrated rays, eight abreast: a lane that has arrived is loaded anew. */
#include <string.h>

#include "advance.h"
#include "host.h"
/* after the host's */
#include "cl/shared/follow_integrated.h"
#include "piece_end.h"

#define POLL_EVERY 64 /* steps of eight lanes */

typedef struct lane_queue {
    const cpm_pass *pass;
    const cpm_flight *flights;
    const cpm_follow_options *options;
    cpm_arrival *arrivals;
    size_t count;
    int32_t medium;
    size_t next;
    size_t owner[CPM_LANES]; /* flight in each lane, count: none */
    cpm_lane_control control;
    cpm_lane_rays rays;
} lane_queue;

/* The next flight that starts in the queue's medium. */
static size_t next_flight(lane_queue *q) {
    for (; q->next < q->count; q->next++) {
        const cpm_flight *flight = &q->flights[q->next];
        if (cpm_region_medium(&flight->region) != q->medium) continue;
        cpm_arrival_begin(flight, &q->arrivals[q->next]);
        if (q->options || !world_has_left(&q->pass->world, flight, q->medium, &q->arrivals[q->next])) return q->next++;
    }
    return q->count;
}

static void load_lane(lane_queue *q, int lane, size_t which) {
    const cpm_flight *flight = &q->flights[which];
    const cpm_medium *medium = q->pass->scene->media[q->medium].medium;
    cpm_lane_rays *rays = &q->rays;
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    world_load_lane(&q->pass->world, q->medium, flight, rays, lane);
    const double n = cpm_medium_n(medium, rays->scale[lane], r);
    q->owner[lane] = which;
    for (int k = 0; k < 3; k++) rays->p[k][lane] *= n;
}

static void retire_lane(lane_queue *q, int lane) {
    cpm_arrival *arrival = &q->arrivals[q->owner[lane]];
    const cpm_lane_rays *rays = &q->rays;
    cpm_lane_arrives(rays, lane, q->control.method, arrival);
    const cpm_medium *medium = q->pass->scene->media[q->medium].medium;
    const double e[3] = {arrival->hit.position.x, arrival->hit.position.y, arrival->hit.position.z};
    arrival->n = cpm_medium_n(medium, rays->scale[lane], e);
    q->owner[lane] = q->count;
    q->rays.status[lane] = CPM_RAY_ARRIVED; /* stands still */
}

static void end_lane_step(lane_queue *q, int lane) {
    size_t which = q->owner[lane];
    cpm_arrival *arrival = &q->arrivals[which];
    cpm_lane_rays *rays = &q->rays;
    double theta = -1.0;
    if (rays->accepted[lane]) {
        cpm_piece piece;
        cpm_lane_piece(rays, lane, &piece);
        cpm_curve curve = cpm_curve_from_piece(&piece, 5);
        theta = world_end_of_piece(&q->pass->world, &q->flights[which], &curve, arrival);
        if (q->options && q->options->sink)
            q->options->sink(q->options->user, which, &piece, 5, theta < 0.0 ? 1.0 : theta);
        arrival->optical_path = rays->optical_path[lane];
        if (theta >= 0.0 || arrival->status == CPM_RAY_HIT) {
            if (q->options) {
                cpm_add_length(arrival, &piece, 5, theta);
                arrival->optical_path =
                    arrival->length + cpm_column_between(rays->optical_path0[lane] - rays->length0[lane],
                                                         rays->optical_path[lane] - rays->length[lane], piece.h,
                                                         piece.n0, piece.n1, theta);
            }
            retire_lane(q, lane);
            return;
        }
        arrival->hit.position = cpm_v(rays->r[0][lane], rays->r[1][lane], rays->r[2][lane]);
        arrival->direction = cpm_unit(cpm_v(rays->p[0][lane], rays->p[1][lane], rays->p[2][lane]));
        arrival->length = rays->length[lane];
        if (rays->status[lane] < 0 && q->options && cpm_beyond(q->options, arrival->length))
            rays->status[lane] = CPM_RAY_LEFT;
    }
    if (rays->status[lane] >= 0) {
        arrival->status = (int32_t)rays->status[lane];
        retire_lane(q, lane);
    }
}

/* Cancelled: rays that have not ended hit nothing. */
static void abandon(lane_queue *q) {
    for (int lane = 0; lane < CPM_LANES; lane++)
        if (q->owner[lane] < q->count) q->arrivals[q->owner[lane]].status = CPM_RAY_EVALUATIONS_EXHAUSTED;
    for (size_t which; (which = next_flight(q)) < q->count;) q->arrivals[which].status = CPM_RAY_EVALUATIONS_EXHAUSTED;
}

void cpm_follow_integrated(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                           const cpm_follow_options *options, cpm_arrival *arrivals) {
    const cpm_scene_options *o = &pass->options;
    lane_queue q = {
        .pass = pass, .flights = flights, .options = options, .arrivals = arrivals, .count = count, .medium = medium};
    q.control = (cpm_lane_control){.medium = &pass->scene->media[medium].medium->data,
                                   .table = pass->scene->media[medium].medium->table,
                                   .method = pass->method[medium],
                                   .rtol = o->rtol,
                                   .atol = o->atol,
                                   .step = o->step,
                                   .max_step = options && options->max_step > 0.0 ? options->max_step : o->max_step,
                                   .expected_length = pass->reach,
                                   .max_evaluations = options ? options->max_evaluations : 0};
    for (int lane = 0; lane < CPM_LANES; lane++) q.owner[lane] = count, q.rays.status[lane] = CPM_RAY_ARRIVED;
    for (int64_t steps = 1;; steps++) {
        if (steps % POLL_EVERY == 0 && cpm_poll(pass->context)) {
            abandon(&q);
            return;
        }
        /* starting lanes costs a whole packet however few they are: not for less than half of them */
        int64_t fresh[CPM_LANES] = {0}, any = 0, going = 0, idle = 0;
        for (int lane = 0; lane < CPM_LANES; lane++) idle += q.owner[lane] == count;
        for (int lane = 0; lane < CPM_LANES; lane++) {
            if (q.owner[lane] == count && idle >= CPM_LANES / 2) {
                size_t which = next_flight(&q);
                if (which < count) {
                    load_lane(&q, lane, which);
                    fresh[lane] = 1;
                    any = 1;
                }
            }
            going |= q.owner[lane] < count;
        }
        if (!going) return;
        if (any) cpm_lanes_start(&q.control, &q.rays, fresh);
        cpm_lanes_step(&q.control, &q.rays);
        for (int lane = 0; lane < CPM_LANES; lane++)
            if (q.owner[lane] < count) end_lane_step(&q, lane);
    }
}
