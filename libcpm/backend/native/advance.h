/* backend/native/advance.h: curved rays for the scene tracer: eight integrated rays at a time, or one exact piece.
 *
 * Integrated (cpm_medium_has_exact is 0, or exact is excluded): fill r, p (|p| = n(r)), scale, length, optical_path of
 * the lanes to be loaded, call cpm_lanes_start for them, then cpm_lanes_step until status is >= 0 or you have what you
 * want. After each call accepted[i] says whether lane i holds a new piece: r0.. to r.. in piece_h. Lanes never
 * influence each other: results do not depend on what is beside a ray, on the ISA or on threads. Lanes that stand still
 * (status
 * >= 0) cost nothing but their place; load them anew at any time.
 *
 * Exact (cl/shared/exact.h): cpm_exact_next gives the next piece of the closed form from (r, p). Homogeneous media need
 * neither: a piece with g = 0 is straight. */
#ifndef CPM_NATIVE_ADVANCE_H
#define CPM_NATIVE_ADVANCE_H
#include <stdint.h>

#include "cl/shared/exact.h"
#include "cl/shared/piece.h"
#include "cl/types/lanes.h" /* cpm_lane_rays */
#include "cl/types/medium.h"
#include "cl/types/ray.h"

typedef struct cpm_lane_control {
    const cpm_medium_data *medium;
    const double *table;
    int32_t method;           /* a cpm_method that integrates (medium/method.h), neither AUTO nor EXACT */
    int32_t single_precision; /* 1: float lanes */
    double rtol, atol;        /* both as asked; rtol 0: the method's default */
    double step, max_step;    /* metres of arc; 0: none */
    double expected_length;   /* metres that a ray is likely to go (the scene's size); 0: rays->expected as loaded */
    int64_t max_evaluations;  /* per ray; 0: 1 000 000 */
} cpm_lane_control;

/* For the lanes with fresh[i] != 0: fills g, n, n_start, and h where it is 0 on entry (one evaluation a ray); clears
 * evaluations, steps, rejected, drift, error and sets status -1 (CPM_RAY_CUTOFF where n^2 <= 0 or is not finite). p is
 * rescaled to |p| = n. length and optical_path are left as loaded; limit and target become infinite. The
 * expected length bounds the first step and shares out atol. */
void cpm_lanes_start(const cpm_lane_control *control, cpm_lane_rays *rays, const int64_t fresh[8]);
/* One attempted step in every lane whose status is -1. */
void cpm_lanes_step(const cpm_lane_control *control, cpm_lane_rays *rays);
/* The piece that lane i has just accepted. */
void cpm_lane_piece(const cpm_lane_rays *rays, int lane, cpm_piece *piece);

/* Exact pieces, in cl/shared/exact.h (static inline, also OpenCL C):
 *
 *   int cpm_exact_next(const cpm_medium_data *medium, CPM_GLOBAL const double *table, double scale,
 *                      const double r[3], double p[3], double sigma_limit, double least, double length0,
 *                      cpm_piece *piece, double *evaluations);
 *
 * The next piece of the exact path from (r, p), at most sigma_limit long (> 0, may be infinite where the medium has
 * natural breaks; the piece may then be infinite where the path is straight to infinity: give a limit), ended earlier
 * at a natural break (layer boundary, a lens's sphere, where |p| falls to `least` in fibre and fish-eye; `linear`,
 * fibre and lenses: where the quintic would leave the curve by 1e-13). piece->r1, p1 are the start of the next piece.
 * Snell's law at a "step" interface is applied at the start of the piece beyond it, in p
 * (so p is not const; piece->p0 is p after it): nothing else to call between pieces. Where r lies on a layer boundary,
 * p says which layer is entered; after a hit you may start from any (r, p) on the path. *evaluations grows by 1 a piece
 * of a layered medium, else by 0. Returns 0; nonzero where there is no closed form (cpm_medium_has_exact). length1 is
 * exact at the piece's end only: for the arc length inside a long parabola ask cpm_exact_length.
 *
 *   double cpm_exact_length(const double p[3], const double g[3], double sigma);   arc length of a parabola from p, g
 */
#endif
