/* shared/emit.h: how paths start. Lanes are paths.
 *
 * A light's paths follow Sobol's sequence, scrambled by the seed: point and spot lights walk through the cells of their
 * projection map in order, area lights through their triangles, and both cover what they walk through evenly. Lit areas
 * come out with far less noise than independent numbers would give. */
#ifndef CPM_SHARED_EMIT_H
#define CPM_SHARED_EMIT_H
#include "../types/emitter.h"
#include "../types/geometry.h"
#include "philox.h"
#include "sampling.h"
#include "sobol.h"

CPM_INLINE real emit_even(const cpm_emitter_data *e, word index, int dimension) {
    return uniform_lanes(sobol_lanes(index, dimension, e->shift[dimension]));
}

/* The walk itself: path i of N is somewhere in [i, i + 1)/N. */
CPM_INLINE real emit_walked(const cpm_emitter_data *e, word index) {
    return (word_reals(index) + uniform_lanes(splat_word(e->shift[0]))) / R(e->count);
}

/* The interval of an ascending table that holds `wanted`: the last i with table[i] <= wanted, below `count`. */
CPM_INLINE size_t emit_interval(CPM_GLOBAL const double *table, size_t count, double wanted) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (table[middle] <= wanted)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* A point or spot light's path `index` (of its own, below 2^32): unit direction, and the weight of its power. */
CPM_INLINE real emit_delta(const cpm_emitter_data *e, CPM_GLOBAL const double *cumulative,
                           CPM_GLOBAL const cpm_i32 *guide, CPM_GLOBAL const float *weight, word index,
                           real3 *direction) {
    real u = emit_even(e, index, 0), v = emit_even(e, index, 1), power = splat(1.0);
    if (e->rows) {
        double wanted[CPM_WIDTH], chosen[CPM_WIDTH], share[CPM_WIDTH];
        const size_t cells = (size_t)e->rows * (size_t)e->columns;
        store_doubles(emit_walked(e, index), wanted, 0);
        for (int i = 0; i < CPM_WIDTH; i++) {
            size_t part = (size_t)(wanted[i] * (double)cells);
            size_t cell = (size_t)guide[part < cells ? part : cells - 1];
            while (cell + 1 < cells && cumulative[cell + 1] <= wanted[i]) cell++;
            chosen[i] = (double)(cpm_i32)cell;
            share[i] = (double)weight[cell];
        }
        real cell = load_doubles(chosen, 0), row = floor_lanes((cell + R(0.5)) / R(e->columns)); /* far from rounding */
        u = (row + u) / R(e->rows);
        v = ((cell - row * R(e->columns)) + v) / R(e->columns);
        power = load_doubles(share, 0);
    }
    real3 axis = triple(splat(e->axis[0]), splat(e->axis[1]), splat(e->axis[2]));
    real cosine = R(1.0) - u * R(e->cutoff);
    *direction = direction_about(axis, larger(splat(-1.0), cosine), v);
    return power;
}

/* A point uniform over an area light, its unit normal, and the primitives that it is on: `along` chooses the triangle,
 * (u, v) the point within it. */
CPM_INLINE void emit_area_point(const cpm_emitter_data *e, CPM_GLOBAL const cpm_triangle *triangles,
                                CPM_GLOBAL const double *area, real along, real u, real v, real3 *point, real3 *normal,
                                cpm_i32 *primitive) {
    if (e->radius > 0.0) {
        *normal = sample_cone(triple(splat(0.0), splat(0.0), splat(1.0)), splat(-1.0), u, v);
        *point = add3(triple(splat(e->position[0]), splat(e->position[1]), splat(e->position[2])), splat(e->radius),
                      *normal);
        for (int i = 0; i < CPM_WIDTH; i++) primitive[i] = e->primitive;
        return;
    }
    double wanted[CPM_WIDTH], of[13][CPM_WIDTH];
    store_doubles(along, wanted, 0);
    for (int i = 0; i < CPM_WIDTH; i++) {
        const size_t which = emit_interval(area, (size_t)e->triangles, wanted[i] * area[e->triangles]);
        CPM_GLOBAL const cpm_triangle *t = &triangles[which];
        for (int k = 0; k < 3; k++) {
            of[k][i] = t->corner[k], of[3 + k][i] = t->edge1[k];
            of[6 + k][i] = t->edge2[k], of[9 + k][i] = t->normal[k];
        }
        of[12][i] = t->inverse_area2;
        primitive[i] = e->primitive + (cpm_i32)which;
    }
    real a, b;
    sample_triangle(u, v, &a, &b);
    *point = add3(add3(load3_doubles(of, 0), a, load3_doubles(of + 3, 0)), b, load3_doubles(of + 6, 0));
    *normal = scale3(root(load_doubles(of[12], 0)), load3_doubles(of + 9, 0));
}

