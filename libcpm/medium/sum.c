/* medium/sum.c: several media as one: a flat list of terms, each with a copy of its table.
 *
 * A ray carries one `scale`: in a sum that disperses it is the wavelength, from which each term finds its own factor
 * (cl/shared/medium_sum.h). */
#include "cl/types/term.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dispersion.h"

typedef struct summand { /* a term on the way in: of a medium, or of a sum that is taken apart */
    cpm_term term;
    const double *table; /* its own */
    size_t table_count;
    const double *coefficients;
} summand;

typedef struct summands {
    summand *list;
    size_t count, tables; /* doubles of all tables, each in whole cache lines */
} summands;

static size_t lines(size_t doubles) { return (doubles + 7) / 8 * 8; }

static void add_summand(summands *all, const summand *s) {
    if (all->count < CPM_MAX_TERMS) all->list[all->count] = *s;
    all->count++;
    all->tables += lines(s->table_count);
}

static void add_medium(summands *all, const cpm_medium *m) {
    if (m->data.kind == CPM_MEDIUM_SUM) {
        for (int32_t i = 0; i < m->data.size[0]; i++) {
            summand s;
            memcpy(&s.term, m->table + m->data.records + CPM_TERM * i, sizeof s.term);
            s.table = m->table + s.term.table;
            s.table_count = (size_t)s.term.table_count;
            s.coefficients = m->table + s.term.coefficients;
            add_summand(all, &s);
        }
        return;
    }
    const int own = m->by_wavelength, disperses = m->dispersive && !own;
    summand s = {.term = {.data = m->data,
                          .table_count = (int64_t)m->table_count,
                          .reference = m->reference,
                          .scaling = own         ? CPM_SCALE_GIVEN
                                     : disperses ? CPM_SCALE_WAVELENGTH
                                                 : CPM_SCALE_NONE,
                          .square = cpm_medium_by_square(&m->data),
                          .dispersion = disperses ? m->dispersion.kind : CPM_DISPERSION_NONE,
                          .count = disperses ? m->dispersion.count : 0,
                          .low = m->dispersion.low,
                          .high = m->dispersion.high},
                 .table = m->table,
                 .table_count = m->table_count,
                 .coefficients = m->dispersion.coefficients};
    add_summand(all, &s);
}

/* The first jump that a step must end at, as cpm_has_kinks has it: for the sum, the largest of the terms'. */
static void measure(cpm_medium_data *data, const summands *all) {
    data->feature = INFINITY;
    data->uniform = 1;
    for (size_t i = 0; i < all->count; i++) {
        const cpm_medium_data *d = &all->list[i].term.data;
        const int cubic = d->interpolation == CPM_FIELD_CUBIC;
        data->size[1] |= d->kind == CPM_MEDIUM_EATON || d->kind == CPM_MEDIUM_SOURCES;
        data->size[2] |= d->kind == CPM_MEDIUM_LAYERED || d->kind == CPM_MEDIUM_SHELLS || d->kind == CPM_MEDIUM_GRID;
        data->feature = fmin(data->feature, d->feature);
        data->jump = fmax(data->jump, d->jump);
        data->kink = fmax(data->kink, cubic ? 200.0 * d->jump * fmin(d->feature, 1e300) : d->kink);
        data->uniform &= d->uniform && all->list[i].term.scaling == CPM_SCALE_NONE;
    }
}

/* The terms' records, tables and coefficients, one after the other. */
static void fill(cpm_medium *m, const summands *all) {
    size_t at = lines(CPM_TERM * all->count), end = at + all->tables;
    for (size_t i = 0; i < all->count; i++) {
        cpm_term term = all->list[i].term;
        term.table = (int64_t)at;
        term.coefficients = (int64_t)end;
        if (all->list[i].table_count)
            memcpy(m->table + at, all->list[i].table, all->list[i].table_count * sizeof(double));
        if (term.count)
            memcpy(m->table + end, all->list[i].coefficients, (size_t)term.count * sizeof(double));
        memcpy(m->table + CPM_TERM * i, &term, sizeof term);
        at += lines(all->list[i].table_count);
        end += (size_t)term.count;
        m->dispersive |= term.scaling != CPM_SCALE_NONE;
    }
    m->by_wavelength = m->dispersive;
}

static cpm_status make(cpm_context *context, const summands *all, cpm_medium **medium) {
    cpm_medium_data data = {.kind = CPM_MEDIUM_SUM, .size = {(int32_t)all->count, 0, 0}};
    size_t coefficients = 0;
    for (size_t i = 0; i < all->count; i++) coefficients += (size_t)all->list[i].term.count;
    measure(&data, all);
    cpm_status status = cpm_medium_make(context, &data, lines(CPM_TERM * all->count) + all->tables + coefficients, NULL,
                                        medium);
    if (status != CPM_OK) return status;
    fill(*medium, all);
    if (!data.uniform) return CPM_OK;
    /* The same everywhere at every wavelength: what a homogeneous medium is. */
    double n = cpm_medium_n(*medium, 1.0, (const double[3]){0.0, 0.0, 0.0});
    cpm_medium_release(*medium);
    *medium = NULL;
    return cpm_medium_create_homogeneous(context, n, NULL, medium);
}

cpm_status cpm_medium_create_sum(cpm_context *context, cpm_medium *const *terms, size_t count, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!terms) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "terms is NULL");
    if (count < 1 || count > CPM_MAX_TERMS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is %zu; must be 1 to %d terms", count,
                        CPM_MAX_TERMS);
    summand list[CPM_MAX_TERMS];
    summands all = {.list = list};
    for (size_t i = 0; i < count; i++) {
        if (!terms[i]) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "terms[%zu] is NULL", i);
        if (cpm_medium_needs_exact(terms[i]))
            return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                            "terms[%zu] is of discrete layers (step), which have no gradient; they cannot be in a sum",
                            i);
        add_medium(&all, terms[i]);
    }
    if (all.count > CPM_MAX_TERMS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "the sum has %zu terms; at most %d are allowed", all.count,
                        CPM_MAX_TERMS);
    return make(context, &all, medium);
}

uint32_t cpm_medium_kinds(const cpm_medium *medium) {
    uint32_t kinds = UINT32_C(1) << medium->data.kind;
    for (int32_t i = 0; medium->data.kind == CPM_MEDIUM_SUM && i < medium->data.size[0]; i++) {
        cpm_term term;
        memcpy(&term, medium->table + CPM_TERM * i, sizeof term);
        kinds |= UINT32_C(1) << term.data.kind;
    }
    return kinds;
}

cpm_status cpm_sum_check(cpm_context *context, const cpm_medium *medium, double wavelength) {
    if (medium->data.kind != CPM_MEDIUM_SUM) return CPM_OK;
    for (int32_t i = 0; i < medium->data.size[0]; i++) {
        cpm_term term;
        memcpy(&term, medium->table + CPM_TERM * i, sizeof term);
        if (term.scaling != CPM_SCALE_WAVELENGTH) continue;
        cpm_dispersion d = {.struct_size = sizeof d,
                            .kind = term.dispersion,
                            .count = term.count,
                            .low = term.low,
                            .high = term.high};
        memcpy(d.coefficients, medium->table + term.coefficients, (size_t)term.count * sizeof(double));
        double n = 1.0;
        cpm_status status = cpm_dispersion_check(context, &d, wavelength, &n);
        if (status != CPM_OK) return status;
    }
    return CPM_OK;
}
