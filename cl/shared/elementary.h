/* shared/elementary.h: exp, log, sin, cos of our own: the platforms' differ by up to 3 ulp, ours agree to the last bit.
 *
 *   of one double    cpm_exp, cpm_log, cpm_log1p, cpm_sin, cpm_cos
 *   of lanes         exp_lanes, log_lanes, sin_lanes, cos_lanes
 *
 * Error bounds, double, measured on 3e6 arguments each against the 80-bit libm:
 *   exp     1 ulp on [-708, 709]; 0 below, infinity above
 *   log     1 ulp on normal positive numbers; -infinity at 0, NaN below; log1p 1.5 ulp on (-1, 1e3)
 *   sin cos absolute 1.8e-16; 2.5 ulp where the result is above 1e-3; |x| <= 1e6 (single: 1e3), wrong beyond */
#ifndef CPM_SHARED_ELEMENTARY_H
#define CPM_SHARED_ELEMENTARY_H
#include "../dialect.h"

/* One double. */
#define E_NAME(f) cpm_##f
#define E_REAL double
#define E_INT cpm_i64
#define E_IS_DOUBLE 1
#define E_C(x) (x)
#define E_PICK(c, a, b) ((c) ? (a) : (b))
#define E_BITS(x) ((cpm_i64)cpm_bits_of(x))
#define E_VALUE(i) cpm_double_of((cpm_u64)(i))
#define E_LEFT(i, n) ((cpm_i64)((cpm_u64)(i) << (n)))
#define E_TRUE(c) (c)
#include "elementary_body.h"

CPM_INLINE double cpm_log1p(double x) {
    double u = 1.0 + x, lost = x - (u - 1.0); /* log(1 + x) = log u + log(1 + lost/u) */
    return x < 1e-16 && x > -1e-16 ? x : cpm_log(u) + lost / u;
}

/* Lanes. */
#define E_NAME(f) f##_lanes
#define E_REAL real
#define E_INT mask
#define E_IS_DOUBLE (!CPM_SINGLE)
#define E_C(x) R(x)
#define E_PICK(c, a, b) pick(c, a, b)
#define E_BITS(x) bits_of(x)
#define E_VALUE(i) real_of(i)
#if CPM_WIDTH > 1
#define E_LEFT(i, n) ((i) << (n))
#define E_TRUE(c) (c)
#elif CPM_SINGLE
#define E_LEFT(i, n) ((cpm_i32)((cpm_u32)(i) << (n)))
#define E_TRUE(c) (-(mask)(c))
#else
#define E_LEFT(i, n) ((cpm_i64)((cpm_u64)(i) << (n)))
#define E_TRUE(c) (-(mask)(c))
#endif
#include "elementary_body.h"
#endif
