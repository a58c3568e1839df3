/* shared/coverage.h: boundary bias. A disc that overhangs the edge of a surface holds photons on a part of its area
 * only; dividing by the whole of it draws dark lines along every edge and corner. So the part that lies on surface is
 * measured: short probes across the tangent plane, a few on the rim first (most discs lie whole on their surface), then
 * a spiral of equal areas (Vogel: A better way to construct the sunflower head. 1979).
 *
 * Needs nothing of the mesh's topology: walls that merely touch serve as well as shared vertices. */
#ifndef CPM_SHARED_COVERAGE_H
#define CPM_SHARED_COVERAGE_H
#include "map_search.h"
#include "piece_end.h"
#include "sampling.h"
#include "straight.h"

#define CPM_RIM_PROBES 8
#define CPM_PROBES 64
#define CPM_LEAST_COVERAGE (1.0 / 16.0) /* below, the estimate would rest on a handful of probes */
#define CPM_PROBE_DEPTH                                                                                                \
    0.2 /* of the radius: how far a surface may bend away from the tangent plane and still count                       \
         */
#define CPM_GOLDEN_TURN 0.38196601125010515

#if CPM_WIDTH == 1 && !CPM_SINGLE
/* Is there any surface between a and b? A host that has a faster tree in float says so before. */
#ifndef CPM_BETWEEN
#define CPM_BETWEEN(w, a, b) world_between(w, a, b)
CPM_INLINE int world_between(const cpm_world *w, cpm_vec a, cpm_vec b) {
    const cpm_curve line = cpm_line(a, cpm_sub(b, a));
    return cpm_meets_any(&w->tree, &line);
}
#endif

CPM_INLINE int cpm_on_surface(const cpm_world *w, cpm_vec point, cpm_vec s, cpm_vec t, cpm_vec depth, double r,
                              double turn) {
    const cpm_vec q = cpm_along(cpm_along(point, r * cpm_cos(CPM_TWO_PI * turn), s), r * cpm_sin(CPM_TWO_PI * turn), t);
    return CPM_BETWEEN(w, cpm_add(q, depth), cpm_sub(q, depth));
}

/* The part of a disc about a surface point that lies on surface, in [1/16, 1]. */
CPM_INLINE double world_disc_coverage(const cpm_world *w, cpm_vec point, cpm_vec normal, double radius) {
    cpm_vec s, t;
    const cpm_vec depth = cpm_scaled(CPM_PROBE_DEPTH * radius, normal);
    int covered = 0;
    frame3(normal, &s, &t);
    for (int i = 0; i < CPM_RIM_PROBES; i++)
        covered += cpm_on_surface(w, point, s, t, depth, 0.98 * radius, (i + 0.5) / CPM_RIM_PROBES);
    if (covered == CPM_RIM_PROBES) return 1.0;
    covered = 0;
    for (int i = 0; i < CPM_PROBES; i++)
        covered +=
            cpm_on_surface(w, point, s, t, depth, radius * cpm_sqrt((i + 0.5) / CPM_PROBES), i * CPM_GOLDEN_TURN);
    return cpm_max((double)covered / CPM_PROBES, CPM_LEAST_COVERAGE);
}

/* How far a hit is from its triangle's edges, metres: a disc of that radius lies whole on its surface. 0 where that does
 * not follow: on spheres, and where the disc is about a shading normal. */
CPM_INLINE double world_room(const cpm_world *w, const cpm_hit *hit) {
    if (hit->primitive >= w->tree.frame.triangle_count || world_surface(w, hit->primitive)->has_normals) return 0.0;
    CPM_GLOBAL const cpm_triangle *t = &w->tree.triangles[hit->primitive];
    const cpm_vec e1 = cpm_v(t->edge1[0], t->edge1[1], t->edge1[2]);
    const cpm_vec e2 = cpm_v(t->edge2[0], t->edge2[1], t->edge2[2]), e3 = cpm_sub(e2, e1);
    const double u = hit->u, v = hit->v, third = 1.0 - u - v; /* u is 0 along edge 2, v along edge 1 */
    if (!(u > 0.0) || !(v > 0.0) || !(third > 0.0)) return 0.0;
    const double a = u * u / cpm_vdot(e2, e2), b = v * v / cpm_vdot(e1, e1), c = third * third / cpm_vdot(e3, e3);
    return t->normal_length * cpm_sqrt(cpm_min(a, cpm_min(b, c))) * (1.0 - 1e-6);
}

/* Adds one population's irradiance where a ray has arrived, on the side of the unit normal, to irradiance[bins].
 * `placed`: the point from the map's origin. *whole: the radius of a disc known to lie wholly on its surface: so do all that are
 * smaller; the widest population first, mostly. */
CPM_INLINE void world_gather(const cpm_world *w, int corrected, cpm_map_search *search, cpm_u32 nearest,
                             double max_radius, const cpm_hit *hit, cpm_vec placed, cpm_vec normal, double *whole,
                             CPM_GLOBAL double *irradiance) {
    const float at[3] = {(float)placed.x, (float)placed.y, (float)placed.z};
    const float n[3] = {(float)normal.x, (float)normal.y, (float)normal.z};
    cpm_map_found found;
    double radius2, total = 0.0, larger_by = 1.0;
    if (!cpm_map_find(search, at, n, nearest, max_radius, &found, &radius2) || !found.count) return;
    CPM_MAP_SUM(search, found.count);
    const double radius = found.enough ? cpm_sqrt(radius2) : max_radius;
    const double factor = cpm_gather_factor(search->map.is.scale, radius2);
    for (cpm_u32 b = 0; b < search->map.is.bins; b++) total += factor * search->sum[b];
    if (!(total > 0.0)) return;
    if (corrected && *whole == 0.0) *whole = world_room(w, hit);
    if (corrected && radius > *whole) {
        larger_by = 1.0 / world_disc_coverage(w, hit->position, normal, radius);
        if (larger_by == 1.0) *whole = radius;
    }
    for (cpm_u32 b = 0; b < search->map.is.bins; b++) irradiance[b] += larger_by * (factor * search->sum[b]);
}
#endif
#endif
