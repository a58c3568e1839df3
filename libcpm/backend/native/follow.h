/* backend/native/follow.h: rays of a scene, each followed to the first surface or boundary that it meets. */
#ifndef CPM_NATIVE_FOLLOW_H
#define CPM_NATIVE_FOLLOW_H
#include <math.h>

#include "cl/types/ray.h"
#include "scene/pass.h"

typedef struct cpm_flight { /* where a ray starts */
    cpm_vec position;
    cpm_vec direction; /* unit */
    cpm_region region;
    int32_t left;     /* primitive that it starts on, -1: none */
    int32_t bin;      /* its wavelength; -1: the bundle */
    int32_t exact;    /* starts near an edge */
    int32_t crossing; /* starts on a boundary that it has just passed: coincident surfaces still count */
    const cpm_box *within; /* where it leaves; NULL: the scene's extent */
} cpm_flight;
static inline const cpm_box *cpm_flight_box(const cpm_pass *pass, const cpm_flight *flight) {
    return flight->within ? flight->within : &pass->extent;
}

typedef struct cpm_arrival {     /* where it ends */
    int32_t status;              /* CPM_RAY_HIT, _LEFT, or why not */
    cpm_hit hit;                 /* position is where it ended, whatever the status */
    cpm_vec direction;           /* unit, of travel */
    double n;                    /* index there, on the side that it comes from */
    cpm_region behind;           /* what contains the ray beyond a boundary; count 0: more than CPM_MAX_NESTED would */
    double length, optical_path; /* with options only */
    double column;               /* int (n - 1) ds, metres; with options only */
    double drift, error;
    double evaluations, steps, rejected;
    int32_t method; /* cpm_method that ran */
} cpm_arrival;

/* A piece of the path as it is found, for those who draw it; length0, length1 count from the flight's start. */
typedef void (*cpm_piece_sink)(void *user, size_t ray, const cpm_piece *piece, int degree, double theta_end);

typedef struct cpm_follow_options {
    int64_t max_evaluations; /* 0: default */
    double max_step;         /* metres, of integrated rays; 0: the pass's */
    double far;              /* metres beyond which a straight ray is of no interest; it has LEFT there */
    cpm_piece_sink sink;     /* NULL: pieces are not kept */
    void *user;
} cpm_follow_options;

/* What is left of light at a bin after a flight that was followed with options. */
static inline double cpm_transmittance(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival,
                                       size_t bin) {
    return exp(-pass->extinction[(size_t)cpm_region_medium(&flight->region) * pass->bins + bin] * arrival->column);
}

/* Arc length from a piece's start to theta, and theta of an arc length; `degree` as in cpm_curve. */
double cpm_piece_arc(const cpm_piece *piece, int degree, double theta);
double cpm_piece_theta_of_arc(const cpm_piece *piece, int degree, double arc);

/* Results do not depend on `count`, on order, or on threads. `options` may be NULL: lengths are not measured then. */
void cpm_follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, const cpm_follow_options *options,
                cpm_arrival *arrivals);
#endif
