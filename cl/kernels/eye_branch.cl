/* kernels/eye_branch.cl: the branches of eye rays behind specular surfaces: counted, then made. */
#include "kernels/eye.h"
#include "shared/eye_branch.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE /* what it calls is of single rays in double */
/* Where `counting`, children[i] is how many branches follow branch i; else they go to next_flights and next_weights
 * from children[i] on. depth: specular surfaces so far. */
__kernel void cpm_eye_branch(CPM_WORLD_PARAMETERS, CPM_EYE_PARAMETERS, __global const cpm_flight *flights,
                             __global const cpm_arrival *arrivals, __global const float *weights,
                             __global const uchar *seen, int depth, int counting, __global int *children,
                             __global cpm_flight *next_flights, __global float *next_weights, int count, int share) {
    CPM_WORLD(w);
    CPM_EYE(eye);
    CPM_EYE_SEGMENT(first, last);
    const int bins = eye.is.bins;
    for (int i = first; i < last; i++) {
        cpm_branches to;
        to.flights = counting ? (__global cpm_flight *)0 : next_flights + children[i];
        to.weights = counting ? (__global float *)0 : next_weights + children[i] * bins;
        to.count = 0;
        if (seen[i] >= CPM_SEEN_MIRROR) {
            cpm_flight flight = flights[i];
            cpm_arrival arrival = arrivals[i];
            eye_branches(&w, &eye, &flight, &arrival, seen[i], weights + i * bins, depth, &to);
        }
        if (counting) children[i] = to.count;
    }
}
#endif
