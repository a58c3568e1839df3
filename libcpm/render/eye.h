/* render/eye.h: eye rays and what they gather. Internal. */
#ifndef CPM_RENDER_EYE_H
#define CPM_RENDER_EYE_H
#include "cl/types/eye.h"
#include "photon/photons.h"
#include "render/image.h"

/* What a gather needs: the maps, how many photons, how far. One a render. */
typedef struct cpm_gather {
    const cpm_photons *photons;
    const cpm_geometry *geometry; /* NULL: no edge correction */
    int32_t nearest;
    double max_radius[CPM_POPULATIONS]; /* metres */
} cpm_gather;

/* gather.c: the caller's radius, or the default: direct light is capped at what its own photons ask for (or it would
 * blur into the shade), the rest at the scene's diagonal. */
cpm_status cpm_gather_begin(cpm_context *context, const cpm_photons *photons, const cpm_geometry *geometry,
                            int32_t nearest, double max_radius, cpm_gather *gather);
/* Scratch of one thread: a query a map. 0: out of memory. */
int cpm_gather_queries(const cpm_gather *gather, cpm_map_query *queries[CPM_POPULATIONS]);
void cpm_gather_queries_free(cpm_map_query *queries[CPM_POPULATIONS]);
/* Irradiance of all maps where an eye ray of the world has arrived, on the side that it came from; overwrites
 * irradiance[bins]. */
void cpm_gather_seen(const cpm_gather *gather, const cpm_world *world, cpm_map_query *queries[CPM_POPULATIONS],
                     const cpm_arrival *arrival, double *irradiance);
/* The order in which populations are searched: the widest discs first, mostly. */
extern const int cpm_gather_order[CPM_POPULATIONS];

/* eye_begin.c: the camera, and how surfaces look; cpm_eye_end after it, also where it fails. */
typedef struct cpm_eye_tables {
    cpm_eye eye;
    int32_t *shape_light;
    double squared_index[CPM_MAX_BINS];
} cpm_eye_tables;
cpm_status cpm_eye_begin(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                         const cpm_image *image, cpm_eye_tables *tables);
void cpm_eye_end(cpm_eye_tables *tables);

/* eye.c: traces and gathers the whole picture. */
cpm_status cpm_eye_pass(const cpm_pass *pass, const cpm_gather *gather, uint64_t seed, int32_t samples,
                        cpm_image *image);
#endif
