/* photon/photons.c: the photon pass from a scene to maps, and what the public API tells of it. */
#include "photons.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/backend.h"
#include "cl/shared/bins.h"
#include "cl/shared/half.h"
#include "cl/shared/octahedral.h"
#include "pages.h"

#define USUAL_NEAREST 150 /* photons of an estimate, where it is not known yet */
#define FAR_OFF 1e4 /* metres of diagonal: half of it, by a float's 24 bits, is 0.3 mm */

void cpm_photons_retain(cpm_photons *photons) {
    if (photons) atomic_fetch_add(&photons->references, 1);
}

void cpm_photons_release(cpm_photons *photons) {
    if (!photons || atomic_fetch_sub(&photons->references, 1) != 1) return;
    for (int p = 0; p < CPM_POPULATIONS; p++) cpm_tree_free(photons->trees[p]);
    free(photons->wavelengths), free(photons->energy);
    cpm_context_release(photons->context);
    free(photons);
}

static double box_diagonal(cpm_box box) {
    double sum = 0.0;
    for (int k = 0; k < 3; k++)
        if (box.high[k] > box.low[k]) sum += (box.high[k] - box.low[k]) * (box.high[k] - box.low[k]);
    return sqrt(sum);
}

/* What positions are told from, in float: the middle of the geometry, or, where that is so far off that it would cost a
 * millimetre (on a planet's ground), the camera, which sees what is near it the sharpest, or a light. */
static cpm_vec origin_of(const cpm_pass *pass, cpm_box box, double diagonal) {
    const cpm_scene *scene = pass->scene;
    if (!(box.low[0] <= box.high[0])) return cpm_v(0.0, 0.0, 0.0);
    if (diagonal > FAR_OFF) {
        const double *c = scene->camera.origin;
        if (scene->has_camera) return cpm_v(c[0], c[1], c[2]);
        for (size_t i = 0; i < scene->light_count; i++)
            if (scene->lights[i].kind != CPM_LIGHT_AREA && !cpm_light_is_far(&scene->lights[i]))
                return scene->lights[i].position;
    }
    return cpm_v(0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1]), 0.5 * (box.low[2] + box.high[2]));
}

static cpm_photons *photons_new(const cpm_pass *pass) {
    cpm_photons *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    atomic_init(&p->references, 1);
    p->context = pass->context;
    cpm_context_retain(p->context);
    p->bins = pass->bins;
    p->wavelengths = malloc(pass->bins * sizeof *p->wavelengths);
    p->energy = calloc(CPM_ENERGY_ROWS * pass->bins, sizeof *p->energy);
    p->stats.struct_size = sizeof p->stats;
    p->stats.features = pass->features;
    cpm_box box = cpm_geometry_box(pass->geometry);
    p->diagonal = box_diagonal(box);
    p->origin = origin_of(pass, box, p->diagonal);
    if (!p->wavelengths || !p->energy) {
        cpm_photons_release(p);
        return NULL;
    }
    memcpy(p->wavelengths, pass->wavelengths, pass->bins * sizeof *p->wavelengths);
    return p;
}

/* build map: one tree a population; those that are empty hold nothing. */
static cpm_status build_maps(cpm_photons *p, cpm_store stores[CPM_POPULATIONS], double scale) {
    uint64_t *counts[] = {&p->stats.photons_stored_direct, &p->stats.photons_stored_later,
                          &p->stats.photons_stored_caustic};
    uint64_t *bytes[] = {&p->stats.bytes_diffuse, &p->stats.bytes_diffuse, &p->stats.bytes_caustic};
    cpm_status status = CPM_OK;
    for (int i = 0; i < CPM_POPULATIONS && !status; i++) {
        *counts[i] = stores[i].count;
        status = cpm_tree_build(p->context, stores[i].photons, stores[i].spectra, stores[i].count,
                                stores[i].spectra_count, cpm_pages_free, p->bins, scale, &p->trees[i]);
        memset(&stores[i], 0, sizeof stores[i]); /* the tree owns them, also on failure */
        if (!status && *counts[i]) *bytes[i] += cpm_tree_bytes(p->trees[i]);
        if (!status && cpm_progress(p->context, "map", (i + 1) / (double)CPM_POPULATIONS))
            status = cpm_fail(p->context, CPM_ERROR_CANCELLED, "cancelled while building the photon maps");
    }
    return status;
}

