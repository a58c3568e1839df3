/* shared/curve.h: a piece of a curved ray as a polynomial, and where it meets triangles and spheres.
 *
 * r(theta) = sum c_i theta^i, theta in [0, 1]. Degree 1: straight; 2: the exact parabola of a linear n^2; 5: the
 * quintic Hermite that takes position, momentum and acceleration at both ends. Hits are roots of the whole curve, not
 * of a chord, so nothing leaks between chords; a chord serves only to find candidates. */
#ifndef CPM_SHARED_CURVE_H
#define CPM_SHARED_CURVE_H
#include "../types/geometry.h"
#include "../types/ray.h"
#include "roots.h"
#include "vec.h"

typedef struct cpm_curve {
    cpm_vec c[6];
    int degree, padding;
} cpm_curve;

/* Coefficients from the ends of a piece; `degree` 1, 2 or 5. Values are scaled by h: theta = sigma/h. */
CPM_INLINE cpm_curve cpm_curve_from_piece(const cpm_piece *a, int degree) {
    cpm_curve k;
    double h = a->h, h2 = 0.5 * h * h;
    cpm_vec v0 = cpm_v(h * a->p0[0], h * a->p0[1], h * a->p0[2]);
    cpm_vec a0 = cpm_v(h2 * a->g0[0], h2 * a->g0[1], h2 * a->g0[2]); /* half the second derivative */
    k.degree = degree;
    k.padding = 0;
    k.c[0] = cpm_v(a->r0[0], a->r0[1], a->r0[2]);
    k.c[1] = v0;
    k.c[2] = a0;
    k.c[3] = k.c[4] = k.c[5] = cpm_v(0.0, 0.0, 0.0);
    if (degree == 5) {
        cpm_vec v1 = cpm_v(h * a->p1[0], h * a->p1[1], h * a->p1[2]);
        cpm_vec a1 = cpm_v(h2 * a->g1[0], h2 * a->g1[1], h2 * a->g1[2]);
        /* what is left of value, slope and half curvature at theta = 1 after the first three terms */
        cpm_vec e = cpm_sub(cpm_sub(cpm_sub(cpm_v(a->r1[0], a->r1[1], a->r1[2]), k.c[0]), v0), a0);
        cpm_vec s = cpm_sub(cpm_sub(v1, v0), cpm_scaled(2.0, a0));
        cpm_vec b = cpm_sub(a1, a0);
        k.c[3] = cpm_add(cpm_sub(cpm_scaled(10.0, e), cpm_scaled(4.0, s)), b);
        k.c[4] = cpm_sub(cpm_add(cpm_scaled(-15.0, e), cpm_scaled(7.0, s)), cpm_scaled(2.0, b));
        k.c[5] = cpm_add(cpm_sub(cpm_scaled(6.0, e), cpm_scaled(3.0, s)), b);
    }
    return k;
}

CPM_INLINE cpm_vec cpm_curve_at(const cpm_curve *k, double t) {
    cpm_vec r = k->c[k->degree];
    for (int i = k->degree - 1; i >= 0; i--) r = cpm_along(k->c[i], t, r);
    return r;
}

CPM_INLINE cpm_vec cpm_curve_tangent(const cpm_curve *k, double t) { /* dr/dtheta */
    cpm_vec v = cpm_scaled((double)k->degree, k->c[k->degree]);
    for (int i = k->degree - 1; i >= 1; i--) v = cpm_along(cpm_scaled((double)i, k->c[i]), t, v);
    return v;
}

/* How far the curve between theta and theta + w leaves its chord at the most, along each axis: w^2/8 max |r''|. */
CPM_INLINE cpm_vec cpm_curve_strays(const cpm_curve *k, double w) {
    double f = 0.125 * w * w, bend[3] = {0.0, 0.0, 0.0};
    for (int i = 2; i <= k->degree; i++) {
        double turn = f * (double)(i * (i - 1));
        bend[0] += turn * fabs(k->c[i].x), bend[1] += turn * fabs(k->c[i].y), bend[2] += turn * fabs(k->c[i].z);
    }
    return cpm_v(bend[0], bend[1], bend[2]);
}

/* Roots of (curve - point) . normal in (a, b]; with `leaving`, the root at theta = 0 is divided out, so that a ray may
 * fall back on what it left. */