/* A surface emits n^2 L: what a bin's power is to be multiplied by where its n^2 is `own`, that of the path `middle`. */
CPM_INLINE float emit_own(float power, double own, double middle) {
    return own > 0.0 ? (float)((double)power * (own / middle)) : 0.0f;
}

/* An area light's path: where it starts, whither, and on which primitive. */
CPM_INLINE void emit_area(const cpm_emitter_data *e, CPM_GLOBAL const cpm_triangle *triangles,
                          CPM_GLOBAL const double *area, word index, real3 *point, real3 *normal, real3 *direction,
                          cpm_i32 *primitive) {
    emit_area_point(e, triangles, area, emit_walked(e, index), emit_even(e, index, 0), emit_even(e, index, 1), point,
                    normal, primitive);
    *direction = sample_cosine(*normal, emit_even(e, index, 2), emit_even(e, index, 3));
}

/* Where paths of direction d come into the emitter's box: uniform over the three faces that d sees, each by the area of
 * its shadow; returns the area of the whole shadow, on a plane across d. */
CPM_INLINE real emit_into_box(const cpm_emitter_data *e, real3 d, real p, real v, real3 *point) {
    const real x = splat(e->high[0] - e->low[0]), y = splat(e->high[1] - e->low[1]), z = splat(e->high[2] - e->low[2]);
    const real of_x = magnitude(d.x) * y * z, of_y = magnitude(d.y) * z * x, of_z = magnitude(d.z) * x * y;
    const real both = of_x + of_y, whole = both + of_z, chosen = p * whole;
    const mask on_x = less(chosen, of_x), below_z = less(chosen, both);
    real u = pick(on_x, chosen / of_x, pick(below_z, (chosen - of_x) / of_y, (chosen - both) / of_z));
    u = smaller(u, splat(1.0));
    const real zero = splat(0.0), one = splat(1.0);
    real px = pick(on_x, pick(less(d.x, zero), one, zero), u);
    real py = pick(on_x, u, pick(below_z, pick(less(d.y, zero), one, zero), v));
    real pz = pick(below_z, v, pick(less(d.z, zero), one, zero));
    *point = triple(splat(e->low[0]) + px * x, splat(e->low[1]) + py * y, splat(e->low[2]) + pz * z);
    return whole;
}

/* A path of a sun or an environment: where it comes into the box, unit direction of travel; returns what its power is
 * per radiance and solid angle of all directions: the box's shadow times the weight of the cell of directions. */
CPM_INLINE real emit_far(const cpm_emitter_data *e, CPM_GLOBAL const double *cumulative, CPM_GLOBAL const float *weight,
                         word index, real3 *point, real3 *direction) {
    real u = emit_even(e, index, 0), v = emit_even(e, index, 1), power = splat(1.0);
    real3 axis = triple(splat(e->axis[0]), splat(e->axis[1]), splat(e->axis[2])), toward;
    if (e->rows) {
        double wanted[CPM_WIDTH], of_column[CPM_WIDTH], share[CPM_WIDTH], edge[2][CPM_WIDTH];
        const size_t columns = (size_t)e->columns, cells = (size_t)e->rows * columns;
        store_doubles(emit_walked(e, index), wanted, 0);
        for (int i = 0; i < CPM_WIDTH; i++) {
            const size_t cell = emit_interval(cumulative, cells, wanted[i]), row = cell / columns;
            of_column[i] = (double)(cpm_i32)(cell - row * columns);
            share[i] = (double)weight[cell];
            edge[0][i] = cumulative[cells + 1 + row], edge[1][i] = cumulative[cells + 2 + row];
        }
        power = load_doubles(share, 0);
        const real top = load_doubles(edge[0], 0), bottom = load_doubles(edge[1], 0);
        const real cosine = top + u * (bottom - top), turn = (load_doubles(of_column, 0) + v) / R(e->columns);
        const real sine = root((R(1.0) - cosine) * (R(1.0) + cosine));
        real3 north = triple(splat(e->position[0]), splat(e->position[1]), splat(e->position[2]));
        real3 east = triple(north.y * axis.z - north.z * axis.y, north.z * axis.x - north.x * axis.z,
                            north.x * axis.y - north.y * axis.x);
        real s, c; /* of the azimuth and half a turn: the first column begins in the south */
        sincos_turns(turn, &s, &c);
        toward = unit3(add3(add3(scale3(cosine, axis), -(sine * c), north), -(sine * s), east));
    } else {
        toward = direction_about(axis, larger(splat(-1.0), R(1.0) - u * R(e->cutoff)), v);
    }
    *direction = scale3(splat(-1.0), toward);
    return power * emit_into_box(e, *direction, emit_even(e, index, 2), emit_even(e, index, 3), point);
}
#endif
