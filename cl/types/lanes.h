/* types/lanes.h: eight integrated rays and what steers them, the same memory on both sides.
 *
 * Arrays of 8 doubles whatever the width or precision of the arithmetic (float lanes hold float values in them), so
 * that a caller reads and loads single rays by index while the steps run on whole lanes. */
#ifndef CPM_TYPES_LANES_H
#define CPM_TYPES_LANES_H
#include "../dialect.h"

#define CPM_LANES 8
#define CPM_ADAMS_ORDER 12 /* the highest; points of the past, the current one among them */

/* cpm_method and cpm_ray_status of the public headers. */
#define CPM_STEP_EXACT 1
#define CPM_STEP_EULER 2
#define CPM_STEP_RK4 3
#define CPM_STEP_DOPRI5 4
#define CPM_STEP_NYSTROM 5
#define CPM_STEP_ADAMS 6
#define CPM_STEP_LEAPFROG 7
#define CPM_STEP_YOSHIDA6 8
#define CPM_ENDED_GOING (-1)
#define CPM_ENDED_ARRIVED 0
#define CPM_ENDED_LEFT 2
#define CPM_ENDED_EXHAUSTED 10
#define CPM_ENDED_UNDERFLOW 11
#define CPM_ENDED_CUTOFF 12
#define CPM_ENDED_CAPTURED 13

typedef struct cpm_lane_rays {
    double r[3][CPM_LANES], p[3][CPM_LANES], g[3][CPM_LANES]; /* current point; g = half grad n^2 there */
    double n[CPM_LANES], scale[CPM_LANES], length[CPM_LANES], optical_path[CPM_LANES];
    double h[CPM_LANES];      /* sigma step to try next; 0: choose */
    double limit[CPM_LANES];  /* sigma that the next attempt must not exceed, not remembered as a step size; start sets
                                 +infinity */
    double target[CPM_LANES]; /* arc length (of `length`) to end at; start sets +infinity. The step that gets there is
                                 shortened to it; the caller ends the ray by the piece */
    double expected[CPM_LANES]; /* metres the ray is likely to go in all; 0: unknown. Shares out atol, first step */
    double n_start[CPM_LANES], evaluations[CPM_LANES], steps[CPM_LANES], rejected[CPM_LANES];
    double drift[CPM_LANES];      /* max | |p| - n | / n */
    double drift_now[CPM_LANES];  /* the same at the current point */
    double error[CPM_LANES];      /* metres: embedded errors, those of direction carried along the ray */
    double error_turn[CPM_LANES]; /* radians: embedded errors of direction */
    double previous[CPM_LANES];   /* log2 of the last ratio of error to tolerance: the step controller's memory */
    double refused[CPM_LANES];    /* attempts refused since the last step */
    double dense[CPM_LANES];      /* f6 h^6/720 of the piece, metres: u^3 of it is the quintic's error (piece.h); 0: not
                                     known */
    cpm_i64 status[CPM_LANES];    /* -1 going, else a cpm_ray_status */
    cpm_i64 at_kink[CPM_LANES];   /* grad n jumps here: g is to be taken anew, beyond it */
    cpm_i64 accepted[CPM_LANES];  /* nonzero: the last attempt was accepted, and the piece below is valid */
    double r0[3][CPM_LANES], p0[3][CPM_LANES], g0[3][CPM_LANES], n0[CPM_LANES], length0[CPM_LANES];
    double optical_path0[CPM_LANES], piece_h[CPM_LANES]; /* the piece: from r0 to r in piece_h */
    /* symplectic methods: what the compensated sums of r (0 to 2) and p (3 to 5) have lost, now and after the attempt
     */
    double low[6][CPM_LANES], low_next[6][CPM_LANES];
    /* adams: g and n at the points before the current one, how far behind it in sigma (< 0), and how many there are;
     * the order to take, and log2 of the errors of one order less and more over its own */
    double past[CPM_ADAMS_ORDER - 1][4][CPM_LANES], past_sigma[CPM_ADAMS_ORDER - 1][CPM_LANES];
    double kept[CPM_LANES], order[CPM_LANES], lower[CPM_LANES], higher[CPM_LANES];
} cpm_lane_rays;

/* What holds for all rays of a call. */
typedef struct cpm_step_control {
    cpm_i32 method; /* CPM_STEP_ */
    cpm_i32 order;  /* of the pair that nystrom takes: 6 or 8; by cpm_step_control_set, as all below from `lenient` */
    cpm_i32 dense;  /* 1: the curve between the ends of a step must be as good as they are */
    cpm_i32 high;   /* 1: nystrom may take 12(10) where there is far to go; by cpm_step_control_set */
    double rtol, atol; /* position error <= atol + rtol x length, direction error <= rtol */
    double step;       /* metres of arc, fixed; 0: adaptive */
    double max_step;   /* metres of arc; infinite: none */
    double max_evaluations;
    double lenient; /* from rtol by cpm_step_control_set (shared/step.h): see there */
    double first;
    double exponent; /* 1/q where errors to tolerances grow as h^q */
    double cost;     /* evaluations an attempt */
    double grow;     /* growth of | |p| - n |/n that a step may have, in rtol cos a */
} cpm_step_control;
CPM_STATIC_ASSERT(sizeof(cpm_step_control) == 96, cpm_step_control_size);
#endif
