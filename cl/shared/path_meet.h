/* shared/path_meet.h: an item's paths where they have arrived: what libcpm/photon/trace.c does natively, on a device.
 */
#ifndef CPM_SHARED_PATH_MEET_H
#define CPM_SHARED_PATH_MEET_H
#include "meet.h"
#include "path.h"
#include "region.h"

typedef struct cpm_meeting {
    const cpm_world *world;
    const cpm_paths *from;
    cpm_paths *to;
    cpm_tally *tally;
    CPM_GLOBAL const cpm_arrival *arrivals;
    CPM_GLOBAL double *energy;
    cpm_surface_tables surfaces;
    cpm_dither_steps steps;
    CPM_GLOBAL cpm_photon *photons; /* stored by this item since the host last took them */
    CPM_GLOBAL unsigned short *spectra;
    cpm_vec origin;
    cpm_u64 seed;
} cpm_meeting;

/* Paths that met something diffuse or black. */
typedef struct cpm_lot {
    cpm_i32 which[CPM_WIDTH], material[CPM_WIDTH], count;
    int black[CPM_WIDTH];
} cpm_lot;

/* Has the path ended without meeting anything? */
CPM_INLINE int path_ends(const cpm_walker *w, cpm_i32 status) {
    return status != CPM_ARRIVAL_HIT || w->bounce >= CPM_MAX_BOUNCES || w->crossings == CPM_MAX_CROSSINGS;
}

CPM_INLINE void path_put(double (*p)[CPM_WIDTH], int i, cpm_vec v) { p[0][i] = v.x, p[1][i] = v.y, p[2][i] = v.z; }
CPM_INLINE real3 path_load(double (*p)[CPM_WIDTH]) {
    return triple(load_doubles(p[0], 0), load_doubles(p[1], 0), load_doubles(p[2], 0));
}
CPM_INLINE void path_keep(real3 v, double (*p)[CPM_WIDTH]) {
    store_doubles(v.x, p[0], 0), store_doubles(v.y, p[1], 0), store_doubles(v.z, p[2], 0);
}

/* Gives the photon a place; its powers are to follow. */
CPM_INLINE void path_store(const cpm_meeting *m, const cpm_walker *w, cpm_i32 bin, cpm_vec hit, cpm_u32 direction,
                           cpm_u32 normal, cpm_powers *p) {
    cpm_tally *t = m->tally;
    cpm_photon_pack(&m->photons[t->photons], cpm_sub(hit, m->origin), direction, normal,
                    (cpm_u32)cpm_population(w) << CPM_STAGED_POPULATION | (cpm_u32)t->halves, w->path, w->bounce, bin);
    p->spectrum = &m->spectra[t->halves];
    p->dither = cpm_dither_start(w->path, w->bounce, cpm_bins_stored(bin));
    t->photons++;
    t->halves += (cpm_i32)p->bins;
}

