/* photon/pass_code.c: the photon pass's arithmetic for this machine. */
#include "cl/shared/store.h"
#include "pass_lanes.h"

extern const cpm_pass_code cpm_pass_code_baseline;
#if CPM_ISA_COUNT > 1
extern const cpm_pass_code cpm_pass_code_v3, cpm_pass_code_v4;
#endif

const cpm_pass_code *cpm_pass_code_chosen(void) {
#if CPM_ISA_COUNT > 1
    if (cpm_isa_chosen() == CPM_ISA_V4) return &cpm_pass_code_v4;
    if (cpm_isa_chosen() == CPM_ISA_V3) return &cpm_pass_code_v3;
#endif
    return &cpm_pass_code_baseline;
}

void cpm_dither_table_fill(cpm_dither_table *table) {
    uint32_t multiply = 1, add = 0;
    for (int i = 0; i < CPM_DITHER_BINS; i++) {
        multiply *= CPM_DITHER_STEP;
        add = cpm_dither_next(add);
        table->multiply[i] = multiply, table->add[i] = add;
    }
}
