/* shared/elementary_body.h: the functions of elementary.h, once for one double and once for lanes (no include guard).
 *
 * exp: x = k ln 2 + f, |f| <= ln 2/2, Taylor to f^13/13!, remainder 4e-18; 2^k goes into the exponent's bits.
 * log: x = 2^k m, m in [sqrt(1/2), sqrt 2); f = m - 1, s = f/(2 + f), z = s^2, log m = f - f^2/2 + s (f^2/2 + R),
 *      R = 2 (z/3 + z^2/5 + ...) to z^11/23, remainder 1e-18.
 * sin, cos: x = k pi/2 + f with pi/2 in three parts, exact while k < 2^20; Taylor to f^17, f^16. */
#define E_POLY(p, f, c) p = p * (f) + E_C(c)
#define E_MAGIC (E_IS_DOUBLE ? E_C(6755399441055744.0) : E_C(12582912.0)) /* rounds to an integer in the low bits */
#define E_SHIFT (E_IS_DOUBLE ? 52 : 23)

CPM_INLINE E_REAL E_NAME(exp)(E_REAL x) {
    E_REAL top = E_C(0.0) * x + (E_IS_DOUBLE ? E_C(709.0) : E_C(88.0)); /* "0 x +": NaN stays NaN, lanes are made */
    E_REAL bottom = E_C(0.0) * x - (E_IS_DOUBLE ? E_C(708.0) : E_C(87.0));
    E_REAL y = E_PICK(E_TRUE(x < top), x, top);
    y = E_PICK(E_TRUE(y < bottom), bottom, y);
    E_REAL t = y * E_C(1.4426950408889634074) + E_MAGIC;
    E_REAL k = t - E_MAGIC;
    E_REAL f = (y - k * (E_IS_DOUBLE ? E_C(6.93147180369123816490e-01) : E_C(0.693359375))) -
               k * (E_IS_DOUBLE ? E_C(1.90821492927058770002e-10) : E_C(-2.12194440054690583e-4));
    E_REAL p = f * E_C(1.0 / 6227020800.0) + E_C(1.0 / 479001600.0);
    E_POLY(p, f, 1.0 / 39916800.0);
    E_POLY(p, f, 1.0 / 3628800.0);
    E_POLY(p, f, 1.0 / 362880.0);
    E_POLY(p, f, 1.0 / 40320.0);
    E_POLY(p, f, 1.0 / 5040.0);
    E_POLY(p, f, 1.0 / 720.0);
    E_POLY(p, f, 1.0 / 120.0);
    E_POLY(p, f, 1.0 / 24.0);
    E_POLY(p, f, 1.0 / 6.0);
    E_POLY(p, f, 0.5);
    p = (p * f) * f + f; /* e^f - 1 */
    p = p + E_C(1.0);
    E_REAL result = E_VALUE(E_BITS(p) + E_LEFT(E_BITS(t), E_SHIFT));
    E_REAL infinite = p / (E_C(0.0) * p);
    result = E_PICK(E_TRUE(x > top), infinite, result);
    return E_PICK(E_TRUE(x < bottom), E_C(0.0) * p, result);
}

