/* kernels/trace.cl: rays alone in a medium; each work-item traces `share` rays, eight at a time. */
#include "shared/trace.h"

__kernel void cpm_trace(__global const cpm_medium_data *medium, __global const double *table,
                        __global const cpm_step_control *control, __global const cpm_ray_goal *plane,
                        __global const cpm_ray_start *starts, __global cpm_ray_end *ends, __global double *positions,
                        long samples, long count, long share) {
    long first = (long)get_global_id(0) * share, last = min(first + share, count);
    cpm_medium_data m = *medium;
    cpm_step_control c = *control;
    cpm_step_control_set(&c); /* what follows from the method and rtol: the host need not know */
    cpm_ray_goal goal = *plane;
    cpm_trace_arrays arrays;
    arrays.starts = starts, arrays.ends = ends, arrays.positions = positions, arrays.samples = samples;
    if (first < last) cpm_trace_range(&c, &m, table, &goal, &arrays, first, last);
}

/* n and (1/2) grad n^2 at points (x, y, z, scale each): out has n, gx, gy, gz each. count is a multiple of CPM_WIDTH.
 */
__kernel void cpm_evaluate(__global const cpm_medium_data *medium, __global const double *table,
                           __global const double *points, __global double *out) {
    cpm_medium_data m = *medium;
    size_t base = get_global_id(0) * CPM_WIDTH;
    double column[4][CPM_WIDTH];
    for (int i = 0; i < CPM_WIDTH; i++)
        for (int k = 0; k < 4; k++) column[k][i] = points[4 * (base + i) + k];
    real n;
    real3 r = triple(load_doubles(column[0], 0), load_doubles(column[1], 0), load_doubles(column[2], 0));
    real3 g = cpm_field(&m, table, r, load_doubles(column[3], 0), &n);
    store_doubles(n, column[0], 0);
    store_doubles(g.x, column[1], 0);
    store_doubles(g.y, column[2], 0);
    store_doubles(g.z, column[3], 0);
    for (int i = 0; i < CPM_WIDTH; i++)
        for (int k = 0; k < 4; k++) out[4 * (base + i) + k] = column[k][i];
}
