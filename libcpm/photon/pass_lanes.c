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
#include "cl/shared/scatter.h"
#include "cl/shared/store.h"

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
        real3 came = load_block(m->came, part);
        real3 facing = scatter_facing(scale3(root(load_doubles(m->factor, part)), load_block(m->normal, part)), came);
        word random[4];
        philox_lanes(seed, load_words(m->path, part), load_words(m->block, part), CPM_STREAM_SCATTER,
                     load_words(m->bin, part), random);
        store_block(scatter_diffuse(facing, random), m->toward, part);
        store_block(scatter_step_back(load_block(m->hit, part), load_block(m->start, part), came, scale), m->from,
                    part);
        store_doubles(uniform_lanes(random[2]), m->chance, part);
        store_words(octahedral_encode(came), m->direction_code, part);
        store_words(octahedral_encode(facing), m->normal_code, part);
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

/* restrict holds in functions that are not inlined only, and without it the loops are mostly checks of what overlaps.
 */
#define APART static __attribute__((noinline))

APART void roulette_bins(const float *restrict before, const float *restrict reflectance, const float *restrict share,
                         size_t bins, int alive, float *restrict after, double *restrict absorbed, double *restrict row,
                         double *restrict variance) {
    const double sign = alive ? 1.0 : -1.0;
    for (size_t b = 0; b < bins; b++) {
        double kept, change;
        after[b] = cpm_roulette(before[b], reflectance[b], share[b], alive, &kept, &change);
        absorbed[b] += (double)before[b] - kept;
        row[b] += sign * change;
        variance[b] += change * change;
    }
}

APART void store_bins(const float *restrict powers, size_t bins, uint32_t dither,
                      const cpm_dither_table *restrict table, uint16_t *restrict to) {
    uint32_t odd = 0;
    for (size_t b = 0; b < bins; b++) {
        cpm_float_bits x;
        x.value = powers[b];
        to[b] = cpm_half_bits_dithered(x.bits, dither * table->multiply[b] + table->add[b]);
        odd |= (uint32_t)!cpm_half_dithers(x.bits);
    }
    for (size_t b = 0; odd && b < bins; b++)
        to[b] = cpm_half_dithered(powers[b], dither * table->multiply[b] + table->add[b]);
}

/* One bin, without a loop's preparations. */
static void settle_one(const cpm_powers *p, const cpm_dither_table *table, const cpm_roulette_rows *rows) {
    double *row = (p->alive ? rows->gain : rows->loss) + p->first, kept, change;
    const float power = *p->before;
    if (p->spectrum) *p->spectrum = cpm_half_dithered(power, p->dither * table->multiply[0] + table->add[0]);
    if (!p->after) {
        rows->absorbed[p->first] += (double)power;
        return;
    }
    *p->after = cpm_roulette(power, *p->reflectance, *p->share, p->alive, &kept, &change);
    rows->absorbed[p->first] += (double)power - kept;
    *row += p->alive ? change : -change;
    rows->variance[p->first] += change * change;
}

static void settle_bins(const cpm_powers *p, const cpm_dither_table *table, const cpm_roulette_rows *rows) {
    if (p->spectrum) store_bins(p->before, p->bins, p->dither, table, p->spectrum);
    if (p->after)
        roulette_bins(p->before, p->reflectance, p->share, p->bins, p->alive, p->after, rows->absorbed + p->first,
                      (p->alive ? rows->gain : rows->loss) + p->first, rows->variance + p->first);
    else
        for (size_t b = 0; b < p->bins; b++) rows->absorbed[p->first + b] += (double)p->before[b];
}

static void settle_block(const cpm_powers *all, size_t count, const cpm_dither_table *table,
                         const cpm_roulette_rows *rows) {
    for (size_t i = 0; i < count; i++)
        if (all[i].bins == 1)
            settle_one(&all[i], table, rows);
        else
            settle_bins(&all[i], table, rows);
}

extern const cpm_pass_code NAME(cpm_pass_code);
const cpm_pass_code NAME(cpm_pass_code) = {emit_delta_block, emit_area_block, meet_block,
                                           power_block,      settle_block,    emit_far_block};
