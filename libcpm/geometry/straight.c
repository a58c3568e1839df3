/* geometry/straight.c: straight rays: Embree's own triangles in float, the hit polished in double; where float's word
 * is not enough, the curve's way (curve.c), which is double. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "cl/shared/clip.h"
#include "cl/shared/straight.h"
#include "embree.h"
#include "parts.h"

/* One query: what the callbacks need beside Embree's float rays. */
typedef struct query {
    cpm_embree_context base; /* first: Embree hands it back */
    const cpm_geometry *geometry;
    const cpm_straight_ray *const *rays; /* one a lane */
} query;

static cpm_curve line_of(const cpm_straight_ray *ray) { return cpm_line(*ray->origin, *ray->direction); }

/* ------------------------------------------------------------------------------------------------ building */

static void sphere_bounds(const struct RTCBoundsFunctionArguments *args) {
    const cpm_geometry *g = args->geometryUserPtr;
    double low[3], high[3], margin = 8.0 * ULP * g->tree.frame.scale;
    cpm_primitive_box(g, g->triangle_count + args->primID, low, high);
    struct RTCBounds *o = args->bounds_o;
    o->lower_x = (float)(low[0] - g->center.x - margin), o->upper_x = (float)(high[0] - g->center.x + margin);
    o->lower_y = (float)(low[1] - g->center.y - margin), o->upper_y = (float)(high[1] - g->center.y + margin);
    o->lower_z = (float)(low[2] - g->center.z - margin), o->upper_z = (float)(high[2] - g->center.z + margin);
}

/* Spheres among Embree's triangles: the straight ray in double, t in metres. Where it meets one before `far`; 0:
 * nowhere. */
static double sphere_hit(const query *q, unsigned lane, unsigned number, float far) {
    const cpm_straight_ray *ray = q->rays[lane];
    const cpm_curve line = line_of(ray);
    const int32_t primitive = (int32_t)(q->geometry->triangle_count + number);
    return cpm_curve_sphere(&line, &q->geometry->tree.spheres[number], primitive == ray->left, 0.0, (double)far);
}

/* Embree's packets of any size N are arrays of N, one after the other, in the order of struct RTCRayHit (its accessors
 * are C++ only). */
enum {
    FAR = offsetof(struct RTCRay, tfar) / 4,
    PRIMITIVE = offsetof(struct RTCRayHit, hit.primID) / 4,
    GEOMETRY = offsetof(struct RTCRayHit, hit.geomID) / 4
};

static void sphere_occluded(const struct RTCOccludedFunctionNArguments *args) {
    float *far = (float *)(void *)args->ray + FAR * args->N;
    for (unsigned i = 0; i < args->N; i++)
        if (args->valid[i] && sphere_hit((query *)(void *)args->context, i, args->primID, far[i]) > 0.0)
            far[i] = -INFINITY;
}

