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

/* Into out: n, then g. Lanes go in and out one by one, for a struct would be copied in halves of what is then read. */
CPM_OUTLINE void cpm_run_expression(const cpm_medium_data *m, CPM_GLOBAL const double *table, real x, real y, real z,
                                    real scale, real *out) {
    const real zero = splat(0.0), one = splat(1.0);
    real registers[CPM_REGISTERS];
    const int reads = m->size[2];
    CPM_GLOBAL const double *at = table + m->records;
    registers[CPM_REGISTER_X] = x;
    registers[CPM_REGISTER_Y] = y;
    registers[CPM_REGISTER_Z] = z;
    if (reads & CPM_READS_R) registers[CPM_REGISTER_R] = root(x * x + y * y + z * z);
    registers[CPM_REGISTER_WAVELENGTH] = scale;
    for (int i = 0; i < m->size[0]; i++, at += CPM_INSTRUCTION) {
        const cpm_u64 code = cpm_bits_of(at[0]);
        /* operands and constants are read by the operations that have them */
#define CPM_A registers[(code >> 16) & 127]
#define CPM_B registers[(code >> 24) & 127]
#define CPM_C registers[(code >> 32) & 127]
#define CPM_K R(at[1])
#define CPM_L R(at[2])
        real result;
        switch ((int)(code & 255)) {
        case CPM_OP_CONSTANT: result = splat(CPM_K); break;
        case CPM_OP_ADD: result = CPM_A + CPM_B; break;
        case CPM_OP_SUBTRACT: result = CPM_A - CPM_B; break;
        case CPM_OP_MULTIPLY: result = CPM_A * CPM_B; break;
        case CPM_OP_DIVIDE: result = CPM_A / CPM_B; break;
        case CPM_OP_SCALE: result = CPM_K * CPM_A; break;
        case CPM_OP_AFFINE: result = CPM_K * CPM_A + CPM_L; break;
        case CPM_OP_MULTIPLY_ADD: result = CPM_A * CPM_B + CPM_C; break;
        case CPM_OP_INVERT: result = CPM_K / CPM_A; break;
        case CPM_OP_SQRT: result = root(CPM_A); break;
        case CPM_OP_EXP: result = exp_lanes(CPM_A); break;
        case CPM_OP_LOG: result = log_lanes(CPM_A); break;
        case CPM_OP_SIN: result = sin_lanes(cpm_angle(CPM_A)); break;
        case CPM_OP_COS: result = cos_lanes(cpm_angle(CPM_A)); break;
        case CPM_OP_TAN: result = tan_lanes(cpm_angle(CPM_A)); break;
        case CPM_OP_ASIN: result = asin_lanes(CPM_A); break;
        case CPM_OP_ACOS: result = acos_lanes(CPM_A); break;
        case CPM_OP_ATAN2: result = atan2_lanes(CPM_A, CPM_B); break;
        case CPM_OP_SINH: result = sinh_lanes(CPM_A); break;
        case CPM_OP_COSH: result = cosh_lanes(CPM_A); break;
        case CPM_OP_TANH: result = tanh_lanes(CPM_A); break;
        case CPM_OP_ABS: result = pick(less(CPM_A, zero), -CPM_A, CPM_A); break;
        case CPM_OP_MIN: result = pick(less(CPM_B, CPM_A), CPM_B, CPM_A); break;
        case CPM_OP_MAX: result = pick(less(CPM_A, CPM_B), CPM_B, CPM_A); break;
        case CPM_OP_SIGN: result = cpm_sign(CPM_A); break;
        case CPM_OP_LESS: result = pick(less(CPM_A, CPM_B), one, zero); break;
        case CPM_OP_POWER: result = cpm_power(CPM_A, CPM_B); break;
        default: result = zero; break;
        }
        registers[(code >> 8) & 127] = result;
#undef CPM_A
#undef CPM_B
#undef CPM_C
#undef CPM_K
#undef CPM_L
    }
    const int results = m->size[1]; /* eight bits each */
    const real s = (reads & CPM_READS_WAVELENGTH) ? one : scale, index = R(1.0) + s * registers[results & 127];
    const real by = s * index, most = splat(CPM_LARGEST_INDEX);
    real gx = by * registers[(results >> 8) & 127], gy = by * registers[(results >> 16) & 127];
    real gz = by * registers[(results >> 24) & 127];
    mask good = less(zero, index) & less(index, most) & less(magnitude(gx) + magnitude(gy) + magnitude(gz), most);
    out[0] = pick(good, index, zero);
    out[1] = pick(good, gx, zero);
    out[2] = pick(good, gy, zero);
    out[3] = pick(good, gz, zero);
}

CPM_INLINE real3 cpm_field_expression(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                      real *n) {
    real out[4];
    cpm_run_expression(m, table, r.x, r.y, r.z, scale, out);
    *n = out[0];
    return triple(out[1], out[2], out[3]);
}
#endif
