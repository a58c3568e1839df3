/* backend/native/piece_end.c: arc lengths of pieces. */
#include "piece_end.h"

#include <math.h>

#include "advance.h"

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

double cpm_transmittance(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, size_t bin) {
    const int32_t medium = cpm_region_medium(&flight->region);
    const size_t went = cpm_pass_bin(pass, flight->bin);
    double column = arrival->optical_path - arrival->length;
    if (went != bin && pass->disperses[medium]) {
        const double own = cpm_pass_index(pass, medium, (int32_t)bin, flight->position) - 1.0;
        const double its = cpm_pass_index(pass, medium, (int32_t)went, flight->position) - 1.0;
        if (fabs(its) > 1e-12) column *= own / its;
    }
    return exp(-pass->extinction[(size_t)medium * pass->bins + bin] * column);
}

/* dC/dtheta = h n (n - 1) with ds = h n dtheta. What methods carry along, optical path and length, gives C at both ends
 * of an integrated piece, to rounding of 1e-16 of the length; between them the cubic of Hermite. */
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
