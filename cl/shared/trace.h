/* shared/trace.h: rays alone in a medium, each to its arc length or to the first crossing of a plane.
 *
 * Eight rays at a time; a lane whose ray has ended is loaded anew once half of the packet is idle, so that a slow ray
 * does not hold the others. Lanes never influence each other: a ray's result does not depend on what runs beside it.
 *
 * Float lanes run in a frame whose origin is the medium's, moved there in double (cpm_local_frame): what the field sees
 * is as small as it can be.
 *
 * With samples > 0 (path samples wanted) the same rays are traced once more, after a first call that found their
 * lengths: positions are written as they are passed, so that no path is ever stored. */
#ifndef CPM_SHARED_TRACE_H
#define CPM_SHARED_TRACE_H
#include "exact.h"
#include "step.h"

#define CPM_TOUCHING 1e-6 /* of a step: a plane so little beyond its end is met: the next step would start on it */
#define CPM_LANDING 0.05  /* of a step: how far beyond its end the quintic is as good as its inside (piece.h) */
#define CPM_REFILL 4      /* idle lanes that are worth a start of new rays */

/* The memory of one range of rays that are traced together. */
typedef struct {
    CPM_GLOBAL const cpm_ray_start *starts;
    CPM_GLOBAL cpm_ray_end *ends;
    CPM_GLOBAL double *positions; /* samples x 3 a ray */
    cpm_i64 samples;
} cpm_trace_arrays;

/* Media that may be moved by their origin, the same in any frame. */
CPM_INLINE int cpm_movable(const cpm_medium_data *m) {
    return m->kind == CPM_MEDIUM_LINEAR_SQUARED || m->kind == CPM_MEDIUM_LINEAR || m->kind == CPM_MEDIUM_LAYERED ||
           m->kind == CPM_MEDIUM_GRID || m->kind == CPM_MEDIUM_SHELLS;
}
/* The medium and the goal in the frame that float lanes run in; `shift` is that frame's origin, 0 in double. */
CPM_INLINE void cpm_local_frame(cpm_medium_data *m, cpm_ray_goal *goal, double shift[3]) {
    for (int k = 0; k < 3; k++) {
        shift[k] = CPM_SINGLE && cpm_movable(m) ? m->origin[k] : 0.0;
        m->origin[k] -= shift[k];
        goal->point[k] -= shift[k];
    }
}

CPM_INLINE void cpm_sample_piece(cpm_samples *s, const cpm_piece *piece, double length, int last,
                                 const double shift[3]) {
    while (s->next < s->count) {
        double wanted = s->step * (double)s->next, r[3];
        if (wanted > length && !last) return;
        cpm_piece_position(piece, cpm_piece_theta(piece, wanted < length ? wanted : length), r);
        for (int k = 0; k < 3; k++) s->position[3 * s->next + k] = r[k] + shift[k];
        s->next++;
    }
}

/* Where the ray ends if it ends in its piece: theta, else CPM_NO_ROOT. `aimed`: steps end near the plane. */
CPM_INLINE double cpm_landing(const cpm_piece *piece, const cpm_ray_goal *plane, double length, int aimed) {
    if (length < 0.0)
        return cpm_piece_plane(piece, plane->point, plane->normal, aimed ? 1.0 + CPM_LANDING : 1.0 + CPM_TOUCHING);
    double margin = CPM_LANDING * (piece->length1 - piece->length0);
    return piece->length1 + margin >= length ? cpm_piece_theta(piece, length) : CPM_NO_ROOT;
}

/* Does grad n jump between the current point of lane i and a little beyond it, `sigma` ahead? A curve ends there, but for a
 * tenth of the distance that turns a ray by rtol. */
