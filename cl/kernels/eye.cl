/* kernels/eye.cl: eye rays start, meet what they see, and are added up to the film. */
#include "kernels/eye.h"
#include "shared/eye.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE /* what it calls is of single rays in double */
/* Branch i: of pixel pixels[i / each], its sample first_sample + i % each (where the camera's medium disperses, `each`
 * counts bins too, the fastest). */
__kernel void cpm_eye_start(CPM_EYE_PARAMETERS, __global const int *pixels, int first_sample, int each,
                            __global cpm_flight *flights, __global float *weights, int count, int share) {
    CPM_EYE(eye);
    CPM_EYE_SEGMENT(first, last);
    const int bins = eye.is.bins;
    for (int i = first; i < last; i++) {
        const int ray = i % each, sample = eye.is.splits ? ray / bins : ray;
        flights[i] = eye_start(&eye, pixels[i / each], first_sample + sample, eye.is.splits ? ray % bins : -1);
        for (int b = 0; b < bins; b++) weights[i * bins + b] = 1.0f;
    }
}

/* seen: what each branch has met. evaluations: of each work-item's branches, added up. */
__kernel void cpm_eye_see(CPM_WORLD_PARAMETERS, CPM_EYE_PARAMETERS, __global const cpm_arrival *arrivals,
                          __global uchar *seen, __global double *evaluations, int count, int share) {
    CPM_WORLD(w);
    CPM_EYE(eye);
    CPM_EYE_SEGMENT(first, last);
    double sum = 0.0;
    for (int i = first; i < last; i++) {
        cpm_arrival arrival = arrivals[i];
        seen[i] = (uchar)eye_seen(&w, &eye, &arrival);
        sum += arrival.evaluations;
    }
    evaluations[get_global_id(0)] = sum;
}

/* Pixel p's branches are first_branch[p] .. first_branch[p + 1] - 1, added in that order. irradiance: that of branch i
 * at row gathered[i]. sums: count x bins. */
__kernel void cpm_eye_film(CPM_WORLD_PARAMETERS, CPM_EYE_PARAMETERS, __global const cpm_flight *flights,
                           __global const cpm_arrival *arrivals, __global const float *weights,
                           __global const uchar *seen, __global const int *gathered, __global const double *irradiance,
                           __global const int *first_branch, __global double *sums, int count, int share) {
    CPM_WORLD(w);
    CPM_EYE(eye);
    CPM_EYE_SEGMENT(first, last);
    const int bins = eye.is.bins;
    for (int p = first; p < last; p++)
        for (int i = first_branch[p]; i < first_branch[p + 1]; i++) {
            cpm_flight flight = flights[i];
            cpm_arrival arrival = arrivals[i];
            eye_add(&w, &eye, &flight, &arrival, seen[i], weights + i * bins, irradiance + gathered[i] * bins,
                    sums + p * bins);
        }
}
#endif
