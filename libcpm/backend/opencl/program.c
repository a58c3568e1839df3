/* backend/opencl/program.c: building programs, once each. */
#include "program.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "source.h"

#define KEY_SIZE 1024
#define LOG_SHOWN 600 /* of a build log's characters */

struct cpm_program {
    char key[KEY_SIZE];
    char function[64];
    cl_program program;
    int owns; /* the program; else another entry's, further down the list */
    cl_kernel kernel;
    cpm_program *next;
};

static cpm_status build_failed(cpm_context *context, const char *name, cl_program program, cl_int code) {
    const cpm_opencl *o = context->opencl;
    size_t size = 0;
    char *log = NULL;
    if (o->cl->GetProgramBuildInfo(program, o->device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) == CL_SUCCESS && size)
        log = calloc(1, size + 1);
    if (log) o->cl->GetProgramBuildInfo(program, o->device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    cpm_status status = cpm_fail(context, CPM_ERROR_BACKEND, "OpenCL device '%s' cannot build kernels/%s.cl (%s): %.*s",
                                 o->name, name, cpm_cl_error(code), LOG_SHOWN, log ? log : "no build log");
    free(log);
    return status;
}

static cl_program from_binary(const cpm_opencl *o, const char *key, const char *options) {
    size_t size = 0;
    unsigned char *binary = cpm_program_load(key, &size);
    if (!binary) return NULL;
    const unsigned char *binaries[1] = {binary};
    cl_int loaded = CL_SUCCESS, code = CL_SUCCESS;
    cl_program program = o->cl->CreateProgramWithBinary(o->context, 1, &o->device, &size, binaries, &loaded, &code);
    free(binary);
    if (code != CL_SUCCESS || !program) return NULL;
    if (loaded == CL_SUCCESS && o->cl->BuildProgram(program, 1, &o->device, options, NULL, NULL) == CL_SUCCESS)
        return program;
    o->cl->ReleaseProgram(program);
    return NULL;
}

static void keep_binary(const cpm_opencl *o, const char *key, cl_program program) {
    size_t size = 0;
    if (o->cl->GetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, NULL) != CL_SUCCESS || !size)
        return;
    unsigned char *binary = malloc(size);
    if (binary && o->cl->GetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof binary, &binary, NULL) == CL_SUCCESS)
        cpm_program_save(key, binary, size);
    free(binary);
}

static cpm_status from_source(cpm_context *context, const char *name, const char *source, size_t size,
                              const char *options, cl_program *program) {
    cpm_opencl *o = context->opencl;
    cl_int code = CL_SUCCESS;
    *program = o->cl->CreateProgramWithSource(o->context, 1, &source, &size, &code);
    if (code != CL_SUCCESS || !*program) return cpm_opencl_failed(context, o, "taking a kernel's source", code);
    code = o->cl->BuildProgram(*program, 1, &o->device, options, NULL, NULL);
    if (code == CL_SUCCESS) return CPM_OK;
    cpm_status status = build_failed(context, name, *program, code);
    o->cl->ReleaseProgram(*program);
    *program = NULL;
    return status;
}

cpm_status cpm_program_kernel(cpm_context *context, const char *name, const char *function, const char *options,
                              cl_kernel *kernel) {
    cpm_opencl *o = context->opencl;
    const double start = cpm_seconds();
    size_t size = 0;
    char *source = cpm_kernel_source(name, &size);
    if (!source) return cpm_fail(context, CPM_ERROR_INTERNAL, "there is no source of kernels/%s.cl", name);
    cpm_program *p = calloc(1, sizeof *p);
    cpm_status status = CPM_OK;
    if (!p)
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a program");
    else if (snprintf(p->key, sizeof p->key, "cpm %s; %s %016llx; %s; %s; %s; %s", cpm_version(), name,
                      (unsigned long long)cpm_hash(CPM_HASH_START, source, size), options, o->name, o->version,
                      o->driver) >= (int)sizeof p->key)
        status = cpm_fail(context, CPM_ERROR_INTERNAL, "the build options of kernels/%s.cl are too long", name);
    for (cpm_program *q = o->programs; q && status == CPM_OK; q = q->next) {
        if (strcmp(q->key, p->key)) continue;
        if (!strcmp(q->function, function)) {
            *kernel = q->kernel;
            free(p), free(source);
            return CPM_OK;
        }
        p->program = q->program;
    }
    if (status == CPM_OK && !p->program) {
        p->owns = 1;
        p->program = from_binary(o, p->key, options);
        o->stats.cached += p->program != NULL;
        if (!p->program) {
            status = from_source(context, name, source, size, options, &p->program);
            if (status == CPM_OK) {
                keep_binary(o, p->key, p->program);
                o->stats.compiled++;
                o->stats.source_bytes += size;
            }
        }
    }
    if (status == CPM_OK) {
        cl_int code = CL_SUCCESS;
        snprintf(p->function, sizeof p->function, "%s", function);
        p->kernel = o->cl->CreateKernel(p->program, function, &code);
        if (code != CL_SUCCESS) {
            if (p->owns) o->cl->ReleaseProgram(p->program);
            status = cpm_opencl_failed(context, o, "making a kernel", code);
        }
    }
    o->stats.seconds += cpm_seconds() - start;
    free(source);
    if (status != CPM_OK) {
        free(p);
        return status;
    }
    p->next = o->programs;
    o->programs = p;
    *kernel = p->kernel;
    return CPM_OK;
}

void cpm_programs_free(cpm_opencl *o) {
    while (o->programs) {
        cpm_program *p = o->programs;
        o->programs = p->next;
        o->cl->ReleaseKernel(p->kernel);
        if (p->owns) o->cl->ReleaseProgram(p->program);
        free(p);
    }
}
#endif
