/* backend/native/native.c: threads and Embree. */
#include "backend/backend.h"

static cpm_status follow(const cpm_pass *pass, const cpm_flight *flights, size_t count, cpm_arrival *arrivals) {
    cpm_follow(pass, flights, count, NULL, arrivals);
    return CPM_OK;
}

const cpm_backend cpm_backend_native = {
    .name = "native",
    .follow = follow,
    .photons = cpm_trace_paths,
    .eye = cpm_eye_pass,
};
