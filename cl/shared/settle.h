/* shared/settle.h: the powers of one path at a surface: stored, then played for. */
#ifndef CPM_SHARED_SETTLE_H
#define CPM_SHARED_SETTLE_H
#include "scatter.h"
#include "store.h"

/* Powers of one path at a surface: bins [first, first + bins) of the film's. */
typedef struct cpm_powers {
    CPM_GLOBAL const float *before, *reflectance, *share; /* share: of the largest reflectance; bins each */
    CPM_GLOBAL float *after;             /* NULL: nothing goes on, all is absorbed. Not where `before` is */
    CPM_GLOBAL unsigned short *spectrum; /* where they are stored first; NULL: not stored */
    cpm_u32 dither;                      /* of the stored ones */
    cpm_u32 first, bins;
    cpm_i32 alive; /* what roulette says */
} cpm_powers;

/* Steps of the dither's sequence that are made in one: state after i + 1 steps = state multiply[i] + add[i]. */
typedef struct cpm_dither_steps {
    CPM_GLOBAL const cpm_u32 *multiply, *add;
} cpm_dither_steps;

/* Energies, each a pointer to all bins. */
typedef struct cpm_roulette_rows {
    CPM_GLOBAL double *absorbed, *gain, *loss, *variance;
} cpm_roulette_rows;

/* restrict holds in functions that are not inlined only, and without it the loops are mostly checks of what overlaps.
 */
CPM_APART void cpm_roulette_bins(CPM_GLOBAL const float *restrict before, CPM_GLOBAL const float *restrict reflectance,
                                 CPM_GLOBAL const float *restrict share, cpm_u32 bins, int alive,
                                 CPM_GLOBAL float *restrict after, CPM_GLOBAL double *restrict absorbed,
                                 CPM_GLOBAL double *restrict row, CPM_GLOBAL double *restrict variance) {
    const double sign = alive ? 1.0 : -1.0;
    for (size_t b = 0; b < bins; b++) {
        double kept, change;
        after[b] = cpm_roulette(before[b], reflectance[b], share[b], alive, &kept, &change);
        absorbed[b] += (double)before[b] - kept;
        row[b] += sign * change;
        variance[b] += change * change;
    }
}

CPM_APART void cpm_store_bins(CPM_GLOBAL const float *restrict powers, cpm_u32 bins, cpm_u32 dither,
                              CPM_GLOBAL const cpm_u32 *restrict multiply, CPM_GLOBAL const cpm_u32 *restrict add,
                              CPM_GLOBAL unsigned short *restrict to) {
    cpm_u32 odd = 0;
    for (size_t b = 0; b < bins; b++) {
        cpm_float_bits x;
        x.value = powers[b];
        to[b] = cpm_half_bits_dithered(x.bits, dither * multiply[b] + add[b]);
        odd |= (cpm_u32)!cpm_half_dithers(x.bits);
    }
    for (size_t b = 0; odd && b < bins; b++) to[b] = cpm_half_dithered(powers[b], dither * multiply[b] + add[b]);
}

/* One bin, without a loop's preparations. */
CPM_INLINE void cpm_settle_one(const cpm_powers *p, const cpm_dither_steps *steps, const cpm_roulette_rows *rows) {
    CPM_GLOBAL double *row = (p->alive ? rows->gain : rows->loss) + p->first;
    double kept, change;
    const float power = *p->before;
    if (p->spectrum) *p->spectrum = cpm_half_dithered(power, p->dither * steps->multiply[0] + steps->add[0]);
    if (!p->after) {
        rows->absorbed[p->first] += (double)power;
        return;
    }
    *p->after = cpm_roulette(power, *p->reflectance, *p->share, p->alive, &kept, &change);
    rows->absorbed[p->first] += (double)power - kept;
    *row += p->alive ? change : -change;
    rows->variance[p->first] += change * change;
}

CPM_INLINE void cpm_settle(const cpm_powers *p, const cpm_dither_steps *steps, const cpm_roulette_rows *rows) {
    if (p->bins == 1) {
        cpm_settle_one(p, steps, rows);
        return;
    }
    if (p->spectrum) cpm_store_bins(p->before, p->bins, p->dither, steps->multiply, steps->add, p->spectrum);
    if (p->after)
        cpm_roulette_bins(p->before, p->reflectance, p->share, p->bins, p->alive, p->after, rows->absorbed + p->first,
                          (p->alive ? rows->gain : rows->loss) + p->first, rows->variance + p->first);
    else
        for (size_t b = 0; b < p->bins; b++) rows->absorbed[p->first + b] += (double)p->before[b];
}
#endif
