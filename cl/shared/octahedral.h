/* shared/octahedral.h: a direction in 32 bits: the sphere flattened onto an octahedron, its lower half folded outward
 * (Meyer, Süssmuth, Sußner, Stamminger, Greiner: On Floating-Point Normal Vectors. EGSR 2010; Cigolle et al.: A Survey
 * of Efficient Representations for Independent Unit Vectors. JCGT 3(2), 2014).
 *
 * Low half: u, high half: v, each a signed 16-bit integer in units of 1/32767. The six axes are exact; elsewhere a
 * direction comes back within 6.5e-5 rad. */
#ifndef CPM_SHARED_OCTAHEDRAL_H
#define CPM_SHARED_OCTAHEDRAL_H
#include "vec.h"

/* `v` need not be unit; zero encodes as +z. */
CPM_INLINE word octahedral_encode(real3 v) {
    real ax = magnitude(v.x), ay = magnitude(v.y), sum = ax + ay + magnitude(v.z);
    real a = ax / sum, b = ay / sum; /* the upper half: |u| + |v| <= 1 */
    mask below = less(v.z, splat(0.0));
    real folded = R(1.0) - b;
    b = pick(below, R(1.0) - a, b);
    a = pick(below, folded, a);
    a = floor_lanes(a * R(32767.0) + R(0.5)), b = floor_lanes(b * R(32767.0) + R(0.5));
    /* negative ones keep their low 16 bits: those of 65536 - |u| */
    a = pick(less(v.x, splat(0.0)) & less(splat(0.0), a), R(65536.0) - a, a);
    b = pick(less(v.y, splat(0.0)) & less(splat(0.0), b), R(65536.0) - b, b);
    mask known = less(splat(0.0), sum);
    a = pick(known, a, splat(0.0)), b = pick(known, b, splat(0.0));
    return real_words(a) | real_words(b) << 16;
}
#if CPM_WIDTH == 1 && !CPM_SINGLE
CPM_INLINE unsigned int cpm_octahedral_encode(cpm_vec v) { return (unsigned int)octahedral_encode(v); }
#endif

typedef struct cpm_octahedral {
    int x, y, z; /* |x| + |y| + |z| = 32767: a point of the octahedron, not a unit vector */
} cpm_octahedral;

/* Exact: the code's point in integers. */
CPM_INLINE cpm_octahedral cpm_octahedral_point(unsigned int code) {
    cpm_octahedral p;
    int u = (int)((code & 0xffffu) ^ 0x8000u) - 32768, v = (int)((code >> 16) ^ 0x8000u) - 32768;
    int au = u < 0 ? -u : u, av = v < 0 ? -v : v;
    int fold = au + av - 32767; /* below the equator: how far */
    p.z = -fold;
    fold = fold > 0 ? fold : 0;
    p.x = u < 0 ? u + fold : u - fold;
    p.y = v < 0 ? v + fold : v - fold;
    return p;
}

CPM_INLINE cpm_vec cpm_octahedral_decode(unsigned int code) {
    cpm_octahedral p = cpm_octahedral_point(code);
    return cpm_unit(cpm_v((double)p.x, (double)p.y, (double)p.z));
}
#endif
