/* backend/native/bundles.h: many wavelengths on one path where a medium disperses.
 *
 * A flight that stands for several bins is followed at its first, its middle and its last wavelength. Where the three
 * meet the same surface within the flight's leeway, all its bins go the middle one's way; else it parts in halves, and
 * each of them is asked the same, down to single bins. A bin's path is then off by the leeway at most, at each surface
 * anew; no path is followed twice. What comes out depends on the flight alone, not on what is beside it. */
#ifndef CPM_NATIVE_BUNDLES_H
#define CPM_NATIVE_BUNDLES_H
#include "cross.h"

typedef struct cpm_leeway { /* how far paths may part and be one still; 0, 0: not at all */
    double size;            /* metres, where the flight starts */
    double angle;           /* radians: what each metre of its way adds; also the most between directions */
} cpm_leeway;

typedef struct cpm_parted { /* what came of one flight, or of a part of its bins */
    size_t from;            /* which flight */
    int32_t bin, padding;   /* what it stands for (cl/shared/bins.h) */
    cpm_arrival arrival;    /* the middle bin's; `evaluations` are those of all paths followed, with the first part */
} cpm_parted;

typedef struct cpm_bundle_node cpm_bundle_node;

typedef struct cpm_bundles { /* one thread's scratch and results; zeroed at first */
    cpm_parted *parted;      /* in order of flights, then of bins */
    size_t count;
    uint64_t followed;   /* paths, by the last call */
    cpm_flight *flights; /* the paths, and whose they are */
    cpm_arrival *arrivals;
    size_t *owners;
    size_t path_count, path_capacity;
    cpm_bundle_node *nodes;
    size_t node_count, node_capacity; /* as much room in `parted` */
    size_t *starts;                   /* of each flight's parts */
    size_t flight_capacity;
} cpm_bundles;

/* Who asks: an eye compares what lies across its ray, and directions of rays that leave; photons compare places on a
 * surface, and are not asked about any more once they have left. */
typedef enum cpm_bundle_use { CPM_BUNDLES_OF_PHOTONS = 0, CPM_BUNDLES_OF_EYE = 1 } cpm_bundle_use;

/* cpm_follow, and parts what must be; `options` may be NULL. 0: out of memory. */
int cpm_follow_bundles(cpm_bundles *bundles, const cpm_pass *pass, cpm_bundle_use use, const cpm_flight *flights,
                       const cpm_leeway *leeways, size_t count, const cpm_follow_options *options);
void cpm_bundles_free(cpm_bundles *bundles);

/* The leeway once the flight has arrived. */
cpm_leeway cpm_leeway_after(const cpm_leeway *leeway, const cpm_flight *flight, const cpm_arrival *arrival);

/* Must a flight of several bins part at the boundary that it met, because they refract or reflect by more than
 * `angle` apart? With angle 0: wherever the medium behind disperses. */
int cpm_bundle_parts(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, double angle);
/* One half of its bins, the lower first: the flight and the arrival that stand for it. Returns how many bins lie before
 * it. */
size_t cpm_bundle_half(const cpm_pass *pass, const cpm_flight *flight, const cpm_arrival *arrival, int upper,
                       cpm_flight *half, cpm_arrival *at);
#endif
