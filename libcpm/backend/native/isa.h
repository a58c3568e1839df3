/* backend/native/isa.h: names of what is compiled once per instruction set.
 *
 * Each file in isa_sources.txt is compiled three times, with CPM_ISA defined as baseline, v3 or v4 and the flags
 *   baseline  (none: x86-64)
 *   v3        -mavx2 -mfma -mbmi -mbmi2 -mlzcnt -mf16c
 *   v4        the same and -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx512cd -mprefer-vector-width=512
 * beside -ffp-contract=off (fma instructions are never used for a*b+c: results are equal on all three). */
#ifndef CPM_NATIVE_ISA_H
#define CPM_NATIVE_ISA_H

#define CPM_ISA_GLUE2(name, isa) name##_##isa
#define CPM_ISA_GLUE(name, isa) CPM_ISA_GLUE2(name, isa)
#ifdef CPM_ISA
#define CPM_ISA_NAME(name) CPM_ISA_GLUE(name, CPM_ISA)
#endif

typedef enum cpm_isa { CPM_ISA_BASELINE = 0, CPM_ISA_V3 = 1, CPM_ISA_V4 = 2 } cpm_isa;

/* What this machine has; the environment's CPM_ISA=baseline|v3|v4 may lower it. Decided once. */
cpm_isa cpm_isa_chosen(void);
const char *cpm_isa_text(cpm_isa isa); /* "x86-64-v4" */
#endif
