/* kernels/emit.cl: how paths start; each work-item starts CPM_WIDTH of them, numbered first, first + 1, ... */
#include "shared/emit.h"

word emit_indices(ulong first, uint *index);
word emit_indices(ulong first, uint *index) {
    for (int i = 0; i < CPM_WIDTH; i++) index[i] = (uint)(first + get_global_id(0) * CPM_WIDTH + i);
    return load_words(index, 0);
}

void emit_write3(real3 v, __global double *to, ulong count);
void emit_write3(real3 v, __global double *to, ulong count) {
    double column[3][CPM_WIDTH];
    store_doubles(v.x, column[0], 0), store_doubles(v.y, column[1], 0), store_doubles(v.z, column[2], 0);
    for (size_t i = 0, at = get_global_id(0) * CPM_WIDTH; i < CPM_WIDTH && at < count; i++, at++)
        for (int k = 0; k < 3; k++) to[3 * at + k] = column[k][i];
}

/* Point and spot lights: directions (count x 3) and weights (count). */
__kernel void cpm_emit_delta(__global const cpm_emitter_data *emitter, __global const double *cumulative,
                             __global const int *guide, __global const float *weight, ulong first, ulong count,
                             __global double *directions, __global double *weights) {
    cpm_emitter_data e = *emitter;
    uint index[CPM_WIDTH];
    double power[CPM_WIDTH];
    real3 direction;
    store_doubles(emit_delta(&e, cumulative, guide, weight, emit_indices(first, index), &direction), power, 0);
    emit_write3(direction, directions, count);
    for (size_t i = 0, at = get_global_id(0) * CPM_WIDTH; i < CPM_WIDTH && at < count; i++, at++)
        weights[at] = power[i];
}

/* Area lights: points, normals and directions (count x 3 each) and primitives (count). */
__kernel void cpm_emit_area(__global const cpm_emitter_data *emitter, __global const cpm_triangle *triangles,
                            __global const double *area, ulong first, ulong count, __global double *points,
                            __global double *normals, __global double *directions, __global int *primitives) {
    cpm_emitter_data e = *emitter;
    uint index[CPM_WIDTH];
    int primitive[CPM_WIDTH];
    real3 point, normal, direction;
    emit_area(&e, triangles, area, emit_indices(first, index), &point, &normal, &direction, primitive);
    emit_write3(point, points, count);
    emit_write3(normal, normals, count);
    emit_write3(direction, directions, count);
    for (size_t i = 0, at = get_global_id(0) * CPM_WIDTH; i < CPM_WIDTH && at < count; i++, at++)
        primitives[at] = primitive[i];
}

/* Suns and environments: points and directions (count x 3 each) and weights (count). */
__kernel void cpm_emit_far(__global const cpm_emitter_data *emitter, __global const double *cumulative,
                           __global const float *weight, ulong first, ulong count, __global double *points,
                           __global double *directions, __global double *weights) {
    cpm_emitter_data e = *emitter;
    uint index[CPM_WIDTH];
    double power[CPM_WIDTH];
    real3 point, direction;
    store_doubles(emit_far(&e, cumulative, weight, emit_indices(first, index), &point, &direction), power, 0);
    emit_write3(point, points, count);
    emit_write3(direction, directions, count);
    for (size_t i = 0, at = get_global_id(0) * CPM_WIDTH; i < CPM_WIDTH && at < count; i++, at++)
        weights[at] = power[i];
}
