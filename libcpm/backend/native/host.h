/* backend/native/host.h: what cl/shared's rays of a scene leave to the host: how a curve's first hit is asked for.
 * Before any header of cl/shared that asks. */
#ifndef CPM_NATIVE_HOST_H
#define CPM_NATIVE_HOST_H
#include "geometry/geometry.h"

#define CPM_HOST_LANES 1
#define CPM_ASK_CURVE(w, curve, end, left, slack, filter, hit)                                                         \
    cpm_geometry_curve((w)->geometry, curve, end, left, slack, filter, hit)
#endif