CPM_INLINE int cpm_curve_plane(const cpm_curve *k, cpm_vec point, cpm_vec normal, int leaving, double a, double b,
                               double *roots) {
    double f[6];
    f[0] = cpm_vdot(cpm_sub(k->c[0], point), normal);
    for (int i = 1; i <= k->degree; i++) f[i] = cpm_vdot(k->c[i], normal);
    if (leaving && a < 0.0) a = 0.0;
    if (k->degree > 2) { /* mostly the slope outweighs the bending: one root at the most, or, leaving, none */
        double bend = 0.0, turn = 0.0, power = 1.0;
        for (int i = 2; i <= k->degree; i++) {
            power *= b;
            bend += fabs(f[i]) * power;
            turn += i * fabs(f[i]) * power;
        }
        if (leaving && fabs(f[1]) > bend) return 0;
        if (!leaving && a >= 0.0 && fabs(f[1]) > turn) {
            double fa = cpm_polynomial(f, k->degree, a), fb = cpm_polynomial(f, k->degree, b);
            if (fb != 0.0 && (fa > 0.0) == (fb > 0.0) && fa != 0.0) return 0;
            if (fa != 0.0 && fb != 0.0) {
                roots[0] = cpm_root_bracketed(f, k->degree, a, b, fa / (fa - fb), fa > 0.0 ? 1 : -1);
                return 1;
            }
        }
    }
    if (leaving) return cpm_roots(f + 1, k->degree - 1, a, b, roots);
    return cpm_roots(f, k->degree, a, b, roots);
}

/* Barycentric coordinates (of corners 1 and 2) of a point on the triangle's plane; inside up to rounding. */
CPM_INLINE int cpm_triangle_contains(const cpm_triangle *t, cpm_vec q, double *u, double *v) {
    cpm_vec w = cpm_v(q.x - t->corner[0], q.y - t->corner[1], q.z - t->corner[2]);
    cpm_vec e1 = cpm_v(t->edge1[0], t->edge1[1], t->edge1[2]), e2 = cpm_v(t->edge2[0], t->edge2[1], t->edge2[2]);
    cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
    *u = cpm_vdot(cpm_cross(w, e2), n) * t->inverse_area2;
    *v = cpm_vdot(cpm_cross(e1, w), n) * t->inverse_area2;
    return *u >= -t->tolerance && *v >= -t->tolerance && *u + *v <= 1.0 + t->tolerance;
}

/* First theta in (a, b] where the curve meets the triangle; below zero: none. */
CPM_INLINE double cpm_curve_triangle(const cpm_curve *k, const cpm_triangle *t, int leaving, double a, double b,
                                     double *u, double *v) {
    double roots[5];
    int count = cpm_curve_plane(k, cpm_v(t->corner[0], t->corner[1], t->corner[2]),
                                cpm_v(t->normal[0], t->normal[1], t->normal[2]), leaving, a, b, roots);
    for (int i = 0; i < count; i++)
        if (cpm_triangle_contains(t, cpm_curve_at(k, roots[i]), u, v)) return roots[i];
    return -2.0;
}

/* The part of a curve that a chord stands for: at no theta is it farther from the chord than `off` along an axis. */
typedef struct cpm_chord {
    cpm_vec start, end; /* of the curve at a and b */
    cpm_vec off;
    double a, b;
} cpm_chord;

/* As cpm_curve_triangle where the degree is 2: the distance from the plane over [a, b] has Bernstein coefficients fa,
 * fm, fb. All of one sign: no root. Ends on opposite sides: one root, the quadratic's with that slope. */
