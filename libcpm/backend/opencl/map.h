/* backend/opencl/map.h: a photon map on the context's device: uploaded once, searched by kernels/gather.cl and
 * kernels/eye_gather.cl. The map is the host's, whole, as photon/tree.h has it: so both find the same photons. */
#ifndef CPM_OPENCL_MAP_H
#define CPM_OPENCL_MAP_H
#include "device.h"
#include "photon/photons.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#define CPM_MAP_BUFFERS 5 /* nodes, points, photons, spectra, numbers: in that order among a kernel's arguments */

typedef struct cpm_opencl_map {
    cl_mem buffers[CPM_MAP_BUFFERS];
} cpm_opencl_map;

/* Bytes of the device that a map takes: nearly none where the device is the processor and can read ours. */
uint64_t cpm_opencl_map_bytes(const cpm_opencl *opencl, const cpm_map_tree *tree);
/* Would it fit: each of its arrays one buffer, all of them in what is allowed? Where not, the host searches it. */
int cpm_opencl_map_fits(const cpm_opencl *opencl, const cpm_map_tree *tree, uint64_t allowed);
/* The tree must outlive it. */
cl_int cpm_opencl_map_open(const cpm_opencl *opencl, const cpm_map_tree *tree, cpm_opencl_map *map);
void cpm_opencl_map_close(const cpm_opencl *opencl, cpm_opencl_map *map);

#define CPM_SCRATCH_BUFFERS 5 /* distance, id, order, stack, sum: in that order among a kernel's arguments */

/* Where work-items list the photons of one search. */
typedef struct cpm_opencl_scratch {
    cl_mem buffers[CPM_SCRATCH_BUFFERS];
    cl_ulong capacity; /* entries of each item */
    size_t items;
} cpm_opencl_scratch;

/* For the k nearest in any of the trees, for as many of `items` as `allowed` bytes hold; fails where those hold not
 * one. */
cpm_status cpm_opencl_scratch_open(cpm_context *context, const cpm_map_tree *const trees[CPM_POPULATIONS], int32_t k,
                                   size_t items, uint64_t allowed, cpm_opencl_scratch *scratch);
void cpm_opencl_scratch_close(const cpm_opencl *opencl, cpm_opencl_scratch *scratch);

/* Sets the next of a kernel's arguments, and goes on to the next, unless one before has failed. */
typedef struct cpm_opencl_arguments {
    const cpm_opencl *opencl;
    cl_kernel kernel;
    cl_uint next;
    cl_int code;
} cpm_opencl_arguments;
void cpm_opencl_give(cpm_opencl_arguments *arguments, size_t size, const void *value);
void cpm_opencl_give_buffers(cpm_opencl_arguments *arguments, const cl_mem *buffers, int count);

/* Trees first..last of the photons' irradiance at points, as photon/irradiance.c has them: local points and unit
 * normals in float, count x 3; irradiance: count x bins, zeros. */
cpm_status cpm_opencl_irradiance(cpm_context *context, const cpm_photons *photons, int first, int last,
                                 const float *points, const float *normals, size_t count, int32_t nearest,
                                 double max_radius, double *irradiance);
#endif
#endif
