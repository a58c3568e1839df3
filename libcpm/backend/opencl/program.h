/* backend/opencl/program.h: a kernel of cl/ compiled for what is asked of it: kept in memory, and as a binary on disk.
 *
 * The key is everything that a compiled program depends on: the source's hash (all that it includes), the options
 * (every -D), the device, its driver's version and this library's. What is found under a key is used only if the whole
 * key is in the file and its checksum is right; anything else is as if it were not there. */
#ifndef CPM_OPENCL_PROGRAM_H
#define CPM_OPENCL_PROGRAM_H
#include "device.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
/* The kernel `function` of kernels/NAME.cl built with `options`. Call with the device locked; the kernel is the
 * cache's. */
cpm_status cpm_program_kernel(cpm_context *context, const char *name, const char *function, const char *options,
                              cl_kernel *kernel);
void cpm_programs_free(cpm_opencl *opencl);

/* program_disk.c: what is kept under a key; NULL: nothing of use. The caller frees. */
void *cpm_program_load(const char *key, size_t *size);
void cpm_program_save(const char *key, const void *binary, size_t size);
#endif
#endif
