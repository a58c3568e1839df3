/* shared/elementary_more.h: what formulas and curved layers need beside elementary.h: the same bits everywhere.
 *
 *   of one double    cpm_atan, cpm_atan2, cpm_asin, cpm_acos, cpm_tan, cpm_sinh, cpm_cosh, cpm_tanh
 *   of lanes         atan_lanes ... tanh_lanes
 *
 * Error bounds, double, measured on 1e6 arguments each against mpmath-grade libm (tests/kernels/test_elementary.py):
 * 4 ulp; tan 6 ulp where |tan| > 1e-3, |x| <= 1e6; sinh and cosh 3 ulp on [-700, 700]. */
#ifndef CPM_SHARED_ELEMENTARY_MORE_H
#define CPM_SHARED_ELEMENTARY_MORE_H
#include "elementary.h"

/* One double. */
#define E_NAME(f) cpm_##f
#define E_REAL double
#define E_C(x) (x)
#define E_PICK(c, a, b) ((c) ? (a) : (b))
#define E_TRUE(c) (c)
#define E_SQRT(x) cpm_sqrt(x)
#include "elementary_more_body.h"
#undef E_NAME
#undef E_REAL
#undef E_C
#undef E_PICK
#undef E_TRUE
#undef E_SQRT

/* Lanes. */
#define E_NAME(f) f##_lanes
#define E_REAL real
#define E_C(x) R(x)
#define E_PICK(c, a, b) pick(c, a, b)
#define E_TRUE(c) CPM_BOOL(c)
#define E_SQRT(x) root(x)
#include "elementary_more_body.h"
#undef E_NAME
#undef E_REAL
#undef E_C
#undef E_PICK
#undef E_TRUE
#undef E_SQRT
#endif
