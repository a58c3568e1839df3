/* backend/opencl/photons_buffers.c: see photons_buffers.h. */
#include "photons_buffers.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "follow.h"
#include "program.h"

#define SHARE_CPU 512 /* flights of an item: its segments stay in a processor's second cache */
#define SLOTS_ELSEWHERE 65536
#define SHARE_ELSEWHERE 16 /* where an item is a thread */

/* ------------------------------------------------------------------------------------------------------- kernels */

/* Bits of the kinds of all media that bend rays: what n at a point may be asked of. */
static unsigned kinds_of(const cpm_pass *pass) {
    unsigned kinds = 1u << CPM_MEDIUM_HOMOGENEOUS;
    for (size_t m = 0; m < pass->scene->medium_count; m++)
        if (pass->way[m] != CPM_WAY_STRAIGHT) kinds |= (unsigned)cpm_medium_kinds(pass->scene->media[m].medium);
    return kinds;
}

cpm_status cpm_photon_kernels_of(const cpm_pass *pass, const cpm_emitter *emitters, size_t count,
                                 cpm_photon_kernels *k) {
    cpm_context *context = pass->context;
    char options[256], media[64];
    int area = 0, delta = 0;
    cpm_status status = CPM_OK;
    memset(k, 0, sizeof *k);
    for (size_t i = 0; i < count; i++)
        if (emitters[i].count) *(emitters[i].light->kind == CPM_LIGHT_AREA ? &area : &delta) = 1;
    snprintf(media, sizeof media, "-DCPM_MEDIA=%u", kinds_of(pass));
    cpm_opencl_options(context->opencl, 8, "", options, sizeof options);
    if (delta) status = cpm_program_kernel(context, "start_delta", "cpm_start_delta", options, &k->start_delta);
    if (!status) status = cpm_program_kernel(context, "meet", "cpm_meet", options, &k->meet);
    cpm_opencl_options(context->opencl, 8, media, options, sizeof options);
    if (!status && area) status = cpm_program_kernel(context, "start_area", "cpm_start_area", options, &k->start_area);
    cpm_opencl_options(context->opencl, 1, media, options, sizeof options);
    if (!status && (pass->features & (CPM_FEATURE_SPECULAR | CPM_FEATURE_BOUNDARIES)))
        status = cpm_program_kernel(context, "specular", "cpm_specular", options, &k->specular);
    return status;
}

/* --------------------------------------------------------------------------------------------------------- sizes */

static void derive(cpm_photon_sizes *s, int parts) {
    s->stride = s->fresh * (parts ? s->bins : 1);
    s->stage = CPM_WAVES * s->stride;
    s->halves = parts ? s->stage : s->stage * s->bins;
}

/* The largest buffer, and all of them. */
static uint64_t bytes_of(const cpm_photon_sizes *s, uint64_t *largest) {
    const uint64_t slots = (uint64_t)s->items * (uint64_t)s->stride, staged = (uint64_t)s->items * (uint64_t)s->stage;
    const uint64_t powers = slots * (uint64_t)s->bins * sizeof(float), flights = slots * sizeof(cpm_flight);
    const uint64_t arrivals = slots * sizeof(cpm_arrival), photons = staged * sizeof(cpm_photon);
    const uint64_t spectra = (uint64_t)s->items * (uint64_t)s->halves * 2;
    const uint64_t each[] = {powers, flights, arrivals, photons, spectra};
    *largest = 0;
    for (size_t i = 0; i < sizeof each / sizeof *each; i++)
        if (each[i] > *largest) *largest = each[i];
    return 2 * (powers + flights + slots * sizeof(cpm_walker)) + arrivals + 2 * (photons + spectra);
}

