/* shared/half.h: 16-bit floats (IEEE 754 binary16) in integer arithmetic: what F16C does, to the last bit.
 *
 * 1 sign, 5 exponent (bias 15), 10 fraction bits: 11 significant bits, largest 65504, steps of 2^-24 below 2^-14. Every
 * half is a whole multiple of 2^-24 below 2^16, so sums of up to 8192 of them are exact in double, in any order. */
#ifndef CPM_SHARED_HALF_H
#define CPM_SHARED_HALF_H
#include "../dialect.h"

typedef union cpm_float_bits {
    float value;
    cpm_u32 bits;
} cpm_float_bits;

/* Exact. Without branches, so that a loop over it becomes vector instructions. A signalling NaN becomes quiet. */
CPM_INLINE float cpm_half_to_float(unsigned short code) {
    cpm_u32 magnitude = code & 0x7fffu, exponent = magnitude & 0x7c00u;
    cpm_float_bits normal, result;
    normal.bits = (magnitude << 13) + (112u << 23); /* bias 15 to bias 127 */
    if (exponent == 0x7c00u) normal.bits = 0x7f800000u | magnitude << 13 | ((magnitude & 0x3ffu) ? 0x400000u : 0u);
    result.value = (float)(int)magnitude * 5.9604644775390625e-8f; /* subnormal: in units of 2^-24 */
    if (exponent) result.bits = normal.bits;
    result.bits |= (cpm_u32)(code & 0x8000u) << 16;
    return result.value;
}

/* Eight halves in a row. */
CPM_INLINE wide_doubles cpm_wide_halves(CPM_GLOBAL const unsigned short *from) {
    double each[8];
    for (int i = 0; i < 8; i++) each[i] = (double)cpm_half_to_float(from[i]);
    return wide_gathered(each);
}

/* The nearest half, ties to even; from 65520 up infinity, NaN stays NaN. Error at most 2^-11 of the value (2^-25 below
 * 2^-14). */
CPM_INLINE unsigned short cpm_half_from_float(float value) {
    cpm_float_bits x;
    x.value = value;
    cpm_u32 sign = (x.bits >> 16) & 0x8000u, magnitude;
    x.bits &= 0x7fffffffu;
    if (x.bits >= 0x47800000u) { /* 2^16 and up, infinity, NaN */
        magnitude = x.bits > 0x7f800000u ? 0x7e00u | ((x.bits >> 13) & 0x3ffu) : 0x7c00u;
    } else if (x.bits < 0x38800000u) { /* below 2^-14: the last bit of 1/2 + x is worth 2^-24, and the adder rounds */
        x.value += 0.5f;
        magnitude = x.bits - 0x3f000000u;
    } else {
        magnitude = (x.bits + 0xfffu + ((x.bits >> 13) & 1u) - (112u << 23)) >> 13;
    }
    return (unsigned short)(sign | magnitude);
}
#endif
