/* types/flight.h: a ray of a scene between two surfaces: where it starts, where it ends; the same memory on both sides.
 */
#ifndef CPM_TYPES_FLIGHT_H
#define CPM_TYPES_FLIGHT_H
#include "tree.h"

#define CPM_MAX_NESTED 8 /* bounded media that may overlap at one point, the one that fills space included */

/* cpm_ray_status of cpm/status.h: of those, what a scene's rays end with. */
#define CPM_ARRIVAL_HIT 1
#define CPM_ARRIVAL_LEFT 2
#define CPM_ARRIVAL_EXHAUSTED 10
#define CPM_ARRIVAL_CUTOFF 12

/* The bounded media that contain a point, in order of addition: the last one is what is there. Entry 0 fills space. */
typedef struct cpm_region {
    unsigned short media[CPM_MAX_NESTED];
    unsigned short count;
} cpm_region;

typedef struct cpm_flight { /* where a ray starts */
    cpm_vec position;
    cpm_vec direction; /* unit */
    cpm_region region;
    cpm_i32 left;     /* primitive that it starts on, -1: none */
    cpm_i32 bin;      /* its wavelength; -1: the bundle; or a run of bins (shared/bins.h) */
    cpm_i32 exact;    /* starts near an edge */
    cpm_i32 crossing; /* starts on a boundary that it has just passed: coincident surfaces still count */
} cpm_flight;
CPM_STATIC_ASSERT(sizeof(cpm_flight) == 88, cpm_flight_size);

typedef struct cpm_arrival {     /* where it ends */
    cpm_i32 status;              /* CPM_ARRIVAL_HIT, _LEFT, or why not */
    cpm_i32 method;              /* cpm_method that ran */
    cpm_hit hit;                 /* position is where it ended, whatever the status */
    cpm_vec direction;           /* unit, of travel */
    double n;                    /* index there, on the side that it comes from */
    cpm_region behind;           /* what contains the ray beyond a boundary; count 0: more than CPM_MAX_NESTED would */
    double length, optical_path; /* on the host, with options only */
    double drift, error;
    double evaluations, steps, rejected;
} cpm_arrival;
CPM_STATIC_ASSERT(sizeof(cpm_arrival) == 176, cpm_arrival_size);

typedef struct cpm_passage { /* both ways on from a boundary */
    cpm_i32 jumps;           /* n jumps: Snell and Fresnel; else `transmitted` goes straight on */
    cpm_i32 total;           /* total reflection: there is no `transmitted` */
    double reflectance;      /* Fresnel, 0 without a jump */
    cpm_flight reflected, transmitted;
} cpm_passage;
#endif
