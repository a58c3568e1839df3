/* kernels/world.h: the buffers of a scene as every kernel takes them, and put together. Each work-item of a kernel that
 * follows has a segment of `share` flights, of which the first counts[item] are there. */
#ifndef CPM_KERNELS_WORLD_H
#define CPM_KERNELS_WORLD_H
#include "../types/world.h"

#define CPM_WORLD_PARAMETERS                                                                                           \
    __global const cpm_world_frame *frame, __global const cpm_tree_frame *tree_frame,                                  \
        __global const cpm_tree_node *nodes, __global const cpm_triangle *triangles,                                   \
        __global const cpm_sphere *spheres, __global const cpm_medium_data *media, __global const double *tables,      \
        __global const long *table_first, __global const cpm_place *places, __global const double *scale,              \
        __global const double *index, __global const int *triangle_shape, __global const int *sphere_shape,            \
        __global const cpm_surface *surfaces, __global const float *normals

#define CPM_WORLD(w)                                                                                                   \
    cpm_world w;                                                                                                       \
    w.tree.nodes = nodes, w.tree.triangles = triangles, w.tree.spheres = spheres;                                      \
    w.tree.frame = *tree_frame;                                                                                        \
    if (!(w.tree.frame.triangle_count + w.tree.frame.sphere_count)) w.tree.nodes = (__global const cpm_tree_node *)0;  \
    w.frame = *frame;                                                                                                  \
    w.media = media, w.tables.all = tables, w.tables.first = table_first, w.places = places;                           \
    w.scale = scale, w.index = index;                                                                                  \
    w.triangle_shape = triangle_shape, w.sphere_shape = sphere_shape, w.surfaces = surfaces, w.normals = normals;      \
    w.geometry = 0
#endif
