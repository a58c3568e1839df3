/* shared/follow_exact.h: rays of a scene whose path is a closed form, piece after piece.
 *
 *   cpm_exact_way way;
 *   if (world_exact_begin(w, m, table, flight, &way, arrival)) return;
 *   while (world_exact_piece(w, m, table, flight, ..., &way, arrival)) {
 *       theta = world_end_of_piece(w, flight, &way.curve, arrival);
 *       if (world_exact_after(&way, theta, arrival)) return;
 *   } */
#ifndef CPM_SHARED_FOLLOW_EXACT_H
#define CPM_SHARED_FOLLOW_EXACT_H
#include "world_index.h"

#define CPM_MAX_PIECES 100000 /* then evaluations_exhausted */

typedef struct cpm_exact_way { /* where a flight has got to */
    double r[3], p[3], n, scale, length;
    double turn; /* sigma at which the piece is cut off; infinite: nowhere */
    cpm_i32 medium, usual, degree, pieces;
    cpm_piece piece;
    cpm_curve curve; /* of the piece */
} cpm_exact_way;

/* Closed forms in sigma: discrete layers are straight, linear n^2 is a parabola; catenaries, ellipses, and the paths of
 * spherical layers are stood for by quintics. */
CPM_INLINE int cpm_exact_degree(const cpm_medium_data *m) {
    const int round = m->kind == CPM_MEDIUM_SHELLS;
    if ((m->kind == CPM_MEDIUM_LAYERED || round) && m->interpolation == CPM_FIELD_STEP) return 1;
    return m->kind == CPM_MEDIUM_LINEAR || round || cpm_is_central(m) ? 5 : 2;
}
/* Outside its sphere a lens bends nothing. */
CPM_INLINE int cpm_piece_is_straight(const cpm_piece *piece) {
    const double *a = piece->g0, *b = piece->g1;
    return a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0 && b[0] == 0.0 && b[1] == 0.0 && b[2] == 0.0;
}

/* The parabola of a linear n^2 without its arc length, which photons and eye rays do not ask for. */
CPM_INLINE void cpm_parabola_piece(const cpm_medium_data *m, double scale, const double r[3], const double p[3],
                                   double h, cpm_piece *piece) {
    for (int k = 0; k < 3; k++) {
        double g = 0.5 * scale * m->axis[k];
        piece->r0[k] = r[k], piece->p0[k] = p[k], piece->g0[k] = piece->g1[k] = g;
        piece->r1[k] = r[k] + h * (p[k] + 0.5 * h * g);
        piece->p1[k] = p[k] + h * g;
    }
    piece->h = h;
    piece->length0 = piece->length1 = piece->n0 = piece->n1 = 0.0;
}

/* Where a parabola that starts in the geometry's box first leaves it, in sigma; infinite: it starts outside. A piece
 * need go no further: shorter pieces have chords that stay closer to them. */
CPM_INLINE double world_leaves_box(const cpm_world *w, const double r[3], const double p[3], const double *g,
                                   double scale) {
    const double *low = w->frame.box_low, *high = w->frame.box_high;
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = 0.5 * scale * g[k]; /* dp/dsigma */
        if (!(r[k] >= low[k] && r[k] <= high[k])) return INFINITY;
        double face = (p[k] > 0.0 ? high[k] : low[k]) - r[k], back = (p[k] > 0.0 ? low[k] : high[k]) - r[k];
        if (a == 0.0) {
            if (p[k] != 0.0) first = cpm_min(first, face / p[k]);
            continue;
        }
        /* p t + a t^2/2 = face, the first crossing ahead; turned back before it: the face behind */
        double d = p[k] * p[k] + 2.0 * a * face;
        double t = 2.0 * face / (p[k] + (p[k] > 0.0 ? sqrt(d) : -sqrt(d)));
        if (!(d >= 0.0)) {
            double root_of = sqrt(p[k] * p[k] + 2.0 * a * back);
            t = (-p[k] + (a > 0.0 ? root_of : -root_of)) / a;
        }
        if (t >= 0.0) first = cpm_min(first, t);
    }
    return first;
}

/* sigma at which a parabola's |p| = n falls to 1e-6 of what it was: a plasma's cut-off, met at normal incidence only;
 * infinite: never. */
CPM_INLINE double cpm_parabola_cut_off(const cpm_piece *piece, double n) {
    const double *p = piece->p0, *g = piece->g0;
    double pg = p[0] * g[0] + p[1] * g[1] + p[2] * g[2], gg = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    double pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], least = 1e-6 * n;
    /* the least |p|^2, pp - pg^2/gg at sigma = -pg/gg, is above `least` squared: for all but one ray in a million */
    if (!(pg < 0.0) || pg * pg <= (pp - least * least) * gg) return INFINITY;
    return -pg / gg - sqrt((least * least - (pp - pg * pg / gg)) / gg);
}

