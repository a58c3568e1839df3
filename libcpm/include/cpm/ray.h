/* cpm/ray.h: curved rays, alone in a medium or in a scene.
 *
 * A ray solves dr/ds = p, dp/ds = (1/2) grad n^2 with p = n dr/dl and ds = dl/n (Gutierrez et al., eq. 2.4, as a
 * Hamiltonian system). Tolerance: position error <= atol + rtol x path length, direction error <= rtol. */
#ifndef CPM_RAY_H
#define CPM_RAY_H
#include "medium.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cpm_scene;

typedef enum cpm_method {
    CPM_METHOD_AUTO = 0,
    CPM_METHOD_EXACT = 1,
    CPM_METHOD_EULER = 2, /* Euler with Richardson extrapolation: the paper's */
    CPM_METHOD_RK4 = 3,
    CPM_METHOD_DOPRI5 = 4,
    CPM_METHOD_NYSTROM = 5,  /* Runge-Kutta-Nystrom pairs 6(4) and 8(6), by tolerance */
    CPM_METHOD_ADAMS = 6,    /* Adams-Bashforth-Moulton, step and order (1 to 12) variable */
    CPM_METHOD_LEAPFROG = 7, /* symplectic, second order, fixed steps */
    CPM_METHOD_YOSHIDA6 = 8  /* symplectic, sixth order, fixed steps */
} cpm_method;

typedef enum cpm_error_mode {
    CPM_ERROR_LOCAL = 0, /* summed embedded errors: indicative */
    CPM_ERROR_GLOBAL = 1 /* difference to a second run at rtol/10 (fixed steps: step/2) */
} cpm_error_mode;

typedef struct cpm_rays_request {
    size_t struct_size;
    size_t count;
    const double *origins;    /* count x 3, contiguous */
    const double *directions; /* count x 3, contiguous; need not be unit */
    const double *wavelengths; /* nm; count, or 1 when wavelength_stride is 0 */
    ptrdiff_t wavelength_stride; /* in doubles: 0 or 1 */
    const double *lengths;     /* metres of arc; NULL with a plane or a scene */
    ptrdiff_t length_stride;   /* in doubles: 0 or 1 */
    const double *plane_point, *plane_normal; /* 3 each, or NULL */
    int32_t method;            /* cpm_method */
    uint32_t exclude;          /* bit 1 << method: keeps AUTO from it */
    double rtol, atol;         /* rtol 0: the method's default (1e-6, euler 1e-2); else 1e-14..1 */
    double step;               /* metres of arc, fixed; 0: adaptive */
    double max_step;           /* metres; 0: none */
    int64_t max_evaluations;   /* per ray; 0: 1 000 000 */
    int32_t error_mode;        /* cpm_error_mode */
    int32_t single_precision;  /* 0 or 1 */
    size_t path_samples;       /* K samples at equal arc length from start to end; 0: none */
} cpm_rays_request;

/* Arrays of `count` that the caller owns; any may be NULL. */
typedef struct cpm_rays_result {
    size_t struct_size;
    double *position;       /* x 3 */
    double *direction;      /* x 3, unit */
    double *momentum;       /* x 3, |momentum| = n */
    double *length;         /* arc, metres */
    double *optical_path;   /* metres */
    double *drift;          /* max | |p| - n | / n */
    double *error_estimate; /* metres at the end */
    int64_t *evaluations;   /* of grad n^2 */
    int64_t *steps;
    int64_t *rejected;
    int64_t *error_evaluations; /* spent on error_mode GLOBAL */
    int32_t *status;        /* cpm_ray_status */
    int32_t *method;        /* cpm_method that ran */
    int32_t *shape;         /* in a scene: what was hit, -1 */
    double *paths;          /* x path_samples x 3 */
} cpm_rays_result;

/* Exactly one of `medium` and `scene` is given. In a scene a ray ends at the first surface, crossing bounded media by
 * Snell's law (reflected only where it must be). The message of a bad input names the first bad index. */
CPM_API cpm_status cpm_rays_trace(cpm_context *context, const cpm_medium *medium, struct cpm_scene *scene,
                                  const cpm_rays_request *request, cpm_rays_result *result);

#ifdef __cplusplus
}
#endif
#endif
