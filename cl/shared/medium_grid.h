/* shared/medium_grid.h: samples of N = n - 1 on a grid, trilinear or by the cubic B-spline that takes them (its
 * coefficients come from the prefilter in libcpm/medium/grid.c). n = 1 + s N, g = n s grad N.
 *
 * Outside the samples' box the edge value is held: a coordinate is clamped to the box, and the gradient along it is 0
 * there (n is continuous, its gradient is not). Tables are z fastest; an axis of n samples has max(n, 2) values in a
 * linear grid, max(n + 2, 4) coefficients in a cubic one. */
#ifndef CPM_SHARED_MEDIUM_GRID_H
#define CPM_SHARED_MEDIUM_GRID_H
#include "../types/medium.h"

typedef struct {
    real t;      /* in [0, 1] within the cell */
    real inside; /* 1/spacing where the coordinate lies within the samples, else 0: the factor of d/dt */
    mask cell;
} cpm_cell;

CPM_INLINE cpm_cell cpm_cell_of(const cpm_medium_data *m, int axis, real coordinate) {
    cpm_cell c;
    real last = splat(m->size[axis] - 1), zero = splat(0.0);
    real u = (coordinate - R(m->origin[axis])) * R(m->axis[axis]);
    real clamped = pick(less(u, last), u, last);
    clamped = pick(less(zero, clamped), clamped, zero);
    real cell = smaller(floor_lanes(clamped), larger(last - R(1.0), zero));
    cell = pick(at_most(zero, cell), cell, zero);
    c.t = clamped - cell;
    c.inside = pick(equal(u, clamped) & less(zero, last), splat(m->axis[axis]), zero);
    c.cell = to_integers(cell);
    return c;
}

CPM_INLINE real3 cpm_field_grid_linear(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                       real *n) {
    cpm_cell x = cpm_cell_of(m, 0, r.x), y = cpm_cell_of(m, 1, r.y), z = cpm_cell_of(m, 2, r.z);
    const integer row = m->size[2] < 2 ? 2 : m->size[2], slab = row * (m->size[1] < 2 ? 2 : m->size[1]);
    mask at = splat_mask(m->records) + x.cell * splat_mask(slab) + y.cell * splat_mask(row) + z.cell;
    cpm_rows rows = rows_at(table, at);
    real a[8]; /* corner 4 x + 2 y + z */
    for (int k = 0; k < 8; k++) a[k] = fetch(&rows, (k >> 2) * slab + ((k >> 1) & 1) * row + (k & 1));
    real dz[4], f[4];
    for (int k = 0; k < 4; k++) dz[k] = a[2 * k + 1] - a[2 * k], f[k] = a[2 * k] + z.t * dz[k];
    real y0 = f[1] - f[0], y1 = f[3] - f[2], f0 = f[0] + y.t * y0, f1 = f[2] + y.t * y1;
    real z0 = dz[0] + y.t * (dz[1] - dz[0]), z1 = dz[2] + y.t * (dz[3] - dz[2]);
    *n = R(1.0) + scale * (f0 + x.t * (f1 - f0));
    real s = scale * *n;
    return triple(s * (f1 - f0) * x.inside, s * (y0 + x.t * (y1 - y0)) * y.inside,
                  s * (z0 + x.t * (z1 - z0)) * z.inside);
}

/* Weights of the four B-splines that reach into a cell, and their derivatives by t. */
CPM_INLINE void cpm_bspline(real t, real w[4], real d[4]) {
    real u = R(1.0) - t, tt = t * t, uu = u * u;
    w[0] = uu * u * R(1.0 / 6.0);
    w[1] = R(2.0 / 3.0) - tt * (R(1.0) - R(0.5) * t);
    w[2] = R(2.0 / 3.0) - uu * (R(1.0) - R(0.5) * u);
    w[3] = tt * t * R(1.0 / 6.0);
    d[0] = R(-0.5) * uu;
    d[1] = t * (R(1.5) * t - R(2.0));
    d[2] = u * (R(2.0) - R(1.5) * u);
    d[3] = R(0.5) * tt;
}

CPM_INLINE real3 cpm_field_grid_cubic(const cpm_medium_data *m, CPM_GLOBAL const double *table, real3 r, real scale,
                                      real *n) {
    cpm_cell x = cpm_cell_of(m, 0, r.x), y = cpm_cell_of(m, 1, r.y), z = cpm_cell_of(m, 2, r.z);
    const integer row = m->size[2] < 2 ? 4 : m->size[2] + 2;
    const integer slab = row * (m->size[1] < 2 ? 4 : m->size[1] + 2);
    mask at = splat_mask(m->records) + x.cell * splat_mask(slab) + y.cell * splat_mask(row) + z.cell;
    real wx[4], wy[4], wz[4], dx[4], dy[4], dz[4], value = splat(0.0);
    real3 slope = triple(value, value, value);
    cpm_rows rows = rows_at(table, at);
    cpm_bspline(x.t, wx, dx);
    cpm_bspline(y.t, wy, dy);
    cpm_bspline(z.t, wz, dz);
    for (int i = 0; i < 4; i++) {
        real plane = splat(0.0), plane_y = plane, plane_z = plane;
        for (int j = 0; j < 4; j++) {
            real c[4];
            fetch4(&rows, i * slab + j * row, c);
            real line = wz[0] * c[0] + wz[1] * c[1] + wz[2] * c[2] + wz[3] * c[3];
            real line_z = dz[0] * c[0] + dz[1] * c[1] + dz[2] * c[2] + dz[3] * c[3];
            plane += wy[j] * line;
            plane_y += dy[j] * line;
            plane_z += wy[j] * line_z;
        }
        value += wx[i] * plane;
        slope.x += dx[i] * plane;
        slope.y += wx[i] * plane_y;
        slope.z += wx[i] * plane_z;
    }
    *n = R(1.0) + scale * value;
    real s = scale * *n;
    return triple(s * slope.x * x.inside, s * slope.y * y.inside, s * slope.z * z.inside);
}
#endif
