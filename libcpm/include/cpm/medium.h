/* cpm/medium.h: refractive index fields n(r, wavelength).
 *
 * A medium is immutable and reference counted. Values that are NaN, infinite or not positive are refused when it is
 * made; the message gives the index of the first bad sample.
 *
 * Dispersion of a varying medium: its own numbers hold at the d line, 587.5618 nm. A medium defined by n (linear, grid,
 * layered cubic and step) scales its refractivity n - 1 by (D(w) - 1)/(D(d) - 1); one defined by n^2 (linear-squared,
 * layered linear-squared, parabolic, Luneburg, Eaton) scales n^2 - 1 by (D(w)^2 - 1)/(D(d)^2 - 1), so that its exact
 * paths stay exact; the index at the centre of a fish-eye scales, for the same reason. A wavelength at which the scale
 * would make another kind of field of a lens (an Eaton lens at half of n^2 - 1 or less) is refused when it is used.
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

/* A published dispersion: "BK7" (SCHOTT N-BK7), "F2", "SF11", "fused silica", "water" (20 C), "sapphire" (ordinary
 * ray), "diamond", "air" (15 C, 101325 Pa, dry). Case, blanks, hyphens and underscores do not matter. Set
 * dispersion->struct_size; all else is written. The range is the source's: set low = high = 0 to go beyond it. n of
 * water and air is absolute, of the others relative to air as their sources have it. Sources: spectral/data. */
CPM_API cpm_status cpm_dispersion_catalogue(cpm_context *context, const char *name, cpm_dispersion *dispersion);

typedef enum cpm_interpolation {
    CPM_INTERPOLATION_LINEAR = 0,         /* grid: trilinear n */
    CPM_INTERPOLATION_CUBIC = 1,          /* grid: C2 interpolating B-spline; layered: C2 natural spline of n */
    CPM_INTERPOLATION_LINEAR_SQUARED = 2, /* layered: n^2 linear in height (spherical: in rho^2) between, constant outside */
    CPM_INTERPOLATION_STEP = 3            /* layered: n constant from a height to the next, Snell between */
} cpm_interpolation;

/* What scatters or absorbs in proportion to n - 1, as the molecules of a gas do: `values` are extinction (1/m) over n - 1,
 * both at the wavelength (nm, increasing; linear between, held beyond), so that the optical depth of a path is values times
 * int (n - 1) ds along it. Eye rays are dimmed by it, and photons of suns and environments on their way in; what is
 * scattered is lost. Only before the medium is used, once; copies of a medium in sums have none. */
CPM_API cpm_status cpm_medium_set_extinction(cpm_context *context, cpm_medium *medium, const double *wavelengths,
                                             const double *values, size_t count);

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

/* Lenses and fibre. `axis` and `center` NULL: +z and the origin. */
/* n^2 = n0^2 (1 - alpha^2 rho^2), rho the distance from the axis through `origin`; alpha >= 0, 1/m. A graded-index fibre:
 * n^2 <= 0 beyond rho = 1/alpha, where rays end, cut off. `axis` need not be unit. */
CPM_API cpm_status cpm_medium_create_parabolic(cpm_context *context, double n, double alpha, const double *axis,
                                               const double *origin, const cpm_dispersion *dispersion,
                                               cpm_medium **medium);
/* n^2 = 2 - r^2/R^2 within the radius R, 1 outside. */
CPM_API cpm_status cpm_medium_create_luneburg(cpm_context *context, double radius, const double *center,
                                              const cpm_dispersion *dispersion, cpm_medium **medium);
/* Maxwell's fish-eye: n = n0/(1 + r^2/a^2), a the radius. */
CPM_API cpm_status cpm_medium_create_fisheye(cpm_context *context, double n, double radius, const double *center,
                                             const cpm_dispersion *dispersion, cpm_medium **medium);
/* n^2 = 2 R/r - 1 within the radius R, 1 outside. Every ray leaves antiparallel to how it came; in closed form also one
 * straight at the centre, where n has no bound; an integrated one that comes too near has CPM_RAY_CAPTURED. */
CPM_API cpm_status cpm_medium_create_eaton(cpm_context *context, double radius, const double *center,
                                           const cpm_dispersion *dispersion, cpm_medium **medium);

