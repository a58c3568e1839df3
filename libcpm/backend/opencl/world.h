/* backend/opencl/world.h: a pass's scene on the context's device: the buffers of cl/kernels/world.h. */
#ifndef CPM_OPENCL_WORLD_H
#define CPM_OPENCL_WORLD_H
#include "device.h"
#include "scene/pass.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#define CPM_WORLD_BUFFERS 15 /* the first arguments of every kernel that takes a scene */

typedef struct cpm_opencl_world {
    const cpm_pass *pass;
    cl_mem buffers[CPM_WORLD_BUFFERS];
    uint64_t bytes; /* of all of them */
} cpm_opencl_world;

/* Call with the device locked, here and below. What does not fit the device is refused by name. */
cpm_status cpm_opencl_world_open(const cpm_pass *pass, cpm_opencl_world *world);
void cpm_opencl_world_close(cpm_opencl_world *world);

/* Sets the kernel's first CPM_WORLD_BUFFERS arguments. */
cl_int cpm_opencl_world_give(const cpm_opencl_world *world, cl_kernel kernel);

/* The options that every program of a scene is built with: lanes as wide as `width` on a processor, single elsewhere;
 * `more` follows. */
void cpm_opencl_options(const cpm_opencl *opencl, int width, const char *more, char *options, size_t size);

/* Runs a kernel whose arguments are all set, on `items` work-items; on a processor one to a group: a group's items
 * share one stack there, and each may have a tree's walk on it. */
cl_int cpm_opencl_run(const cpm_opencl *opencl, cl_kernel kernel, size_t items);
#endif
#endif
