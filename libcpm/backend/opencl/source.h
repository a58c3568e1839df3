/* backend/opencl/source.h: the files of cl/, as they were when the library was built, and one text of them. */
#ifndef CPM_OPENCL_SOURCE_H
#define CPM_OPENCL_SOURCE_H
#include <stddef.h>
#include <stdint.h>

typedef struct cpm_kernel_file {
    const char *name; /* "shared/trace.h" */
    const char *text;
    size_t size;
} cpm_kernel_file;

/* Made at build time from cl/ (cmake/EmbedKernels.cmake). */
extern const cpm_kernel_file cpm_kernel_files[];
extern const size_t cpm_kernel_file_count;

/* kernels/NAME.cl with every include in its place, once: one self-contained OpenCL C text that the caller frees. NULL:
 * no such kernel, or no memory. */
char *cpm_kernel_source(const char *name, size_t *size);

/* FNV-1a, to tell texts apart: start with CPM_HASH_START. */
#define CPM_HASH_START UINT64_C(14695981039346656037)
uint64_t cpm_hash(uint64_t hash, const void *bytes, size_t size);
#endif