CPM_INLINE double cpm_parabola_triangle(const cpm_curve *k, const cpm_triangle *t, int leaving, double a, double b,
                                        double *u, double *v) {
    cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
    double f0 = cpm_vdot(cpm_v(k->c[0].x - t->corner[0], k->c[0].y - t->corner[1], k->c[0].z - t->corner[2]), n);
    double f1 = cpm_vdot(k->c[1], n), f2 = cpm_vdot(k->c[2], n), root;
    if (leaving) { /* the root at 0 divided out: f1 + f2 theta */
        double fb = f1 + b * f2;
        if ((f1 > 0.0 && fb > 0.0) || (f1 < 0.0 && fb < 0.0) || f2 == 0.0) return -2.0;
        root = -f1 / f2;
        if (!(root > (a < 0.0 ? 0.0 : a) && root <= b)) return -2.0;
        return cpm_triangle_contains(t, cpm_curve_at(k, root), u, v) ? root : -2.0;
    }
    double fa = f0 + a * (f1 + a * f2), fb = f0 + b * (f1 + b * f2), fm = fa + 0.5 * (b - a) * (f1 + 2.0 * a * f2);
    if ((fa > 0.0 && fm > 0.0 && fb > 0.0) || (fa < 0.0 && fm < 0.0 && fb < 0.0)) return -2.0;
    double d = f1 * f1 - 4.0 * f2 * f0;
    if ((fa > 0.0 && fb < 0.0) || (fa < 0.0 && fb > 0.0)) {
        double slope = fa > 0.0 ? -sqrt(cpm_max(d, 0.0)) : sqrt(cpm_max(d, 0.0)); /* f1 + 2 f2 theta at the root */
        root = (f1 < 0.0) == (slope < 0.0) ? -2.0 * f0 / (f1 + slope) : (slope - f1) / (2.0 * f2);
        root = cpm_min(cpm_max(root, a), b); /* the signs say that it is between; rounding may not */
        return cpm_triangle_contains(t, cpm_curve_at(k, root), u, v) ? root : -2.0;
    }
    double roots[2];
    int count = cpm_roots_quadratic(f0, f1, f2, a, b, roots);
    for (int i = 0; i < count; i++)
        if (cpm_triangle_contains(t, cpm_curve_at(k, roots[i]), u, v)) return roots[i];
    return -2.0;
}

/* As cpm_curve_triangle, for a triangle that the ray does not start on: most are told apart by the chord's ends. Both
 * farther from the plane than the curve is from its chord, on one side: no root. On opposite sides, with the slope
 * (end - start distance) beyond what curvature can turn (4 off): one root, bracketed. */
CPM_INLINE double cpm_chord_triangle(const cpm_curve *k, const cpm_chord *chord, const cpm_triangle *t, double b,
                                     double *u, double *v) {
    cpm_vec corner = cpm_v(t->corner[0], t->corner[1], t->corner[2]);
    cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
    double da = cpm_vdot(cpm_sub(chord->start, corner), n), db = cpm_vdot(cpm_sub(chord->end, corner), n);
    double off = fabs(n.x) * chord->off.x + fabs(n.y) * chord->off.y + fabs(n.z) * chord->off.z;
    if ((da > off && db > off) || (da < -off && db < -off)) return -2.0;
    if ((da > off && db < -off) || (da < -off && db > off)) {
        if (fabs(db - da) > 5.0 * off && k->degree > 2) {
            double f[6];
            f[0] = cpm_vdot(cpm_sub(k->c[0], corner), n);
            for (int i = 1; i <= k->degree; i++) f[i] = cpm_vdot(k->c[i], n);
            double root = cpm_root_bracketed(f, k->degree, chord->a, chord->b, da / (da - db), da > 0.0 ? 1 : -1);
            return root <= b && cpm_triangle_contains(t, cpm_curve_at(k, root), u, v) ? root : -2.0;
        }
    }
    return cpm_curve_triangle(k, t, 0, chord->a, b, u, v);
}

/* First theta in (a, b] where |r - c|^2 = R^2; below -1: none. */
CPM_INLINE double cpm_curve_sphere(const cpm_curve *k, const cpm_sphere *s, int leaving, double a, double b) {
    double f[CPM_ROOTS_MAX_DEGREE + 1], roots[CPM_ROOTS_MAX_DEGREE];
    cpm_vec c[6];
    c[0] = cpm_v(k->c[0].x - s->center[0], k->c[0].y - s->center[1], k->c[0].z - s->center[2]);
    for (int i = 1; i <= k->degree; i++) c[i] = k->c[i];
    double d = cpm_norm(c[0]);
    for (int i = 0; i <= 2 * k->degree; i++) {
        double sum = 0.0;
        for (int j = i > k->degree ? i - k->degree : 0; j <= i && j <= k->degree; j++) sum += cpm_vdot(c[j], c[i - j]);
        f[i] = sum;
    }
    f[0] = (d - s->radius) * (d + s->radius);
    int count = leaving ? cpm_roots(f + 1, 2 * k->degree - 1, a < 0.0 ? 0.0 : a, b, roots)
                        : cpm_roots(f, 2 * k->degree, a, b, roots);
    return count ? roots[0] : -2.0;
}
#endif
