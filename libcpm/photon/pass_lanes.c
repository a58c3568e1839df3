/* photon/pass_lanes.c: see pass_lanes.h; compiled once for each instruction set (backend/native/isa.h). */
#if defined(__AVX512F__)
#define CPM_WIDTH 8
#elif defined(__AVX2__)
#define CPM_WIDTH 4
#else
#define CPM_WIDTH 2
#endif
#include "pass_lanes.h"

#include "cl/shared/emit.h"
#include "cl/shared/meet.h"

#define NAME(f) CPM_ISA_NAME(f)
#define LANES_OF(count) (((int)(count) + CPM_WIDTH - 1) / CPM_WIDTH)

static real3 load_block(const double (*p)[CPM_BLOCK], int part) {
    return triple(load_doubles(p[0], part), load_doubles(p[1], part), load_doubles(p[2], part));
}

static void store_block(real3 v, double (*p)[CPM_BLOCK], int part) {
    store_doubles(v.x, p[0], part), store_doubles(v.y, p[1], part), store_doubles(v.z, p[2], part);
}

static word indices_from(uint64_t first) {
    uint32_t index[CPM_WIDTH];
    for (int i = 0; i < CPM_WIDTH; i++) index[i] = (uint32_t)(first + (uint64_t)i);
    return load_words(index, 0);
}

static void emit_delta_block(const cpm_emitter_data *given, const double *cumulative, const int32_t *guide,
                             const float *weight, uint64_t index, size_t count, cpm_emissions *out) {
    const cpm_emitter_data e = *given; /* in registers: what is stored below does not change it */
    for (int part = 0; part < LANES_OF(count); part++) {
        real3 direction;
        real power =
            emit_delta(&e, cumulative, guide, weight, indices_from(index + (uint64_t)(part * CPM_WIDTH)), &direction);
        store_doubles(power, out->weight, part);
        store_block(direction, out->direction, part);
    }
}

static void emit_area_block(const cpm_emitter_data *e, const cpm_triangle *triangles, const double *area,
                            uint64_t index, size_t count, cpm_emissions *out) {
    for (int part = 0; part < LANES_OF(count); part++) {
        real3 point, normal, direction;
        emit_area(e, triangles, area, indices_from(index + (uint64_t)(part * CPM_WIDTH)), &point, &normal, &direction,
                  &out->primitive[part * CPM_WIDTH]);
        store_block(point, out->position, part);
        store_block(normal, out->normal, part);
        store_block(direction, out->direction, part);
    }
}

static void emit_far_block(const cpm_emitter_data *e, const double *cumulative, const float *weight, uint64_t index,
                           size_t count, cpm_emissions *out) {
    for (int part = 0; part < LANES_OF(count); part++) {
        real3 point, direction;
        real power =
            emit_far(e, cumulative, weight, indices_from(index + (uint64_t)(part * CPM_WIDTH)), &point, &direction);
        store_doubles(power, out->weight, part);
        store_block(point, out->position, part);
        store_block(direction, out->direction, part);
    }
}

static void meet_block(uint64_t seed, double scale, size_t count, cpm_meetings *m) {
    for (int part = 0; part < LANES_OF(count); part++) {
        cpm_encounter e;
        e.came = load_block(m->came, part), e.start = load_block(m->start, part), e.hit = load_block(m->hit, part);
        e.normal = load_block(m->normal, part), e.factor = load_doubles(m->factor, part);
        e.path = load_words(m->path, part), e.block = load_words(m->block, part), e.bin = load_words(m->bin, part);
        const cpm_outcome o = scatter_meet(seed, scale, &e);
        store_block(o.toward, m->toward, part);
        store_block(o.from, m->from, part);
        store_doubles(o.chance, m->chance, part);
        store_words(o.direction_code, m->direction_code, part);
        store_words(o.normal_code, m->normal_code, part);
    }
}

static void power_block(const float *restrict weight, size_t count, const float *restrict spectrum, size_t bins,
                        float *restrict powers, double *restrict emitted) {
    for (size_t i = 0; i < count; i++)
        for (size_t b = 0; b < bins; b++) {
            const float power = weight[i] * spectrum[b];
            powers[i * bins + b] = power;
            emitted[b] += (double)power;
        }
}

static void settle_block(const cpm_powers *all, size_t count, const cpm_dither_table *table,
                         const cpm_roulette_rows *rows) {
    const cpm_dither_steps steps = {table->multiply, table->add};
    for (size_t i = 0; i < count; i++) cpm_settle(&all[i], &steps, rows);
}

extern const cpm_pass_code NAME(cpm_pass_code);
const cpm_pass_code NAME(cpm_pass_code) = {emit_delta_block, emit_area_block, meet_block,
                                           power_block,      settle_block,    emit_far_block};
