/* photon/photons.h: the photon pass's inside.
 *
 * project -> emit -> trace -> store -> build map. A photon's powers are floats relative to one scale, the mean power of
 * a path; so they stay near 1 and fit 16 bits when stored. */
#ifndef CPM_PHOTON_PHOTONS_H
#define CPM_PHOTON_PHOTONS_H
#include <stdatomic.h>

#include "backend/native/bundles.h"
#include "cl/types/photon.h"
#include "cl/types/walker.h"
#include "photon/map.h"
#include "photon/pass_lanes.h"
#include "photon/store.h"
#include "scene/pass.h"

/* Populations that are searched apart. */
enum {
    CPM_DIRECT = CPM_POPULATION_DIRECT,
    CPM_LATER = CPM_POPULATION_LATER,
    CPM_CAUSTIC = CPM_POPULATION_CAUSTIC,
    CPM_POPULATIONS = 3
};

/* Rows of the energy table, W/nm a bin. */
enum {
    CPM_EMITTED = CPM_ROW_EMITTED,
    CPM_GAIN = CPM_ROW_GAIN,
    CPM_ABSORBED = CPM_ROW_ABSORBED,
    CPM_ESCAPED = CPM_ROW_ESCAPED,
    CPM_LOSS = CPM_ROW_LOSS,
    CPM_VARIANCE = CPM_ROW_VARIANCE,
    CPM_ENERGY_ROWS = CPM_ROWS
};

struct cpm_photons {
    atomic_int references;
    cpm_context *context;
    size_t bins;
    double *wavelengths;
    cpm_vec origin;  /* subtracted from stored positions */
    double diagonal; /* of the scene: the default max_radius */
    cpm_map_tree *trees[CPM_POPULATIONS];
    double *energy; /* CPM_ENERGY_ROWS x bins */
    cpm_stats stats;
};

/* A light's directions cut into cells of equal solid angle, rows of cos theta by columns of azimuth about its axis. */
typedef struct cpm_projection {
    int32_t rows, columns;
    double *cumulative; /* cells + 1: probability that a cell's photons start below it */
    int32_t *guide;     /* cells: the cell that holds the lower end of each of as many equal parts of probability */
    float *weight;      /* cells: what keeps the estimate unbiased */
    uint64_t active, caustic;
} cpm_projection;

/* How the paths of one light start. */
typedef struct cpm_emitter {
    const light *light;
    cpm_emitter_data data;     /* what cl/shared/emit.h reads */
    uint64_t first, count;     /* its path numbers */
    float *weight;             /* bins: power of one of its paths over the scale */
    cpm_projection projection; /* no cells: all directions alike */
    cpm_region region;         /* where a point or spot light sits */
    double *area;              /* area light: cumulative area of its triangles */
    double power_factor;       /* area light: 1/mean n^2, so that a weight of 1 is the mean; far light: power of a path
                                  over the scale, per radiance and m2 of the box's shadow */
    size_t number;             /* of the light */
    cpm_box box;               /* far light: what its paths cross first */
    int32_t traced_back;       /* far light: what a path brings is found by tracing it back to the extent */
    cpm_pass *inside;          /* far light where light bends: the pass with the box for its extent; NULL: none */
} cpm_emitter;

/* project.c */
cpm_status cpm_project(const cpm_pass *pass, cpm_emitter *emitter, cpm_stats *stats);

/* emit.c */
cpm_status cpm_emitters_create(const cpm_pass *pass, uint64_t photons, uint64_t seed, int32_t project,
                               cpm_emitter **emitters, size_t *count, double *scale, cpm_stats *stats);
void cpm_emitters_free(cpm_emitter *emitters, size_t count);
/* Starts paths [path, path + count) of one emitter, count <= CPM_BLOCK: the number of those that carry anything, their
 * flights, path numbers, and the weight of each one's power. `made` is scratch. */
size_t cpm_emit(const cpm_pass *pass, const cpm_emitter *emitter, uint64_t path, size_t count, cpm_emissions *made,
                cpm_flight *flights, uint32_t *paths, float *weights);

/* far.c: suns and environments. A light's solid angle times the mean shadow of the box that its paths cross first times
 * n^2 there: 0 where there is nothing to shine on. Fills the emitter's data. */
cpm_status cpm_far_begin(const cpm_pass *pass, cpm_emitter *emitter, int32_t project, double *factor);
/* Starts paths [path, path + count), count <= CPM_BLOCK: the number of flights made, one a path, or one a path and bin
 * where the medium disperses; each with its path's number and its powers, pass->bins of them at i * bins, or the one of
 * its bin there. `arrivals` is scratch; all hold CPM_BLOCK x bins. */
size_t cpm_far_emit(const cpm_pass *pass, const cpm_emitter *emitter, uint64_t path, size_t count, cpm_emissions *made,
                    cpm_flight *flights, cpm_arrival *arrivals, uint32_t *paths, float *powers);
/* Powers of a path of weight 1 that starts so, over the scale: bins, e->weight or `own` filled in. */
const float *cpm_emit_spectrum(const cpm_pass *pass, const cpm_emitter *emitter, const cpm_flight *flight, float *own);

/* How far apart bins of one path may be and go one way: the pass's tolerance of the circle that `nearest` paths of this
 * light fill, one of them weighing `weight`, if nothing focuses them. */
cpm_leeway cpm_emitter_leeway(const cpm_pass *pass, const cpm_emitter *emitter, float weight);

/* trace.c: the pass itself, into per-population stores (opened here; the caller frees them, also on failure) and the
 * energy table (CPM_ENERGY_ROWS x bins, over the scale). */
cpm_status cpm_trace_paths(const cpm_pass *pass, const cpm_emitter *emitters, size_t emitter_count, uint64_t photons,
                           uint64_t seed, int32_t batch, cpm_vec origin, cpm_store stores[CPM_POPULATIONS],
                           double *energy, cpm_stats *stats);

/* Opens the stores, and says how many bytes photons may take; 0: no memory. */
uint64_t cpm_stores_open(int32_t threads, cpm_store stores[CPM_POPULATIONS]);
/* The failure where they take more. */
cpm_status cpm_stores_too_full(cpm_context *context, uint64_t photons, uint64_t most);
/* Reflectance over the largest of its material, for the survivors of roulette: materials x bins and one more, which the
 * caller frees; NULL: no memory. */
float *cpm_surface_shares(const cpm_pass *pass);

/* photons.c: everything from a pass to maps. */
cpm_status cpm_photons_run(const cpm_pass *pass, const cpm_photons_options *options, cpm_photons **photons);
#endif
