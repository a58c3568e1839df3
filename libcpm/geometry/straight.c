/* geometry/straight.c: straight rays: Embree's own triangles in float, the hit polished in double; where float's word
 * is not enough, the curve's way (curve.c), which is double. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "embree.h"
#include "parts.h"

/* One query: what the callbacks need beside Embree's float ray. */
typedef struct query {
    cpm_embree_context base; /* first: Embree hands it back */
    const cpm_geometry *geometry;
    const cpm_curve *line;
    int32_t left;
    const cpm_filter *filter;
} query;

/* ------------------------------------------------------------------------------------------------ building */

static void sphere_bounds(const struct RTCBoundsFunctionArguments *args) {
    const cpm_geometry *g = args->geometryUserPtr;
    double low[3], high[3], margin = 8.0 * ULP * g->scale;
    cpm_primitive_box(g, g->triangle_count + args->primID, low, high);
    struct RTCBounds *o = args->bounds_o;
    o->lower_x = (float)(low[0] - g->center.x - margin), o->upper_x = (float)(high[0] - g->center.x + margin);
    o->lower_y = (float)(low[1] - g->center.y - margin), o->upper_y = (float)(high[1] - g->center.y + margin);
    o->lower_z = (float)(low[2] - g->center.z - margin), o->upper_z = (float)(high[2] - g->center.z + margin);
}

/* The same for any-hit queries. */
static void sphere_occluded(const struct RTCOccludedFunctionNArguments *args) {
    if (!args->valid[0]) return;
    query *q = (query *)(void *)args->context;
    struct RTCRay *ray = (struct RTCRay *)(void *)args->ray;
    double t = cpm_curve_sphere(q->line, &q->geometry->spheres[args->primID], 0, 0.0, (double)ray->tfar);
    if (t > 0.0) ray->tfar = -INFINITY;
}

/* Spheres among Embree's triangles: the straight ray in double; t is in metres there, as the query's curve is. */
static void sphere_intersect(const struct RTCIntersectFunctionNArguments *args) {
    if (!args->valid[0]) return;
    query *q = (query *)(void *)args->context;
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)args->rayhit;
    size_t primitive = q->geometry->triangle_count + args->primID;
    double t = cpm_curve_sphere(q->line, &q->geometry->spheres[args->primID], (int32_t)primitive == q->left, 0.0,
                                (double)rayhit->ray.tfar);
    if (!(t > 0.0)) return;
    rayhit->ray.tfar = (float)t;
    rayhit->hit.geomID = 1;
    rayhit->hit.primID = args->primID;
}

static cpm_status embree_failed(cpm_context *context, cpm_geometry *g) {
    return cpm_fail(context, CPM_ERROR_BACKEND, "Embree failed with code %d while building the scene",
                    (int)rtcGetDeviceError(g->device));
}

cpm_status cpm_straight_build(cpm_context *context, cpm_geometry *g) {
    g->straight = rtcNewScene(g->device);
    rtcSetSceneFlags(g->straight, RTC_SCENE_FLAG_ROBUST);
    if (g->triangle_count) {
        RTCGeometry mesh = rtcNewGeometry(g->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        float *vertices =
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * g->triangle_count);
        unsigned *faces =
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, g->triangle_count);
        if (!vertices || !faces) {
            rtcReleaseGeometry(mesh);
            return embree_failed(context, g);
        }
        double center[3] = {g->center.x, g->center.y, g->center.z};
        for (size_t i = 0; i < g->triangle_count; i++) {
            const cpm_triangle *t = &g->triangles[i];
            for (int k = 0; k < 3; k++) {
                double a = t->corner[k] - center[k];
                vertices[9 * i + (size_t)k] = (float)a;
                vertices[9 * i + 3 + (size_t)k] = (float)(a + t->edge1[k]);
                vertices[9 * i + 6 + (size_t)k] = (float)(a + t->edge2[k]);
                faces[3 * i + (size_t)k] = (unsigned)(3 * i + (size_t)k);
            }
        }
        rtcCommitGeometry(mesh);
        rtcAttachGeometryByID(g->straight, mesh, 0);
        rtcReleaseGeometry(mesh);
    }
    if (g->sphere_count) {
        RTCGeometry balls = rtcNewGeometry(g->device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(balls, (unsigned)g->sphere_count);
        rtcSetGeometryUserData(balls, g);
        rtcSetGeometryBoundsFunction(balls, sphere_bounds, NULL);
        rtcSetGeometryIntersectFunction(balls, sphere_intersect);
        rtcSetGeometryOccludedFunction(balls, sphere_occluded);
        rtcCommitGeometry(balls);
        rtcAttachGeometryByID(g->straight, balls, 1);
        rtcReleaseGeometry(balls);
    }
    rtcCommitScene(g->straight);
    return rtcGetDeviceError(g->device) == RTC_ERROR_NONE ? CPM_OK : embree_failed(context, g);
}

