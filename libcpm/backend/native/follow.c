/* backend/native/follow.c: the three ways of a ray: straight, by closed form, integrated eight abreast.
 *
 * A curved ray comes as pieces (position, momentum and acceleration at both ends). Each piece is asked for its first
 * hit on the curve itself, then whether it crosses the scene's extent; what is first ends the ray. */
#include "follow.h"

#include <math.h>
#include <string.h>

#include "advance.h"
#include "cross.h"

#define MAX_PIECES 100000      /* of a closed form; then evaluations_exhausted */
#define SLACK CPM_COINCIDE     /* how far behind its start a crossing ray looks */

/* A surface at the very place where one piece ends and the next begins may be missed by both, by rounding; so may one
 * that coincides with a boundary just passed. Such starts look back a little. */
typedef struct start {
    const cpm_pass *pass;
    const cpm_flight *flight;
} start;

static double slack_of(const cpm_pass *pass, const cpm_flight *flight, int first) {
    return flight->crossing || !first ? SLACK * pass->reach : 0.0;
}

/* A boundary met at the very start counts only if passing it changes what contains the ray: not the other half of the
 * face just crossed, nor a face that two media share. */
static int boundary_counts(void *user, int32_t primitive, cpm_vec position, cpm_vec direction) {
    const start *s = user;
    return cpm_boundary_counts(s->pass, &s->flight->region, primitive, position, direction);
}

static void begin(const cpm_flight *flight, cpm_arrival *arrival) {
    memset(arrival, 0, sizeof *arrival);
    arrival->hit.primitive = -1;
    arrival->hit.position = flight->position;
    arrival->direction = flight->direction;
    arrival->method = CPM_METHOD_EXACT;
}

/* theta where the curve first crosses a face of the extent outward, in (0, end]; infinite: it does not. */
static double leaves_extent(const cpm_pass *pass, const cpm_curve *curve, double end) {
    cpm_vec at = cpm_curve_at(curve, end);
    const double r[3] = {at.x, at.y, at.z};
    int outside = 0;
    for (int k = 0; k < 3; k++) outside |= !(r[k] >= pass->extent.low[k] && r[k] <= pass->extent.high[k]);
    if (!outside) return INFINITY; /* pieces are short beside the extent: out and in again is not looked for */
    double first = INFINITY;
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            double face = side ? pass->extent.high[k] : pass->extent.low[k], sign = side ? 1.0 : -1.0;
            if (!isfinite(face)) continue;
            cpm_vec normal = cpm_v(k == 0 ? sign : 0.0, k == 1 ? sign : 0.0, k == 2 ? sign : 0.0);
            double roots[5];
            int count = cpm_curve_plane(curve, cpm_scaled(sign * face, normal), normal, 0, 0.0, end, roots);
            for (int i = 0; i < count; i++)
                if (cpm_vdot(cpm_curve_tangent(curve, roots[i]), normal) > 0.0) first = cpm_min(first, roots[i]);
        }
    return isfinite(first) ? first : end; /* it was outside all along */
}

static void arrive(cpm_arrival *arrival, const cpm_curve *curve, double theta, int32_t status) {
    arrival->status = status;
    arrival->hit.position = cpm_curve_at(curve, theta);
    arrival->direction = cpm_unit(cpm_curve_tangent(curve, theta));
}

/* One piece: does it hit or leave? theta of its end, or a negative number to go on. */
static double end_of_piece(const cpm_pass *pass, const cpm_flight *flight, const cpm_curve *curve,
                           cpm_arrival *arrival) {
    /* a layer's face at the start makes a first piece of no length: the next one starts on the surface still */
    int first = cpm_norm(cpm_sub(curve->c[0], flight->position)) <= SLACK * pass->reach;
    double out = leaves_extent(pass, curve, 1.0), end = cpm_min(1.0, out);
    double speed = cpm_norm(curve->c[1]); /* dr/dtheta */
    cpm_hit hit;
    start from = {pass, flight};
    const cpm_filter filter = {boundary_counts, &from};
    cpm_geometry_curve(pass->geometry, curve, end, first ? flight->left : -1,
                       speed > 0.0 ? slack_of(pass, flight, first) / speed : 0.0, &filter, &hit);
    if (hit.primitive >= 0) {
        arrive(arrival, curve, hit.t, CPM_RAY_HIT);
        hit.position = arrival->hit.position;
        arrival->hit = hit;
        return hit.t;
    }
    if (isfinite(out)) {
        arrive(arrival, curve, out, CPM_RAY_LEFT);
        return out;
    }
    return -1.0;
}

double cpm_piece_arc(const cpm_piece *piece, int degree, double theta) {
    if (degree == 1) return theta * (piece->length1 - piece->length0);
    if (degree == 2) return cpm_exact_length(piece->p0, piece->g0, theta * piece->h);
    return cpm_piece_length(piece, theta) - piece->length0;
}

