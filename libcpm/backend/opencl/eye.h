/* backend/opencl/eye.h: the eye pass on the context's device: a wavefront of branches. */
#ifndef CPM_OPENCL_EYE_H
#define CPM_OPENCL_EYE_H
#include "render/eye.h"

/* As cpm_eye_pass (render/eye.h). The picture depends on the scene, the maps and the seed; not on memory, batches or
 * the number of work-items. */
cpm_status cpm_opencl_eye(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                          cpm_image *image);
#endif
