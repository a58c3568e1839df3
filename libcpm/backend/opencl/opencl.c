/* backend/opencl/opencl.c: the context's device; which backend a context has. */
#include "backend/backend.h"
#include "photons.h"

static cpm_status no_eye(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                         cpm_image *image) {
    (void)gather, (void)seed, (void)samples, (void)image;
    return cpm_fail(pass->context, CPM_ERROR_UNSUPPORTED,
                    "an OpenCL device traces photons here, and rays alone in a medium; pictures need the native backend");
}

const cpm_backend cpm_backend_opencl = {
    .name = "opencl",
    .photons = cpm_opencl_photons,
    .eye = no_eye,
};

const cpm_backend *cpm_backend_of(const cpm_context *context) {
    return context->opencl ? &cpm_backend_opencl : &cpm_backend_native;
}