CPM_APART int cpm_kink_before(const cpm_step_control *c, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                              const cpm_lane_rays *rays, int i, double sigma) {
    const int part = i / CPM_WIDTH;
    const double spare = CPM_IS_KIND(m, CPM_MEDIUM_SUM) ? 0.0 : 100.0 * (double)cpm_hair(m, c->rtol) / rays->n[i];
    double ahead[CPM_LANES];
    mask near = splat_mask(0);
    cpm_point a;
    if (rays->at_kink[i]) return sigma > spare;
    a.r = load3_doubles(rays->r, part), a.p = load3_doubles(rays->p, part), a.g = load3_doubles(rays->g, part);
    a.n = load_doubles(rays->n, part), a.scale = load_doubles(rays->scale, part);
    store_doubles(cpm_next_kink(m, table, c->rtol, &a, &near), ahead, part);
    return sigma - ahead[i] > spare;
}

/* Sigma to the plane along the parabola of the current point; infinite: it is not met. */
CPM_INLINE double cpm_aim_at_plane(const cpm_lane_rays *rays, int i, const cpm_ray_goal *plane) {
    double f = 0.0, speed = 0.0, bend = 0.0;
    for (int k = 0; k < 3; k++) {
        f += (rays->r[k][i] - plane->point[k]) * plane->normal[k];
        speed += rays->p[k][i] * plane->normal[k], bend += rays->g[k][i] * plane->normal[k];
    }
    if (f > 0.0) f = -f, speed = -speed, bend = -bend; /* now f <= 0, and speed > 0 goes there */
    double square = speed * speed - 2.0 * bend * f;
    if (!(square >= 0.0)) return CPM_INFINITE;
    double sigma = speed > 0.0  ? -2.0 * f / (speed + cpm_sqrt(square))
                   : bend > 0.0 ? (cpm_sqrt(square) - speed) / bend
                                : CPM_INFINITE;
    if (!(sigma > 0.0)) return CPM_INFINITE;
    if (!(rays->steps[i] > 0.0) || rays->at_kink[i] || !(sigma < 2.0 * rays->piece_h[i])) return sigma;
    /* to fifth order: the piece behind, continued */
    cpm_piece piece;
    double c[6], g0 = 0.0, g1 = 0.0, p0 = 0.0, p1 = 0.0, f0 = 0.0, f1 = 0.0;
    cpm_lanes_piece(rays, i, &piece);
    for (int k = 0; k < 3; k++) {
        const double n = plane->normal[k];
        f0 += (piece.r0[k] - plane->point[k]) * n, f1 += (piece.r1[k] - plane->point[k]) * n;
        p0 += piece.p0[k] * n, p1 += piece.p1[k] * n, g0 += piece.g0[k] * n, g1 += piece.g1[k] * n;
    }
    cpm_quintic(piece.h, f0, p0, g0, f1, p1, g1, c);
    double theta = 1.0 + sigma / piece.h;
    for (int step = 0; step < 3; step++) {
        double miss = cpm_quintic_at(c, theta), fall = cpm_quintic_slope(c, theta);
        theta = 1.0 + fmin(fmax(theta - 1.0 - miss / fall, 0.5 * sigma / piece.h), 2.0 * sigma / piece.h);
    }
    return theta > 1.0 ? (theta - 1.0) * piece.h : sigma; /* also NaN */
}

/* An error of position `off` (metres) and one of direction `turn` at theta, over a tenth of what the tolerance allows
 * (of rounding where steps are fixed, so that each method shows its order). */
CPM_INLINE double cpm_excess(const cpm_step_control *c, const cpm_lane_rays *rays, int i, double theta, double off,
                             double turn) {
    const double length = rays->length0[i] + theta * (rays->length[i] - rays->length0[i]);
    const double rtol = c->step > 0.0 ? 100.0 * CPM_ROUNDING : c->rtol;
    return fmax(10.0 * off / (rtol * length + (c->step > 0.0 ? 0.0 : c->atol)), 10.0 * turn / rtol);
}

