/* shared/elementary_more_body.h: the functions of elementary_more.h, once for one double and once for lanes (no include
 * guard).
 *
 * atan: |x| > 1 by pi/2 - atan(1/|x|), above tan(pi/8) by pi/4 + atan((t - 1)/(t + 1)), then halved: atan t = 2 atan(t/(1 +
 *       sqrt(1 + t^2))) leaves |t| <= tan(pi/16) = 0.199; Taylor to t^23, remainder 4e-19.
 * asin, acos: atan2 with sqrt((1 - x)(1 + x)); beyond +-1 NaN.
 * sinh: |x| < 1 by Taylor to x^19, remainder 2e-20; else (e - 1/e)/2. tanh: sinh/cosh, +-1 beyond 20. */
#define E_POLY(p, f, c) p = p * (f) + E_C(c)

CPM_INLINE E_REAL E_NAME(atan)(E_REAL x) {
    const E_REAL zero = E_C(0.0) * x, one = zero + E_C(1.0); /* lanes are made; of an infinity see the end */
    E_REAL a = E_PICK(E_TRUE(x < E_C(0.0)), -x, x);
    E_REAL t = E_PICK(E_TRUE(a > E_C(1.0)), E_C(1.0) / a, a);
    E_REAL steep = E_PICK(E_TRUE(t > E_C(0.41421356237309503)), one, zero);
    t = E_PICK(E_TRUE(t > E_C(0.41421356237309503)), (t - E_C(1.0)) / (t + E_C(1.0)), t);
    t = t / (E_C(1.0) + E_SQRT(E_C(1.0) + t * t));
    E_REAL z = t * t, p = z * E_C(-1.0 / 23.0) + E_C(1.0 / 21.0);
    E_POLY(p, z, -1.0 / 19.0);
    E_POLY(p, z, 1.0 / 17.0);
    E_POLY(p, z, -1.0 / 15.0);
    E_POLY(p, z, 1.0 / 13.0);
    E_POLY(p, z, -1.0 / 11.0);
    E_POLY(p, z, 1.0 / 9.0);
    E_POLY(p, z, -1.0 / 7.0);
    E_POLY(p, z, 1.0 / 5.0);
    E_POLY(p, z, -1.0 / 3.0);
    E_REAL twice = t + t, angle = twice + twice * (z * p);
    angle = angle + steep * E_C(0.78539816339744831);
    angle = E_PICK(E_TRUE(a > E_C(1.0)), (E_C(1.5707963267948966) - angle) + E_C(6.123233995736766e-17), angle);
    angle = E_PICK(E_TRUE(a > E_C(1e30)), E_C(1.5707963267948966) + (E_C(0.0) / a), angle);
    return E_PICK(E_TRUE(x < E_C(0.0)), -angle, angle);
}

CPM_INLINE E_REAL E_NAME(atan2)(E_REAL y, E_REAL x) {
    E_REAL ay = E_PICK(E_TRUE(y < E_C(0.0)), -y, y), ax = E_PICK(E_TRUE(x < E_C(0.0)), -x, x);
    E_REAL angle = E_NAME(atan)(ay / ax);
    angle = E_PICK(E_TRUE(ay + ax == E_C(0.0)), E_C(0.0) * y, angle);
    angle = E_PICK(E_TRUE(x < E_C(0.0)), (E_C(3.1415926535897931) - angle) + E_C(1.2246467991473532e-16), angle);
    return E_PICK(E_TRUE(y < E_C(0.0)), -angle, angle);
}
CPM_INLINE E_REAL E_NAME(asin)(E_REAL x) {
    return E_NAME(atan2)(x, E_SQRT((E_C(1.0) - x) * (E_C(1.0) + x)));
}
CPM_INLINE E_REAL E_NAME(acos)(E_REAL x) {
    return E_NAME(atan2)(E_SQRT((E_C(1.0) - x) * (E_C(1.0) + x)), x);
}
CPM_INLINE E_REAL E_NAME(tan)(E_REAL x) { return E_NAME(sin)(x) / E_NAME(cos)(x); }

CPM_INLINE E_REAL E_NAME(sinh)(E_REAL x) {
    E_REAL z = x * x, p = z * E_C(1.0 / 121645100408832000.0) + E_C(1.0 / 355687428096000.0);
    E_POLY(p, z, 1.0 / 1307674368000.0);
    E_POLY(p, z, 1.0 / 6227020800.0);
    E_POLY(p, z, 1.0 / 39916800.0);
    E_POLY(p, z, 1.0 / 362880.0);
    E_POLY(p, z, 1.0 / 5040.0);
    E_POLY(p, z, 1.0 / 120.0);
    E_POLY(p, z, 1.0 / 6.0);
    p = x + x * (z * p);
    E_REAL e = E_NAME(exp)(x);
    return E_PICK(E_TRUE(z < E_C(1.0)), p, E_C(0.5) * (e - E_C(1.0) / e));
}
CPM_INLINE E_REAL E_NAME(cosh)(E_REAL x) {
    E_REAL e = E_NAME(exp)(x);
    return E_C(0.5) * (e + E_C(1.0) / e);
}
CPM_INLINE E_REAL E_NAME(tanh)(E_REAL x) {
    E_REAL one = E_C(0.0) * x + E_C(1.0), far = E_PICK(E_TRUE(x < E_C(0.0)), -one, one);
    E_REAL t = E_NAME(sinh)(x) / E_NAME(cosh)(x);
    return E_PICK(E_TRUE(x * x > E_C(400.0)), far, t);
}
#undef E_POLY