/* Newton from the proportional guess: the arc grows with theta at h |p|. */
double cpm_piece_theta_of_arc(const cpm_piece *piece, int degree, double arc) {
    double whole = piece->length1 - piece->length0, theta = whole > 0.0 ? arc / whole : 0.0;
    for (int i = 0; i < 30; i++) {
        double p[3];
        cpm_piece_momentum(piece, theta, p);
        double slope = piece->h * sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (!(slope > 0.0)) break;
        double change = (arc - cpm_piece_arc(piece, degree, theta)) / slope;
        theta += change;
        if (!(fabs(change) > 1e-15)) break;
    }
    return cpm_min(cpm_max(theta, 0.0), 1.0);
}

static void add_length(cpm_arrival *arrival, const cpm_piece *piece, int degree, double theta) {
    arrival->length = piece->length0 + cpm_piece_arc(piece, degree, theta);
}

static void follow_straight(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options,
                            size_t number, cpm_arrival *arrival) {
    int32_t medium = cpm_region_medium(&flight->region);
    begin(flight, arrival);
    arrival->n = pass->index[(size_t)medium * pass->bins + (size_t)(flight->bin < 0 ? pass->middle : flight->bin)];
    start from = {pass, flight};
    const cpm_filter filter = {boundary_counts, &from};
    cpm_geometry_straight(pass->geometry, flight->position, flight->direction, flight->left, slack_of(pass, flight, 1),
                          &filter, flight->exact, &arrival->hit);
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

/* Closed forms in sigma: discrete layers are straight, linear n^2 is a parabola; a catenary is stood for by quintics. */
static int degree_of(const cpm_medium_data *medium) {
    if (medium->kind == CPM_MEDIUM_LAYERED && medium->interpolation == CPM_FIELD_STEP) return 1;
    return medium->kind == CPM_MEDIUM_LINEAR ? 5 : 2;
}

/* The parabola of a linear n^2 without its arc length, which photons and eye rays do not ask for. */
static void parabola(const cpm_medium_data *medium, double scale, const double r[3], const double p[3], double h,
                     cpm_piece *piece) {
    for (int k = 0; k < 3; k++) {
        double g = 0.5 * scale * medium->axis[k];
        piece->r0[k] = r[k], piece->p0[k] = p[k], piece->g0[k] = piece->g1[k] = g;
        piece->r1[k] = r[k] + h * (p[k] + 0.5 * h * g);
        piece->p1[k] = p[k] + h * g;
    }
    piece->h = h;
    piece->length0 = piece->length1 = piece->n0 = piece->n1 = 0.0;
}

/* Beyond a face of the geometry's box, on its way out and drawn no other way, a ray meets nothing any more: what scatters
 * off the outside of a room mostly ends here, at no cost. The gradient has one direction in linear media, and one axis in
 * layers: across it momentum is constant. */
static int never_returns(const cpm_pass *pass, const cpm_flight *flight, int32_t medium) {
    const cpm_medium_data *data = &pass->scene->media[medium].medium->data;
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    const cpm_box *box = &pass->box;
    if (data->kind == CPM_MEDIUM_GRID) return 0;
    for (int k = 0; k < 3; k++) {
        double a = data->axis[k]; /* the scale is positive: it changes no sign */
        if (data->kind == CPM_MEDIUM_LAYERED && a != 0.0) continue;
        if ((r[k] <= box->low[k] && d[k] < 0.0 && a <= 0.0) || (r[k] >= box->high[k] && d[k] > 0.0 && a >= 0.0)) return 1;
    }
    return 0;
}

/* Refractivity may be scaled by a negative factor only where dispersion crosses 1; then nothing is cut short. */
static int has_left(const cpm_pass *pass, const cpm_flight *flight, int32_t medium, const cpm_follow_options *options,
                    cpm_arrival *arrival) {
    int32_t bin = flight->bin < 0 ? pass->middle : flight->bin;
    if (options || !(pass->scale[(size_t)medium * pass->bins + (size_t)bin] > 0.0)) return 0;
    if (!never_returns(pass, flight, medium)) return 0;
    arrival->status = CPM_RAY_LEFT;
    return 1;
}

/* Where a parabola that starts in the geometry's box first leaves it, in sigma; infinite: it starts outside. A piece need
 * go no further: shorter pieces have chords that stay closer to them. */
static double leaves_box(const cpm_box *box, const double r[3], const double p[3], const double *g, double scale) {
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = 0.5 * scale * g[k]; /* dp/dsigma */
        if (!(r[k] >= box->low[k] && r[k] <= box->high[k])) return INFINITY;
        double face = (p[k] > 0.0 ? box->high[k] : box->low[k]) - r[k], back = (p[k] > 0.0 ? box->low[k] : box->high[k]) - r[k];
        if (a == 0.0) {
            if (p[k] != 0.0) first = cpm_min(first, face / p[k]);
            continue;
        }
        /* p t + a t^2/2 = face, the first crossing ahead; turned back before it: the face behind */
        double d = p[k] * p[k] + 2.0 * a * face;
        double t = 2.0 * face / (p[k] + (p[k] > 0.0 ? sqrt(d) : -sqrt(d)));
        if (!(d >= 0.0)) {
            double root = sqrt(p[k] * p[k] + 2.0 * a * back);
            t = (-p[k] + (a > 0.0 ? root : -root)) / a;
        }
        if (t >= 0.0) first = cpm_min(first, t);
    }
    return first;
}

