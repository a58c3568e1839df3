/* geometry/few.h: where there are few primitives no tree is walked: each is asked of a lot of chords at once, in lanes
 * of rays, without a branch; part of curve.c. What is asked, and why it loses nothing, is cpm_faces_met's of
 * cl/shared/walk.h. */
#ifndef CPM_GEOMETRY_FEW_H
#define CPM_GEOMETRY_FEW_H
#include "bvh.h"
#include "cl/shared/walk.h"

#define LOT 64 /* curves asked at once */

/* Products and sums may be fused here: these are bounds with room for rounding, no result hangs on a bit of them. */
#if defined(__clang__) || !defined(__GNUC__)
#define FUSED
#else
#define FUSED __attribute__((optimize("fp-contract=fast")))
#endif

typedef struct chords { /* as the tree sees them: start + t slope, t in [0, 1]; the curve strays at most `grow` from it
                         */
    float start[3][LOT], slope[3][LOT], grow[3][LOT];
    uint32_t low[LOT], high[LOT]; /* bits: primitives 0 to 31 and 32 to 63 that the curve may meet */
} chords;

static inline void set_chord(chords *to, size_t i, const cpm_query *q) {
    const cpm_cast s = cpm_cast_of(q);
    for (int k = 0; k < 3; k++) to->start[k][i] = s.start[k], to->slope[k][i] = s.slope[k], to->grow[k][i] = s.grow[k];
}

/* One triangle's `face` and all chords: bit `bit` of `met` where a curve may meet it. Whatever is NaN passes. */
FUSED static void ask_face(const chords *c, const float face[CPM_FACE_ROWS], uint32_t bit, uint32_t *met) {
    const float *p = face + CPM_FACE_PLANE, *u = face + CPM_FACE_U, *v = face + CPM_FACE_V;
    const float pa[3] = {fabsf(p[0]), fabsf(p[1]), fabsf(p[2])}, ua[3] = {fabsf(u[0]), fabsf(u[1]), fabsf(u[2])};
    const float va[3] = {fabsf(v[0]), fabsf(v[1]), fabsf(v[2])};
    for (int i = 0; i < LOT; i++) {
        const float x = c->start[0][i], y = c->start[1][i], z = c->start[2][i];
        const float dx = c->slope[0][i], dy = c->slope[1][i], dz = c->slope[2][i];
        const float gx = c->grow[0][i], gy = c->grow[1][i], gz = c->grow[2][i];
        const float stray = pa[0] * gx + pa[1] * gy + pa[2] * gz, start = p[3] + p[0] * x + p[1] * y + p[2] * z;
        const float inverse = 1.0f / (p[0] * dx + p[1] * dy + p[2] * dz);
        const float one = (-stray - start) * inverse, other = (stray - start) * inverse;
        const float least = one < other ? one : other, most = one > other ? one : other;
        const float in = least > 0.0f ? least : 0.0f,
                    out = most < 1.0f + CPM_WALK_ROUNDING ? most : 1.0f + CPM_WALK_ROUNDING;
        const float us = u[3] + u[0] * x + u[1] * y + u[2] * z, ud = u[0] * dx + u[1] * dy + u[2] * dz;
        const float vs = v[3] + v[0] * x + v[1] * y + v[2] * z, vd = v[0] * dx + v[1] * dy + v[2] * dz;
        const float ug = ua[0] * gx + ua[1] * gy + ua[2] * gz, vg = va[0] * gx + va[1] * gy + va[2] * gz;
        const float u0 = us + in * ud, u1 = us + out * ud, v0 = vs + in * vd, v1 = vs + out * vd;
        const float most_u = u0 > u1 ? u0 : u1, most_v = v0 > v1 ? v0 : v1;
        const float least_w = u0 + v0 < u1 + v1 ? u0 + v0 : u1 + v1;
        const int missed = (out < in) | (most_u + ug < 0.0f) | (most_v + vg < 0.0f) | (least_w - (ug + vg) > 1.0f);
        met[i] |= missed ? 0u : bit;
    }
}

/* Sets low and high; `count` is at most CPM_FEW. */
static void ask_few(chords *c, const cpm_bvh_leaf *few, size_t triangles, size_t count) {
    memset(c->low, 0, sizeof c->low), memset(c->high, 0, sizeof c->high);
    for (size_t j = 0; j < triangles; j++) ask_face(c, few[j].face, 1u << (j & 31), j < 32 ? c->low : c->high);
    for (size_t j = triangles; j < count; j++) /* spheres: all pass */
        for (int i = 0; i < LOT; i++) (j < 32 ? c->low : c->high)[i] |= 1u << (j & 31);
}
#endif
