/* cpm/medium.h: refractive index fields n(r, wavelength).
 *
 * A medium is immutable and reference counted. Values that are NaN, infinite or not positive are refused when it is
 * made; the message gives the index of the first bad sample.
 *
 * Dispersion of a varying medium: its own numbers hold at the d line, 587.5618 nm. A medium defined by n (linear, grid,
 * layered cubic and step) scales its refractivity n - 1 by (D(w) - 1)/(D(d) - 1); one defined by n^2 (linear-squared,
 * layered linear-squared) scales n^2 - 1 by (D(w)^2 - 1)/(D(d)^2 - 1), so that its exact paths stay exact.
 * A homogeneous medium made from a dispersion alone has n = D(w). */
#ifndef CPM_MEDIUM_H
#define CPM_MEDIUM_H
#include "context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cpm_medium cpm_medium;

typedef enum cpm_dispersion_kind {
    CPM_DISPERSION_NONE = 0,
    CPM_DISPERSION_CONSTANT = 1,  /* n = c[0] */
    CPM_DISPERSION_CAUCHY = 2,    /* n = c[0] + c[1]/w^2 + c[2]/w^4 + ..., w in micrometres */
    CPM_DISPERSION_SELLMEIER = 3, /* n^2 = 1 + sum c[2i] w^2/(w^2 - c[2i+1]), w in micrometres, c[2i+1] in um^2 */
    CPM_DISPERSION_TABULATED = 4, /* linear between (c[2i] nm, c[2i+1]) */
    CPM_DISPERSION_GAS = 5        /* n = 1 + c[0] + c[1] k + c[2] k^2 + c[3] k^3 + sum c[2i+4]/(c[2i+5] - k), k = 1/w^2,
                                     w in micrometres; at least the four first. Edlen's and Ciddor's form for air */
} cpm_dispersion_kind;

#define CPM_DISPERSION_MAX_COEFFICIENTS 64

typedef struct cpm_dispersion {
    size_t struct_size;
    int32_t kind;  /* cpm_dispersion_kind */
    int32_t count; /* coefficients used */
    double coefficients[CPM_DISPERSION_MAX_COEFFICIENTS];
    double low, high; /* valid range, nm; 0, 0: no limit. Outside: an error when a wavelength is used */
} cpm_dispersion;

/* A published dispersion: "BK7" (SCHOTT N-BK7), "F2", "SF11", "fused silica", "water" (20 C), "sapphire" (ordinary ray),
 * "diamond", "air" (15 C, 101325 Pa, dry). Case, blanks, hyphens and underscores do not matter. Set
 * dispersion->struct_size; all else is written. The range is the source's: set low = high = 0 to go beyond it. n of
 * water and air is absolute, of the others relative to air as their sources have it. Sources: spectral/data. */
CPM_API cpm_status cpm_dispersion_catalogue(cpm_context *context, const char *name, cpm_dispersion *dispersion);

typedef enum cpm_interpolation {
    CPM_INTERPOLATION_LINEAR = 0,         /* grid: trilinear n */
    CPM_INTERPOLATION_CUBIC = 1,          /* grid: C2 interpolating B-spline; layered: C2 natural spline of n */
    CPM_INTERPOLATION_LINEAR_SQUARED = 2, /* layered: n^2 linear in height (spherical: in rho^2) between, constant outside */
    CPM_INTERPOLATION_STEP = 3            /* layered: n constant from a height to the next, Snell between */
} cpm_interpolation;

/* In every creator `dispersion` may be NULL; points and vectors are 3 doubles, metres. */
CPM_API cpm_status cpm_medium_create_homogeneous(cpm_context *context, double n, const cpm_dispersion *dispersion,
                                                 cpm_medium **medium);
/* n = D(wavelength) itself. */
CPM_API cpm_status cpm_medium_create_dispersive(cpm_context *context, const cpm_dispersion *dispersion,
                                                cpm_medium **medium);
/* n^2 = n_squared + gradient . (r - origin) */
CPM_API cpm_status cpm_medium_create_linear_squared(cpm_context *context, double n_squared, const double *gradient,
                                                    const double *origin, const cpm_dispersion *dispersion,
                                                    cpm_medium **medium);
/* n = n0 + gradient . (r - origin) */
CPM_API cpm_status cpm_medium_create_linear(cpm_context *context, double n, const double *gradient,
                                            const double *origin, const cpm_dispersion *dispersion,
                                            cpm_medium **medium);

typedef struct cpm_layered_desc {
    size_t struct_size;
    const double *heights; /* count, metres, strictly increasing, measured along `up` from `origin` */
    const double *n;       /* count, > 0 */
    size_t count;          /* >= 2 (>= 1 for step) */
    double up[3];          /* need not be unit; 0 0 0: +y */
    double origin[3];
    int32_t interpolation; /* CUBIC, LINEAR_SQUARED or STEP */
    int32_t reserved;
    double radius; /* metres; 0: flat. Else heights are above a sphere of this radius whose centre is `radius` below
                      origin (against `up`), all above -radius; LINEAR_SQUARED is linear in the square of the distance
                      from that centre */
    const size_t *kinks; /* CUBIC: kink_count ascending indices of heights where the slope of n may jump (a tropopause):
                            natural splines that meet there. NULL: one spline */
    size_t kink_count;
} cpm_layered_desc;
CPM_API cpm_status cpm_medium_create_layered(cpm_context *context, const cpm_layered_desc *desc,
                                             const cpm_dispersion *dispersion, cpm_medium **medium);

typedef struct cpm_grid_desc {
    size_t struct_size;
    const double *values;  /* n at (nx, ny, nz) samples */
    size_t size[3];        /* nx, ny, nz; >= 1 each */
    ptrdiff_t stride[3];   /* bytes between neighbours in x, y, z; 0 0 0: C-contiguous (z fastest) */
    double origin[3];      /* position of sample (0, 0, 0) */
    double spacing[3];     /* > 0 */
    int32_t interpolation; /* LINEAR or CUBIC; the edge value is held outside */
    int32_t reserved;
} cpm_grid_desc;
CPM_API cpm_status cpm_medium_create_grid(cpm_context *context, const cpm_grid_desc *desc,
                                          const cpm_dispersion *dispersion, cpm_medium **medium);

CPM_API void cpm_medium_retain(cpm_medium *medium);
CPM_API void cpm_medium_release(cpm_medium *medium);

/* n at `count` points (contiguous, 3 doubles each) and, unless NULL, grad n (3 doubles each), at one wavelength (nm). */
CPM_API cpm_status cpm_medium_evaluate(cpm_context *context, const cpm_medium *medium, const double *points,
                                       size_t count, double wavelength, double *n, double *gradient);

#ifdef __cplusplus
}
#endif
#endif
