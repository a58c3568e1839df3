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
