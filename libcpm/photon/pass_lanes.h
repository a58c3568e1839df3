/* photon/pass_lanes.h: the photon pass's arithmetic on blocks of paths, compiled for each instruction set. The physics
 * is cl/shared/emit.h, scatter.h and store.h; results do not depend on the instruction set. */
#ifndef CPM_PHOTON_PASS_LANES_H
#define CPM_PHOTON_PASS_LANES_H
#include <stdint.h>

#include "backend/native/isa.h"
#include "cl/shared/settle.h"
#include "cl/types/emitter.h"
#include "cl/types/geometry.h"

#define CPM_BLOCK 16 /* paths at a time: their numbers stay in the nearest cache (64: 8 % slower) */

typedef struct cpm_emissions {
    double position[3][CPM_BLOCK], normal[3][CPM_BLOCK]; /* of area lights only; position of far ones too */
    double direction[3][CPM_BLOCK];
    double weight[CPM_BLOCK]; /* of point, spot and far lights only */
    int32_t primitive[CPM_BLOCK];
} cpm_emissions;

/* Paths at diffuse or black surfaces. */
typedef struct cpm_meetings {
    /* in */
    double came[3][CPM_BLOCK], start[3][CPM_BLOCK], hit[3][CPM_BLOCK];
    double normal[3][CPM_BLOCK], factor[CPM_BLOCK];             /* geometric, of any length; 1/length^2 */
    uint32_t path[CPM_BLOCK], block[CPM_BLOCK], bin[CPM_BLOCK]; /* counters of the random numbers */
    /* out */
    double toward[3][CPM_BLOCK], from[3][CPM_BLOCK]; /* direction and start of a survivor */
    double chance[CPM_BLOCK];                        /* the roulette's number */
    uint32_t direction_code[CPM_BLOCK], normal_code[CPM_BLOCK];
} cpm_meetings;

#define CPM_DITHER_BINS 256 /* steps of the dither's sequence that are made in one */
typedef struct cpm_dither_table {
    uint32_t multiply[CPM_DITHER_BINS], add[CPM_DITHER_BINS]; /* state after i + 1 steps */
} cpm_dither_table;
void cpm_dither_table_fill(cpm_dither_table *table);

typedef struct cpm_pass_code {
    /* Paths index .. index + count (count <= CPM_BLOCK; the arrays are filled up to a whole lane). */
    void (*emit_delta)(const cpm_emitter_data *e, const double *cumulative, const int32_t *guide, const float *weight,
                       uint64_t index, size_t count, cpm_emissions *out);
    void (*emit_area)(const cpm_emitter_data *e, const cpm_triangle *triangles, const double *area, uint64_t index,
                      size_t count, cpm_emissions *out);
    void (*meet)(uint64_t seed, double scale, size_t count, cpm_meetings *m);
    /* powers[i bins + b] = weight[i] spectrum[b]; also added to emitted[bins]. */
    void (*power)(const float *weight, size_t count, const float *spectrum, size_t bins, float *powers,
                  double *emitted);
    /* Stores powers, then plays roulette with them. */
    void (*settle)(const cpm_powers *all, size_t count, const cpm_dither_table *table, const cpm_roulette_rows *rows);
    /* As emit_delta and emit_area: position, direction and weight. */
    void (*emit_far)(const cpm_emitter_data *e, const double *cumulative, const float *weight, uint64_t index,
                     size_t count, cpm_emissions *out);
} cpm_pass_code;

const cpm_pass_code *cpm_pass_code_chosen(void);
#endif
