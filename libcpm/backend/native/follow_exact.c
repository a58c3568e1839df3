/* backend/native/follow_exact.c: rays whose path is a closed form, piece after piece. */
#include <math.h>
#include <string.h>

#include "advance.h"
#include "piece_end.h"

#define MAX_PIECES 100000 /* then evaluations_exhausted */

/* Closed forms in sigma: discrete layers are straight, linear n^2 is a parabola; catenaries, ellipses, and the paths of
 * spherical layers are stood for by quintics. */
static int degree_of(const cpm_medium_data *medium) {
    const int round = medium->kind == CPM_MEDIUM_SHELLS;
    if ((medium->kind == CPM_MEDIUM_LAYERED || round) && medium->interpolation == CPM_FIELD_STEP) return 1;
    return medium->kind == CPM_MEDIUM_LINEAR || round || cpm_is_central(medium) ? 5 : 2;
}
/* Outside its sphere a lens bends nothing. */
static int is_straight(const cpm_piece *piece) {
    const double *a = piece->g0, *b = piece->g1;
    return a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0 && b[0] == 0.0 && b[1] == 0.0 && b[2] == 0.0;
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

/* Where a parabola that starts in the geometry's box first leaves it, in sigma; infinite: it starts outside. A piece
 * need go no further: shorter pieces have chords that stay closer to them. */
static double leaves_box(const cpm_box *box, const double r[3], const double p[3], const double *g, double scale) {
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = 0.5 * scale * g[k]; /* dp/dsigma */
        if (!(r[k] >= box->low[k] && r[k] <= box->high[k])) return INFINITY;
        double face = (p[k] > 0.0 ? box->high[k] : box->low[k]) - r[k],
               back = (p[k] > 0.0 ? box->low[k] : box->high[k]) - r[k];
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
    /* the least |p|^2, pp - pg^2/gg at sigma = -pg/gg, is above `least` squared: for all but one ray in a million */
    if (!(pg < 0.0) || pg * pg <= (pp - least * least) * gg) return INFINITY;
    return -pg / gg - sqrt((least * least - (pp - pg * pg / gg)) / gg);
}

void cpm_follow_exact(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options, size_t number,
                      cpm_arrival *arrival) {
    int32_t m = cpm_region_medium(&flight->region);
    const cpm_medium *medium = pass->scene->media[m].medium;
    double scale = pass->scale[(size_t)m * pass->bins + (size_t)(flight->bin < 0 ? pass->middle : flight->bin)];
    double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    cpm_arrival_begin(flight, arrival);
    double n = cpm_medium_n_toward(medium, scale, r, d), length = 0.0;
    arrival->n = n;
    arrival->status = n > 0.0 ? CPM_RAY_EVALUATIONS_EXHAUSTED : CPM_RAY_CUTOFF;
    if (!(n > 0.0)) return;
    double p[3] = {n * d[0], n * d[1], n * d[2]};
    const int usual = degree_of(&medium->data);
    if (cpm_has_left(pass, flight, m, options, arrival)) return;
    for (int i = 0; i < MAX_PIECES; i++) {
        cpm_piece piece;
        double speed = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (!(speed > 1e-6 * n)) {
            arrival->status = CPM_RAY_CUTOFF;
            return;
        }
        cpm_vec away = cpm_sub(cpm_v(r[0], r[1], r[2]), pass->center);
        double limit2 = cpm_vdot(away, away), limit = pass->reach;
        if (limit2 > limit * limit) limit = sqrt(limit2);
        if (!options && medium->data.kind == CPM_MEDIUM_LINEAR_SQUARED) {
            double inside = leaves_box(&pass->box, r, p, medium->data.axis, scale);
            double h = cpm_min(limit / speed, inside * (1.0 + 1e-6) + 1e-6 * pass->reach / speed);
            parabola(&medium->data, scale, r, p, h, &piece);
        } else if (cpm_exact_next(&medium->data, medium->table, scale, r, p, limit / speed, 0.99e-6 * n, length, &piece,
                                  &arrival->evaluations))
            return;
        const int degree = usual == 5 && is_straight(&piece) ? 1 : usual;
        double turn = degree == 2 ? cut_off(&piece, n) : INFINITY;
        if (turn < piece.h) /* again, no further than there */
            cpm_exact_next(&medium->data, medium->table, scale, r, p, turn, 0.0, length, &piece, &arrival->evaluations);
        cpm_curve curve = cpm_curve_from_piece(&piece, degree);
        double theta = cpm_end_of_piece(pass, flight, &curve, arrival);
        arrival->steps += 1.0;
        if (pass->extinction && options) arrival->column += cpm_column_of(&curve, piece.h, theta < 0.0 ? 1.0 : theta);
        if (options && options->sink) options->sink(options->user, number, &piece, degree, theta < 0.0 ? 1.0 : theta);
        if (theta >= 0.0 || arrival->status == CPM_RAY_HIT) {
            if (options) cpm_add_length(arrival, &piece, degree, theta);
            arrival->n = cpm_norm(cpm_curve_tangent(&curve, theta)) / piece.h; /* |p| */
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
