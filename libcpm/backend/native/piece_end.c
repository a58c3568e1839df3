/* backend/native/piece_end.c: the first of a hit on the curve itself and the scene's extent; arc lengths; rays that
 * cannot come back. */
#include "piece_end.h"

#include <math.h>
#include <string.h>

#include "advance.h"

#define SLACK CPM_COINCIDE /* how far behind its start a crossing ray looks */

/* A surface at the very place where one piece ends and the next begins may be missed by both, by rounding; so may one
 * that coincides with a boundary just passed. Such starts look back a little. */
double cpm_slack_of(const cpm_pass *pass, const cpm_flight *flight, int first) {
    return flight->crossing || !first ? SLACK * pass->reach : 0.0;
}

/* A boundary met at the very start counts only if passing it changes what contains the ray: not the other half of the
 * face just crossed, nor a face that two media share. */
int cpm_start_counts(void *user, int32_t primitive, cpm_vec position, cpm_vec direction) {
    const cpm_start *s = user;
    return cpm_boundary_counts(s->pass, &s->flight->region, primitive, position, direction);
}

void cpm_arrival_begin(const cpm_flight *flight, cpm_arrival *arrival) {
    memset(arrival, 0, sizeof *arrival);
    arrival->hit.primitive = -1;
    arrival->hit.position = flight->position;
    arrival->direction = flight->direction;
    arrival->method = CPM_METHOD_EXACT;
}

/* theta where the curve first crosses a face of the extent outward, in (0, end]; infinite: it does not. */
static double leaves_extent(const cpm_box *box, const cpm_curve *curve, double end) {
    cpm_vec at = cpm_curve_at(curve, end);
    const double r[3] = {at.x, at.y, at.z};
    int outside = 0;
    for (int k = 0; k < 3; k++) outside |= !(r[k] >= box->low[k] && r[k] <= box->high[k]);
    if (!outside) return INFINITY; /* pieces are short beside the extent: out and in again is not looked for */
    double first = INFINITY;
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            double face = side ? box->high[k] : box->low[k], sign = side ? 1.0 : -1.0;
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
double cpm_end_of_piece(const cpm_pass *pass, const cpm_flight *flight, const cpm_curve *curve, cpm_arrival *arrival) {
    /* a layer's face at the start makes a first piece of no length: the next one starts on the surface still */
    int first = cpm_norm(cpm_sub(curve->c[0], flight->position)) <= SLACK * pass->reach;
    double speed = cpm_norm(curve->c[1]); /* dr/dtheta */
    /* A wall on the very face of a layer may lie beyond the piece's end by rounding, and the next piece may be thrown back
     * there: so what is that near counts, before the ray turns. */
    double ahead = speed > 0.0 ? SLACK * pass->reach / speed : 0.0;
    double out = leaves_extent(cpm_flight_box(pass, flight), curve, 1.0), end = cpm_min(1.0 + ahead, out);
    cpm_hit hit;
    cpm_start from = {pass, flight};
    const cpm_filter filter = {cpm_start_counts, &from};
    cpm_geometry_curve(pass->geometry, curve, end, first ? flight->left : -1,
                       speed > 0.0 ? cpm_slack_of(pass, flight, first) / speed : 0.0, &filter, &hit);
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

/* dC/dtheta = h n (n - 1) with ds = h n dtheta. What methods carry along, optical path and length, gives C at both ends of
 * an integrated piece, to rounding of 1e-16 of the length; between them the cubic of Hermite. */
double cpm_column_between(double before, double after, double h, double n0, double n1, double theta) {
    const double slope0 = h * n0 * (n0 - 1.0), slope1 = h * n1 * (n1 - 1.0), rise = after - before, t = theta;
    return before + t * (slope0 + t * ((3.0 * rise - 2.0 * slope0 - slope1) + t * (slope0 + slope1 - 2.0 * rise)));
}

/* Three points of Gauss and Legendre along a closed form, where n = |p|. */
double cpm_column_of(const cpm_curve *curve, double h, double theta) {
    static const double x[3] = {0.1127016653792583, 0.5, 0.8872983346207417}, w[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double n = cpm_norm(cpm_curve_tangent(curve, theta * x[i])) / h;
        sum += w[i] * n * (n - 1.0);
    }
    return theta * h * sum;
}

void cpm_add_length(cpm_arrival *arrival, const cpm_piece *piece, int degree, double theta) {
    arrival->length = piece->length0 + cpm_piece_arc(piece, degree, theta);
}

/* Beyond a face of the geometry's box, on its way out and drawn no other way, a ray meets nothing any more: what
 * scatters off the outside of a room mostly ends here, at no cost. The gradient has one direction in linear media, and
 * one axis in layers: across it momentum is constant. */
static int never_returns(const cpm_pass *pass, int32_t medium, const double r[3], const double d[3]) {
    const cpm_medium_data *data = &pass->scene->media[medium].medium->data;
    const cpm_box *box = &pass->box;
    if (data->kind != CPM_MEDIUM_LINEAR_SQUARED && data->kind != CPM_MEDIUM_LINEAR && data->kind != CPM_MEDIUM_LAYERED)
        return 0;
    for (int k = 0; k < 3; k++) {
        double a = data->axis[k]; /* the scale is positive: it changes no sign */
        if (data->kind == CPM_MEDIUM_LAYERED && a != 0.0) continue;
        if ((r[k] <= box->low[k] && d[k] < 0.0 && a <= 0.0) || (r[k] >= box->high[k] && d[k] > 0.0 && a >= 0.0))
            return 1;
    }
    return 0;
}

/* Refractivity may be scaled by a negative factor only where dispersion crosses 1; then nothing is cut short. */
static int scale_is_positive(const cpm_pass *pass, const cpm_flight *flight, int32_t medium) {
    int32_t bin = flight->bin < 0 ? pass->middle : flight->bin;
    return pass->scale[(size_t)medium * pass->bins + (size_t)bin] > 0.0;
}

int cpm_has_left(const cpm_pass *pass, const cpm_flight *flight, int32_t medium, const cpm_follow_options *options,
                 cpm_arrival *arrival) {
    if (options || !scale_is_positive(pass, flight, medium)) return 0;
    const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
    const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
    if (!never_returns(pass, medium, r, d)) return 0;
    arrival->status = CPM_RAY_LEFT;
    return 1;
}

int cpm_leaves_after(const cpm_pass *pass, const cpm_flight *flight, int32_t medium, cpm_vec end, cpm_vec tangent,
                     cpm_arrival *arrival) {
    const double r[3] = {end.x, end.y, end.z}, d[3] = {tangent.x, tangent.y, tangent.z};
    if (!scale_is_positive(pass, flight, medium) || !never_returns(pass, medium, r, d)) return 0;
    arrival->status = CPM_RAY_LEFT;
    arrival->hit.position = end;
    arrival->direction = cpm_unit(tangent);
    return 1;
}
