/* shared/sampling.h: directions and points from uniform numbers in (0, 1); lanes, of which one ray is a case. */
#ifndef CPM_SHARED_SAMPLING_H
#define CPM_SHARED_SAMPLING_H
#include "elementary.h"
#include "vec.h"

#define CPM_TWO_PI 6.283185307179586476925
#define CPM_PI 3.14159265358979323846

/* sin and cos of `turn` whole turns, turn in [0, 1], at once: the quarter turn nearest, and Taylor over +-1/8 of a turn
 * (to x^17 and x^16; error below 2e-16). */
CPM_INLINE void sincos_turns(real turn, real *sine, real *cosine) {
    real t = turn * R(4.0) + CPM_MAGIC, quarter = t - CPM_MAGIC; /* rounds to an integer, whose bits end those of t */
    real f = (turn - R(0.25) * quarter) * R(CPM_TWO_PI), z = f * f;
    real s = R(1.0 / 6227020800.0) + z * (R(-1.0 / 1307674368000.0) + z * R(1.0 / 355687428096000.0));
    s = R(-1.0 / 5040.0) + z * (R(1.0 / 362880.0) + z * (R(-1.0 / 39916800.0) + z * s));
    s = f + f * (z * (R(-1.0 / 6.0) + z * (R(1.0 / 120.0) + z * s)));
    real c = R(1.0 / 479001600.0) + z * (R(-1.0 / 87178291200.0) + z * R(1.0 / 20922789888000.0));
    c = R(1.0 / 24.0) + z * (R(-1.0 / 720.0) + z * (R(1.0 / 40320.0) + z * (R(-1.0 / 3628800.0) + z * c)));
    c = R(1.0) - z * (R(0.5) - z * c);
    mask q = bits_of(t), odd = CPM_BOOL((q & 1) != 0);
    real a = pick(odd, c, s), b = pick(odd, s, c);
    *sine = pick(CPM_BOOL((q & 2) != 0), -a, a);
    *cosine = pick(CPM_BOOL(((q + 1) & 2) != 0), -b, b);
}

/* Unit vector at cos theta from the axis n, at azimuth `turn` (in turns). */
CPM_INLINE real3 direction_about(real3 n, real cos_theta, real turn) {
    real3 s, t;
    real sine = root((R(1.0) - cos_theta) * (R(1.0) + cos_theta)), c, w;
    frame3(n, &s, &t);
    sincos_turns(turn, &w, &c);
    return unit3(add3(add3(scale3(cos_theta, n), sine * c, s), sine * w, t));
}

/* Density cos theta / pi about n (Malley). */
CPM_INLINE real3 sample_cosine(real3 n, real u, real v) { return direction_about(n, root(R(1.0) - u), v); }

/* Uniform in solid angle over 1 >= cos theta >= cos_cutoff. */
CPM_INLINE real3 sample_cone(real3 axis, real cos_cutoff, real u, real v) {
    return direction_about(axis, R(1.0) - u * (R(1.0) - cos_cutoff), v);
}

/* Uniform over a triangle: barycentric coordinates of corners 1 and 2. */
CPM_INLINE void sample_triangle(real u, real v, real *b1, real *b2) {
    real side = root(u);
    *b1 = side * (R(1.0) - v);
    *b2 = side * v;
}
#endif
