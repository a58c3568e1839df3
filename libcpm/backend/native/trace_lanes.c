/* backend/native/trace_lanes.c: the shared ray code in lanes, compiled once for each instruction set (isa.h), for the
 * linear fields and tables; with CPM_ANY_MEDIUM (trace_lanes_any.c) for every medium. Company costs: together with the
 * others a trilinear grid takes 8 % more instructions. */
#ifndef CPM_ANY_MEDIUM
#define CPM_ANY_MEDIUM 0
#define CPM_MEDIA 0x1f /* kinds up to CPM_MEDIUM_GRID */
#endif
#ifndef CPM_SINGLE
#define CPM_SINGLE 0
#endif
#if defined(__AVX512F__) || (CPM_SINGLE && defined(__AVX2__))
#define CPM_WIDTH 8
#elif defined(__AVX2__) || CPM_SINGLE
#define CPM_WIDTH 4
#else
#define CPM_WIDTH 2
#endif
#include "cl/shared/trace.h"

#include "isa.h"
#include "lanes.h"

#if CPM_SINGLE && CPM_ANY_MEDIUM
#define NAME(f) CPM_ISA_NAME(f##_any_single)
#elif CPM_ANY_MEDIUM
#define NAME(f) CPM_ISA_NAME(f##_any)
#elif CPM_SINGLE
#define NAME(f) CPM_ISA_NAME(f##_single)
#else
#define NAME(f) CPM_ISA_NAME(f)
#endif

void NAME(cpm_range_trace)(const cpm_step_control *c, const cpm_medium_data *m, const double *table,
                           const cpm_ray_goal *plane, const cpm_trace_arrays *arrays, int64_t first, int64_t last) {
    cpm_trace_range(c, m, table, plane, arrays, first, last);
}

void NAME(cpm_packet_begin)(const cpm_step_control *c, const cpm_medium_data *m, const double *table,
                            cpm_lane_rays *rays, const int64_t *fresh) {
    cpm_lanes_begin(c, m, table, rays, fresh);
}

void NAME(cpm_packet_attempt)(const cpm_step_control *c, const cpm_medium_data *m, const double *table,
                              cpm_lane_rays *rays) {
    cpm_lanes_attempt(c, m, table, rays);
}