/* Returns 1 where the flight ends at once. `m` is medium `medium` of the scene, where the flight starts. */
CPM_INLINE int world_exact_begin(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                 CPM_GLOBAL const double *table, const cpm_flight *flight, cpm_exact_way *way,
                                 cpm_arrival *arrival) {
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    cpm_arrival_begin(flight, arrival);
    way->medium = medium, way->pieces = 0, way->length = 0.0;
    way->scale = world_scale(w, flight, medium);
    way->n = cpm_index_toward(m, table, way->scale, r, d);
    way->usual = cpm_exact_degree(m);
    arrival->n = way->n;
    arrival->status = way->n > 0.0 ? CPM_ARRIVAL_EXHAUSTED : CPM_ARRIVAL_CUTOFF;
    for (int k = 0; k < 3; k++) way->r[k] = r[k], way->p[k] = way->n * d[k];
    return !(way->n > 0.0);
}

/* The next piece; 0 where the flight ends instead. `measured`: its arc length is wanted. */
CPM_INLINE int world_exact_piece(const cpm_world *w, const cpm_medium_data *m, CPM_GLOBAL const double *table,
                                 int measured, cpm_exact_way *way, cpm_arrival *arrival) {
    double *r = way->r, *p = way->p;
    cpm_piece *piece = &way->piece;
    if (way->pieces++ == CPM_MAX_PIECES) return 0;
    double speed = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    if (!(speed > 1e-6 * way->n)) {
        arrival->status = CPM_ARRIVAL_CUTOFF;
        return 0;
    }
    cpm_vec away = cpm_sub(cpm_v(r[0], r[1], r[2]), cpm_v(w->frame.center[0], w->frame.center[1], w->frame.center[2]));
    double limit2 = cpm_vdot(away, away), limit = w->frame.reach;
    if (limit2 > limit * limit) limit = sqrt(limit2);
    if (!measured && CPM_IS_KIND(m, CPM_MEDIUM_LINEAR_SQUARED)) {
        double inside = world_leaves_box(w, r, p, m->axis, way->scale);
        double h = cpm_min(limit / speed, inside * (1.0 + 1e-6) + 1e-6 * w->frame.reach / speed);
        cpm_parabola_piece(m, way->scale, r, p, h, piece);
    } else if (cpm_exact_next(m, table, way->scale, r, p, limit / speed, 0.99e-6 * way->n, way->length, piece,
                              &arrival->evaluations))
        return 0;
    way->degree = way->usual == 5 && cpm_piece_is_straight(piece) ? 1 : way->usual;
    way->turn = way->degree == 2 ? cpm_parabola_cut_off(piece, way->n) : INFINITY;
    if (way->turn < piece->h) /* again, no further than there */
        cpm_exact_next(m, table, way->scale, r, p, way->turn, 0.0, way->length, piece, &arrival->evaluations);
    way->curve = cpm_curve_from_piece(piece, way->degree);
    arrival->steps += 1.0;
    return 1;
}

/* After its piece was asked for its end, theta (negative: none): 1 where the flight ends. */
CPM_INLINE int world_exact_after(cpm_exact_way *way, double theta, cpm_arrival *arrival) {
    const cpm_piece *piece = &way->piece;
    if (theta >= 0.0 || arrival->status == CPM_ARRIVAL_HIT) {
        arrival->n = cpm_norm(cpm_curve_tangent(&way->curve, theta)) / piece->h; /* |p| */
        return 1;
    }
    arrival->hit.position = cpm_v(piece->r1[0], piece->r1[1], piece->r1[2]);
    if (way->turn <= piece->h) {
        arrival->status = CPM_ARRIVAL_CUTOFF;
        return 1;
    }
    for (int k = 0; k < 3; k++) way->r[k] = piece->r1[k], way->p[k] = piece->p1[k];
    arrival->length = way->length = piece->length1;
    return 0;
}

/* The whole flight. */
CPM_APART void world_follow_exact(const cpm_world *w, cpm_i32 medium, const cpm_medium_data *m,
                                  CPM_GLOBAL const double *table, const cpm_flight *flight, cpm_arrival *arrival) {
    cpm_exact_way way;
    if (world_exact_begin(w, medium, m, table, flight, &way, arrival)) return;
    if (world_has_left(w, flight, medium, arrival)) return;
    while (world_exact_piece(w, m, table, 0, &way, arrival))
        if (world_exact_after(&way, world_end_of_piece(w, flight, &way.curve, arrival), arrival)) return;
}
#endif
