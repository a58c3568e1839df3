/* api/version.c: what this library is and what it was built with. */
#include "api/version.h"

#include "backend/native/isa.h"

#ifdef CPM_WITH_OPENEXR
#include <openexr.h>
#define OPENEXR "openexr " OPENEXR_VERSION_STRING
#else
#define OPENEXR "no openexr"
#endif

#ifdef CPM_OPENCL_HEADERS_VERSION
#define OPENCL "opencl headers " CPM_OPENCL_HEADERS_VERSION
#else
#define OPENCL "no opencl"
#endif

#ifndef CPM_EMBREE_VERSION /* set by the build */
#define CPM_EMBREE_VERSION "unknown"
#endif

#define BUILT_WITH "embree " CPM_EMBREE_VERSION ", " OPENEXR ", " OPENCL ", " COMPILER ", isa "
#if defined(__clang__)
#define COMPILER "clang " CPM_TEXT_OF(__clang_major__) "." CPM_TEXT_OF(__clang_minor__)
#elif defined(__GNUC__)
#define COMPILER "gcc " CPM_TEXT_OF(__GNUC__) "." CPM_TEXT_OF(__GNUC_MINOR__)
#else
#define COMPILER "unknown compiler"
#endif

#if defined(__x86_64__)
#define BASELINE "x86-64"
#else
#define BASELINE "baseline"
#endif

const char *cpm_version(void) { return CPM_VERSION_TEXT; }

const char *cpm_build_info(void) {
    switch (cpm_isa_chosen()) { /* what runs here, of what was built */
    case CPM_ISA_V4: return BUILT_WITH "x86-64-v4";
    case CPM_ISA_V3: return BUILT_WITH "x86-64-v3";
    case CPM_ISA_BASELINE: break;
    }
    return BUILT_WITH BASELINE;
}
