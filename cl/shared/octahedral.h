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
CPM_INLINE unsigned int cpm_octahedral_encode(cpm_vec v) {
    double ax = v.x < 0.0 ? -v.x : v.x, ay = v.y < 0.0 ? -v.y : v.y, az = v.z < 0.0 ? -v.z : v.z;
    double sum = ax + ay + az;
    if (!(sum > 0.0)) return 0u;
    double a = ax / sum, b = ay / sum; /* the upper half: |u| + |v| <= 1 */
    if (v.z < 0.0) {
        double folded = 1.0 - b;
        b = 1.0 - a;
        a = folded;
    }
    int u = (int)(a * 32767.0 + 0.5), w = (int)(b * 32767.0 + 0.5);
    if (v.x < 0.0) u = -u;
    if (v.y < 0.0) w = -w;
    return ((unsigned int)u & 0xffffu) | ((unsigned int)w & 0xffffu) << 16;
}

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
