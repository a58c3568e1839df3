/* photon/map.h: a photon map: k nearest photons and the irradiance that they carry.
 *
 * Internal. One tree holds one population (direct, later or caustic photons); a public map is one tree or two. */
#ifndef CPM_PHOTON_MAP_H
#define CPM_PHOTON_MAP_H
#include "api/context.h"
#include "cl/types/photon.h"

typedef struct cpm_map_tree cpm_map_tree;

/* Builds a tree over `count` photons, parallel, O(N log N) or better; takes ownership of both arrays, which `release`
 * (free, or cpm_pages_free) frees (also on failure). `spectra` holds `spectra_count` half floats, addressed by
 * photon.spectrum; both are reordered so that neighbours in space are neighbours in memory. The result depends on the
 * set of photons only: not on their order (ties of the sort key fall to (path, bounce, bin)), not on the number of
 * threads. `scale`: W/nm of a half-float 1. count = 0 is allowed: a tree of no bytes. */
cpm_status cpm_tree_build(cpm_context *context, cpm_photon *photons, uint16_t *spectra, size_t count,
                          size_t spectra_count, void (*release)(void *), size_t bins, double scale,
                          cpm_map_tree **tree);
void cpm_tree_free(cpm_map_tree *tree);

size_t cpm_tree_count(const cpm_map_tree *tree);
size_t cpm_tree_bytes(const cpm_map_tree *tree);              /* all that it holds */
const cpm_photon *cpm_tree_photons(const cpm_map_tree *tree); /* in the tree's order */
const uint16_t *cpm_tree_spectra(const cpm_map_tree *tree);
double cpm_tree_scale(const cpm_map_tree *tree);

/* Scratch of one thread. `radius` remembers the last query's, as a first guess for the next: it changes the cost, never
 * the result. */
typedef struct cpm_map_query cpm_map_query;
cpm_map_query *cpm_query_create(const cpm_map_tree *tree); /* NULL: out of memory */
void cpm_query_free(cpm_map_query *query);

/* Irradiance at a point (metres from the map's origin) on the side of the unit normal, W/m2/nm, ADDED to
 * irradiance[bins]. E = sum(the k - 1 nearer)/(pi r_k^2); fewer than k within max_radius: all of them over pi
 * max_radius^2. A photon counts (also among the k) if its stored normal is within 60 degrees of `normal`.
 * "Nearer" is by the squared distance in single precision as cl/shared/gather.h rounds it, then by (path, bounce, bin):
 * the result is the same to the last bit for any order of photons, threads, queries and instruction set. r_k is held at
 * the spacing of floats at the point (many photons in one point: the estimate is large, never infinite).
 * Returns the radius used; 0, and nothing is added, for an empty tree, for max_radius <= 0 or NaN, or where k is above
 * 1024 and there is no memory for it. */
double cpm_tree_irradiance(const cpm_map_tree *tree, cpm_map_query *query, const float *point, const float *normal,
                           int32_t k, double max_radius, double *irradiance);

/* r_k itself (of photons within 60 degrees as above; 0 where k photons share the point), max_radius where there are
 * fewer. */
double cpm_tree_radius(const cpm_map_tree *tree, cpm_map_query *query, const float *point, const float *normal,
                       int32_t k, double max_radius);
#endif