CPM_INLINE E_REAL E_NAME(log)(E_REAL x) {
    /* The exponent k that leaves m = x/2^k in [sqrt(1/2), sqrt 2): subtract the bits of sqrt(1/2), keep the top. */
    E_REAL sound = E_PICK(E_TRUE(x > E_C(0.0)), x, E_C(1.0) + E_C(0.0) * x); /* the bits of -0 would overflow below */
    E_INT bits = E_BITS(sound);
#if E_IS_DOUBLE
    E_INT k = (bits - 0x3FE6A09E667F3BCDL) >> 52;
#else
    E_INT k = (bits - 0x3F3504F3) >> 23;
#endif
    E_REAL f = E_VALUE(bits - E_LEFT(k, E_SHIFT)) - E_C(1.0);
    E_REAL s = f / (f + E_C(2.0)), z = s * s, square = E_C(0.5) * f * f;
    E_REAL p = z * E_C(2.0 / 23.0) + E_C(2.0 / 21.0);
    E_POLY(p, z, 2.0 / 19.0);
    E_POLY(p, z, 2.0 / 17.0);
    E_POLY(p, z, 2.0 / 15.0);
    E_POLY(p, z, 2.0 / 13.0);
    E_POLY(p, z, 2.0 / 11.0);
    E_POLY(p, z, 2.0 / 9.0);
    E_POLY(p, z, 2.0 / 7.0);
    E_POLY(p, z, 2.0 / 5.0);
    E_POLY(p, z, 2.0 / 3.0);
    p = p * z;
    /* k as a real, without a conversion instruction that AVX2 lacks: k + magic's bits. */
    E_REAL e = E_VALUE(k + E_BITS(E_C(0.0) * f + E_MAGIC)) - E_MAGIC;
    E_REAL low = s * (square + p) + e * (E_IS_DOUBLE ? E_C(1.90821492927058770002e-10) : E_C(-2.12194440054690583e-4));
    E_REAL result = e * (E_IS_DOUBLE ? E_C(6.93147180369123816490e-01) : E_C(0.693359375)) - ((square - low) - f);
    E_REAL zero = E_C(0.0) * x, infinite = E_C(1.0) / (zero * zero);
    result = E_PICK(E_TRUE(x > zero), result, zero / zero); /* also +infinity and NaN: zero is NaN */
    return E_PICK(E_TRUE(x == zero), -infinite, result);
}

/* sin (shift 0) or cos (shift 1): quadrant k + shift. */
CPM_INLINE E_REAL E_NAME(wave)(E_REAL x, int shift) {
    E_REAL t = x * E_C(6.36619772367581382433e-01) + E_MAGIC;
    E_REAL k = t - E_MAGIC;
    E_REAL f = ((x - k * (E_IS_DOUBLE ? E_C(1.57079632673412561417) : E_C(1.5703125))) -
                k * (E_IS_DOUBLE ? E_C(6.07710050630396597660e-11) : E_C(4.8351287841796875e-4))) -
               k * (E_IS_DOUBLE ? E_C(2.02226624879595063154e-21) : E_C(3.13855707645416259766e-7));
    E_REAL z = f * f;
    E_REAL s = z * E_C(1.0 / 355687428096000.0) - E_C(1.0 / 1307674368000.0);
    E_POLY(s, z, 1.0 / 6227020800.0);
    E_POLY(s, z, -1.0 / 39916800.0);
    E_POLY(s, z, 1.0 / 362880.0);
    E_POLY(s, z, -1.0 / 5040.0);
    E_POLY(s, z, 1.0 / 120.0);
    E_POLY(s, z, -1.0 / 6.0);
    s = f + f * (z * s);
    E_REAL c = z * E_C(1.0 / 20922789888000.0) - E_C(1.0 / 87178291200.0);
    E_POLY(c, z, 1.0 / 479001600.0);
    E_POLY(c, z, -1.0 / 3628800.0);
    E_POLY(c, z, 1.0 / 40320.0);
    E_POLY(c, z, -1.0 / 720.0);
    E_POLY(c, z, 1.0 / 24.0);
    c = E_C(1.0) - (E_C(0.5) * z - z * (z * c));
    E_INT quadrant = E_BITS(t) + shift;
    E_REAL result = E_PICK(E_TRUE((quadrant & 1) != 0), c, s);
    return E_PICK(E_TRUE((quadrant & 2) != 0), -result, result);
}
CPM_INLINE E_REAL E_NAME(sin)(E_REAL x) { return E_NAME(wave)(x, 0); }
CPM_INLINE E_REAL E_NAME(cos)(E_REAL x) { return E_NAME(wave)(x, 1); }

#undef E_POLY
#undef E_MAGIC
#undef E_SHIFT
#undef E_NAME
#undef E_REAL
#undef E_INT
#undef E_IS_DOUBLE
#undef E_C
#undef E_PICK
#undef E_BITS
#undef E_VALUE
#undef E_LEFT
#undef E_TRUE
