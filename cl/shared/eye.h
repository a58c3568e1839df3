/* shared/eye.h: eye rays: how they start, and what their branches see. One branch carries a weight for each of its
 * bins: all, or after a split the one at weights[0].
 *
 * All branches of a picture's pixels go on together, level after level; a pixel's sum is added up in the order of its
 * branches, so that it depends on nothing else (docs/decisions/0010-one-eye-ray.md). */
#ifndef CPM_SHARED_EYE_H
#define CPM_SHARED_EYE_H
#include "../types/eye.h"
#include "bins.h"
#include "shading.h"

CPM_INLINE cpm_i32 eye_bins(const cpm_eye *eye, const cpm_flight *flight) {
    return cpm_bins_count(flight->bin, eye->is.bins);
}
CPM_INLINE cpm_i32 eye_first_bin(const cpm_flight *flight) { return cpm_bins_first(flight->bin); }

/* n where a branch has arrived, for one of its bins. Where bins go one way together though their medium disperses, which
 * the host knows, each has its own. */
#ifndef CPM_EYE_INDEX
#define CPM_EYE_INDEX(w, flight, arrival, bin) ((arrival)->n)
#endif

#if CPM_WIDTH == 1 && !CPM_SINGLE
/* Ray `sample` of a pixel; `bin`: -1, or one of a camera whose medium disperses. */
CPM_INLINE cpm_flight eye_start(const cpm_eye *eye, cpm_i32 pixel, cpm_i32 sample, cpm_i32 bin) {
    const cpm_eye_frame *is = &eye->is;
    cpm_flight flight;
    double x, y;
    CPM_CLEAR(flight);
    cpm_eye_place(is->seed, (cpm_u32)pixel, sample, is->samples, &x, &y);
    flight.position = cpm_v(is->origin[0], is->origin[1], is->origin[2]);
    flight.direction = eye_direction(
        cpm_v(is->forward[0], is->forward[1], is->forward[2]), cpm_v(is->right[0], is->right[1], is->right[2]),
        cpm_v(is->up[0], is->up[1], is->up[2]), pixel % is->width + x, pixel / is->width + y, is->width, is->height);
    flight.region = is->region;
    flight.left = -1;
    flight.bin = bin;
    return flight;
}

CPM_INLINE cpm_i32 eye_seen(const cpm_world *w, const cpm_eye *eye, const cpm_arrival *a) {
    if (a->status != CPM_ARRIVAL_HIT) return CPM_SEEN_NOTHING;
    CPM_GLOBAL const cpm_surface *s = world_surface(w, a->hit.primitive);
    if (s->kind >= CPM_SURFACE_DIELECTRIC) return CPM_SEEN_BOUNDARY;
    if (s->kind == CPM_SURFACE_MIRROR) return CPM_SEEN_MIRROR;
    return eye->reflectance_max[s->material] > 0.0f ? CPM_SEEN_DIFFUSE : CPM_SEEN_DARK;
}

/* The light of a surface seen from its front, -1: none. */
CPM_INLINE cpm_i32 eye_light(const cpm_world *w, const cpm_eye *eye, const cpm_arrival *a) {
    const cpm_i32 light = eye->shape_light[world_surface(w, a->hit.primitive) - w->surfaces];
    if (light < 0) return light;
    return cpm_vdot(world_normal(w, a->hit.primitive, a->hit.position), a->direction) < 0.0 ? light : -1;
}

/* The geometric normal on the side that a branch comes from. */
CPM_INLINE cpm_vec eye_facing(const cpm_world *w, const cpm_arrival *a) {
    const cpm_vec geometric = world_normal(w, a->hit.primitive, a->hit.position);
    return cpm_vdot(geometric, a->direction) < 0.0 ? geometric : cpm_scaled(-1.0, geometric);
}

/* What a branch adds to its pixel's bins; irradiance: where it is CPM_SEEN_DIFFUSE. */
CPM_INLINE void eye_add(const cpm_world *w, const cpm_eye *eye, const cpm_flight *flight, const cpm_arrival *a,
                        cpm_i32 seen, CPM_GLOBAL const float *weights, CPM_GLOBAL const double *irradiance,
                        CPM_GLOBAL double *sum) {
    const cpm_i32 count = eye_bins(eye, flight), first = eye_first_bin(flight);
    if (seen == CPM_SEEN_NOTHING || seen == CPM_SEEN_BOUNDARY) return;
    const cpm_i32 light = eye_light(w, eye, a);
    if (light >= 0)
        for (cpm_i32 b = 0; b < count; b++)
            sum[first + b] += cpm_shade_light(weights[b], eye->emission[light * eye->is.bins + first + b],
                                              eye->squared_index[first + b]);
    if (seen != CPM_SEEN_DIFFUSE) return;
    CPM_GLOBAL const float *reflectance =
        &eye->reflectance[world_surface(w, a->hit.primitive)->material * eye->is.bins];
    for (cpm_i32 b = 0; b < count; b++)
        sum[first + b] += cpm_shade_diffuse(weights[b], reflectance[first + b], irradiance[first + b],
                                            eye->squared_index[first + b],
                                            CPM_EYE_INDEX(w, flight, a, first + b));
}

#endif
#endif
