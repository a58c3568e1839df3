/* geometry/geometry.c: Embree scenes over double-precision primitives. See geometry.h for the two ways to ask.
 *
 * Why nothing leaks. A curve stays within `sagitta` of its chord, and the chord of theta in [a, b] is at parameter theta
 * when the curve is at theta: so where the curve meets a primitive, the chord is inside the primitive's grown box at
 * that very parameter. Embree therefore reports the primitive before it passes that parameter, and shortening the
 * chord to the best theta so far never hides a nearer one. Float rounding is covered by growing the boxes by a few ulp
 * of the largest coordinate. */
#include "geometry.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/scatter.h"
#include "parts.h"

#define SAGITTA_OF_DIAGONAL 0.02 /* boxes of large triangles are grown by at most this part of the scene */
#define SAGITTA_OF_EDGE 0.5      /* and by half the median edge of small ones */
#define MAX_CHORDS 100000.0
#define OVERLAP 1e-12 /* of theta: a root where two chords meet belongs to one of them at least */

/* One query: what the callbacks need beside Embree's float ray. */
typedef struct query {
    cpm_embree_context base; /* first: Embree hands it back */
    const cpm_geometry *geometry;
    const cpm_curve *curve;
    cpm_chord chord; /* a, b: theta of its ends */
    int32_t left;
    double slack; /* theta within which the filter is asked */
    const cpm_filter *filter;
    cpm_hit best;
} query;

