/* shared/exact_layers.h: exact paths through a table of height whose layers have n^2 linear in height, or n constant.
 *
 * Within a layer the path is a parabola (or straight); it ends where the height reaches the layer's lower or upper
 * face, the smallest positive root of h0 + u x + a x^2/2 = face, u = p . up, a = g . up. On a face, u says which layer
 * is entered (u = 0: the one that a pulls into; pulled back from both sides: along the face, straight). Between
 * discrete layers Snell's law keeps q, the part of p along the face: u' = +- sqrt(n'^2 - q^2), or -u where that is not
 * real (total reflection). */
#ifndef CPM_SHARED_EXACT_LAYERS_H
#define CPM_SHARED_EXACT_LAYERS_H
#include "../types/medium.h"
#include "exact_parabola.h"

/* Last layer that starts at or below the height: 0 below all. */
CPM_INLINE int cpm_layer_at(const cpm_medium_data *m, CPM_GLOBAL const double *table, double height) {
    int low = 0, high = m->size[0];
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (table[m->heights + middle - 1] <= height)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}
CPM_INLINE double cpm_layer_record(const cpm_medium_data *m, CPM_GLOBAL const double *table, int layer, int k) {
    return table[m->records + CPM_RECORD * layer + k];
}
CPM_INLINE double cpm_layer_pull(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale, int layer) {
    return m->interpolation == CPM_FIELD_STEP ? 0.0 : 0.5 * scale * cpm_layer_record(m, table, layer, 1);
}

/* The height of r, and how far rounding may have moved it. */
CPM_INLINE double cpm_height_of(const cpm_medium_data *m, const double r[3], double *rounding) {
    double height = 0.0, size = 0.0;
    for (int k = 0; k < 3; k++) {
        height += (r[k] - m->origin[k]) * m->axis[k];
        size += (fabs(r[k]) + fabs(m->origin[k])) * fabs(m->axis[k]);
    }
    *rounding = 2e-15 * size;
    return height;
}

/* Which layer the ray (r, p) moves in; at a discrete face p is refracted or reflected. *along_face: straight on. */
CPM_INLINE int cpm_layer_enter(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale, double height,
                               double rounding, double p[3], int *along_face) {
    int layer = cpm_layer_at(m, table, height + rounding), below = layer - 1; /* layer: the upper one at a face */
    *along_face = 0;
    if (layer == 0 || height - table[m->heights + layer - 1] > rounding) return layer;
    double u = cpm_dot(p, m->axis), size = cpm_sqrt(cpm_dot(p, p));
    if (m->interpolation != CPM_FIELD_STEP) {
        double above_pull = cpm_layer_pull(m, table, scale, layer), below_pull = cpm_layer_pull(m, table, scale, below);
        if (fabs(u) <= 1e-14 * size) {
            if (above_pull > 0.0) return layer;
            if (below_pull < 0.0) return below;
            *along_face = 1;
            return layer;
        }
        return u > 0.0 ? layer : below;
    }
    int into = u > 0.0 ? layer : below;
    double n = 1.0 + scale * cpm_layer_record(m, table, into, 0);
    if (u == 0.0 || fabs(size - n) <= 1e-12 * n) return into;
    double rest[3];
    for (int k = 0; k < 3; k++) rest[k] = p[k] - u * m->axis[k];
    double square = n * n - cpm_dot(rest, rest);
    if (square < 0.0) {
        for (int k = 0; k < 3; k++) p[k] = rest[k] - u * m->axis[k];
        return into == layer ? below : layer;
    }
    double v = u > 0.0 ? cpm_sqrt(square) : -cpm_sqrt(square);
    for (int k = 0; k < 3; k++) p[k] = rest[k] + v * m->axis[k];
    return into;
}

/* The parabola from (r, p) and the sigma at which it leaves its layer (at most sigma_limit); p may be turned by Snell.
 */
CPM_INLINE double cpm_layer_parabola(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                                     const double r[3], double p[3], double g[3], double sigma_limit, double *face) {
    double rounding, roots[2], height = cpm_height_of(m, r, &rounding), end = sigma_limit;
    int along, layer = cpm_layer_enter(m, table, scale, height, rounding, p, &along);
    double pull = along ? 0.0 : cpm_layer_pull(m, table, scale, layer), u = along ? 0.0 : cpm_dot(p, m->axis);
    *face = CPM_EXACT_INFINITE;
    for (int k = 0; k < 3; k++) g[k] = pull * m->axis[k];
    for (int upper = 0; upper < 2 && !along; upper++) {
        int bound = layer - 1 + upper;
        if (bound < 0 || bound >= m->size[0]) continue;
        double c = height - table[m->heights + bound];
        int count = fabs(c) <= rounding ? cpm_roots_quadratic(u, 0.5 * pull, 0.0, 0.0, end, roots)
                                        : cpm_roots_quadratic(c, u, 0.5 * pull, 0.0, end, roots);
        if (count && roots[0] <= end) {
            end = roots[0];
            *face = table[m->heights + bound];
        }
    }
    return end;
}
#endif
