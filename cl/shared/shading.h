/* shared/shading.h: the normal that a surface is shaded with. */
#ifndef CPM_SHARED_SHADING_H
#define CPM_SHARED_SHADING_H
#include "region.h"
#include "shade.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE
/* Interpolated shading normal where the mesh has them, else the geometric one; on the geometric normal's side. */
CPM_INLINE cpm_vec world_shading_normal(const cpm_world *w, const cpm_hit *hit, cpm_vec geometric) {
    if (hit->primitive >= w->tree.frame.triangle_count || !world_surface(w, hit->primitive)->has_normals)
        return geometric;
    CPM_GLOBAL const float *n = &w->normals[9 * (size_t)hit->primitive];
    cpm_vec corner[3];
    for (int k = 0; k < 3; k++) corner[k] = cpm_v((double)n[3 * k], (double)n[3 * k + 1], (double)n[3 * k + 2]);
    return shade_normal(corner[0], corner[1], corner[2], hit->u, hit->v, geometric);
}
#endif
#endif
