# CPM_OPENCL_HEADERS_VERSION: "3.0" and the like, empty where there are no headers: then the library is built without the
# OpenCL backend. The loader itself is found when the library runs, or not.
set(CPM_OPENCL_HEADERS_VERSION "")
find_path(OPENCL_HEADERS_DIR CL/cl_version.h)
mark_as_advanced(OPENCL_HEADERS_DIR)
if(OPENCL_HEADERS_DIR)
    file(STRINGS "${OPENCL_HEADERS_DIR}/CL/cl_version.h" target_line REGEX "^#define CL_TARGET_OPENCL_VERSION [0-9]+")
    string(REGEX MATCH "([0-9])([0-9])0" ignored "${target_line}")
    set(CPM_OPENCL_HEADERS_VERSION "${CMAKE_MATCH_1}.${CMAKE_MATCH_2}")
endif()
