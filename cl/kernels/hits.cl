/* kernels/hits.cl: the first primitive that each of many curves meets; each work-item takes `share` of them. */
#include "shared/walk.h"

/* left: the primitive that a curve starts on, -1: none. theta_end: how far it is followed. */
__kernel void cpm_hits(__global const cpm_tree_node *nodes, __global const cpm_triangle *triangles,
                       __global const cpm_sphere *spheres, __global const cpm_tree_frame *frame,
                       __global const cpm_curve *curves, __global const int *left, __global cpm_hit *hits,
                       double theta_end, long count, long share) {
    long first = (long)get_global_id(0) * share, last = min(first + share, count);
    cpm_tree tree;
    tree.nodes = nodes, tree.triangles = triangles, tree.spheres = spheres;
    tree.frame = *frame;
    for (long i = first; i < last; i++) {
        cpm_curve curve = curves[i];
        cpm_hit hit;
        cpm_first_hit(&tree, &curve, theta_end, left[i], 0.0, (const cpm_filter *)0, &hit);
        hits[i] = hit;
    }
}