/* sigma at which a parabola's |p| = n falls to 1e-6 of what it was: a plasma's cut-off, met at normal incidence only;
 * infinite: never. */
static double cut_off(const cpm_piece *piece, double n) {
    const double *p = piece->p0, *g = piece->g0;
    double pg = p[0] * g[0] + p[1] * g[1] + p[2] * g[2], gg = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    double pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], least = 1e-6 * n;
    if (!(pg < 0.0)) return INFINITY;
    double across = pp - pg * pg / gg; /* the least |p|^2, at sigma = -pg/gg */
    return across < least * least ? -pg / gg - sqrt((least * least - across) / gg) : INFINITY;
}

static void follow_exact(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options,
                         size_t number, cpm_arrival *arrival) {
    int32_t m = cpm_region_medium(&flight->region);
    const cpm_medium *medium = pass->scene->media[m].medium;
    double scale = pass->scale[(size_t)m * pass->bins + (size_t)(flight->bin < 0 ? pass->middle : flight->bin)];
    double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    begin(flight, arrival);
    double n = cpm_medium_n_toward(medium, scale, r, d), length = 0.0;
    arrival->n = n;
    arrival->status = n > 0.0 ? CPM_RAY_EVALUATIONS_EXHAUSTED : CPM_RAY_CUTOFF;
    if (!(n > 0.0)) return;
    double p[3] = {n * d[0], n * d[1], n * d[2]};
    int degree = degree_of(&medium->data);
    if (has_left(pass, flight, m, options, arrival)) return;
    for (int i = 0; i < MAX_PIECES; i++) {
        cpm_piece piece;
        double speed = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (!(speed > 1e-6 * n)) {
            arrival->status = CPM_RAY_CUTOFF;
            return;
        }
        double limit = cpm_max(pass->reach, cpm_norm(cpm_sub(cpm_v(r[0], r[1], r[2]), pass->center)));
        if (!options && medium->data.kind == CPM_MEDIUM_LINEAR_SQUARED) {
            double inside = leaves_box(&pass->box, r, p, medium->data.axis, scale);
            double h = cpm_min(limit / speed, inside * (1.0 + 1e-6) + 1e-6 * pass->reach / speed);
            parabola(&medium->data, scale, r, p, h, &piece);
        }
        else if (cpm_exact_next(&medium->data, medium->table, scale, r, p, limit / speed, length, &piece,
                                &arrival->evaluations))
            return;
        double turn = degree == 2 ? cut_off(&piece, n) : INFINITY;
        if (turn < piece.h) /* again, no further than there */
            cpm_exact_next(&medium->data, medium->table, scale, r, p, turn, length, &piece, &arrival->evaluations);
        cpm_curve curve = cpm_curve_from_piece(&piece, degree);
        double theta = end_of_piece(pass, flight, &curve, arrival);
        arrival->steps += 1.0;
        if (options && options->sink) options->sink(options->user, number, &piece, degree, theta < 0.0 ? 1.0 : theta);
        if (theta >= 0.0 || arrival->status == CPM_RAY_HIT) {
            if (options) add_length(arrival, &piece, degree, theta);
            const double e[3] = {arrival->hit.position.x, arrival->hit.position.y, arrival->hit.position.z};
            arrival->n = degree == 1 ? piece.n0 : cpm_medium_n(medium, scale, e);
            return;
        }
        if (turn <= piece.h) {
            arrival->status = CPM_RAY_CUTOFF;
            arrival->hit.position = cpm_v(piece.r1[0], piece.r1[1], piece.r1[2]);
            return;
        }
        memcpy(r, piece.r1, sizeof r);
        memcpy(p, piece.p1, sizeof p);
        length = piece.length1;
        arrival->hit.position = cpm_v(r[0], r[1], r[2]);
        arrival->length = length;
    }
}

/* ---------------------------------------------------------------------------------------------- integrated */

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
        begin(flight, &q->arrivals[q->next]);
        if (!has_left(q->pass, flight, q->medium, q->options, &q->arrivals[q->next])) return q->next++;
    }
    return q->count;
}