int cpm_triangle_complete(cpm_triangle *t, double scale) {
    cpm_vec e1 = cpm_v(t->edge1[0], t->edge1[1], t->edge1[2]), e2 = cpm_v(t->edge2[0], t->edge2[1], t->edge2[2]);
    cpm_vec n = cpm_cross(e1, e2), e3 = cpm_sub(e2, e1);
    double area2 = cpm_norm(n);
    double longest = sqrt(cpm_max(cpm_vdot(e1, e1), cpm_max(cpm_vdot(e2, e2), cpm_vdot(e3, e3))));
    t->normal[0] = n.x, t->normal[1] = n.y, t->normal[2] = n.z;
    if (!(area2 > 1e-14 * longest * longest) || !(area2 * area2 > 0.0)) return 0;
    double height = area2 / longest;
    t->normal_length = area2;
    t->inverse_area2 = 1.0 / (area2 * area2);
    t->tolerance = 1e-12 + 8.0 * DBL_EPSILON * scale / height;
    t->near_edge = 4.0 * START_ULPS * ULP * scale / height;
    return 1;
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Half the median of up to 1024 triangles' longest edges, at most a part of the diagonal. */
static double choose_sagitta(const cpm_geometry *g, double diagonal) {
    double edges[1024], cap = SAGITTA_OF_DIAGONAL * diagonal;
    size_t count = g->triangle_count < 1024 ? g->triangle_count : 1024;
    if (!count) return cap;
    for (size_t i = 0; i < count; i++) {
        const cpm_triangle *t = &g->triangles[i * g->triangle_count / count];
        double a = 0.0, b = 0.0;
        for (int k = 0; k < 3; k++) a += t->edge1[k] * t->edge1[k], b += t->edge2[k] * t->edge2[k];
        edges[i] = sqrt(cpm_max(a, b));
    }
    qsort(edges, count, sizeof *edges, compare_doubles);
    return cpm_min(cap, SAGITTA_OF_EDGE * edges[count / 2]);
}

cpm_box cpm_geometry_box(const cpm_geometry *geometry) { return geometry->box; }
double cpm_geometry_scale(const cpm_geometry *geometry) { return geometry->scale; }

static void measure_box(cpm_geometry *g) {
    for (int k = 0; k < 3; k++) g->box.low[k] = INFINITY, g->box.high[k] = -INFINITY;
    for (size_t i = 0; i < g->triangle_count; i++) {
        const cpm_triangle *t = &g->triangles[i];
        for (int k = 0; k < 3; k++) {
            double a = t->corner[k], b = a + t->edge1[k], c = a + t->edge2[k];
            g->box.low[k] = cpm_min(g->box.low[k], cpm_min(a, cpm_min(b, c)));
            g->box.high[k] = cpm_max(g->box.high[k], cpm_max(a, cpm_max(b, c)));
        }
    }
    for (size_t i = 0; i < g->sphere_count; i++) {
        const cpm_sphere *s = &g->spheres[i];
        for (int k = 0; k < 3; k++) {
            g->box.low[k] = cpm_min(g->box.low[k], s->center[k] - s->radius);
            g->box.high[k] = cpm_max(g->box.high[k], s->center[k] + s->radius);
        }
    }
}

cpm_status cpm_geometry_create(cpm_context *context, const cpm_triangle *triangles, size_t triangle_count,
                               const cpm_sphere *spheres, size_t sphere_count, cpm_geometry **geometry) {
    cpm_geometry *g = calloc(1, sizeof *g);
    *geometry = NULL;
    if (!g) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the scene's geometry");
    g->triangles = triangles, g->triangle_count = triangle_count;
    g->spheres = spheres, g->sphere_count = sphere_count;
    measure_box(g);
    if (triangle_count + sphere_count) {
        double d2 = 0.0;
        double center[3];
        for (int k = 0; k < 3; k++) {
            double size = g->box.high[k] - g->box.low[k];
            center[k] = 0.5 * (g->box.low[k] + g->box.high[k]);
            d2 += size * size;
            g->scale = cpm_max(g->scale, 0.5 * size);
        }
        g->center = cpm_v(center[0], center[1], center[2]);
        g->sagitta = choose_sagitta(g, sqrt(d2));
    }
    *geometry = g;
    return CPM_OK;
}

void cpm_geometry_free(cpm_geometry *g) {
    if (!g) return;
    if (g->straight) rtcReleaseScene(g->straight);
    if (g->curved) rtcReleaseScene(g->curved);
    if (g->device) rtcReleaseDevice(g->device);
    free(g);
}

/* ------------------------------------------------------------------------------------------------ building */

void cpm_primitive_box(const cpm_geometry *g, size_t primitive, double low[3], double high[3]) {
    if (primitive < g->triangle_count) {
        const cpm_triangle *t = &g->triangles[primitive];
        for (int k = 0; k < 3; k++) {
            double a = t->corner[k], b = a + t->edge1[k], c = a + t->edge2[k];
            low[k] = cpm_min(a, cpm_min(b, c)), high[k] = cpm_max(a, cpm_max(b, c));
        }
    } else {
        const cpm_sphere *s = &g->spheres[primitive - g->triangle_count];
        for (int k = 0; k < 3; k++) low[k] = s->center[k] - s->radius, high[k] = s->center[k] + s->radius;
    }
}

static void primitive_bounds(const cpm_geometry *g, size_t primitive, double grow, struct RTCBounds *o) {
    double low[3], high[3], center[3] = {g->center.x, g->center.y, g->center.z};
    cpm_primitive_box(g, primitive, low, high);
    float f[6];
    for (int k = 0; k < 3; k++) {
        double margin = grow + 4.0 * ULP * (g->scale + fabs(low[k] - center[k]) + fabs(high[k] - center[k]));
        f[k] = (float)(low[k] - center[k] - margin);
        f[3 + k] = (float)(high[k] - center[k] + margin);
    }
    o->lower_x = f[0], o->lower_y = f[1], o->lower_z = f[2];
    o->upper_x = f[3], o->upper_y = f[4], o->upper_z = f[5];
}

static void curve_bounds(const struct RTCBoundsFunctionArguments *args) {
    const cpm_geometry *g = args->geometryUserPtr;
    primitive_bounds(g, args->primID, g->sagitta, args->bounds_o);
}

/* Tests the query's curve against one primitive; shortens Embree's ray to the best so far. */
static void test_primitive(query *q, size_t primitive, struct RTCRayHit *rayhit) {
    const cpm_geometry *g = q->geometry;
    double end = q->best.primitive >= 0 && q->best.t < q->chord.b ? q->best.t : q->chord.b;
    int leaving = (int32_t)primitive == q->left;
    double u = 0.0, v = 0.0;
    double t = primitive < g->triangle_count
                   ? leaving ? cpm_curve_triangle(q->curve, &g->triangles[primitive], 1, q->chord.a, end, &u, &v)
                             : cpm_chord_triangle(q->curve, &q->chord, &g->triangles[primitive], end, &u, &v)
                   : cpm_curve_sphere(q->curve, &g->spheres[primitive - g->triangle_count], leaving, q->chord.a, end);
    if (!(t > -1.0)) return;
    if (q->filter && t <= q->slack &&
        !q->filter->counts(q->filter->user, (int32_t)primitive, cpm_curve_at(q->curve, t),
                           cpm_curve_tangent(q->curve, t)))
        return;
    if (q->best.primitive >= 0 && (t > q->best.t || (t == q->best.t && (int32_t)primitive >= q->best.primitive))) return;
    q->best.primitive = (int32_t)primitive;
    q->best.t = t, q->best.u = u, q->best.v = v;
    /* a little beyond the best, so that an equal hit of a lower number is still seen */
    float far = (float)((t - q->chord.a) / (q->chord.b - q->chord.a)) * (1.0f + 4.0f * FLT_EPSILON) + FLT_EPSILON;
    if (far < rayhit->ray.tfar) rayhit->ray.tfar = far;
    rayhit->hit.geomID = 0;
    rayhit->hit.primID = (unsigned)primitive;
}

static void curve_intersect(const struct RTCIntersectFunctionNArguments *args) {
    if (!args->valid[0]) return;
    test_primitive((query *)(void *)args->context, args->primID, (struct RTCRayHit *)(void *)args->rayhit);
}

static cpm_status embree_failed(cpm_context *context, cpm_geometry *g) {
    return cpm_fail(context, CPM_ERROR_BACKEND, "Embree failed with code %d while building the scene",
                    (int)rtcGetDeviceError(g->device));
}

static cpm_status build_curved(cpm_context *context, cpm_geometry *g) {
    g->curved = rtcNewScene(g->device);
    rtcSetSceneFlags(g->curved, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry all = rtcNewGeometry(g->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(all, (unsigned)(g->triangle_count + g->sphere_count));
    rtcSetGeometryUserData(all, g);
    rtcSetGeometryBoundsFunction(all, curve_bounds, NULL);
    rtcSetGeometryIntersectFunction(all, curve_intersect);
    rtcCommitGeometry(all);
    rtcAttachGeometryByID(g->curved, all, 0);
    rtcReleaseGeometry(all);
    rtcCommitScene(g->curved);
    return rtcGetDeviceError(g->device) == RTC_ERROR_NONE ? CPM_OK : embree_failed(context, g);
}

cpm_status cpm_geometry_prepare(cpm_context *context, cpm_geometry *g, int straight, int curved) {
    if (!(g->triangle_count + g->sphere_count)) return CPM_OK;
    if (!g->device) {
        char config[32];
        snprintf(config, sizeof config, "threads=%d", (int)context->threads);
        g->device = rtcNewDevice(config);
        if (!g->device) return cpm_fail(context, CPM_ERROR_BACKEND, "Embree gave no device");
    }
    /* straight rays fall back on the curve scene near edges */
    if ((curved || straight) && !g->curved) {
        cpm_status status = build_curved(context, g);
        if (status) return status;
    }
    return straight && !g->straight ? cpm_straight_build(context, g) : CPM_OK;
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

/* The part [enter, leave] of o + t d inside the box grown by `grow`; 0: none. */
int cpm_clip_to_box(const cpm_geometry *g, cpm_vec o, cpm_vec d, double grow, double *enter, double *leave) {
    const double *low = g->box.low, *high = g->box.high;
    double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z};
    for (int k = 0; k < 3; k++) {
        double t0 = (low[k] - grow - origin[k]) / direction[k], t1 = (high[k] + grow - origin[k]) / direction[k];
        if (direction[k] == 0.0) {
            if (origin[k] < low[k] - grow || origin[k] > high[k] + grow) return 0;
            continue;
        }
        *enter = cpm_max(*enter, cpm_min(t0, t1));
        *leave = cpm_min(*leave, cpm_max(t0, t1));
    }
    return *enter <= *leave;
}

void cpm_geometry_curve(const cpm_geometry *g, const cpm_curve *curve, double theta_end, int32_t left, double slack,
                        const cpm_filter *filter, cpm_hit *hit) {
    query q;
    hit->primitive = -1;
    if (!g->curved) return;
    cpm_embree_context_init(&q.base);
    q.geometry = g;
    q.curve = curve;
    q.left = left;
    q.slack = slack;
    q.filter = slack > 0.0 ? filter : NULL;
    q.best.primitive = -1;
    q.best.t = INFINITY;
    double sagitta = cpm_curve_sagitta(curve, theta_end);
    double chords = 1.0;
    if (sagitta > g->sagitta) chords = cpm_min(ceil(sqrt(sagitta / g->sagitta)), MAX_CHORDS);
    double grow = sagitta / (chords * chords) + 1e-12 * g->scale;
    cpm_vec start = curve->c[0];
    for (double i = 0.0; i < chords && q.best.primitive < 0; i++) {
        double a = theta_end * i / chords, b = i + 1.0 < chords ? theta_end * (i + 1.0) / chords : theta_end;
        cpm_vec end = cpm_curve_at(curve, b), chord = cpm_sub(end, start);
        double enter = 0.0, leave = 1.0; /* cut to the scene's box: fewer queries, and float sees small numbers */
        if (cpm_clip_to_box(g, start, chord, grow, &enter, &leave)) {
            struct RTCRayHit rayhit;
            set_ray(&rayhit, cpm_sub(cpm_along(start, enter, chord), g->center), cpm_scaled(leave - enter, chord),
                    0.0f, 1.0f);
            q.chord.a = i == 0.0 && enter == 0.0 ? -slack : a + enter * (b - a) - OVERLAP * theta_end;
            q.chord.b = a + leave * (b - a);
            q.chord.start = cpm_along(start, enter, chord), q.chord.end = cpm_along(start, leave, chord);
            q.chord.off = grow + 1e-9 * g->scale; /* also of this part of the chord; and of a start that looks back */
            cpm_embree_intersect(g->curved, &q.base, &rayhit);
        }
        start = end;
    }
    *hit = q.best;
    if (hit->primitive >= 0) hit->position = cpm_curve_at(curve, hit->t);
}

cpm_vec cpm_geometry_step_back(const cpm_geometry *g, const cpm_hit *hit, cpm_vec start, cpm_vec came) {
    return scatter_step_back(hit->position, start, came, g->scale);
}

int cpm_geometry_near_edge(const cpm_geometry *g, const cpm_hit *hit) {
    if ((size_t)hit->primitive >= g->triangle_count) return 1;
    double least = cpm_min(hit->u, cpm_min(hit->v, 1.0 - hit->u - hit->v));
    return !(least > g->triangles[hit->primitive].near_edge);
}

const char *cpm_geometry_embree_version(void) {
    static const char version[] = RTC_VERSION_STRING;
    return version;
}
