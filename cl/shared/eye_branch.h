/* shared/eye_branch.h: the branches of an eye ray behind specular surfaces: mirrors, and both ways on at a boundary. */
#ifndef CPM_SHARED_EYE_BRANCH_H
#define CPM_SHARED_EYE_BRANCH_H
#include "boundary.h"
#include "eye.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE
/* Where branches go; flights NULL: they are only counted. */
typedef struct cpm_branches {
    CPM_GLOBAL cpm_flight *flights;
    CPM_GLOBAL float *weights; /* bins each */
    cpm_i32 count;
} cpm_branches;

/* A branch: `weights` times `factor`, times `spectrum` unless NULL (from its first bin on). */
CPM_INLINE void eye_branch(const cpm_eye *eye, const cpm_flight *flight, CPM_GLOBAL const float *weights, double factor,
                           CPM_GLOBAL const float *spectrum, cpm_branches *to) {
    const cpm_i32 count = eye_bins(eye, flight), first = eye_first_bin(flight);
    float most = 0.0f;
    for (cpm_i32 b = 0; b < count; b++) {
        const float weight = cpm_shade_branch(weights[b], (float)factor, spectrum ? spectrum[first + b] : 1.0f);
        if (to->flights) to->weights[to->count * eye->is.bins + b] = weight;
        if (weight > most) most = weight;
    }
    if (most < CPM_EYE_LEAST) return;
    if (to->flights) to->flights[to->count] = *flight;
    to->count++;
}

CPM_INLINE void eye_branch_boundary(const cpm_world *w, const cpm_eye *eye, const cpm_flight *flight,
                                    const cpm_arrival *a, CPM_GLOBAL const float *weights, cpm_branches *to) {
    cpm_passage passage;
    if (!world_pass_boundary(w, flight, a, &passage)) return;
    if (passage.jumps) eye_branch(eye, &passage.reflected, weights, passage.reflectance, 0, to);
    if (!passage.total) eye_branch(eye, &passage.transmitted, weights, 1.0 - passage.reflectance, 0, to);
}

/* The branches behind what was met; `depth`: specular surfaces so far. At most two a bin. */
CPM_INLINE void eye_branches(const cpm_world *w, const cpm_eye *eye, const cpm_flight *flight, const cpm_arrival *a,
                             cpm_i32 seen, CPM_GLOBAL const float *weights, cpm_i32 depth, cpm_branches *to) {
    if (depth >= CPM_EYE_DEPTH) return;
    if (seen == CPM_SEEN_MIRROR) {
        const cpm_vec facing = eye_facing(w, a);
        const cpm_vec way = scatter_mirror(a->direction, world_shading_normal(w, &a->hit, facing), facing);
        const cpm_flight next = world_depart(w, flight, a, way);
        eye_branch(eye, &next, weights, 1.0,
                   &eye->reflectance[world_surface(w, a->hit.primitive)->material * eye->is.bins], to);
    }
    if (seen != CPM_SEEN_BOUNDARY) return;
    if (!world_splits(w, flight, a)) {
        eye_branch_boundary(w, eye, flight, a, weights, to);
        return;
    }
    for (cpm_i32 b = 0; b < eye->is.bins; b++) {
        cpm_flight one = *flight;
        one.bin = b;
        eye_branch_boundary(w, eye, &one, a, &weights[b], to);
    }
}
#endif
#endif
