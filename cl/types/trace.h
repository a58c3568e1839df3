/* types/trace.h: rays alone in a medium: how they start, where they are to end, how they ended. */
#ifndef CPM_TYPES_TRACE_H
#define CPM_TYPES_TRACE_H
#include "../dialect.h"

typedef struct cpm_ray_start {
    double r[3], d[3]; /* metres; direction of any length but 0 */
    double scale;      /* of the dispersion at the ray's wavelength */
    double length;     /* metres of arc to go; < 0: to the goal's plane */
    double max_step;   /* metres; 0: the control's */
} cpm_ray_start;

typedef struct cpm_ray_end {
    double r[3], p[3];
    double length, optical_path; /* metres */
    double drift;                /* max | |p| - n | / n */
    double error;                /* metres at the end, embedded errors summed; 0 for exact paths */
    double evaluations, steps, rejected;
    cpm_i32 status, reserved; /* cpm_ray_status */
} cpm_ray_end;

/* Where a ray is to end. */
typedef struct cpm_ray_goal {
    double length; /* metres of arc; < 0: the first crossing of the plane */
    double point[3], normal[3];
    double max_evaluations;
} cpm_ray_goal;

/* Positions at equal arc lengths: count of them, `step` apart from the ray's start, written as they are passed. */
typedef struct cpm_samples {
    CPM_GLOBAL double *position; /* count x 3 */
    double step;
    cpm_i64 count, next;
} cpm_samples;

CPM_STATIC_ASSERT(sizeof(cpm_ray_start) == 72, cpm_ray_start_size);
CPM_STATIC_ASSERT(sizeof(cpm_ray_end) == 112, cpm_ray_end_size);
CPM_STATIC_ASSERT(sizeof(cpm_ray_goal) == 64, cpm_ray_goal_size);
#endif