cpm_status cpm_photons_run(const cpm_pass *pass, const cpm_photons_options *o, cpm_photons **photons) {
    cpm_context *context = pass->context;
    cpm_emitter *emitters = NULL;
    size_t emitter_count = 0;
    double scale = 0.0, start = cpm_seconds();
    cpm_store stores[CPM_POPULATIONS] = {0};
    cpm_photons *p = photons_new(pass);
    *photons = NULL;
    if (!p) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for photon maps");

    cpm_status status =
        cpm_emitters_create(pass, o->photons, o->seed, !o->no_projection, &emitters, &emitter_count, &scale, &p->stats);
    double projected = cpm_seconds();
    if (!status)
        status = cpm_backend_of(context)->photons(pass, emitters, emitter_count, o->photons, o->seed, o->batch,
                                                  p->origin, stores, p->energy, &p->stats);
    cpm_emitters_free(emitters, emitter_count);
    double traced = cpm_seconds();
    if (!status) status = build_maps(p, stores, scale);
    for (int i = 0; i < CPM_POPULATIONS; i++) cpm_store_free(&stores[i]);
    for (size_t i = 0; i < CPM_ENERGY_ROWS * p->bins; i++)
        p->energy[i] *= i / p->bins == CPM_VARIANCE ? scale * scale : scale;
    p->stats.seconds_project = projected - start;
    p->stats.seconds_trace = traced - projected;
    p->stats.seconds_map = cpm_seconds() - traced;
    p->stats.seconds_total = cpm_seconds() - start;
    if (status)
        cpm_photons_release(p);
    else
        *photons = p;
    return status;
}

cpm_status cpm_photons_trace(cpm_context *context, cpm_scene *scene, const cpm_photons_options *options,
                             cpm_photons **photons) {
    if (photons) *photons = NULL;
    if (!context || !scene || !options || !photons)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "context, scene, options and photons must not be NULL");
    cpm_photons_options o;
    CPM_TAKE(o, options);
    cpm_status status = cpm_check_wavelengths(context, o.wavelengths, o.wavelength_count);
    if (status) return status;
    if (o.photons > 0xFFFFFFFFu)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "photons is %llu; allowed: 0 to 4294967295",
                        (unsigned long long)o.photons);
    if (o.batch < 0 || o.batch > 1 << 20)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "batch is %d; allowed: 0 to 1048576", o.batch);
    cpm_progress_begin(context);
    double start = cpm_seconds();
    cpm_pass pass;
    status = cpm_pass_begin(context, scene, o.wavelengths, o.wavelength_count, &pass);
    if (status) return status;
    double prepared = cpm_seconds() - start;
    status = cpm_pass_take_bundles(&pass, o.bundle_tolerance, USUAL_NEAREST);
    if (!status) status = cpm_photons_run(&pass, &o, photons);
    if (!status) {
        (*photons)->stats.seconds_prepare = prepared;
        (*photons)->stats.seconds_total += prepared;
    }
    cpm_pass_end(&pass);
    return status;
}

static int trees_of(cpm_map map, int *first) {
    *first = map == CPM_MAP_CAUSTIC ? CPM_CAUSTIC : CPM_DIRECT;
    return map == CPM_MAP_CAUSTIC ? CPM_CAUSTIC : CPM_LATER;
}

size_t cpm_photons_count(const cpm_photons *photons, cpm_map map) {
    if (!photons || (map != CPM_MAP_DIFFUSE && map != CPM_MAP_CAUSTIC)) return 0;
    int first, last = trees_of(map, &first);
    size_t count = 0;
    for (int i = first; i <= last; i++) count += cpm_tree_count(photons->trees[i]);
    return count;
}

