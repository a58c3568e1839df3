/* backend/opencl/photons_buffers.h: what the photon pass has on a device: kernels, how much of everything, buffers. */
#ifndef CPM_OPENCL_PHOTONS_BUFFERS_H
#define CPM_OPENCL_PHOTONS_BUFFERS_H
#include "cl/types/path.h"
#include "device.h"
#include "photon/photons.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#define CPM_WAVES 4 /* between two looks of the host, at most; a power of 2 */

typedef struct cpm_photon_kernels { /* NULL: the scene needs none */
    cl_kernel start_delta, start_area, meet, specular;
} cpm_photon_kernels;

typedef struct cpm_photon_sizes {
    size_t items;  /* work-items */
    cl_int fresh;  /* flights of an item up to which it starts paths */
    cl_int stride; /* places of an item: where bundles part, each may become as many as there are bins */
    cl_int stage;  /* photons that an item may store between two looks */
    cl_int halves; /* and their powers */
    cl_int bins;
} cpm_photon_sizes;

typedef struct cpm_photon_side { /* flights of all items, now or next */
    cl_mem flights, walkers, powers, counts;
} cpm_photon_side;

typedef struct cpm_emitter_buffers {
    cl_mem data, cumulative, guide, weight, area, spectrum, region;
} cpm_emitter_buffers;

typedef struct cpm_photon_buffers {
    cpm_photon_side side[2];
    int now; /* which side is followed */
    cl_mem arrivals, tallies, energies;
    cl_mem photons[2], spectra[2]; /* two stages: one is filled while the host takes the other */
    cl_mem reflectance, shares, largest, one, multiply, add;
    cpm_emitter_buffers *emitters;
    size_t emitter_count;
} cpm_photon_buffers;

/* Builds them, or takes them from the cache. */
cpm_status cpm_photon_kernels_of(const cpm_pass *pass, const cpm_emitter *emitters, size_t count,
                                 cpm_photon_kernels *kernels);
/* As many flights as the device's memory (less `taken` bytes) allows, and no more than fit its caches. */
cpm_status cpm_photon_sizes_of(const cpm_pass *pass, uint64_t photons, int32_t batch, uint64_t taken,
                               cpm_photon_sizes *sizes);
cpm_status cpm_photon_buffers_open(const cpm_pass *pass, const cpm_emitter *emitters, size_t count,
                                   const cpm_photon_sizes *sizes, const cpm_tally *tallies,
                                   cpm_photon_buffers *buffers);
void cpm_photon_buffers_close(const cpm_opencl *opencl, cpm_photon_buffers *buffers);
#endif
#endif
