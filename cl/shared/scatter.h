/* shared/scatter.h: what happens to a path at a surface: Russian roulette, and the direction of the survivor. Lanes are
 * paths, each with random numbers of its own (shared/philox.h): 0 and 1 for a diffuse direction, 2 for the roulette, 3
 * for reflection or transmission at a boundary.
 *
 * Store before roulette. A surface reflects power P_b rho_b; the path survives with the largest rho of its bundle, its
 * powers then P_b rho_b/rho_max. Gain and loss are what roulette adds and takes: zero in the mean. */
#ifndef CPM_SHARED_SCATTER_H
#define CPM_SHARED_SCATTER_H
#include "bins.h"
#include "fresnel.h"
#include "philox.h"
#include "sampling.h"

/* A path's block of random numbers: surfaces met, and boundaries passed unbroken since. */
CPM_INLINE cpm_u32 cpm_scatter_block(cpm_u32 bounce, cpm_u32 crossings) { return bounce << 16 | crossings; }
/* The last counter: 0 for the bundle, then each run of bins its own (bins.h). */
CPM_INLINE cpm_u32 cpm_scatter_bin(cpm_i32 bin) { return bin == -1 ? 0u : cpm_bins_stored(bin) + 1u; }

/* The normal on the side that a ray comes from. */
CPM_INLINE real3 scatter_facing(real3 normal, real3 came) {
    return pick3(less(splat(0.0), dot3(normal, came)), scale3(splat(-1.0), normal), normal);
}

CPM_INLINE real3 scatter_diffuse(real3 facing, const word random[4]) {
    return sample_cosine(facing, uniform_lanes(random[0]), uniform_lanes(random[1]));
}

/* About the shading normal; about the geometric one where that would lead through the surface. */
CPM_INLINE real3 scatter_mirror(real3 came, real3 shading, real3 facing) {
    real3 direction = reflect3(came, shading);
    return pick3(at_most(dot3(direction, facing), splat(0.0)), reflect3(came, facing), direction);
}

/* Both ways on at a jump of n from n1 to n2: returns the reflectance (1: total, and `refracted` is of no use).
 * `geometric` is unit, of either side. */
CPM_INLINE real scatter_boundary(real3 came, real3 shading, real3 geometric, real n1, real n2, real3 *reflected,
                                 real3 *refracted) {
    real side = dot3(came, geometric);
    /* a shading normal may tell the wrong side at grazing incidence: the geometric one has the last word */
    real3 normal = pick3(at_most(dot3(came, shading) * side, splat(0.0)), geometric, shading);
    real3 mirrored = reflect3(came, normal);
    *reflected = pick3(at_most(splat(0.0), dot3(mirrored, geometric) * side), reflect3(came, geometric), mirrored);
    *refracted = came;
    real reflectance = fresnel_lanes(came, normal, n1, n2, refracted);
    *refracted = pick3(at_most(dot3(*refracted, geometric) * side, splat(0.0)), came, *refracted);
    return reflectance;
}

/* Where a ray that is thrown back starts: the hit, a hair back along the way that it came (1e-12 of the scene, above
 * rounding, below everything else). At an edge or in a corner the hit itself lies on several walls, and which side of
 * the others it is on is rounding's choice; the way that it came is inside of all of them. Never more than half the way
 * back to `start`. `scale`: largest coordinate of the scene. */
#define CPM_STEP_BACK 1e-12
CPM_INLINE real3 scatter_step_back(real3 hit, real3 start, real3 came, double scale) {
    real size = R(scale) + magnitude(hit.x) + magnitude(hit.y) + magnitude(hit.z);
    real3 way = sub3(hit, start);
    real back = R(CPM_STEP_BACK) * size, squared = dot3(way, way);
    if (any_lane(less(squared, R(16.0) * back * back))) { /* seldom: spares the rest a root */
        real half_way = R(0.5) * root(squared);
        back = pick(less(back, half_way), back, half_way);
    }
    return add3(hit, -back, came);
}

/* Roulette over one bin: returns its power after it; `kept` is what the surface reflects, `change` what roulette adds
 * (or, where the path ends, takes: negative). `share` is rho_b/rho_max. */
CPM_INLINE float cpm_roulette(float power, float reflectance, float share, int alive, double *kept, double *change) {
    float after = alive ? power * share : 0.0f;
    *kept = (double)power * (double)reflectance;
    *change = (double)after - *kept;
    return after;
}
#endif