CPM_INLINE void path_meet_lot(const cpm_meeting *m, cpm_lot *lot) {
    double came[3][CPM_WIDTH], start[3][CPM_WIDTH], hit[3][CPM_WIDTH], normal[3][CPM_WIDTH], factor[CPM_WIDTH];
    double toward[3][CPM_WIDTH], from[3][CPM_WIDTH], chance[CPM_WIDTH];
    cpm_u32 path[CPM_WIDTH], block[CPM_WIDTH], bins[CPM_WIDTH], direction[CPM_WIDTH], side[CPM_WIDTH];
    const cpm_roulette_rows rows = cpm_rows_of(m->energy, m->from->bins);
    for (int k = 0; k < CPM_WIDTH; k++) { /* lanes that nobody uses: as the first */
        const cpm_i32 i = lot->which[k < lot->count ? k : 0];
        CPM_GLOBAL const cpm_arrival *a = &m->arrivals[i];
        CPM_GLOBAL const cpm_walker *w = &m->from->walkers[i];
        const cpm_vec at = a->hit.position;
        const cpm_facet facet = world_facet(m->world, a->hit.primitive, at);
        path_put(came, k, a->direction), path_put(start, k, m->from->flights[i].position), path_put(hit, k, at);
        path_put(normal, k, facet.normal);
        factor[k] = facet.factor;
        path[k] = w->path, block[k] = cpm_scatter_block(w->bounce, w->crossings);
        bins[k] = cpm_scatter_bin(m->from->flights[i].bin);
    }
    cpm_encounter e;
    e.came = path_load(came), e.start = path_load(start), e.hit = path_load(hit), e.normal = path_load(normal);
    e.factor = load_doubles(factor, 0);
    e.path = load_words(path, 0), e.block = load_words(block, 0), e.bin = load_words(bins, 0);
    const cpm_outcome o = scatter_meet(m->seed, m->world->tree.frame.scale, &e);
    path_keep(o.toward, toward), path_keep(o.from, from);
    store_doubles(o.chance, chance, 0);
    store_words(o.direction_code, direction, 0), store_words(o.normal_code, side, 0);
    for (int k = 0; k < lot->count; k++) {
        const cpm_i32 i = lot->which[k];
        CPM_GLOBAL const cpm_arrival *a = &m->arrivals[i];
        CPM_GLOBAL const cpm_flight *f = &m->from->flights[i];
        cpm_walker w = m->from->walkers[i];
        cpm_powers p;
        cpm_paths *to = m->to;
        const size_t many = (size_t)to->bins;
        cpm_play(&m->surfaces, to->bins, f->bin, lot->material[k], m->from->powers + (size_t)i * many, chance[k],
                 lot->black[k] ? (CPM_GLOBAL float *)0 : to->powers + (size_t)to->count * many, &p);
        path_store(m, &w, f->bin, a->hit.position, direction[k], side[k], &p);
        cpm_settle(&p, &m->steps, &rows);
        if (lot->black[k] || !p.alive) continue;
        CPM_GLOBAL cpm_flight *on = &to->flights[to->count];
        CPM_GLOBAL cpm_walker *next = &to->walkers[to->count++];
        next->path = w.path;
        next->bounce = (unsigned short)(w.bounce + 1);
        next->crossings = 0;
        next->specular = next->direct = 0;
        on->position = cpm_v(from[0][k], from[1][k], from[2][k]);
        on->direction = cpm_v(toward[0][k], toward[1][k], toward[2][k]);
        on->region = f->region;
        on->left = a->hit.primitive;
        on->bin = f->bin;
        cpm_hit there;
        there.primitive = a->hit.primitive, there.u = a->hit.u, there.v = a->hit.v;
        on->exact = cpm_is_near_edge(&m->world->tree, &there);
        on->crossing = 0;
    }
    lot->count = 0;
}

CPM_INLINE void path_meet(const cpm_meeting *m) {
    cpm_lot lot;
    cpm_tally *t = m->tally;
    const cpm_paths *from = m->from;
    lot.count = 0;
    t->segments += (cpm_u64)from->count;
    for (cpm_i32 i = 0; i < from->count; i++) {
        CPM_GLOBAL const cpm_arrival *a = &m->arrivals[i];
        const cpm_walker w = from->walkers[i];
        const cpm_i32 status = a->status;
        t->evaluations += a->evaluations;
        if (path_ends(&w, status)) {
            cpm_account(m->energy, CPM_ROW_ESCAPED, from->bins, from->flights[i].bin,
                        from->powers + (size_t)i * (size_t)from->bins);
            t->lost += status != CPM_ARRIVAL_LEFT;
            continue;
        }
        CPM_GLOBAL const cpm_surface *s = world_surface(m->world, a->hit.primitive);
        if (s->kind > CPM_SURFACE_DIFFUSE) continue;
        lot.which[lot.count] = i, lot.material[lot.count] = s->material;
        lot.black[lot.count] = s->kind == CPM_SURFACE_BLACK;
        if (++lot.count == CPM_WIDTH) path_meet_lot(m, &lot);
    }
    if (lot.count) path_meet_lot(m, &lot);
}
#endif
