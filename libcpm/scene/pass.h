/* scene/pass.h: a scene at given wavelengths: everything looked up once, before any ray runs. */
#ifndef CPM_SCENE_PASS_H
#define CPM_SCENE_PASS_H
#include "cl/types/sky.h"
#include "cl/shared/bins.h"
#include "cl/shared/region.h"
#include "scene.h"

/* How rays run in a medium. */
typedef enum cpm_way {
    CPM_WAY_STRAIGHT = CPM_STRAIGHT_WAY,
    CPM_WAY_EXACT = CPM_EXACT_WAY,
    CPM_WAY_INTEGRATED = CPM_INTEGRATED_WAY
} cpm_way;

typedef struct cpm_pass {
    cpm_context *context; /* the call's: threads, progress, messages */
    cpm_scene *scene;
    const cpm_geometry *geometry;
    cpm_scene_options options; /* method and tolerances: the scene's, or a request's own */
    size_t bins;
    double *wavelengths;    /* bins */
    int32_t middle;         /* the bin that stands for a whole bundle where nothing disperses */
    float *reflectance;     /* materials x bins */
    float *reflectance_max; /* materials */
    double *scale;          /* media x bins: dispersion factor */
    double *index;          /* media x bins: n of uniform media */
    uint8_t *disperses;     /* media: n differs between the bins */
    uint8_t *way;           /* media: cpm_way */
    uint8_t *method;        /* media: cpm_method that runs */
    double *extinction;     /* media x bins: over n - 1, 1/m; NULL: nothing dims */
    double *emission;       /* lights x bins; of an image its mean over all directions */
    struct cpm_sky *sky;    /* lights: what suns and environments look like; NULL: there are none */
    cpm_box extent;
    cpm_box box;     /* of the geometry */
    double reach;    /* a good length of one curved piece, metres: the geometry's diagonal */
    cpm_vec center;  /* of the geometry: pieces that start far from it may be as long as that is far */
    double nudge;    /* metres: far below the geometry, far above rounding */
    int32_t bounded; /* the extent is finite */
    double bundle_tolerance; /* of a pixel, and of a photon's share of surface: how far bins may part and go one way */
    int32_t nearest;         /* photons whose share that is */
    uint32_t features;
    cpm_world world; /* the same as rays see it: what cl/shared reads */
} cpm_pass;

cpm_status cpm_pass_begin(cpm_context *context, cpm_scene *scene, const double *wavelengths, size_t bins,
                          cpm_pass *pass);
/* The same with other methods or tolerances than the scene's. */
cpm_status cpm_pass_begin_with(cpm_context *context, cpm_scene *scene, const cpm_scene_options *options,
                               const double *wavelengths, size_t bins, cpm_pass *pass);
void cpm_pass_end(cpm_pass *pass);
/* A request's bundle_tolerance, and the photons of an estimate. */
cpm_status cpm_pass_take_bundles(cpm_pass *pass, double tolerance, int32_t nearest);
cpm_status cpm_check_wavelengths(cpm_context *context, const double *wavelengths, size_t count);

/* What contains a point; on a boundary, what `direction` enters. */
cpm_region cpm_region_at(const cpm_pass *pass, cpm_vec point, cpm_vec direction);

/* A sun or an environment at the pass's wavelengths (sky.c). */
typedef struct cpm_sky {
    cpm_sky_data data;
    double *limb;  /* bins x 6: of the radiance over its mean */
    float *pixels; /* height x width x bins */
} cpm_sky;
cpm_status cpm_sky_begin(cpm_pass *pass);
void cpm_sky_end(cpm_pass *pass);
/* Basic radiance seen in a unit direction at the extent, bins [first, first + count); 0: none of this light. */
int cpm_sky_radiance(const cpm_pass *pass, size_t light, cpm_vec direction, size_t first, size_t count,
                     double *radiance);
/* Bundles may stay together where a medium disperses (backend/native/bundles.h). */
static inline int cpm_pass_bundles(const cpm_pass *pass) {
    return pass->bundle_tolerance > 0.0 && (pass->features & CPM_FEATURE_DISPERSION);
}

/* The bin whose way a flight goes (cl/shared/bins.h). */
static inline size_t cpm_pass_bin(const cpm_pass *pass, int32_t bin) {
    return (size_t)cpm_bins_middle(bin, (int32_t)pass->bins);
}

/* n at a point of a medium, for a bin (-1: the bundle). */
double cpm_pass_index(const cpm_pass *pass, int32_t medium, int32_t bin, cpm_vec point);
#endif
