/* shared/region.h: what contains a ray, and what a primitive's boundary does to that. */
#ifndef CPM_SHARED_REGION_H
#define CPM_SHARED_REGION_H
#include "../types/world.h"

CPM_INLINE cpm_i32 cpm_region_medium(const cpm_region *region) { return region->media[region->count - 1]; }

/* Adds or removes a medium (idempotent); 0: more than CPM_MAX_NESTED overlap. */
CPM_INLINE int cpm_region_cross(cpm_region *region, cpm_i32 medium, int entering) {
    const unsigned short m = (unsigned short)medium;
    int at = 0;
    while (at < region->count && region->media[at] < m) at++;
    int present = at < region->count && region->media[at] == m;
    if (entering == present) return 1;
    if (entering) {
        if (region->count == CPM_MAX_NESTED) return 0;
        for (int i = region->count; i > at; i--) region->media[i] = region->media[i - 1];
        region->media[at] = m;
        region->count++;
    } else {
        for (int i = at; i + 1 < region->count; i++) region->media[i] = region->media[i + 1];
        region->count--;
    }
    return 1;
}

CPM_INLINE CPM_GLOBAL const cpm_surface *world_surface(const cpm_world *w, cpm_i32 primitive) {
    const cpm_i32 triangles = w->tree.frame.triangle_count;
    return &w->surfaces[primitive < triangles ? w->triangle_shape[primitive] : w->sphere_shape[primitive - triangles]];
}

/* The geometric normal of what was hit, of any length, and 1/length^2. */
typedef struct cpm_facet {
    cpm_vec normal;
    double factor;
} cpm_facet;
CPM_INLINE cpm_facet world_facet(const cpm_world *w, cpm_i32 primitive, cpm_vec position) {
    const cpm_i32 triangles = w->tree.frame.triangle_count;
    cpm_facet facet;
    if (primitive < triangles) {
        CPM_GLOBAL const cpm_triangle *t = &w->tree.triangles[primitive];
        facet.normal = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
        facet.factor = t->inverse_area2;
    } else {
        CPM_GLOBAL const double *c = w->tree.spheres[primitive - triangles].center;
        facet.normal = cpm_unit(cpm_sub(position, cpm_v(c[0], c[1], c[2])));
        facet.factor = 1.0;
    }
    return facet;
}
/* Unit, (b - a) x (c - a) for triangles, outward for spheres. */
CPM_INLINE cpm_vec world_normal(const cpm_world *w, cpm_i32 primitive, cpm_vec position) {
    const cpm_facet facet = world_facet(w, primitive, position);
    return cpm_scaled(sqrt(facet.factor), facet.normal);
}

/* Is the hit so near an edge of its triangle that the next straight ray has to be asked exactly? */
CPM_INLINE int cpm_is_near_edge(const cpm_tree *tree, const cpm_hit *hit) {
    if (hit->primitive >= tree->frame.triangle_count) return 1;
    double least = cpm_min(hit->u, cpm_min(hit->v, 1.0 - hit->u - hit->v));
    return !(least > tree->triangles[hit->primitive].near_edge);
}

/* Only bounds a medium, or is a dielectric. */
CPM_INLINE int world_is_boundary(const cpm_world *w, cpm_i32 primitive) {
    return world_surface(w, primitive)->kind >= CPM_SURFACE_DIELECTRIC;
}

/* Into or out of all media that the primitive's shape bounds; 0: too many. */
CPM_INLINE int world_cross(const cpm_world *w, cpm_region *region, cpm_i32 primitive, cpm_vec position,
                           cpm_vec direction) {
    int entering = cpm_vdot(direction, world_normal(w, primitive, position)) < 0.0, fits = 1;
    for (cpm_i32 m = world_surface(w, primitive)->medium; m > 0; m = w->places[m].also)
        fits &= cpm_region_cross(region, m, entering);
    return fits;
}

/* Would passing this primitive in this direction change the region? Surfaces always count. */
CPM_INLINE int world_boundary_counts(const cpm_world *w, const cpm_region *region, cpm_i32 primitive, cpm_vec position,
                                     cpm_vec direction) {
    if (!world_is_boundary(w, primitive)) return 1;
    cpm_region trial = *region;
    world_cross(w, &trial, primitive, position, direction);
    return trial.count != region->count;
}

/* For shared/walk.h: a boundary met at the very start counts only if passing it changes what contains the ray: not the
 * other half of the face just crossed, nor a face that two media share. */
#define CPM_HIT_COUNTS(q, primitive, t)                                                                                \
    world_boundary_counts((q)->filter->world, (q)->filter->region, primitive, cpm_curve_at((q)->curve, t),             \
                          cpm_curve_tangent((q)->curve, t))
#endif