cpm_status cpm_photon_sizes_of(const cpm_pass *pass, uint64_t photons, int32_t batch, uint64_t taken,
                               cpm_photon_sizes *s) {
    const cpm_opencl *o = pass->context->opencl;
    const int parts = (pass->features & CPM_FEATURE_DISPERSION) != 0;
    const uint64_t most = cpm_opencl_budget(o);
    memset(s, 0, sizeof *s);
    s->bins = (cl_int)pass->bins;
    s->items = o->is_cpu ? (size_t)o->units * CPM_ITEMS_A_UNIT : SLOTS_ELSEWHERE / SHARE_ELSEWHERE;
    s->fresh = o->is_cpu ? SHARE_CPU : SHARE_ELSEWHERE;
    if (parts) s->fresh = s->fresh / s->bins > 8 ? s->fresh / s->bins : 8;
    if (batch > 0) {
        while (s->items > 1 && s->items > (size_t)batch) s->items /= 2;
        s->fresh = (cl_int)(((size_t)batch + s->items - 1) / s->items);
    }
    if ((uint64_t)s->fresh > photons / s->items + 1) s->fresh = (cl_int)(photons / s->items + 1);
    for (;;) {
        uint64_t largest, bytes;
        derive(s, parts);
        bytes = bytes_of(s, &largest) + taken;
        if (bytes <= most && largest <= o->largest && largest / (uint64_t)s->items < INT32_MAX) return CPM_OK;
        if (s->fresh > 1)
            s->fresh /= 2;
        else if (s->items > 1)
            s->items /= 2;
        else
            return cpm_fail(
                pass->context, CPM_ERROR_OUT_OF_MEMORY,
                "OpenCL device '%s': the scene takes %.1f MB and one path %.1f MB more, but only %.1f MB may "
                "be used; allow more memory, or use another device or the native backend",
                o->name, 1e-6 * (double)taken, 1e-6 * (double)(bytes - taken), 1e-6 * (double)most);
    }
}

/* ------------------------------------------------------------------------------------------------------- buffers */

typedef struct maker { /* makes buffers until one cannot be had */
    const cpm_opencl *opencl;
    cl_int code;
} maker;

static cl_mem made(maker *m, size_t count, size_t size, const void *contents) {
    if (m->code != CL_SUCCESS) return NULL;
    const cl_mem_flags flags = contents ? CL_MEM_READ_ONLY : CL_MEM_READ_WRITE;
    return cpm_opencl_buffer(m->opencl, flags, count * size, contents, &m->code);
}

static void open_emitter(maker *m, const cpm_pass *pass, const cpm_emitter *e, cpm_emitter_buffers *b) {
    const cpm_projection *p = &e->projection;
    const size_t cells = (size_t)p->rows * (size_t)p->columns;
    const int area = e->light->kind == CPM_LIGHT_AREA;
    static const double nothing = 0.0;
    b->data = made(m, 1, sizeof e->data, &e->data);
    b->spectrum = made(m, pass->bins, sizeof *e->weight, e->weight);
    if (area) {
        b->area = made(m, e->area ? (size_t)e->data.triangles + 1 : 1, sizeof(double), e->area ? e->area : &nothing);
        return;
    }
    b->cumulative = made(m, cells ? cells + 1 : 1, sizeof(double), cells ? p->cumulative : &nothing);
    b->guide = made(m, cells ? cells : 1, sizeof(int32_t), cells ? (const void *)p->guide : &nothing);
    b->weight = made(m, cells ? cells : 1, sizeof(float), cells ? (const void *)p->weight : &nothing);
    b->region = made(m, 1, sizeof e->region, &e->region);
}

static void open_surfaces(maker *m, const cpm_pass *pass, const float *shares, cpm_photon_buffers *b) {
    const size_t materials = pass->scene->material_count + 1;
    static const float one = 1.0f;
    cpm_dither_table dither;
    cpm_dither_table_fill(&dither);
    b->reflectance = made(m, materials * pass->bins, sizeof(float), pass->reflectance);
    b->shares = made(m, pass->scene->material_count * pass->bins + 1, sizeof(float), shares);
    b->largest = made(m, materials, sizeof(float), pass->reflectance_max);
    b->one = made(m, 1, sizeof one, &one);
    b->multiply = made(m, CPM_DITHER_BINS, sizeof(uint32_t), dither.multiply);
    b->add = made(m, CPM_DITHER_BINS, sizeof(uint32_t), dither.add);
}

