/* backend/backend.h: what a backend does: the two passes over rays. Everything else (scenes, inspection, emitters'
 * shares, projection maps' weights, film, files) is shared code above it.
 *
 * `native` (backend/native) runs threads over Embree. `opencl` (backend/opencl) runs the kernels of cl/ on a device.
 * One source for the physics: what either does to one item is in cl/shared. A pass's results depend on its arguments
 * alone, not on the backend's threads or batches. */
#ifndef CPM_BACKEND_H
#define CPM_BACKEND_H
#include "photon/photons.h"
#include "render/eye.h"

typedef struct cpm_backend {
    const char *name;
    /* Rays to the first surface or boundary that each meets, as those of projection maps. */
    cpm_status (*follow)(const cpm_pass *pass, const cpm_flight *flights, size_t count, cpm_arrival *arrivals);
    /* Photon pass: paths [0, photons) of the emitters, into a store for each population and the energy table
     * (CPM_ENERGY_ROWS x bins, over the scale). `batch` 0: chosen. */
    cpm_status (*photons)(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                          uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                          double *energy, cpm_stats *stats);
    /* Eye pass: every pixel of the image, gathered from the maps. */
    cpm_status (*eye)(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples, cpm_image *image);
} cpm_backend;

extern const cpm_backend cpm_backend_native, cpm_backend_opencl;

/* The one that the context has set. */
const cpm_backend *cpm_backend_of(const cpm_context *context);

/* An error that names what of the scene's light a device cannot do. */
cpm_status cpm_opencl_refuses(const cpm_pass *pass);
#endif
