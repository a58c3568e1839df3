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

void cpm_add_length(cpm_arrival *arrival, const cpm_piece *piece, int degree, double theta) {
    arrival->length = piece->length0 + cpm_piece_arc(piece, degree, theta);
}
