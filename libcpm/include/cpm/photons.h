/* cpm/photons.h: the photon pass and its maps: caustic (L S+ D) and diffuse (everything else, direct light included). */
#ifndef CPM_PHOTONS_H
#define CPM_PHOTONS_H
#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cpm_photons cpm_photons;

typedef enum cpm_map { CPM_MAP_DIFFUSE = 0, CPM_MAP_CAUSTIC = 1 } cpm_map;

typedef struct cpm_photons_options {
    size_t struct_size;
    uint64_t photons; /* paths emitted over all lights, not stored; at most 4 294 967 295 */
    uint64_t seed;
    const double *wavelengths; /* bin centres, nm, strictly increasing */
    size_t wavelength_count;   /* 1..CPM_MAX_BINS */
    int32_t no_projection;     /* 1: emit over all directions */
    int32_t batch;             /* paths a task; 0: chosen. Results do not depend on it */
    double bundle_tolerance;   /* where a medium disperses: wavelengths whose paths meet a surface within so many radii of
                                  the circle that 150 photons of the light fill there, unfocused, share one path.
                                  0: each goes its own way. At most 100 */
} cpm_photons_options;

#define CPM_MAX_BINS 256

/* Seconds, work and bytes of a photon pass or a render. */
typedef struct cpm_stats {
    size_t struct_size;
    double seconds_prepare;  /* acceleration structures */
    double seconds_project;  /* projection maps */
    double seconds_trace;    /* emit, trace, store */
    double seconds_map;      /* building the maps */
    double seconds_gather;   /* eye rays and gather */
    double seconds_total;
    uint64_t photons_emitted;
    uint64_t photons_stored_direct; /* diffuse map, bounce 0 */
    uint64_t photons_stored_later;  /* diffuse map, bounce >= 1 */
    uint64_t photons_stored_caustic;
    uint64_t photon_segments;
    uint64_t photon_evaluations; /* of grad n^2 */
    uint64_t photons_lost;       /* paths ended by a status other than hit or left */
    uint64_t eye_rays;
    uint64_t eye_segments;
    uint64_t eye_evaluations;
    uint64_t gathers;
    uint64_t bytes_diffuse;
    uint64_t bytes_caustic;
    uint64_t projection_cells;         /* of the maps that were made */
    uint64_t projection_active;
    uint64_t projection_caustic_cells; /* 0 where there is nothing specular */
    uint64_t projection_caustic_active;
    uint32_t features;                 /* CPM_FEATURE_ */
    uint32_t reserved;
} cpm_stats;

CPM_API cpm_status cpm_photons_trace(cpm_context *context, cpm_scene *scene, const cpm_photons_options *options,
                                     cpm_photons **photons);
CPM_API void cpm_photons_retain(cpm_photons *photons);
CPM_API void cpm_photons_release(cpm_photons *photons);

CPM_API size_t cpm_photons_count(const cpm_photons *photons, cpm_map map);
CPM_API size_t cpm_photons_bins(const cpm_photons *photons);

/* Arrays of cpm_photons_count that the caller owns; any may be NULL. */
typedef struct cpm_photons_arrays {
    size_t struct_size;
    float *position;    /* x 3, metres */
    float *direction;   /* x 3, unit, of travel */
    float *power;       /* x bins, W/nm; 0 where a split photon does not carry the bin */
    double *wavelength; /* x bins, nm */
    int32_t *bounce;    /* 0: first surface */
} cpm_photons_arrays;
CPM_API cpm_status cpm_photons_read(const cpm_photons *photons, cpm_map map, cpm_photons_arrays *arrays);

/* Irradiance (actual, W/m2/nm, count x bins) on the side of the normals. E = sum(the k - 1 nearer)/(pi r_k^2); direct
 * photons and later ones are searched apart. max_radius <= 0: the scene's diagonal. */
CPM_API cpm_status cpm_photons_irradiance(cpm_context *context, const cpm_photons *photons, cpm_map map,
                                          const double *points, const double *normals, size_t count, int32_t nearest,
                                          double max_radius, double *irradiance);

/* Energy balance per bin, W/nm, each array `bins` long and may be NULL:
 * emitted + roulette_gain = absorbed + escaped + roulette_loss. */
CPM_API cpm_status cpm_photons_energy(const cpm_photons *photons, double *emitted, double *roulette_gain,
                                      double *absorbed, double *escaped, double *roulette_loss);
/* Variance of roulette_gain - roulette_loss (sum over paths of squares), per bin. */
CPM_API cpm_status cpm_photons_roulette_variance(const cpm_photons *photons, double *variance);
CPM_API cpm_status cpm_photons_stats(const cpm_photons *photons, cpm_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
