/* backend/opencl/loader.h: OpenCL's functions, found when first asked for: the library runs without any OpenCL. */
#ifndef CPM_OPENCL_LOADER_H
#define CPM_OPENCL_LOADER_H
#ifdef CPM_OPENCL_HEADERS_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#define CPM_CL_FUNCTIONS(X)                                                                                            \
    X(GetPlatformIDs)                                                                                                  \
    X(GetPlatformInfo)                                                                                                 \
    X(GetDeviceIDs) X(GetDeviceInfo) X(CreateContext) X(RetainContext) X(ReleaseContext) X(CreateCommandQueue)         \
        X(RetainCommandQueue) X(ReleaseCommandQueue) X(GetCommandQueueInfo) X(CreateProgramWithSource)                 \
            X(CreateProgramWithBinary) X(BuildProgram) X(GetProgramBuildInfo) X(GetProgramInfo) X(ReleaseProgram)      \
                X(CreateKernel) X(ReleaseKernel) X(SetKernelArg) X(CreateBuffer) X(ReleaseMemObject)                   \
                    X(EnqueueWriteBuffer) X(EnqueueReadBuffer) X(EnqueueMapBuffer) X(EnqueueUnmapMemObject)           \
                        X(EnqueueFillBuffer) X(EnqueueNDRangeKernel) X(Flush) X(Finish)

typedef struct cpm_cl_functions {
#define CPM_CL_MEMBER(name) __typeof__(cl##name) *name;
    CPM_CL_FUNCTIONS(CPM_CL_MEMBER)
#undef CPM_CL_MEMBER
} cpm_cl_functions;

/* NULL where no loader (libOpenCL.so.1) is installed, or it lacks something. */
const cpm_cl_functions *cpm_cl(void);
/* "CL_OUT_OF_RESOURCES" */
const char *cpm_cl_error(cl_int code);
#endif
#endif
