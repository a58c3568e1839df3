/* backend/native/dispatch.c: the instruction set that this machine has, and the calls of advance.h on it. */
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "advance.h"
#include "cpm/ray.h"
#include "lanes.h"
#include "parabolas.h"

#ifndef CPM_ISA_COUNT
#if defined(__x86_64__)
#define CPM_ISA_COUNT 3
#else
#define CPM_ISA_COUNT 1
#endif
#endif

#define LANES(isa)                                                                                                     \
    { cpm_range_trace_##isa, cpm_packet_begin_##isa, cpm_packet_attempt_##isa }
static const cpm_lane_code codes[][2] = {
    {LANES(baseline), LANES(single_baseline)},
#if CPM_ISA_COUNT > 1
    {LANES(v3), LANES(single_v3)},
    {LANES(v4), LANES(single_v4)},
#endif
};

extern const cpm_parabolas cpm_follow_parabolas_baseline;
#if CPM_ISA_COUNT > 1
extern const cpm_parabolas cpm_follow_parabolas_v3, cpm_follow_parabolas_v4;
#endif

static cpm_isa detect(void) {
    cpm_isa best = CPM_ISA_BASELINE;
#if CPM_ISA_COUNT > 1
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        best = CPM_ISA_V3;
    if (best == CPM_ISA_V3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
        best = CPM_ISA_V4;
    const char *wish = getenv("CPM_ISA");
    if (wish && !strcmp(wish, "baseline")) best = CPM_ISA_BASELINE;
    if (wish && !strcmp(wish, "v3") && best > CPM_ISA_V3) best = CPM_ISA_V3;
#endif
    return best;
}

cpm_isa cpm_isa_chosen(void) {
    static atomic_int chosen = -1; /* detection twice by two threads gives the same */
    int isa = atomic_load(&chosen);
    if (isa < 0) {
        isa = (int)detect();
        atomic_store(&chosen, isa);
    }
    return (cpm_isa)isa;
}

cpm_parabolas cpm_parabolas_chosen(void) {
#if CPM_ISA_COUNT > 1
    if (cpm_isa_chosen() == CPM_ISA_V4) return cpm_follow_parabolas_v4;
    if (cpm_isa_chosen() == CPM_ISA_V3) return cpm_follow_parabolas_v3;
#endif
    return cpm_follow_parabolas_baseline;
}

const char *cpm_isa_text(cpm_isa isa) {
    static const char *const text[] = {"x86-64", "x86-64-v3", "x86-64-v4"};
    return CPM_ISA_COUNT > 1 ? text[isa] : "generic";
}

const cpm_lane_code *cpm_lane_code_for(int single_precision) { return &codes[cpm_isa_chosen()][single_precision != 0]; }

static cpm_step_control control_of(const cpm_lane_control *c) {
    int euler = c->method == CPM_METHOD_EULER;
    cpm_step_control s = {.method = c->method == CPM_METHOD_AUTO || c->method == CPM_METHOD_EXACT ? CPM_STEP_DOPRI5
                                                                                                  : c->method,
                          .rtol = c->rtol > 0.0 ? c->rtol
                                  : euler       ? 1e-2
                                                : 1e-6,
                          .atol = c->atol,
                          .step = c->step,
                          .max_step = c->max_step > 0.0 ? c->max_step : CPM_INFINITE,
                          .max_evaluations = c->max_evaluations > 0 ? (double)c->max_evaluations : 1e6};
    cpm_step_control_set(&s);
    return s;
}

void cpm_lanes_start(const cpm_lane_control *control, cpm_lane_rays *rays, const int64_t fresh[8]) {
    cpm_step_control c = control_of(control);
    for (int i = 0; i < CPM_LANES; i++)
        if (fresh[i] && control->expected_length > 0.0) rays->expected[i] = control->expected_length;
    cpm_lane_code_for(control->single_precision)->begin(&c, control->medium, control->table, rays, fresh);
}

void cpm_lanes_step(const cpm_lane_control *control, cpm_lane_rays *rays) {
    cpm_step_control c = control_of(control);
    cpm_lane_code_for(control->single_precision)->attempt(&c, control->medium, control->table, rays);
}

void cpm_lane_piece(const cpm_lane_rays *rays, int lane, cpm_piece *piece) { cpm_lanes_piece(rays, lane, piece); }