/* The same of the quintic, as far as its error is known: u^3 of `dense`, and in the slope its derivative. */
CPM_INLINE double cpm_dense_excess(const cpm_step_control *c, const cpm_lane_rays *rays, int i, double theta) {
    const double u = theta * (1.0 - theta), off = rays->dense[i] * fabs(u * u * u);
    return cpm_excess(c, rays, i, theta, off, 3.0 * u * u * rays->dense[i] / (rays->piece_h[i] * rays->n[i]));
}

/* What cpm_polish leaves unsure over a way of x pieces: 10 dense |x|^q, q = 5 for its fourth order, 7 for its sixth. */
CPM_INLINE double cpm_polish_excess(const cpm_step_control *c, const cpm_lane_rays *rays, int i, double x, int sixth) {
    const double x2 = x * x, turn = 10.0 * rays->dense[i] * x2 * x2 * (sixth ? x2 : 1.0);
    return cpm_excess(c, rays, i, 1.0, turn * fabs(x), turn / (rays->piece_h[i] * rays->n[i]));
}

/* Takes the last step of lane i back, to be tried again with the sigma that ends at theta of it. */
CPM_INLINE void cpm_step_back(cpm_lane_rays *rays, int i, double theta) {
    for (int k = 0; k < 3; k++)
        rays->r[k][i] = rays->r0[k][i], rays->p[k][i] = rays->p0[k][i], rays->g[k][i] = rays->g0[k][i];
    rays->n[i] = rays->n0[i], rays->length[i] = rays->length0[i], rays->optical_path[i] = rays->optical_path0[i];
    rays->steps[i] -= 1.0, rays->rejected[i] += 1.0;
    rays->limit[i] = theta * rays->piece_h[i];
    rays->accepted[i] = 0;
    rays->kept[i] = 0.0; /* the past has moved on: begin anew */
}

/* n and g at r, of one ray. */
CPM_INLINE double cpm_field_alone(const cpm_medium_data *m, CPM_GLOBAL const double *table, const double r[3],
                                  double scale, double g[3]) {
    double column[4][CPM_LANES];
    real n;
    real3 at = triple(splat(r[0]), splat(r[1]), splat(r[2])), out = cpm_field(m, table, at, splat(scale), &n);
    store_doubles(out.x, column[0], 0), store_doubles(out.y, column[1], 0), store_doubles(out.z, column[2], 0);
    store_doubles(n, column[3], 0);
    for (int k = 0; k < 3; k++) g[k] = column[k][0];
    return column[3][0];
}

/* From the piece's end to the goal, a little before or beyond it, where the quintic is not good enough: by the
 * fourth-order Nystrom method, stages in the middle and at the end, 2 evaluations; where that is not good enough
 * either, by the pair 6(4), 5. Then a Newton step onto the goal. */
CPM_APART void cpm_polish(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_lane_rays *rays, int i,
                          const cpm_ray_goal *plane, double length, double sigma, int sixth, cpm_ray_end *end) {
    const int last = sixth ? 5 : 2;
    double r[3], p[3], g[6][3], n[6], f = 0.0, speed = 0.0, way = 0.0, path = 0.0, turn[3] = {0.0, 0.0, 0.0};
    n[0] = rays->n[i];
    for (int k = 0; k < 3; k++) g[0][k] = rays->g[k][i];
    for (int stage = 1; stage <= last; stage++) {
        const double part = (sixth ? cpm_rkn6_c[stage] : 0.5 * stage) * sigma;
        for (int k = 0; k < 3; k++) {
            double bend = sixth ? 0.0 : 0.125 * stage * stage * g[stage - 1][k];
            for (int j = 0; sixth && j < stage; j++) bend += cpm_rkn6_A[stage][j] * g[j][k];
            r[k] = rays->r[k][i] + (part * rays->p[k][i] + sigma * sigma * bend);
        }
        n[stage] = cpm_field_alone(m, table, r, rays->scale[i], g[stage]);
    }
    for (int stage = 0; stage <= last; stage++) {
        const double b = sixth ? cpm_rkn6_b[stage] : stage == 1 ? 2.0 / 3.0 : 1.0 / 6.0;
        way += sigma * b * n[stage], path += sigma * b * n[stage] * n[stage];
        for (int k = 0; k < 3; k++) turn[k] += sigma * b * g[stage][k];
    }
    for (int k = 0; k < 3; k++) {
        p[k] = rays->p[k][i] + turn[k];
        if (!sixth) r[k] = rays->r[k][i] + sigma * (rays->p[k][i] + sigma * (g[0][k] + 2.0 * g[1][k]) / 6.0);
        f += (r[k] - plane->point[k]) * plane->normal[k], speed += p[k] * plane->normal[k];
    }
    double rest = length >= 0.0 ? (length - rays->length[i] - way) / n[last] : -f / speed;
    if (!(fabs(rest) <= fabs(sigma))) rest = 0.0; /* also NaN */
    for (int k = 0; k < 3; k++) {
        end->r[k] = r[k] + rest * (p[k] + 0.5 * rest * g[last][k]);
        end->p[k] = p[k] + rest * g[last][k];
    }
    end->length = length >= 0.0 ? length : rays->length[i] + way + rest * n[last];
    end->optical_path = rays->optical_path[i] + path + rest * n[last] * n[last];
    end->evaluations += (double)last;
}

