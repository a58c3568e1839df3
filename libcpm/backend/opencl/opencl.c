/* backend/opencl/opencl.c: the context's device; which backend a context has. */
#include "backend/backend.h"
#include "eye.h"
#include "follow.h"
#include "photons.h"

const cpm_backend cpm_backend_opencl = {
    .name = "opencl",
    .follow = cpm_opencl_follow_all,
    .photons = cpm_opencl_photons,
    .eye = cpm_opencl_eye,
};

const cpm_backend *cpm_backend_of(const cpm_context *context) {
    return context->opencl ? &cpm_backend_opencl : &cpm_backend_native;
}

cpm_status cpm_opencl_refuses(const cpm_pass *pass) {
    const uint32_t beyond = pass->features & (CPM_FEATURE_SKY | CPM_FEATURE_EXTINCTION);
    if (!beyond) return CPM_OK;
    return cpm_fail(pass->context, CPM_ERROR_UNSUPPORTED,
                    "%s: an OpenCL device does not do this yet; use the native backend",
                    beyond & CPM_FEATURE_SKY ? "a sun or an environment" : "a medium with extinction");
}
