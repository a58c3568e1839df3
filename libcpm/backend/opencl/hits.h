/* backend/opencl/hits.h: the first primitives that curves meet, on the context's device. */
#ifndef CPM_OPENCL_HITS_H
#define CPM_OPENCL_HITS_H
#include "geometry/geometry.h"

/* As cpm_geometry_curve(geometry, curve, theta_end, left, 0, NULL, hit) of each of `count` curves. The geometry is
 * prepared for curves. */
cpm_status cpm_opencl_hits(cpm_context *context, const cpm_geometry *geometry, const cpm_curve *curves,
                           const int32_t *left, size_t count, double theta_end, cpm_hit *hits);
#endif
