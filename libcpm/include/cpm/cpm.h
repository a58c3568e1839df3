/* cpm/cpm.h: spectral global illumination where light bends. Include this one.
 *
 * Units: metres, nanometres for wavelength, degrees for angles, W m-2 sr-1 nm-1 for radiance.
 * Every fallible call returns cpm_status; cpm_context_last_error says more. Descriptor structs begin with struct_size,
 * the size that the caller compiled with, so that fields can be added at their ends. Handles are opaque and reference
 * counted; release takes NULL. */
#ifndef CPM_CPM_H
#define CPM_CPM_H

#include "context.h"
#include "device.h"
#include "image.h"
#include "medium.h"
#include "photons.h"
#include "ray.h"
#include "scene.h"
#include "status.h"

#endif
