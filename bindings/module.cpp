/* bindings/module.cpp: the module cpm._core. */
#include "bindings.h"

PYBIND11_MODULE(_core, module) {
    module.doc() = "libcpm's C ABI, handle by handle; the package cpm is the interface";
    bind_context(module);
    bind_medium(module);
    bind_scene(module);
    bind_rays(module);
    bind_photons(module);
    bind_image(module);
}
