/* shared/step_trial.h: what a step starts from and what it proposes. */
#ifndef CPM_SHARED_STEP_TRIAL_H
#define CPM_SHARED_STEP_TRIAL_H
#include "medium.h"

typedef struct {
    real3 r, p, g; /* g = half grad n^2 at r */
    real n, scale;
} cpm_point;

typedef struct {
    cpm_point end;
    real3 bend, push;     /* end.r - r - h p and end.p - p: what float lanes are added up by (step.h); set where CPM_SINGLE */
    real way, path;       /* arc length and optical path of the step, metres */
    real error_position2; /* metres^2: square of the estimate for the lower-order result */
    real error_way;       /* metres of arc length, signed */
    real error_momentum2; /* square, of p; all 0 where the method has no estimate */
    real curve;           /* metres: dense of the position alone; set by nystrom */
    real dense;           /* metres: f6 h^6/720, what the quintic between the ends lacks; 0 where it is not known */
    mask good;            /* n > 0 at every point that was evaluated */
} cpm_trial;
#endif