size_t cpm_photons_bins(const cpm_photons *photons) { return photons ? photons->bins : 0; }

static void read_tree(const cpm_photons *p, const cpm_map_tree *tree, size_t offset, const cpm_photons_arrays *to) {
    const cpm_photon *all = cpm_tree_photons(tree);
    const uint16_t *spectra = cpm_tree_spectra(tree);
    const double scale = cpm_tree_scale(tree);
    for (size_t i = 0; i < cpm_tree_count(tree); i++) {
        const cpm_photon *from = &all[i];
        size_t at = offset + i;
        const double origin[3] = {p->origin.x, p->origin.y, p->origin.z};
        if (to->position)
            for (int k = 0; k < 3; k++)
                to->position[3 * at + (size_t)k] = (float)(origin[k] + (double)from->position[k]);
        if (to->direction) {
            cpm_vec d = cpm_octahedral_decode(from->direction);
            to->direction[3 * at] = (float)d.x, to->direction[3 * at + 1] = (float)d.y;
            to->direction[3 * at + 2] = (float)d.z;
        }
        if (to->power)
            for (size_t b = 0; b < p->bins; b++) {
                const size_t first = cpm_photon_first(from->bin);
                int carries = b >= first && b < first + cpm_photon_count(from->bin, (uint32_t)p->bins);
                size_t s = from->spectrum + (carries ? b - first : 0);
                to->power[at * p->bins + b] = carries ? (float)(scale * (double)cpm_half_to_float(spectra[s])) : 0.0f;
            }
        if (to->wavelength)
            for (size_t b = 0; b < p->bins; b++) to->wavelength[at * p->bins + b] = p->wavelengths[b];
        if (to->bounce) to->bounce[at] = from->bounce;
    }
}

cpm_status cpm_photons_read(const cpm_photons *photons, cpm_map map, cpm_photons_arrays *arrays) {
    if (!photons || !arrays || (map != CPM_MAP_DIFFUSE && map != CPM_MAP_CAUSTIC)) return CPM_ERROR_INVALID_ARGUMENT;
    cpm_photons_arrays a;
    CPM_TAKE(a, arrays);
    size_t offset = 0;
    int first, last = trees_of(map, &first);
    for (int i = first; i <= last; i++) {
        read_tree(photons, photons->trees[i], offset, &a);
        offset += cpm_tree_count(photons->trees[i]);
    }
    return CPM_OK;
}

cpm_status cpm_photons_energy(const cpm_photons *photons, double *emitted, double *roulette_gain, double *absorbed,
                              double *escaped, double *roulette_loss) {
    if (!photons) return CPM_ERROR_INVALID_ARGUMENT;
    const size_t size = photons->bins * sizeof(double);
    double *to[] = {emitted, roulette_gain, absorbed, escaped, roulette_loss};
    for (size_t row = 0; row < 5; row++)
        if (to[row]) memcpy(to[row], &photons->energy[row * photons->bins], size);
    return CPM_OK;
}

cpm_status cpm_photons_roulette_variance(const cpm_photons *photons, double *variance) {
    if (!photons || !variance) return CPM_ERROR_INVALID_ARGUMENT;
    memcpy(variance, &photons->energy[CPM_VARIANCE * photons->bins], photons->bins * sizeof(double));
    return CPM_OK;
}

cpm_status cpm_photons_stats(const cpm_photons *photons, cpm_stats *stats) {
    if (!photons || !stats || stats->struct_size < sizeof(size_t)) return CPM_ERROR_INVALID_ARGUMENT;
    size_t size = stats->struct_size < sizeof *stats ? stats->struct_size : sizeof *stats;
    memcpy(stats, &photons->stats, size);
    stats->struct_size = size;
    return CPM_OK;
}
