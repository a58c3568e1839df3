/* render/coverage.c: boundary bias. A disc that overhangs the edge of a surface holds photons on a part of its area
 * only; dividing by the whole of it draws dark lines along every edge and corner. So the part that lies on surface is
 * measured: short probes across the tangent plane, a few on the rim first (most discs lie whole on their surface), then
 * a spiral of equal areas (Vogel: A better way to construct the sunflower head. 1979).
 *
 * Needs nothing of the mesh's topology: walls that merely touch serve as well as shared vertices. */
#include <math.h>

#include "cl/shared/sampling.h"
#include "eye.h"

#define RIM_PROBES 8
#define PROBES 64
#define LEAST (1.0 / 16.0) /* below, the estimate would rest on a handful of probes */
#define DEPTH 0.2          /* of the radius: how far a surface may bend away from the tangent plane and still count */
#define GOLDEN_TURN 0.38196601125010515

static int on_surface(const cpm_geometry *geometry, cpm_vec point, cpm_vec s, cpm_vec t, cpm_vec depth, double r,
                      double turn) {
    cpm_vec q = cpm_along(cpm_along(point, r * cpm_cos(CPM_TWO_PI * turn), s), r * cpm_sin(CPM_TWO_PI * turn), t);
    return cpm_geometry_between(geometry, cpm_add(q, depth), cpm_sub(q, depth));
}

double cpm_disc_coverage(const cpm_geometry *geometry, cpm_vec point, cpm_vec normal, double radius) {
    cpm_vec s, t, depth = cpm_scaled(DEPTH * radius, normal);
    int covered = 0;
    frame3(normal, &s, &t);
    for (int i = 0; i < RIM_PROBES; i++)
        covered += on_surface(geometry, point, s, t, depth, 0.98 * radius, (i + 0.5) / RIM_PROBES);
    if (covered == RIM_PROBES) return 1.0;
    covered = 0;
    for (int i = 0; i < PROBES; i++)
        covered += on_surface(geometry, point, s, t, depth, radius * sqrt((i + 0.5) / PROBES), i * GOLDEN_TURN);
    return cpm_max((double)covered / PROBES, LEAST);
}