static void load_lane(lane_queue *q, int lane, size_t which) {
    const cpm_flight *flight = &q->flights[which];
    const cpm_medium *medium = q->pass->scene->media[q->medium].medium;
    cpm_lane_rays *rays = &q->rays;
    int32_t bin = flight->bin < 0 ? q->pass->middle : flight->bin;
    double scale = q->pass->scale[(size_t)q->medium * q->pass->bins + (size_t)bin];
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    double n = cpm_medium_n(medium, scale, r);
    q->owner[lane] = which;
    for (int k = 0; k < 3; k++) rays->r[k][lane] = r[k], rays->p[k][lane] = n * d[k];
    rays->scale[lane] = scale;
    rays->h[lane] = 0.0;
    rays->length[lane] = rays->optical_path[lane] = 0.0;
    rays->accepted[lane] = 0;
}

static void retire_lane(lane_queue *q, int lane) {
    cpm_arrival *arrival = &q->arrivals[q->owner[lane]];
    const cpm_lane_rays *rays = &q->rays;
    arrival->evaluations = rays->evaluations[lane];
    arrival->steps = rays->steps[lane];
    arrival->rejected = rays->rejected[lane];
    arrival->drift = rays->drift[lane];
    arrival->error = rays->error[lane];
    arrival->method = q->control.method == CPM_METHOD_AUTO ? CPM_METHOD_DOPRI5 : q->control.method;
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
        theta = end_of_piece(q->pass, &q->flights[which], &curve, arrival);
        if (q->options && q->options->sink)
            q->options->sink(q->options->user, which, &piece, 5, theta < 0.0 ? 1.0 : theta);
        arrival->optical_path = rays->optical_path[lane];
        if (theta >= 0.0 || arrival->status == CPM_RAY_HIT) {
            if (q->options) add_length(arrival, &piece, 5, theta);
            retire_lane(q, lane);
            return;
        }
        arrival->hit.position = cpm_v(rays->r[0][lane], rays->r[1][lane], rays->r[2][lane]);
        arrival->direction = cpm_unit(cpm_v(rays->p[0][lane], rays->p[1][lane], rays->p[2][lane]));
        arrival->length = rays->length[lane];
    }
    if (rays->status[lane] >= 0) {
        arrival->status = (int32_t)rays->status[lane];
        retire_lane(q, lane);
    }
}

static void follow_integrated(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                              const cpm_follow_options *options, cpm_arrival *arrivals) {
    const cpm_scene_options *o = &pass->options;
    lane_queue q = {.pass = pass, .flights = flights, .options = options, .arrivals = arrivals, .count = count,
                    .medium = medium};
    q.control = (cpm_lane_control){.medium = &pass->scene->media[medium].medium->data,
                                   .table = pass->scene->media[medium].medium->table,
                                   .method = o->method == CPM_METHOD_EXACT ? CPM_METHOD_AUTO : o->method,
                                   .rtol = o->rtol,
                                   .atol = o->atol, .step = o->step, .max_step = o->max_step,
                                   .expected_length = pass->reach,
                                   .max_evaluations = options ? options->max_evaluations : 0};
    for (int lane = 0; lane < CPM_LANES; lane++) q.owner[lane] = count, q.rays.status[lane] = CPM_RAY_ARRIVED;
    for (;;) {
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

/* A surface that coincides with a boundary stands before it: what lies on a floor does not let the ray into the floor. */
static void prefer_surface(const cpm_pass *pass, const cpm_flight *flight, cpm_arrival *arrival) {
    if (arrival->status != CPM_RAY_HIT || !cpm_is_boundary(pass, arrival->hit.primitive)) return;
    cpm_region region = flight->region;
    int32_t surface = cpm_cross_all(pass, &arrival->hit, arrival->direction, &region);
    if (surface < 0) return;
    arrival->hit.primitive = surface;
    arrival->hit.u = arrival->hit.v = 1.0 / 3.0;
}

void cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                cpm_arrival *arrivals) {
    for (size_t i = 0; i < count; i++) {
        uint8_t way = pass->way[cpm_region_medium(&flights[i].region)];
        if (way == CPM_WAY_STRAIGHT) follow_straight(pass, &flights[i], options, i, &arrivals[i]);
        else if (way == CPM_WAY_EXACT) follow_exact(pass, &flights[i], options, i, &arrivals[i]);
    }
    if (pass->features & CPM_FEATURE_INTEGRATOR)
        for (size_t m = 0; m < pass->scene->medium_count; m++)
            if (pass->way[m] == CPM_WAY_INTEGRATED)
                follow_integrated(pass, flights, count, (int32_t)m, options, arrivals);
    if (pass->features & CPM_FEATURE_BOUNDARIES)
        for (size_t i = 0; i < count; i++) prefer_surface(pass, &flights[i], &arrivals[i]);
}