CPM_INLINE void cpm_end_of_lane(const cpm_lane_rays *rays, int i, const cpm_piece *piece, double theta, double length,
                                const double shift[3], cpm_ray_end *end) {
    for (int k = 0; k < 3; k++) end->r[k] = rays->r[k][i], end->p[k] = rays->p[k][i];
    end->length = rays->length[i], end->optical_path = rays->optical_path[i];
    end->status = (cpm_i32)rays->status[i];
    if (theta != CPM_NO_ROOT) {
        double c[6];
        cpm_piece_position(piece, theta, end->r);
        cpm_piece_momentum(piece, theta, end->p);
        end->length = length >= 0.0 ? length : cpm_piece_length(piece, theta);
        cpm_quintic(piece->h, rays->optical_path0[i], piece->n0 * piece->n0, 2.0 * cpm_dot(piece->g0, piece->p0),
                    rays->optical_path[i], piece->n1 * piece->n1, 2.0 * cpm_dot(piece->g1, piece->p1), c);
        end->optical_path = cpm_quintic_at(c, theta);
        end->status = CPM_ENDED_ARRIVED;
    }
    for (int k = 0; k < 3; k++) end->r[k] += shift[k];
    end->drift = rays->drift[i], end->error = rays->error[i];
    end->evaluations = rays->evaluations[i];
    end->steps = rays->steps[i], end->rejected = rays->rejected[i];
    end->reserved = 0;
}

/* The distance to go that is known beforehand: bounds the first step. */
CPM_INLINE double cpm_expected_length(const cpm_ray_start *start, const cpm_ray_goal *plane) {
    if (start->length >= 0.0) return start->length;
    double rounding, f = cpm_plane_offset(start->r, plane->point, plane->normal, &rounding);
    double forward = -f / cpm_dot(start->d, plane->normal) * cpm_sqrt(cpm_dot(start->d, start->d));
    return forward > 0.0 && forward < CPM_EXACT_FAR ? forward : 0.0;
}

