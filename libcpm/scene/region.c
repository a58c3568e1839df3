/* scene/region.c: which bounded media contain a point. */
#include <math.h>

#include "pass.h"

/* Crossings of the half line from `point` along `direction` with the mesh, odd: inside. */
static int crossings_odd(const cpm_scene *scene, const shape *s, cpm_vec point, cpm_vec direction) {
    int odd = 0;
    for (size_t i = 0; i < s->count; i++) {
        const cpm_triangle *t = &scene->triangles[s->first + i];
        cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
        double distance =
            cpm_vdot(cpm_sub(cpm_v(t->corner[0], t->corner[1], t->corner[2]), point), n) / cpm_vdot(direction, n);
        double u, v;
        if (distance > 0.0 && isfinite(distance) &&
            cpm_triangle_contains(t, cpm_along(point, distance, direction), &u, &v))
            odd ^= 1;
    }
    return odd;
}

static int shape_contains(const cpm_scene *scene, const shape *s, cpm_vec p) {
    const double r[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; k++)
        if (r[k] < s->box.low[k] || r[k] > s->box.high[k]) return 0;
    if (s->is_sphere) {
        const cpm_sphere *ball = &scene->spheres[s->first];
        return cpm_norm(cpm_sub(p, cpm_v(ball->center[0], ball->center[1], ball->center[2]))) < ball->radius;
    }
    /* three directions in general position outvote a hit on an edge */
    int votes = crossings_odd(scene, s, p, cpm_v(0.5377, 0.8339, -0.1249)) +
                crossings_odd(scene, s, p, cpm_v(-0.8622, 0.3188, 0.3939));
    if (votes == 1) votes += crossings_odd(scene, s, p, cpm_v(0.3252, -0.7549, 0.5696));
    return votes >= 2;
}

cpm_region cpm_region_at(const cpm_pass *pass, cpm_vec point, cpm_vec direction) {
    const cpm_scene *scene = pass->scene;
    cpm_region region = {.media = {0}, .count = 1};
    if (scene->medium_count == 1) return region;
    double length = cpm_norm(direction);
    cpm_vec inside = length > 0.0 ? cpm_along(point, pass->nudge / length, direction) : point;
    for (size_t m = 1; m < scene->medium_count; m++)
        if (shape_contains(scene, &scene->shapes[scene->media[m].shape], inside))
            cpm_region_cross(&region, (int32_t)m, 1);
    return region;
}
