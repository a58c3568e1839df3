/* photon/irradiance.c: irradiance at the caller's points, from the maps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "photons.h"

typedef struct request {
    const cpm_photons *photons;
    const double *points, *normals;
    int32_t nearest;
    double max_radius;
    double *irradiance;
    int first, last; /* trees */
} request;

static void estimate(const request *q, cpm_map_query *queries[CPM_POPULATIONS], size_t i) {
    const double *r = &q->points[3 * i], *n = &q->normals[3 * i];
    cpm_vec local = cpm_sub(cpm_v(r[0], r[1], r[2]), q->photons->origin);
    cpm_vec unit = cpm_unit(cpm_v(n[0], n[1], n[2]));
    const float point[3] = {(float)local.x, (float)local.y, (float)local.z};
    const float normal[3] = {(float)unit.x, (float)unit.y, (float)unit.z};
    double *to = &q->irradiance[i * q->photons->bins];
    memset(to, 0, q->photons->bins * sizeof *to);
    for (int t = q->first; t <= q->last; t++)
        cpm_tree_irradiance(q->photons->trees[t], queries[t], point, normal, q->nearest, q->max_radius, to);
}

static cpm_status check(cpm_context *context, const double *points, const double *normals, size_t count,
                        int32_t nearest) {
    if (nearest < 2 || nearest > 1000000)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "nearest is %d; allowed: 2 to 1000000", nearest);
    for (size_t i = 0; i < count; i++) {
        const double *r = &points[3 * i], *n = &normals[3 * i];
        if (!isfinite(r[0] + r[1] + r[2]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "point %zu is (%g, %g, %g); it must be finite", i,
                            r[0], r[1], r[2]);
        if (!isfinite(n[0] + n[1] + n[2]) || !(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "normal %zu is (%g, %g, %g); it must be finite and not zero", i, n[0], n[1], n[2]);
    }
    return CPM_OK;
}

cpm_status cpm_photons_irradiance(cpm_context *context, const cpm_photons *photons, cpm_map map, const double *points,
                                  const double *normals, size_t count, int32_t nearest, double max_radius,
                                  double *irradiance) {
    if (!context || !photons || (count && (!points || !normals || !irradiance)))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "context, photons and arrays must not be NULL");
    if (map != CPM_MAP_DIFFUSE && map != CPM_MAP_CAUSTIC)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "map is %d; allowed: diffuse 0, caustic 1", (int)map);
    if (isnan(max_radius)) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "max_radius is NaN");
    cpm_status status = check(context, points, normals, count, nearest);
    if (status) return status;
    cpm_progress_begin(context);
    cpm_progress(context, "gather", 0.0);
    request q = {photons,
                 points,
                 normals,
                 nearest,
                 max_radius > 0.0 ? max_radius : photons->diagonal,
                 irradiance,
                 map == CPM_MAP_CAUSTIC ? CPM_CAUSTIC : CPM_DIRECT,
                 map == CPM_MAP_CAUSTIC ? CPM_CAUSTIC : CPM_LATER};
    int failed = 0;
#pragma omp parallel num_threads(context->threads) if (count > 64)
    {
        cpm_map_query *queries[CPM_POPULATIONS] = {NULL};
        int ready = 1;
        for (int t = q.first; t <= q.last; t++) ready &= (queries[t] = cpm_query_create(photons->trees[t])) != NULL;
        if (!ready) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < count; i++)
            if (ready && !cpm_poll(context)) estimate(&q, queries, i);
        for (int t = q.first; t <= q.last; t++) cpm_query_free(queries[t]);
    }
    if (failed) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory to search the photon maps");
    return cpm_poll(context) ? cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while estimating irradiance") : CPM_OK;
}