/* Exact paths, or straight ones. */
CPM_INLINE void cpm_trace_exact(const cpm_medium_data *m, CPM_GLOBAL const double *table, const cpm_ray_goal *plane,
                                const cpm_trace_arrays *arrays, cpm_i64 ray) {
    cpm_ray_start start = arrays->starts[ray];
    cpm_ray_goal goal = *plane;
    cpm_ray_end end;
    cpm_samples samples;
    double p[3], n = cpm_exact_index(m, table, start.scale, start.r, start.d);
    double largest = fmax(fabs(start.d[0]), fmax(fabs(start.d[1]), fabs(start.d[2]))), size = 0.0;
    for (int k = 0; k < 3; k++) p[k] = start.d[k] / largest, size += p[k] * p[k];
    for (int k = 0; k < 3; k++) p[k] *= n / cpm_sqrt(size);
    if (!(n > 0.0)) { /* n^2 <= 0 where it starts */
        CPM_CLEAR(end);
        for (int k = 0; k < 3; k++) end.r[k] = start.r[k], end.p[k] = start.d[k];
        end.status = CPM_ENDED_CUTOFF;
        arrays->ends[ray] = end;
        return;
    }
    goal.length = start.length;
    samples.count = arrays->samples, samples.next = 0;
    samples.position = arrays->positions;
    if (arrays->samples) samples.position += 3 * arrays->samples * ray; /* no offset to NULL */
    samples.step = samples.count > 1 ? arrays->ends[ray].length / (double)(samples.count - 1) : 0.0;
    cpm_exact_trace(m, table, start.scale, start.r, p, &goal, &samples, &end);
    for (; samples.next < samples.count; samples.next++)
        for (int k = 0; k < 3; k++) samples.position[3 * samples.next + k] = end.r[k];
    arrays->ends[ray] = end;
}

CPM_INLINE void cpm_load_lane(cpm_lane_rays *rays, int i, cpm_ray_start *start, const cpm_ray_goal *plane,
                              const double shift[3]) {
    for (int k = 0; k < 3; k++) start->r[k] -= shift[k];
    for (int k = 0; k < 3; k++) rays->r[k][i] = start->r[k], rays->p[k][i] = start->d[k];
    rays->scale[i] = start->scale;
    rays->length[i] = rays->optical_path[i] = rays->h[i] = 0.0;
    rays->expected[i] = cpm_expected_length(start, plane);
}

