/* shared/clip.h: a ray cut to the box of the scene's primitives. */
#ifndef CPM_SHARED_CLIP_H
#define CPM_SHARED_CLIP_H
#include "../types/tree.h"

/* The part [enter, leave] of o + t d inside the box grown by `grow`; 0: none. */
CPM_INLINE int cpm_clip_to_box(const cpm_tree *tree, cpm_vec o, cpm_vec d, double grow, double *enter, double *leave) {
    const double *low = tree->frame.low, *high = tree->frame.high;
    double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z};
    for (int k = 0; k < 3; k++) {
        double t0 = (low[k] - grow - origin[k]) / direction[k], t1 = (high[k] + grow - origin[k]) / direction[k];
        if (direction[k] == 0.0) {
            if (origin[k] < low[k] - grow || origin[k] > high[k] + grow) return 0;
            continue;
        }
        *enter = cpm_max(*enter, cpm_min(t0, t1));
        *leave = cpm_min(*leave, cpm_max(t0, t1));
    }
    return *enter <= *leave;
}
#endif
