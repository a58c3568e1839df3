# Target cpm_openexr: OpenEXRCore alone, the C library (3.1 or newer). OpenEXR's own CMake files are not asked: they bring
# the C++ libraries with them, and Debian's name files that are not in the package.
find_path(OPENEXR_INCLUDE_DIR openexr.h PATH_SUFFIXES OpenEXR)
find_library(OPENEXRCORE_LIBRARY NAMES OpenEXRCore OpenEXRCore-3_1 OpenEXRCore-3_2 OpenEXRCore-3_3 OpenEXRCore-3_4)
mark_as_advanced(OPENEXR_INCLUDE_DIR OPENEXRCORE_LIBRARY)
if(NOT OPENEXR_INCLUDE_DIR OR NOT OPENEXRCORE_LIBRARY)
    message(FATAL_ERROR "OpenEXR 3.1 or newer was not found. On Debian: apt-get install libopenexr-dev. "
                        "Without it: -DCPM_WITH_OPENEXR=OFF.")
endif()
file(STRINGS "${OPENEXR_INCLUDE_DIR}/OpenEXRConfig.h" openexr_version REGEX "define +OPENEXR_VERSION_STRING")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" openexr_version "${openexr_version}")
message(STATUS "OpenEXR ${openexr_version}")

add_library(cpm_openexr INTERFACE)
target_link_libraries(cpm_openexr INTERFACE "${OPENEXRCORE_LIBRARY}")
target_include_directories(cpm_openexr SYSTEM INTERFACE "${OPENEXR_INCLUDE_DIR}")