/* Rays first..last - 1. */
CPM_INLINE void cpm_trace_range(const cpm_step_control *c, const cpm_medium_data *medium,
                                CPM_GLOBAL const double *table, const cpm_ray_goal *goal,
                                const cpm_trace_arrays *arrays, cpm_i64 first, cpm_i64 last) {
    if (c->method == CPM_STEP_EXACT) {
        for (cpm_i64 ray = first; ray < last; ray++) cpm_trace_exact(medium, table, goal, arrays, ray);
        return;
    }
    cpm_medium_data moved = *medium;
    cpm_ray_goal local_goal = *goal;
    double shift[3];
    cpm_local_frame(&moved, &local_goal, shift);
    const cpm_medium_data *m = &moved;
    const cpm_ray_goal *plane = &local_goal;
    cpm_lane_rays rays;
    cpm_i64 owner[CPM_LANES], fresh[CPM_LANES];
    double length[CPM_LANES], longest[CPM_LANES];
    cpm_samples samples[CPM_LANES];
    /* Methods whose steps are long: they aim at planes, and know how good the curve between their ends is. */
    const int aware = c->method == CPM_STEP_NYSTROM || c->method == CPM_STEP_ADAMS;
    const int kinks = cpm_has_kinks(m, c->rtol) && !(c->step > 0.0);
    int idle = CPM_LANES;
    CPM_CLEAR(rays);
    for (int i = 0; i < CPM_LANES; i++) owner[i] = -1, rays.status[i] = CPM_ENDED_ARRIVED;
    for (;;) {
        if (first < last && (idle >= CPM_REFILL || idle == CPM_LANES)) {
            for (int i = 0; i < CPM_LANES; i++) {
                fresh[i] = owner[i] < 0 && first < last;
                if (!fresh[i]) continue;
                cpm_ray_start start = arrays->starts[first];
                cpm_load_lane(&rays, i, &start, plane, shift);
                length[i] = start.length, longest[i] = start.max_step;
                samples[i].count = arrays->samples, samples[i].next = 0;
                samples[i].position = arrays->positions;
                if (arrays->samples) samples[i].position += 3 * arrays->samples * first;
                samples[i].step =
                    arrays->samples > 1 ? arrays->ends[first].length / (double)(arrays->samples - 1) : 0.0;
                owner[i] = first++;
                idle--;
            }
            cpm_lanes_begin(c, m, table, &rays, fresh);
            for (int i = 0; i < CPM_LANES; i++) {
                if (!fresh[i]) continue;
                const int aimed = aware && length[i] < 0.0;
                if (length[i] >= 0.0) rays.target[i] = length[i];
                if (longest[i] > 0.0) rays.limit[i] = longest[i] / rays.n_start[i];
                if (aimed) rays.limit[i] = fmin(rays.limit[i], cpm_aim_at_plane(&rays, i, plane));
                if (length[i] == 0.0 && rays.status[i] < 0) rays.status[i] = CPM_ENDED_ARRIVED;
            }
        } else if (idle == CPM_LANES)
            return;
        else
            cpm_lanes_attempt(c, m, table, &rays);
        for (int i = 0; i < CPM_LANES; i++) {
            if (owner[i] < 0 || !(rays.accepted[i] || rays.status[i] >= 0)) continue;
            cpm_piece piece;
            const int aimed = aware && length[i] < 0.0;
            double theta = CPM_NO_ROOT;
            if (length[i] >= 0.0 && !arrays->samples && rays.status[i] < 0 && /* far from the goal: no piece is needed */
                rays.length[i] + CPM_LANDING * (rays.length[i] - rays.length0[i]) < length[i]) {
                if (aware) rays.limit[i] = longest[i] > 0.0 ? longest[i] / rays.n_start[i] : CPM_INFINITE;
                continue;
            }
            cpm_lanes_piece(&rays, i, &piece);
            if (rays.accepted[i]) theta = cpm_landing(&piece, plane, length[i], aimed);
            if (kinks && theta != CPM_NO_ROOT && theta > 1.0 + CPM_TOUCHING &&
                cpm_kink_before(c, m, table, &rays, i, (theta - 1.0) * piece.h))
                theta = CPM_NO_ROOT;
            const int poor = aware && theta != CPM_NO_ROOT && cpm_dense_excess(c, &rays, i, theta) > 1.0;
            const int sixth = poor && cpm_polish_excess(c, &rays, i, theta - 1.0, 0) > 1.0;
            const int rough = sixth && !(c->step > 0.0) && cpm_polish_excess(c, &rays, i, theta - 1.0, 1) > 1.0;
            if (poor && (rough || theta < 1.0 - CPM_LANDING) && theta < 1.0 && theta > 1e-3 && rays.status[i] < 0) {
                cpm_step_back(&rays, i, theta);
                continue;
            }
            if (rough && theta > 1.0 && rays.status[i] < 0) theta = CPM_NO_ROOT; /* a step more */
            if (aware && rays.accepted[i]) {
                rays.limit[i] = longest[i] > 0.0 ? longest[i] / rays.n_start[i] : CPM_INFINITE;
                if (aimed) rays.limit[i] = fmin(rays.limit[i], cpm_aim_at_plane(&rays, i, plane));
            }
            int over = theta != CPM_NO_ROOT || rays.status[i] >= 0;
            if (rays.accepted[i] && arrays->samples)
                cpm_sample_piece(&samples[i], &piece,
                                 theta != CPM_NO_ROOT ? cpm_piece_length(&piece, theta) : piece.length1, over, shift);
            if (!over) continue;
            cpm_ray_end end;
            cpm_end_of_lane(&rays, i, &piece, theta, length[i], shift, &end);
            if (poor) {
                cpm_polish(m, table, &rays, i, plane, length[i], (theta - 1.0) * piece.h, sixth, &end);
                for (int k = 0; k < 3; k++) end.r[k] += shift[k];
            }
            for (; samples[i].next < samples[i].count; samples[i].next++)
                for (int k = 0; k < 3; k++) samples[i].position[3 * samples[i].next + k] = end.r[k];
            arrays->ends[owner[i]] = end;
            owner[i] = -1;
            rays.status[i] = CPM_ENDED_ARRIVED; /* stands still */
            rays.accepted[i] = 0;
            idle++;
        }
    }
}
#endif
