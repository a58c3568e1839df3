/* shared/medium_shells.h: spherical layers: a table of height above a sphere of radius R whose centre is R below `origin`.
 *
 * With d = r - origin, v = d . up, x the rest of d, rho = |r - centre| = sqrt((R + v)^2 + x^2):
 *
 *   q = rho^2 - R^2 = 2 R v + v^2 + x^2,   h = q/(R + rho)                                                         (1)
 *
 * so that millimetres of height survive beside 6.4e6 m of radius, in float too. Records are those of medium_layered.h:
 * cubics in h - h_i, but for linear-squared, whose n^2 is linear in rho^2: t = rho^2 - rho_i^2 = (h - h_i)(2 R + h + h_i),
 * g = s S' (r - centre): a linear force. */
#ifndef CPM_SHARED_MEDIUM_SHELLS_H
#define CPM_SHARED_MEDIUM_SHELLS_H
#include "medium_layered.h"

typedef struct {
    real height, q, rho; /* metres; q = rho^2 - R^2, metres^2 */
    real3 out;           /* r - centre */
} cpm_shell_place;

CPM_INLINE cpm_shell_place cpm_shell_at(const cpm_medium_data *m, real3 r) {
    cpm_shell_place s;
    const scalar radius = R(m->radius);
    real3 up = cpm_times_axis(m, splat(1.0));
    real3 d = triple(r.x - R(m->origin[0]), r.y - R(m->origin[1]), r.z - R(m->origin[2]));
    real v = dot3(d, up);
    real3 across = add3(d, -v, up);
    real x2 = dot3(across, across), along = radius + v;
    s.q = v * (R(2.0) * radius + v) + x2;
    s.rho = root(along * along + x2);
    s.height = s.q / (radius + s.rho);
    s.out = add3(across, along, up);
    return s;
}

CPM_OUTLINE real3 cpm_field_shells(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                   real *n) {
    cpm_shell_place s = cpm_shell_at(m, r);
    real c[4];
    mask layer = cpm_layer_of(m, table, s.height);
    cpm_rows rows = rows_at(table, layer * splat_mask(CPM_RECORD) + splat_mask(m->records));
    real start = fetch(&rows, 4), t = s.height - start;
    fetch4(&rows, 0, c);
    if (m->interpolation == CPM_FIELD_LINEAR_SQUARED) {
        *n = root(R(1.0) + scale * (c[0] + t * (R(2.0 * m->radius) + s.height + start) * c[1]));
        return scale3(scale * c[1], s.out);
    }
    *n = R(1.0) + scale * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
    real slope = scale * (c[1] + t * (R(2.0) * c[2] + R(3.0) * t * c[3]));
    return scale3(*n * slope / (s.rho + R(1e-30)), s.out); /* at the centre n is constant: 0/1e-30 */
}
#endif