/* Gravity centres and lines: n = 1 + sum m_i/d_i^k_i, d_i the distance from a point or an infinite line, metres. */
typedef struct cpm_sources_desc {
    size_t struct_size;
    size_t count;             /* >= 1 */
    const double *centers;    /* count x 3, metres: the points; on lines any of their points */
    const double *directions; /* count x 3, of the lines, need not be unit; 0 0 0: a point. NULL: points all */
    const double *strengths;  /* count; m, metres^k; > 0 attracts */
    const double *exponents;  /* count; k, in (0, 64] */
} cpm_sources_desc;
/* A ray that falls into an attracting source ends with CPM_RAY_CAPTURED. */
CPM_API cpm_status cpm_medium_create_sources(cpm_context *context, const cpm_sources_desc *desc,
                                             const cpm_dispersion *dispersion, cpm_medium **medium);
/* A formula, as a program: instructions over registers that leave the refractivity N = n - 1 and its gradient in four of
 * them. Registers 0 to 4 hold x, y, z (metres), r = sqrt(x^2 + y^2 + z^2) and the wavelength (nm); those from 5 to 127 are
 * free, each written before it is read. A value that is NaN or infinite, or n <= 0, met on the way ends the ray (CUTOFF).
 * (The Python package makes programs from text; so may anyone.) */
typedef enum cpm_operation {
    CPM_OPERATION_CONSTANT = 1,     /* k */
    CPM_OPERATION_ADD = 2,          /* a + b */
    CPM_OPERATION_SUBTRACT = 3,     /* a - b */
    CPM_OPERATION_MULTIPLY = 4,     /* a b */
    CPM_OPERATION_DIVIDE = 5,       /* a/b */
    CPM_OPERATION_SCALE = 6,        /* k a */
    CPM_OPERATION_AFFINE = 7,       /* k a + l */
    CPM_OPERATION_MULTIPLY_ADD = 8, /* a b + c, rounded twice */
    CPM_OPERATION_INVERT = 9,       /* k/a */
    CPM_OPERATION_SQRT = 20,
    CPM_OPERATION_EXP = 21,
    CPM_OPERATION_LOG = 22,
    CPM_OPERATION_SIN = 23, /* angles up to 1e6, in single precision 1e3; NaN beyond */
    CPM_OPERATION_COS = 24,
    CPM_OPERATION_TAN = 25,
    CPM_OPERATION_ASIN = 26,
    CPM_OPERATION_ACOS = 27,
    CPM_OPERATION_ATAN2 = 28, /* of a over b */
    CPM_OPERATION_SINH = 29,
    CPM_OPERATION_COSH = 30,
    CPM_OPERATION_TANH = 31,
    CPM_OPERATION_ABS = 32,
    CPM_OPERATION_MIN = 33,
    CPM_OPERATION_MAX = 34,
    CPM_OPERATION_SIGN = 35, /* -1, 0, 1 */
    CPM_OPERATION_LESS = 36, /* 1 where a < b, else 0 */
    CPM_OPERATION_POWER = 37 /* a^b, a >= 0 */
} cpm_operation;

typedef struct cpm_instruction {
    int32_t operation;       /* cpm_operation */
    int32_t target, a, b, c; /* registers; those that the operation does not take are ignored */
    int32_t reserved;
    double k, l;
} cpm_instruction;

#define CPM_MAX_INSTRUCTIONS 4096

typedef struct cpm_expression_desc {
    size_t struct_size;
    const cpm_instruction *instructions;
    size_t count;       /* 1 to CPM_MAX_INSTRUCTIONS */
    int32_t results[4]; /* registers of N, dN/dx, dN/dy, dN/dz */
    double feature;     /* metres over which n may change its shape: bounds the first step; 0: unknown */
} cpm_expression_desc;
/* A program that reads the wavelength disperses by itself: `dispersion` must be NULL then. */
CPM_API cpm_status cpm_medium_create_expression(cpm_context *context, const cpm_expression_desc *desc,
                                                const cpm_dispersion *dispersion, cpm_medium **medium);

#define CPM_MAX_TERMS 64

/* n = 1 + sum (n_i - 1), each term at its own dispersion. Sums are taken apart into their terms, at most CPM_MAX_TERMS in
 * all; discrete layers (step) have no gradient and cannot be a term. The terms are copied: release them as you like. */
CPM_API cpm_status cpm_medium_create_sum(cpm_context *context, cpm_medium *const *terms, size_t count,
                                         cpm_medium **medium);

CPM_API void cpm_medium_retain(cpm_medium *medium);
CPM_API void cpm_medium_release(cpm_medium *medium);

/* n at `count` points (contiguous, 3 doubles each) and, unless NULL, grad n (3 doubles each), at one wavelength (nm). */
CPM_API cpm_status cpm_medium_evaluate(cpm_context *context, const cpm_medium *medium, const double *points,
                                       size_t count, double wavelength, double *n, double *gradient);

#ifdef __cplusplus
}
#endif
#endif