static void sphere_intersect(const struct RTCIntersectFunctionNArguments *args) {
    float *far = (float *)(void *)args->rayhit + FAR * args->N;
    unsigned *geometry = (unsigned *)(void *)args->rayhit + GEOMETRY * args->N;
    unsigned *primitive = (unsigned *)(void *)args->rayhit + PRIMITIVE * args->N;
    for (unsigned i = 0; i < args->N; i++) {
        double t = args->valid[i] ? sphere_hit((query *)(void *)args->context, i, args->primID, far[i]) : 0.0;
        if (!(t > 0.0)) continue;
        far[i] = (float)t;
        geometry[i] = 1, primitive[i] = args->primID;
    }
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
            const cpm_triangle *t = &g->tree.triangles[i];
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

/* In double throughout, by the curves' way. */
static void ask_exactly(const cpm_geometry *g, const cpm_straight_ray *ray) {
    double enter = -ray->slack, leave = INFINITY;
    ray->hit->primitive = -1;
    if (!cpm_clip_to_box(&g->tree, *ray->origin, *ray->direction, 1e-12 * g->tree.frame.scale, &enter, &leave) ||
        !(leave > 0.0))
        return;
    const double reach = leave + 1e-9 * (leave + g->tree.frame.scale);
    cpm_curve line = line_of(ray);
    line.c[1] = cpm_scaled(reach, line.c[1]);
    cpm_geometry_curve(g, &line, 1.0, ray->left, ray->slack / reach, ray->filter, ray->hit);
    ray->hit->t *= reach;
}

/* Embree's answer, a geometry and the number of one of its primitives, for one ray. */
static void settle(const cpm_geometry *g, const cpm_straight_ray *ray, unsigned geometry, unsigned number, float far) {
    int known = 0;
    if (geometry == 0 && (int32_t)number != ray->left) {
        ray->hit->primitive = (int32_t)number;
        known = cpm_polish_triangle(&g->tree.triangles[number], *ray->origin, *ray->direction, ray->hit);
    } else if (geometry == 1) {
        ray->hit->primitive = (int32_t)(g->triangle_count + number);
        known = cpm_polish_sphere(&g->tree.spheres[number], *ray->origin, *ray->direction,
                                  ray->hit->primitive == ray->left, (double)far, ray->hit);
    }
    if (!known) ask_exactly(g, ray); /* a miss, or itself, or so near an edge */
}

static void set_lane(struct RTCRayHit4 *to, int lane, cpm_vec origin, cpm_vec direction, float near) {
    to->ray.org_x[lane] = (float)origin.x, to->ray.org_y[lane] = (float)origin.y, to->ray.org_z[lane] = (float)origin.z;
    to->ray.dir_x[lane] = (float)direction.x, to->ray.dir_y[lane] = (float)direction.y;
    to->ray.dir_z[lane] = (float)direction.z;
    to->ray.tnear[lane] = near;
    to->ray.tfar[lane] = INFINITY;
    to->ray.time[lane] = 0.0f;
    to->ray.mask[lane] = 0xFFFFFFFFu;
    to->ray.id[lane] = to->ray.flags[lane] = 0;
    to->hit.geomID[lane] = to->hit.primID[lane] = to->hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
}

/* At most four rays by one call: Embree's setup is shared, each then walks the tree by itself (they are incoherent), so
 * that no ray's answer depends on its neighbours. */
static void ask_four(const cpm_geometry *g, const cpm_straight_ray *const *rays, int count) {
    int valid[4] __attribute__((aligned(16))) = {0, 0, 0, 0};
    struct RTCRayHit4 four;
    query q;
    cpm_embree_context_init(&q.base);
    q.geometry = g;
    q.rays = rays;
    for (int i = 0; i < count; i++) {
        const cpm_vec local = cpm_sub(*rays[i]->origin, g->center);
        const double size = cpm_max(g->tree.frame.scale, cpm_max(fabs(local.x), cpm_max(fabs(local.y), fabs(local.z))));
        set_lane(&four, i, local, *rays[i]->direction, rays[i]->left >= 0 ? (float)(START_ULPS * ULP * size) : 0.0f);
        valid[i] = -1;
    }
    for (int i = count; i < 4; i++) set_lane(&four, i, cpm_v(0.0, 0.0, 0.0), cpm_v(0.0, 0.0, 1.0), 0.0f);
    cpm_embree_intersect4(valid, g->straight, &q.base, &four);
    for (int i = 0; i < count; i++) settle(g, rays[i], four.hit.geomID[i], four.hit.primID[i], four.ray.tfar[i]);
}

void cpm_geometry_straight_many(const cpm_geometry *g, const cpm_straight_ray *rays, size_t count) {
    const cpm_straight_ray *waiting[4]; /* for float */
    int n = 0;
    for (size_t i = 0; i < count; i++) {
        rays[i].hit->primitive = -1;
        if (!g->tree.nodes) continue;
        if (rays[i].exact || rays[i].slack > 0.0 || !g->straight) {
            ask_exactly(g, &rays[i]);
            continue;
        }
        waiting[n++] = &rays[i];
        if (n == 4) {
            ask_four(g, waiting, 4);
            n = 0;
        }
    }
    if (n) ask_four(g, waiting, n);
}

void cpm_geometry_straight(const cpm_geometry *g, cpm_vec origin, cpm_vec direction, int32_t left, double slack,
                           const cpm_filter *filter, int exact, cpm_hit *hit) {
    const cpm_straight_ray ray = {&origin, &direction, left, exact, slack, filter, hit};
    cpm_geometry_straight_many(g, &ray, 1);
}

int cpm_geometry_between(const cpm_geometry *g, cpm_vec a, cpm_vec b) {
    query q;
    if (!g->straight) { /* float is too coarse for this scene */
        cpm_hit hit;
        cpm_curve line = {.degree = 1};
        line.c[0] = a, line.c[1] = cpm_sub(b, a);
        cpm_geometry_curve(g, &line, 1.0, -1, 0.0, NULL, &hit);
        return hit.primitive >= 0;
    }
    const cpm_vec way = cpm_sub(b, a), local = cpm_sub(a, g->center);
    const cpm_straight_ray line = {.origin = &a, .direction = &way, .left = -1}, *only = &line;
    cpm_embree_context_init(&q.base);
    q.geometry = g;
    q.rays = &only;
    struct RTCRay ray = {.org_x = (float)local.x,
                         .org_y = (float)local.y,
                         .org_z = (float)local.z,
                         .dir_x = (float)way.x,
                         .dir_y = (float)way.y,
                         .dir_z = (float)way.z,
                         .tfar = 1.0f,
                         .mask = 0xFFFFFFFFu};
    cpm_embree_occluded(g->straight, &q.base, &ray);
    return ray.tfar < 0.0f;
}
