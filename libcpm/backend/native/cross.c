/* backend/native/cross.c: Snell and Fresnel where a bounded medium's n differs from its surroundings'. */
#include "cross.h"

#include <math.h>

#include "cl/shared/scatter.h"

cpm_flight cpm_depart(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec direction) {
    cpm_flight next = *flight;
    next.position = cpm_geometry_step_back(pass->geometry, &arrival->hit, flight->position, arrival->direction);
    next.direction = direction;
    next.left = arrival->hit.primitive;
    next.exact = cpm_geometry_near_edge(pass->geometry, &arrival->hit);
    next.crossing = 0;
    next.within = NULL;
    return next;
}

int cpm_is_boundary(const cpm_pass *pass, int32_t primitive) {
    const shape *s = &pass->scene->shapes[cpm_primitive_shape(pass->scene, primitive)];
    return s->material == CPM_NO_MATERIAL || pass->scene->materials[s->material].kind == CPM_MATERIAL_DIELECTRIC;
}

static int enters(const cpm_pass *pass, int32_t primitive, cpm_vec position, cpm_vec direction) {
    const cpm_hit hit = {.primitive = primitive, .position = position};
    return cpm_vdot(direction, cpm_geometric_normal(pass->scene, &hit)) < 0.0;
}

/* Into or out of all media that the primitive's shape bounds; 0: too many. */
static int cross_shape(const cpm_pass *pass, cpm_region *region, int32_t primitive, cpm_vec position,
                       cpm_vec direction) {
    const cpm_scene *scene = pass->scene;
    int entering = enters(pass, primitive, position, direction), fits = 1;
    int32_t medium = scene->shapes[cpm_primitive_shape(scene, primitive)].medium;
    for (; medium > 0; medium = scene->media[medium].also) fits &= cpm_region_cross(region, medium, entering);
    return fits;
}

int cpm_boundary_counts(const cpm_pass *pass, const cpm_region *region, int32_t primitive, cpm_vec position,
                        cpm_vec direction) {
    if (!cpm_is_boundary(pass, primitive)) return 1;
    cpm_region trial = *region;
    cross_shape(pass, &trial, primitive, position, direction);
    return trial.count != region->count;
}

typedef struct crossing {
    const cpm_pass *pass;
    const cpm_region *region;
} crossing;

static int counts(void *user, int32_t primitive, cpm_vec position, cpm_vec direction) {
    const crossing *c = user;
    return cpm_boundary_counts(c->pass, c->region, primitive, position, direction);
}

/* What else is within a hair of a hit, before or behind, and counts. */
static cpm_hit coincident(const cpm_pass *pass, const cpm_hit *hit, int32_t primitive, cpm_vec direction,
                          const cpm_region *region) {
    cpm_curve line = {.degree = 1};
    crossing c = {pass, region};
    const cpm_filter filter = {counts, &c};
    cpm_hit other;
    line.c[0] = hit->position, line.c[1] = cpm_scaled(CPM_COINCIDE * pass->reach, direction);
    cpm_geometry_curve(pass->geometry, &line, 1.0, primitive, 1.0, &filter, &other);
    return other;
}

void cpm_look_behind(const cpm_pass *pass, const cpm_flight *flight, cpm_arrival *arrival) {
    cpm_region *region = &arrival->behind;
    *region = flight->region;
    if (arrival->status != CPM_RAY_HIT || !cpm_is_boundary(pass, arrival->hit.primitive)) return;
    int32_t primitive = arrival->hit.primitive;
    for (int i = 0; i < 2 * CPM_MAX_NESTED; i++) {
        if (!cross_shape(pass, region, primitive, arrival->hit.position, arrival->direction)) {
            region->count = 0;
            return;
        }
        cpm_hit other = coincident(pass, &arrival->hit, primitive, arrival->direction, region);
        if (other.primitive < 0) return;
        if (!cpm_is_boundary(pass, other.primitive)) {
            other.position = arrival->hit.position;
            other.t = arrival->hit.t;
            arrival->hit = other;
            return;
        }
        primitive = other.primitive;
    }
}

int cpm_splits(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival) {
    return flight->bin < 0 && arrival->behind.count && pass->disperses[cpm_region_medium(&arrival->behind)];
}

int cpm_pass_boundary(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival,
                      cpm_passage *passage) {
    cpm_vec geometric = cpm_geometric_normal(pass->scene, &arrival->hit);
    const cpm_region region = arrival->behind;
    if (!region.count) return 0;
    passage->jumps = passage->total = 0;
    passage->reflectance = 0.0;
    passage->transmitted = cpm_depart(pass, flight, arrival, arrival->direction);
    passage->transmitted.position = arrival->hit.position;
    passage->transmitted.region = region;
    passage->transmitted.crossing = 1;
    int32_t before = cpm_region_medium(&flight->region), behind = cpm_region_medium(&region);
    if (before == behind) return 1;
    double n = cpm_pass_index(pass, behind, flight->bin, arrival->hit.position);
    if (!(fabs(n - arrival->n) > CPM_EQUAL_INDEX)) return 1;

    cpm_vec normal = cpm_shading_normal(pass->scene, &arrival->hit, geometric), reflected, refracted;
    passage->jumps = 1;
    passage->reflectance =
        scatter_boundary(arrival->direction, normal, geometric, arrival->n, n, &reflected, &refracted);
    passage->total = passage->reflectance >= 1.0;
    passage->reflected = cpm_depart(pass, flight, arrival, reflected);
    if (!passage->total) passage->transmitted.direction = refracted;
    return 1;
}
