/* backend/native/cross.c: Snell and Fresnel where a bounded medium's n differs from its surroundings'. */
#include "cross.h"

#include <math.h>

#include "cl/shared/fresnel.h"

cpm_flight cpm_depart(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec direction) {
    cpm_flight next = *flight;
    next.position = cpm_geometry_step_back(pass->geometry, &arrival->hit, flight->position, arrival->direction);
    next.direction = direction;
    next.left = arrival->hit.primitive;
    next.exact = cpm_geometry_near_edge(pass->geometry, &arrival->hit);
    next.crossing = 0;
    return next;
}

/* The region behind, and whether it fits. */
static int region_behind(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_vec normal,
                         cpm_region *region) {
    const cpm_scene *scene = pass->scene;
    int32_t medium = scene->shapes[cpm_primitive_shape(scene, arrival->hit.primitive)].medium;
    *region = flight->region;
    return medium <= 0 || cpm_region_cross(region, medium, cpm_vdot(arrival->direction, normal) < 0.0);
}

int32_t cpm_medium_behind(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival) {
    cpm_region region;
    cpm_vec normal = cpm_geometric_normal(pass->scene, &arrival->hit);
    return region_behind(pass, flight, arrival, normal, &region) ? cpm_region_medium(&region)
                                                                 : cpm_region_medium(&flight->region);
}

int cpm_pass_boundary(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, cpm_passage *passage) {
    cpm_vec geometric = cpm_geometric_normal(pass->scene, &arrival->hit);
    cpm_region region;
    if (!region_behind(pass, flight, arrival, geometric, &region)) return 0;
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

    cpm_vec normal = cpm_shading_normal(pass->scene, &arrival->hit, geometric), refracted;
    /* a shading normal may tell the wrong side at grazing incidence: the geometric one has the last word */
    if (cpm_vdot(arrival->direction, normal) * cpm_vdot(arrival->direction, geometric) <= 0.0) normal = geometric;
    cpm_vec reflected = cpm_reflect(arrival->direction, normal);
    if (cpm_vdot(reflected, geometric) * cpm_vdot(arrival->direction, geometric) >= 0.0)
        reflected = cpm_reflect(arrival->direction, geometric);
    passage->jumps = 1;
    passage->reflectance = cpm_fresnel(arrival->direction, normal, arrival->n, n, &refracted);
    passage->total = passage->reflectance >= 1.0;
    passage->reflected = cpm_depart(pass, flight, arrival, reflected);
    if (!passage->total) {
        if (cpm_vdot(refracted, geometric) * cpm_vdot(arrival->direction, geometric) <= 0.0)
            refracted = arrival->direction;
        passage->transmitted.direction = refracted;
    }
    return 1;
}
