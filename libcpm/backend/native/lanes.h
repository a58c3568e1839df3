/* backend/native/lanes.h: what trace_lanes.c defines, for each instruction set and precision, and the table of it. */
#ifndef CPM_NATIVE_LANES_H
#define CPM_NATIVE_LANES_H
#include "cl/shared/trace.h"
#include "isa.h"

/* What is compiled once per instruction set. */
typedef struct cpm_lane_code {
    void (*trace)(const cpm_step_control *, const cpm_medium_data *, const double *, const cpm_ray_goal *,
                  const cpm_trace_arrays *, int64_t, int64_t);
    void (*begin)(const cpm_step_control *, const cpm_medium_data *, const double *, cpm_lane_rays *, const int64_t *);
    void (*attempt)(const cpm_step_control *, const cpm_medium_data *, const double *, cpm_lane_rays *);
} cpm_lane_code;

#define CPM_DECLARE_LANES(suffix)                                                                                      \
    void cpm_range_trace##suffix(const cpm_step_control *, const cpm_medium_data *, const double *,                    \
                                 const cpm_ray_goal *, const cpm_trace_arrays *, int64_t, int64_t);                    \
    void cpm_packet_begin##suffix(const cpm_step_control *, const cpm_medium_data *, const double *, cpm_lane_rays *,  \
                                  const int64_t *);                                                                    \
    void cpm_packet_attempt##suffix(const cpm_step_control *, const cpm_medium_data *, const double *, cpm_lane_rays *);

#define CPM_DECLARE_ISA(isa)                                                                                           \
    CPM_DECLARE_LANES(_##isa)                                                                                          \
    CPM_DECLARE_LANES(_single_##isa)                                                                                   \
    CPM_DECLARE_LANES(_any_##isa)                                                                                      \
    CPM_DECLARE_LANES(_any_single_##isa)
CPM_DECLARE_ISA(baseline)
CPM_DECLARE_ISA(v3)
CPM_DECLARE_ISA(v4)

/* The code for this machine and a kind of medium. */
const cpm_lane_code *cpm_lane_code_for(int32_t kind, int single_precision);
#endif
