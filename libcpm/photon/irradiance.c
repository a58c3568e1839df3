/* photon/irradiance.c: irradiance at the caller's points, from the maps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/opencl/map.h"
#include "photons.h"

typedef struct request {
    const cpm_photons *photons;
    const double *points, *normals;
    int32_t nearest;
    double max_radius;
    double *irradiance;
    int first, last; /* trees */
} request;

/* A point from the map's origin, and its normal, as a search takes them. */
static void ask(const request *q, size_t i, float point[3], float normal[3]) {
    const double *r = &q->points[3 * i], *n = &q->normals[3 * i];
    cpm_vec local = cpm_sub(cpm_v(r[0], r[1], r[2]), q->photons->origin);
    cpm_vec unit = cpm_unit(cpm_v(n[0], n[1], n[2]));
    point[0] = (float)local.x, point[1] = (float)local.y, point[2] = (float)local.z;
    normal[0] = (float)unit.x, normal[1] = (float)unit.y, normal[2] = (float)unit.z;
}

static void estimate(const request *q, cpm_map_query *queries[CPM_POPULATIONS], size_t i) {
    float point[3], normal[3];
    ask(q, i, point, normal);
    double *to = &q->irradiance[i * q->photons->bins];
    memset(to, 0, q->photons->bins * sizeof *to);
    for (int t = q->first; t <= q->last; t++)
        cpm_tree_irradiance(q->photons->trees[t], queries[t], point, normal, q->nearest, q->max_radius, to);
}

#ifdef CPM_OPENCL_HEADERS_VERSION
/* Does the context's device search these maps? A map that does not fit it is the host's. */
static int on_device(const cpm_context *context, const request *q) {
    const cpm_opencl *o = context->opencl;
    uint64_t left = o ? cpm_opencl_budget(o) : 0;
    for (int t = q->first; o && t <= q->last; t++) {
        if (!cpm_opencl_map_fits(o, q->photons->trees[t], left / 2)) return 0;
        left -= cpm_opencl_map_bytes(o, q->photons->trees[t]);
    }
    return o != NULL;
}

static cpm_status ask_device(cpm_context *context, const request *q, size_t count) {
    float *points = malloc((3 * count + 1) * sizeof *points), *normals = malloc((3 * count + 1) * sizeof *normals);
    cpm_status status = CPM_OK;
    memset(q->irradiance, 0, count * q->photons->bins * sizeof *q->irradiance);
    if (!points || !normals) status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for %zu points", count);
    for (size_t i = 0; i < count && !status; i++) ask(q, i, &points[3 * i], &normals[3 * i]);
    if (!status)
        status = cpm_opencl_irradiance(context, q->photons, q->first, q->last, points, normals, count, q->nearest,
                                       q->max_radius, q->irradiance);
    free(points), free(normals);
    return status;
}
#endif

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
#ifdef CPM_OPENCL_HEADERS_VERSION
    if (on_device(context, &q)) return ask_device(context, &q, count);
#endif
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
