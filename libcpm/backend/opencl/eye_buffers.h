/* backend/opencl/eye_buffers.h: what the eye pass has on a device: kernels, how many branches, buffers. */
#ifndef CPM_OPENCL_EYE_BUFFERS_H
#define CPM_OPENCL_EYE_BUFFERS_H
#include "follow.h"
#include "map.h"
#include "render/eye.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#define CPM_EYE_TABLES 6 /* the arguments of CPM_EYE_PARAMETERS (cl/kernels/eye.h) */

typedef struct cpm_eye_kernels {
    cl_kernel start, see, film, gather;
    cl_kernel branch; /* NULL: nothing is specular */
} cpm_eye_kernels;

typedef struct cpm_eye_device { /* buffers for `capacity` branches, of as many pixels at most */
    cl_int capacity, bins;
    size_t items;
    cl_mem tables[CPM_EYE_TABLES];
    cl_mem flights[2], weights[2]; /* those that live now, and those that follow */
    cl_mem arrivals, seen, evaluations, counts, children;
    cl_mem pixels, first_branch, sums;        /* a pixel of the batch each */
    cl_mem list, gathered, irradiance, whole; /* a gather each; gathered: a branch each */
    cl_mem map_origin;
} cpm_eye_device;

cpm_status cpm_eye_kernels_of(const cpm_pass *pass, cpm_eye_kernels *kernels);
/* As many branches as `allowed` bytes hold. */
cpm_status cpm_eye_device_open(const cpm_pass *pass, const cpm_gather *gather, const cpm_eye *eye, uint64_t allowed,
                               cpm_eye_device *device);
void cpm_eye_device_close(const cpm_opencl *opencl, cpm_eye_device *device);

/* The host's side of a batch: what it reads of a level, and what it makes of it. */
typedef struct cpm_eye_host {
    unsigned char *seen;
    cl_int *children, *list, *gathered, *first_branch, *counts, *pixels;
    cl_int *owner[2]; /* which pixel of the batch a branch is of */
    double *evaluations, *sums, *irradiance;
    cpm_arrival *arrivals; /* where the host gathers */
} cpm_eye_host;
int cpm_eye_host_open(const cpm_eye_device *device, int host_gathers, cpm_eye_host *host); /* 0: no memory */
void cpm_eye_host_close(cpm_eye_host *host);
#endif
#endif
