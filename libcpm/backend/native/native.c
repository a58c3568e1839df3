/* backend/native/native.c: threads and Embree. */
#include "backend/backend.h"

const cpm_backend cpm_backend_native = {
    .name = "native",
    .photons = cpm_trace_paths,
    .eye = cpm_eye_pass,
};
