/* backend/native/follow.h: rays of a scene, each followed to the first surface or boundary that it meets. */
#ifndef CPM_NATIVE_FOLLOW_H
#define CPM_NATIVE_FOLLOW_H
#include "cl/types/flight.h"
#include "cl/types/ray.h"
#include "scene/pass.h"

/* A piece of the path as it is found, for those who draw it; length0, length1 count from the flight's start. */
typedef void (*cpm_piece_sink)(void *user, size_t ray, const cpm_piece *piece, int degree, double theta_end);

typedef struct cpm_follow_options {
    int64_t max_evaluations; /* 0: default */
    double max_step;         /* metres, of integrated rays; 0: the pass's */
    double far;              /* metres beyond which a straight ray is of no interest; it has LEFT there */
    double longest;          /* metres of arc beyond which a bent path is of no interest, likewise; 0: no bound */
    cpm_piece_sink sink;     /* NULL: pieces are not kept */
    void *user;
} cpm_follow_options;

/* What is left of light at a bin after a flight that was followed with options. Optical path less length is
 * int (n - 1) ds at the wavelength whose way the flight went; at another n - 1 is in proportion. */
double cpm_transmittance(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, size_t bin);

/* Arc length from a piece's start to theta, and theta of an arc length; `degree` as in cpm_curve. */
double cpm_piece_arc(const cpm_piece *piece, int degree, double theta);
double cpm_piece_theta_of_arc(const cpm_piece *piece, int degree, double arc);

/* Results do not depend on `count`, on order, or on threads. `options` may be NULL: lengths are not measured then. */
void cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                cpm_arrival *arrivals);
#endif
