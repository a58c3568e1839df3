# Target cpm_embree: Embree 4 or 3, whichever is found first. CPM_EMBREE_MAJOR says which to the one C file that hides
# the difference.
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
    find_package(embree 3.10 CONFIG QUIET)
endif()
if(NOT embree_FOUND)
    message(FATAL_ERROR "Embree 3.10 or newer was not found. On Debian: apt-get install libembree-dev. "
                        "Elsewhere: set embree_DIR to the folder of embree-config.cmake.")
endif()
string(REGEX MATCH "^[0-9]+" embree_major "${embree_VERSION}")

# Debian's targets lack an include folder, other builds' have one: both are served.
add_library(cpm_embree INTERFACE)
target_link_libraries(cpm_embree INTERFACE embree)
if(EMBREE_INCLUDE_DIRS AND NOT EMBREE_INCLUDE_DIRS STREQUAL "/usr/include")
    target_include_directories(cpm_embree SYSTEM INTERFACE ${EMBREE_INCLUDE_DIRS})
endif()
target_compile_definitions(cpm_embree INTERFACE CPM_EMBREE_MAJOR=${embree_major}
                                                CPM_EMBREE_VERSION="${embree_VERSION}")
message(STATUS "Embree ${embree_VERSION}")