cpm_status cpm_photon_buffers_open(const cpm_pass *pass, const cpm_emitter *emitters, size_t count,
                                   const cpm_photon_sizes *s, const cpm_tally *tallies, cpm_photon_buffers *b) {
    cpm_context *context = pass->context;
    maker m = {context->opencl, CL_SUCCESS};
    const size_t slots = s->items * (size_t)s->stride, row = CPM_ENERGY_ROWS * pass->bins;
    float *shares = cpm_surface_shares(pass);
    double *zeros = calloc(s->items * row + 1, sizeof *zeros);
    cl_int *none = calloc(s->items + 1, sizeof *none);
    memset(b, 0, sizeof *b);
    b->emitters = calloc(count + 1, sizeof *b->emitters);
    b->emitter_count = b->emitters ? count : 0;
    const int fine = shares && zeros && none && b->emitters;
    for (int k = 0; k < 2 && fine; k++) {
        b->side[k].flights = made(&m, slots, sizeof(cpm_flight), NULL);
        b->side[k].walkers = made(&m, slots, sizeof(cpm_walker), NULL);
        b->side[k].powers = made(&m, slots * pass->bins, sizeof(float), NULL);
        if (m.code == CL_SUCCESS) /* written to, and zero at first */
            b->side[k].counts = cpm_opencl_buffer(m.opencl, CL_MEM_READ_WRITE, s->items * sizeof *none, none, &m.code);
    }
    if (fine) {
        b->arrivals = made(&m, slots, sizeof(cpm_arrival), NULL);
        for (int k = 0; k < 2; k++) {
            b->photons[k] = made(&m, s->items * (size_t)s->stage, sizeof(cpm_photon), NULL);
            b->spectra[k] = made(&m, s->items * (size_t)s->halves, sizeof(uint16_t), NULL);
        }
        if (m.code == CL_SUCCESS)
            b->tallies = cpm_opencl_buffer(m.opencl, CL_MEM_READ_WRITE, s->items * sizeof *tallies, tallies, &m.code);
        if (m.code == CL_SUCCESS)
            b->energies =
                cpm_opencl_buffer(m.opencl, CL_MEM_READ_WRITE, s->items * row * sizeof *zeros, zeros, &m.code);
        open_surfaces(&m, pass, shares, b);
        for (size_t i = 0; i < count; i++)
            if (emitters[i].count) open_emitter(&m, pass, &emitters[i], &b->emitters[i]);
    }
    free(shares), free(zeros), free(none);
    if (!fine) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the photon pass");
    return m.code == CL_SUCCESS ? CPM_OK : cpm_opencl_failed(context, m.opencl, "making buffers", m.code);
}

void cpm_photon_buffers_close(const cpm_opencl *o, cpm_photon_buffers *b) {
    const cl_mem own[] = {b->side[0].flights,
                          b->side[0].walkers,
                          b->side[0].powers,
                          b->side[0].counts,
                          b->side[1].flights,
                          b->side[1].walkers,
                          b->side[1].powers,
                          b->side[1].counts,
                          b->arrivals,
                          b->tallies,
                          b->energies,
                          b->photons[0],
                          b->photons[1],
                          b->spectra[0],
                          b->spectra[1],
                          b->reflectance,
                          b->shares,
                          b->largest,
                          b->one,
                          b->multiply,
                          b->add};
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (own[i]) o->cl->ReleaseMemObject(own[i]);
    for (size_t i = 0; i < b->emitter_count; i++) {
        const cpm_emitter_buffers *e = &b->emitters[i];
        const cl_mem of[] = {e->data, e->cumulative, e->guide, e->weight, e->area, e->spectrum, e->region};
        for (size_t k = 0; k < sizeof of / sizeof *of; k++)
            if (of[k]) o->cl->ReleaseMemObject(of[k]);
    }
    free(b->emitters);
    memset(b, 0, sizeof *b);
}
#endif
