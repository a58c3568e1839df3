/* backend/opencl/loader.c: dlopen, once. */
#include "loader.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <dlfcn.h>
#include <pthread.h>
#include <stddef.h>
#include <string.h>

static cpm_cl_functions functions;
static const cpm_cl_functions *loaded;
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* Never closed: a driver may keep threads of its own. */
static void load(void) {
    void *library = dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) library = dlopen("libOpenCL.so", RTLD_NOW | RTLD_LOCAL);
    if (!library) return;
    static const struct {
        const char *name;
        size_t offset;
    } wanted[] = {
#define CPM_CL_WANTED(name) {"cl" #name, offsetof(cpm_cl_functions, name)},
        CPM_CL_FUNCTIONS(CPM_CL_WANTED)
#undef CPM_CL_WANTED
    };
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        void *function = dlsym(library, wanted[i].name);
        if (!function) return;
        memcpy((char *)&functions + wanted[i].offset, &function, sizeof function);
    }
    loaded = &functions;
}

const cpm_cl_functions *cpm_cl(void) {
    pthread_once(&once, load);
    return loaded;
}

const char *cpm_cl_error(cl_int code) {
#define CPM_CL_CASE(name)                                                                                              \
    case name: return #name;
    switch (code) {
        CPM_CL_CASE(CL_DEVICE_NOT_FOUND)
        CPM_CL_CASE(CL_DEVICE_NOT_AVAILABLE)
        CPM_CL_CASE(CL_COMPILER_NOT_AVAILABLE)
        CPM_CL_CASE(CL_MEM_OBJECT_ALLOCATION_FAILURE)
        CPM_CL_CASE(CL_OUT_OF_RESOURCES)
        CPM_CL_CASE(CL_OUT_OF_HOST_MEMORY)
        CPM_CL_CASE(CL_BUILD_PROGRAM_FAILURE)
        CPM_CL_CASE(CL_INVALID_VALUE)
        CPM_CL_CASE(CL_INVALID_DEVICE)
        CPM_CL_CASE(CL_INVALID_CONTEXT)
        CPM_CL_CASE(CL_INVALID_COMMAND_QUEUE)
        CPM_CL_CASE(CL_INVALID_BINARY)
        CPM_CL_CASE(CL_INVALID_BUILD_OPTIONS)
        CPM_CL_CASE(CL_INVALID_KERNEL_NAME)
        CPM_CL_CASE(CL_INVALID_KERNEL_ARGS)
        CPM_CL_CASE(CL_INVALID_WORK_GROUP_SIZE)
        CPM_CL_CASE(CL_INVALID_BUFFER_SIZE)
        CPM_CL_CASE(CL_INVALID_OPERATION)
    default: return "an OpenCL error";
    }
#undef CPM_CL_CASE
}
#endif
