/* backend/opencl/trace.h: rays alone in a medium, on the context's device. */
#ifndef CPM_OPENCL_TRACE_H
#define CPM_OPENCL_TRACE_H
#include "api/context.h"
#include "cl/shared/trace.h"
#include "medium/medium.h"

/* As cpm_range_trace of the native lanes: `starts` and `ends` of `count` rays; positions: samples x 3 a ray, or NULL.
 * The goal and control are those of the call; progress goes from `from` to `to`. */
cpm_status cpm_opencl_trace(cpm_context *context, const cpm_medium *medium, const cpm_step_control *control,
                            const cpm_ray_goal *goal, int single_precision, const cpm_ray_start *starts,
                            cpm_ray_end *ends, double *positions, int64_t samples, int64_t count, double from,
                            double to);
#endif
