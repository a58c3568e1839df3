/* geometry/geometry.h: primitives, and the first one that a ray meets.
 *
 * Two ways to ask, each built when first needed:
 *  - straight: Embree's own triangles (float, ROBUST), the hit polished in double;
 *  - curve: a tree of our own (cl/shared/walk.h) whose boxes and triangles grow by what a curve strays from its chord;
 * what may be met is then tested on the curve itself, in double. */
#ifndef CPM_GEOMETRY_H
#define CPM_GEOMETRY_H
#include "api/context.h"
#include "cl/shared/curve.h"
#include "cl/types/world.h" /* cpm_hit, cpm_filter */

typedef struct cpm_geometry cpm_geometry;

/* Borrows the arrays. Primitives are numbered triangles first, then spheres. */
cpm_status cpm_geometry_create(cpm_context *context, const cpm_triangle *triangles, size_t triangle_count,
                               const cpm_sphere *spheres, size_t sphere_count, cpm_geometry **geometry);
void cpm_geometry_free(cpm_geometry *geometry);

/* Builds what a pass will ask for; not thread-safe, unlike the queries below. */
cpm_status cpm_geometry_prepare(cpm_context *context, cpm_geometry *geometry, int straight, int curved);

/* Fills what follows from corner and edges; returns 0 where the area is 0. `scale`: largest coordinate of the scene. */
int cpm_triangle_complete(cpm_triangle *triangle, double scale);

/* The box of all primitives; empty (low > high) without any. */
cpm_box cpm_geometry_box(const cpm_geometry *geometry);
/* Its largest coordinate from the middle, metres. */
double cpm_geometry_scale(const cpm_geometry *geometry);

/* Every query takes a cpm_filter (cl/types/world.h): may a primitive be met at or about its start? NULL: yes. Asked
 * only of what lies within `slack` of the start. */

/* First hit of origin + t direction, t > 0; direction is unit. `left`: the primitive that the ray starts on, -1: none
 * (only its root at t = 0 is excluded). `slack` metres behind the start count too (coincident surfaces); `exact`: skip
 * float, ask the curve scene (the start is so near an edge that float cannot tell sides). */
void cpm_geometry_straight(const cpm_geometry *geometry, cpm_vec origin, cpm_vec direction, int32_t left, double slack,
                           const cpm_filter *filter, int exact, cpm_hit *hit);

/* The same for many rays, four to a call of Embree: no answer depends on what is asked beside it. */
typedef struct cpm_straight_ray {
    const cpm_vec *origin, *direction;
    int32_t left, exact;
    double slack;
    const cpm_filter *filter;
    cpm_hit *hit;
} cpm_straight_ray;
void cpm_geometry_straight_many(const cpm_geometry *geometry, const cpm_straight_ray *rays, size_t count);

/* First hit of the curve for theta in (0, theta_end]; `left` and `slack` (in theta) as above. */
void cpm_geometry_curve(const cpm_geometry *geometry, const cpm_curve *curve, double theta_end, int32_t left,
                        double slack, const cpm_filter *filter, cpm_hit *hit);

/* The same for theta in (0, 1] of many curves at once, without slack; `from`: theta before which, the caller knows, a
 * curve is outside of the geometry's box. */
void cpm_geometry_curves(const cpm_geometry *geometry, const cpm_curve *curves, const double *from, const int32_t *left,
                         size_t count, cpm_hit *hits);

/* Where a ray that is thrown back starts: scatter_step_back (cl/shared/scatter.h) in this scene. */
cpm_vec cpm_geometry_step_back(const cpm_geometry *geometry, const cpm_hit *hit, cpm_vec start, cpm_vec came);

/* Is the hit so near an edge of its triangle that the next straight ray has to be asked exactly? */
int cpm_geometry_near_edge(const cpm_geometry *geometry, const cpm_hit *hit);

/* Is there any surface between a and b? In float where that will do: for coverage, not for
 * light. */
int cpm_geometry_between(const cpm_geometry *geometry, cpm_vec a, cpm_vec b);

/* Version of the Embree that runs, "3.13.5". */
const char *cpm_geometry_embree_version(void);
#endif
