/* shared/medium_expression.h: n by a formula: a program that leaves the refractivity N and its gradient in four
 * registers. n = 1 + s N, g = n s grad N; s is the dispersion's, or 1 where the formula itself reads the wavelength, which
 * then is what `scale` holds.
 *
 * What cannot be (a logarithm of a negative number, an overflow, sine of more than 1e6) is NaN and stays so; where n or its
 * gradient is not finite, or n not positive, n is given as 0: the ray ends there. At r = 0, where r has no gradient, that of
 * a formula in r is 0. */
#ifndef CPM_SHARED_MEDIUM_EXPRESSION_H
#define CPM_SHARED_MEDIUM_EXPRESSION_H
#include "../types/expression.h"
#include "../types/medium.h"
#include "elementary_more.h"

#define CPM_LARGEST_INDEX (CPM_SINGLE ? 1e15 : 1e100)
#define CPM_LARGEST_ANGLE (CPM_SINGLE ? 1e3 : 1e6) /* as far as elementary.h reduces angles */

CPM_INLINE real cpm_angle(real x) { return pick(at_most(magnitude(x), R(CPM_LARGEST_ANGLE)), x, x / (x - x)); }

/* a^b for a >= 0 by exp(b log a), of relative error 2^-53 |b log a|; below 0 it has no real value. */
CPM_INLINE real cpm_power(real a, real b) {
    const real zero = splat(0.0), one = splat(1.0);
    real at_zero = pick(less(zero, b), zero, pick(equal(b, zero), one, one / zero));
    return pick(equal(a, zero), at_zero, exp_lanes(b * log_lanes(a)));
}
CPM_INLINE real cpm_sign(real a) {
    const real zero = splat(0.0), one = splat(1.0);
    return pick(less(zero, a), one, pick(less(a, zero), -one, R(0.0) * a));
}

CPM_INLINE real cpm_operation(int operation, real a, real b, real c, scalar k, scalar l) {
    const real zero = splat(0.0), one = splat(1.0);
    switch (operation) {
    case CPM_OP_CONSTANT: return splat(k);
    case CPM_OP_ADD: return a + b;
    case CPM_OP_SUBTRACT: return a - b;
    case CPM_OP_MULTIPLY: return a * b;
    case CPM_OP_DIVIDE: return a / b;
    case CPM_OP_SCALE: return k * a;
    case CPM_OP_AFFINE: return k * a + l;
    case CPM_OP_MULTIPLY_ADD: return a * b + c;
    case CPM_OP_INVERT: return k / a;
    case CPM_OP_SQRT: return root(a);
    case CPM_OP_EXP: return exp_lanes(a);
    case CPM_OP_LOG: return log_lanes(a);
    case CPM_OP_SIN: return sin_lanes(cpm_angle(a));
    case CPM_OP_COS: return cos_lanes(cpm_angle(a));
    case CPM_OP_TAN: return tan_lanes(cpm_angle(a));
    case CPM_OP_ASIN: return asin_lanes(a);
    case CPM_OP_ACOS: return acos_lanes(a);
    case CPM_OP_ATAN2: return atan2_lanes(a, b);
    case CPM_OP_SINH: return sinh_lanes(a);
    case CPM_OP_COSH: return cosh_lanes(a);
    case CPM_OP_TANH: return tanh_lanes(a);
    case CPM_OP_ABS: return pick(less(a, zero), -a, a);
    case CPM_OP_MIN: return pick(less(b, a), b, a);
    case CPM_OP_MAX: return pick(less(a, b), b, a);
    case CPM_OP_SIGN: return cpm_sign(a);
    case CPM_OP_LESS: return pick(less(a, b), one, zero);
    case CPM_OP_POWER: return cpm_power(a, b);
    default: return zero;
    }
}

CPM_INLINE real3 cpm_field_expression(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                      real *n) {
    real registers[CPM_REGISTERS];
    const int reads = m->size[2];
    CPM_GLOBAL const double *at = table + m->records;
    registers[CPM_REGISTER_X] = r.x;
    registers[CPM_REGISTER_Y] = r.y;
    registers[CPM_REGISTER_Z] = r.z;
    registers[CPM_REGISTER_R] = (reads & CPM_READS_R) ? root(dot3(r, r)) : r.x;
    registers[CPM_REGISTER_WAVELENGTH] = scale;
    for (int i = 0; i < m->size[0]; i++, at += CPM_INSTRUCTION) {
        const cpm_u64 code = cpm_bits_of(at[0]);
        registers[(code >> 8) & 127] =
            cpm_operation((int)(code & 255), registers[(code >> 16) & 127], registers[(code >> 24) & 127],
                          registers[(code >> 32) & 127], R(at[1]), R(at[2]));
    }
    const int out = m->size[1]; /* the four results, eight bits each */
    real3 slope = triple(registers[(out >> 8) & 127], registers[(out >> 16) & 127], registers[(out >> 24) & 127]);
    real s = (reads & CPM_READS_WAVELENGTH) ? splat(1.0) : scale;
    real index = R(1.0) + s * registers[out & 127];
    slope = scale3(s * index, slope);
    const real zero = splat(0.0), most = splat(CPM_LARGEST_INDEX);
    mask good = less(zero, index) & less(index, most) &
                less(magnitude(slope.x) + magnitude(slope.y) + magnitude(slope.z), most);
    *n = pick(good, index, zero);
    return pick3(good, slope, triple(zero, zero, zero));
}
#endif
