/* backend/opencl/photons.h: the photon pass on the context's device. */
#ifndef CPM_OPENCL_PHOTONS_H
#define CPM_OPENCL_PHOTONS_H
#include "photon/photons.h"

/* As cpm_trace_paths (photon/photons.h); the same photons, stored in another order. `batch`: flights on the device at a
 * time, 0: as many as its memory and caches like. */
cpm_status cpm_opencl_photons(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                              uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                              double *energy, cpm_stats *stats);
#endif