/* ------------------------------------------------------------------------------------------------- asking */

static void set_ray(struct RTCRayHit *rayhit, cpm_vec origin, cpm_vec direction, float near, float far) {
    memset(rayhit, 0, sizeof *rayhit);
    rayhit->ray.org_x = (float)origin.x, rayhit->ray.org_y = (float)origin.y, rayhit->ray.org_z = (float)origin.z;
    rayhit->ray.dir_x = (float)direction.x, rayhit->ray.dir_y = (float)direction.y,
    rayhit->ray.dir_z = (float)direction.z;
    rayhit->ray.tnear = near;
    rayhit->ray.tfar = far;
    rayhit->ray.mask = 0xFFFFFFFFu;
    rayhit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.primID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

static void straight_exact(const cpm_geometry *g, const query *from, double leave, double slack, cpm_hit *hit) {
    cpm_curve line = *from->line;
    line.c[1] = cpm_scaled(leave, line.c[1]);
    cpm_geometry_curve(g, &line, 1.0, from->left, slack / leave, from->filter, hit);
    hit->t *= leave;
}

void cpm_geometry_straight(const cpm_geometry *g, cpm_vec origin, cpm_vec direction, int32_t left, double slack,
                           const cpm_filter *filter, int exact, cpm_hit *hit) {
    hit->primitive = -1;
    double enter = -slack, leave = INFINITY;
    if (!g->curved.nodes || !cpm_clip_to_box(g, origin, direction, 1e-12 * g->scale, &enter, &leave) || !(leave > 0.0))
        return;

    query q;
    q.geometry = g;
    cpm_curve line;
    line.degree = 1;
    line.c[0] = origin, line.c[1] = direction;
    q.line = &line;
    q.left = left;
    q.filter = filter;
    double reach = leave + 1e-9 * (leave + g->scale);
    if (exact || slack > 0.0 || !g->straight) {
        straight_exact(g, &q, reach, slack, hit);
        return;
    }
    cpm_embree_context_init(&q.base);
    cpm_vec local = cpm_sub(origin, g->center);
    double size = cpm_max(g->scale, cpm_max(fabs(local.x), cpm_max(fabs(local.y), fabs(local.z))));
    struct RTCRayHit rayhit;
    set_ray(&rayhit, local, direction, left >= 0 ? (float)(START_ULPS * ULP * size) : 0.0f, (float)reach * 1.0001f);
    cpm_embree_intersect(g->straight, &q.base, &rayhit);

    int32_t primitive = -1;
    if (rayhit.hit.geomID == 0)
        primitive = (int32_t)rayhit.hit.primID;
    else if (rayhit.hit.geomID == 1)
        primitive = (int32_t)(g->triangle_count + rayhit.hit.primID);
    if (primitive < 0 || (primitive == left && (size_t)primitive < g->triangle_count)) {
        straight_exact(g, &q, reach, slack, hit); /* a miss, or itself: float's word is not enough */
        return;
    }
    hit->primitive = primitive;
    if ((size_t)primitive < g->triangle_count) { /* polish on the plane, in double */
        const cpm_triangle *t = &g->triangles[primitive];
        cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
        cpm_vec corner = cpm_v(t->corner[0], t->corner[1], t->corner[2]);
        hit->t = cpm_vdot(cpm_sub(corner, origin), n) / cpm_vdot(direction, n);
        hit->position = cpm_along(origin, hit->t, direction);
        if (!(hit->t > 0.0) || !isfinite(hit->t)) {
            straight_exact(g, &q, reach, slack, hit);
            return;
        }
        cpm_triangle_contains(t, hit->position, &hit->u, &hit->v);
        if (!(cpm_min(hit->u, cpm_min(hit->v, 1.0 - hit->u - hit->v)) > -t->near_edge))
            straight_exact(g, &q, reach, slack, hit);
    } else {
        hit->t = cpm_curve_sphere(q.line, &g->spheres[(size_t)primitive - g->triangle_count], primitive == left, 0.0,
                                  (double)rayhit.ray.tfar * 1.001);
        hit->u = hit->v = 0.0;
        hit->position = cpm_along(origin, hit->t, direction);
        if (!(hit->t > 0.0)) straight_exact(g, &q, reach, slack, hit);
    }
}

int cpm_geometry_between(const cpm_geometry *g, cpm_vec a, cpm_vec b) {
    query q;
    struct RTCRayHit rayhit;
    if (!g->straight) return 0;
    cpm_embree_context_init(&q.base);
    q.geometry = g;
    cpm_curve line;
    line.degree = 1;
    line.c[0] = a, line.c[1] = cpm_sub(b, a);
    q.line = &line;
    q.left = -1;
    set_ray(&rayhit, cpm_sub(a, g->center), line.c[1], 0.0f, 1.0f);
    cpm_embree_occluded(g->straight, &q.base, &rayhit.ray);
    return rayhit.ray.tfar < 0.0f;
}
