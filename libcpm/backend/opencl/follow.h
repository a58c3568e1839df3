/* backend/opencl/follow.h: flights of a scene on the context's device, each followed to the first surface or boundary
 * that it meets: cpm_follow (backend/native/follow.h) in kernels.
 *
 * How to use it (photons.c does), with the device locked (cpm_opencl_lock) all the while:
 *
 *   cpm_opencl_world world;                          the pass's scene in buffers
 *   cpm_opencl_follow_plan plan;                     which kernels this scene's media need
 *   status = cpm_opencl_world_open(pass, &world);
 *   status = cpm_opencl_follow_open(&world, &plan);  builds programs, or takes them from the cache
 *   code = cpm_opencl_follow(&plan, flights, arrivals, counts, items, share);       enqueues; does not wait
 *   cpm_opencl_follow_close(&plan), cpm_opencl_world_close(&world);
 *
 * Buffers: `flights` holds items x share cpm_flight, `arrivals` as many cpm_arrival (cl/types/flight.h), `counts` one
 * cl_int an item: item i follows flights i share .. i share + counts[i] - 1 and fills their arrivals (`behind` too,
 * where the scene has boundaries). A flight's arrival depends on that flight alone. Results equal the native ones to
 * the last bit, but where float told Embree another primitive near an edge, for media free of transcendental functions.
 *
 * On a processor some items a unit (CPM_ITEMS_A_UNIT) with long segments fill the lanes; elsewhere an item is a thread,
 * and segments may be as short as 1. */
#ifndef CPM_OPENCL_FOLLOW_H
#define CPM_OPENCL_FOLLOW_H
#include "world.h"

/* All of that in one call, for flights and arrivals of the host's; locks the device. */
cpm_status cpm_opencl_follow_all(const cpm_pass *pass, const cpm_flight *flights, size_t count, cpm_arrival *arrivals);

#ifdef CPM_OPENCL_HEADERS_VERSION
#define CPM_ITEMS_A_UNIT 16

typedef struct cpm_opencl_way { /* how rays run in one medium, or in all that are straight */
    cl_kernel kernel;
    cl_mem control; /* cpm_step_control of integrated rays */
    cl_int medium;  /* -1: all straight ones */
} cpm_opencl_way;

typedef struct cpm_opencl_follow_plan {
    const cpm_opencl_world *world;
    cpm_opencl_way *ways;
    size_t way_count;
    cl_kernel behind; /* NULL: the scene has no boundaries */
} cpm_opencl_follow_plan;

cpm_status cpm_opencl_follow_open(const cpm_opencl_world *world, cpm_opencl_follow_plan *plan);
void cpm_opencl_follow_close(cpm_opencl_follow_plan *plan);

cl_int cpm_opencl_follow(const cpm_opencl_follow_plan *plan, cl_mem flights, cl_mem arrivals, cl_mem counts,
                         size_t items, cl_int share);
#endif
#endif
