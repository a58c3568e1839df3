/* shared/path_specular.h: an item's paths at mirrors and boundaries; single rays in double. */
#ifndef CPM_SHARED_PATH_SPECULAR_H
#define CPM_SHARED_PATH_SPECULAR_H
#include "boundary.h"
#include "path_meet.h"

#if CPM_WIDTH == 1 && !CPM_SINGLE
CPM_INLINE cpm_random path_random(const cpm_meeting *m, const cpm_walker *w, cpm_i32 bin) {
    return cpm_philox(m->seed, w->path, cpm_scatter_block(w->bounce, w->crossings), CPM_STREAM_SCATTER,
                      cpm_scatter_bin(bin));
}

CPM_INLINE void path_meet_mirror(const cpm_meeting *m, cpm_walker w, const cpm_flight *f, const cpm_arrival *a,
                                 CPM_GLOBAL const float *powers, cpm_i32 material) {
    const cpm_roulette_rows rows = cpm_rows_of(m->energy, m->from->bins);
    cpm_paths *to = m->to;
    const cpm_vec facing = scatter_facing(world_normal(m->world, a->hit.primitive, a->hit.position), a->direction);
    const cpm_random r = path_random(m, &w, f->bin);
    cpm_powers p;
    cpm_play(&m->surfaces, to->bins, f->bin, material, powers, cpm_uniform(r.v[2]),
             to->powers + (size_t)to->count * (size_t)to->bins, &p);
    p.dither = 0;
    cpm_settle(&p, &m->steps, &rows);
    if (!p.alive) return;
    const cpm_flight on = world_depart(
        m->world, f, a, scatter_mirror(a->direction, world_shading_normal(m->world, &a->hit, facing), facing));
    cpm_walker_reflects(&w);
    cpm_paths_add(to, &w, &on);
}

/* One path, of one bin or all. */
CPM_INLINE void path_pass(const cpm_meeting *m, cpm_walker w, const cpm_flight *f, const cpm_arrival *a,
                          CPM_GLOBAL const float *powers) {
    const cpm_i32 bins = cpm_bins_count(f->bin, m->from->bins);
    cpm_passage passage;
    if (!world_pass_boundary(m->world, f, a, &passage)) {
        cpm_account(m->energy, CPM_ROW_ESCAPED, m->from->bins, f->bin, powers);
        m->tally->lost++;
        return;
    }
    const cpm_flight *on = &passage.transmitted;
    if (passage.jumps) {
        const cpm_random r = path_random(m, &w, f->bin);
        if (cpm_uniform(r.v[3]) < passage.reflectance) on = &passage.reflected;
        cpm_walker_reflects(&w);
    } else {
        w.crossings++;
    }
    CPM_GLOBAL float *kept = cpm_paths_add(m->to, &w, on);
    for (cpm_i32 b = 0; b < bins; b++) kept[b] = powers[b];
}

CPM_INLINE void path_meet_boundary(const cpm_meeting *m, const cpm_walker *w, cpm_flight *f, const cpm_arrival *a,
                                   CPM_GLOBAL const float *powers) {
    if (!world_splits(m->world, f, a)) {
        path_pass(m, *w, f, a, powers);
        return;
    }
    for (f->bin = 0; f->bin < m->from->bins; f->bin++) /* each wavelength its own way */
        if (powers[f->bin] != 0.0f) path_pass(m, *w, f, a, &powers[f->bin]);
}

CPM_INLINE void path_meet_specular(const cpm_meeting *m) {
    const cpm_paths *from = m->from;
    for (cpm_i32 i = 0; i < from->count; i++) {
        const cpm_walker w = from->walkers[i];
        if (path_ends(&w, m->arrivals[i].status)) continue;
        CPM_GLOBAL const cpm_surface *s = world_surface(m->world, m->arrivals[i].hit.primitive);
        if (s->kind <= CPM_SURFACE_DIFFUSE) continue;
        const cpm_arrival a = m->arrivals[i];
        CPM_GLOBAL const float *powers = from->powers + (size_t)i * (size_t)from->bins;
        cpm_flight f = from->flights[i];
        if (s->kind == CPM_SURFACE_MIRROR)
            path_meet_mirror(m, w, &f, &a, powers, s->material);
        else
            path_meet_boundary(m, &w, &f, &a, powers);
    }
}
#endif
#endif
