/* geometry/geometry.c: primitives in double, and what is built over them: Embree's scene for straight rays
 * (straight.c), a tree for curves (bvh.c, curve.c). See geometry.h for the two ways to ask. */
#include "geometry.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/region.h"
#include "cl/shared/scatter.h"
#include "embree.h"
#include "parts.h"

#define SAGITTA_OF_DIAGONAL 0.02 /* the farthest that a chord may be from its curve: of the scene */
#define SAGITTA_OF_EDGE 0.5      /* and of the median edge of small triangles */

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
        const cpm_triangle *t = &g->tree.triangles[i * g->triangle_count / count];
        double a = 0.0, b = 0.0;
        for (int k = 0; k < 3; k++) a += t->edge1[k] * t->edge1[k], b += t->edge2[k] * t->edge2[k];
        edges[i] = sqrt(cpm_max(a, b));
    }
    qsort(edges, count, sizeof *edges, compare_doubles);
    return cpm_min(cap, SAGITTA_OF_EDGE * edges[count / 2]);
}

/* Is float too coarse for these primitives, as where the Earth is one and a house another? A straight ray starts
 * START_ULPS of the scene away: that has to be nothing beside the smallest sphere and the usual triangle. */
static int is_coarse(const cpm_geometry *g) {
    double size = g->triangle_count ? g->tree.frame.sagitta : INFINITY;
    for (size_t i = 0; i < g->sphere_count; i++) size = cpm_min(size, g->tree.spheres[i].radius);
    return START_ULPS * ULP * g->tree.frame.scale > 1e-2 * size;
}

cpm_box cpm_geometry_box(const cpm_geometry *geometry) { return geometry->box; }

double cpm_geometry_scale(const cpm_geometry *geometry) { return geometry->tree.frame.scale; }

void cpm_primitive_box(const cpm_geometry *g, size_t primitive, double low[3], double high[3]) {
    if (primitive < g->triangle_count) {
        const cpm_triangle *t = &g->tree.triangles[primitive];
        for (int k = 0; k < 3; k++) {
            double a = t->corner[k], b = a + t->edge1[k], c = a + t->edge2[k];
            low[k] = cpm_min(a, cpm_min(b, c)), high[k] = cpm_max(a, cpm_max(b, c));
        }
    } else {
        const cpm_sphere *s = &g->tree.spheres[primitive - g->triangle_count];
        for (int k = 0; k < 3; k++) low[k] = s->center[k] - s->radius, high[k] = s->center[k] + s->radius;
    }
}

static void measure_box(cpm_geometry *g) {
    for (int k = 0; k < 3; k++) g->box.low[k] = INFINITY, g->box.high[k] = -INFINITY;
    for (size_t i = 0; i < g->triangle_count + g->sphere_count; i++) {
        double low[3], high[3];
        cpm_primitive_box(g, i, low, high);
        for (int k = 0; k < 3; k++) {
            g->box.low[k] = cpm_min(g->box.low[k], low[k]);
            g->box.high[k] = cpm_max(g->box.high[k], high[k]);
        }
    }
}

cpm_status cpm_geometry_create(cpm_context *context, const cpm_triangle *triangles, size_t triangle_count,
                               const cpm_sphere *spheres, size_t sphere_count, cpm_geometry **geometry) {
    cpm_geometry *g = calloc(1, sizeof *g);
    *geometry = NULL;
    if (!g) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the scene's geometry");
    g->tree.triangles = triangles, g->triangle_count = triangle_count;
    g->tree.spheres = spheres, g->sphere_count = sphere_count;
    measure_box(g);
    if (triangle_count + sphere_count) {
        double d2 = 0.0;
        double center[3];
        for (int k = 0; k < 3; k++) {
            double size = g->box.high[k] - g->box.low[k];
            center[k] = 0.5 * (g->box.low[k] + g->box.high[k]);
            d2 += size * size;
            g->tree.frame.scale = cpm_max(g->tree.frame.scale, 0.5 * size);
        }
        g->center = cpm_v(center[0], center[1], center[2]);
        for (int k = 0; k < 3; k++)
            g->tree.frame.center[k] = center[k], g->tree.frame.low[k] = g->box.low[k],
            g->tree.frame.high[k] = g->box.high[k];
        g->tree.frame.unit = 1.0 / g->tree.frame.scale;
        g->tree.frame.triangle_count = (cpm_i32)triangle_count, g->tree.frame.sphere_count = (cpm_i32)sphere_count;
        g->tree.frame.sagitta = choose_sagitta(g, sqrt(d2));
    }
    *geometry = g;
    return CPM_OK;
}

void cpm_geometry_free(cpm_geometry *g) {
    if (!g) return;
    if (g->straight) rtcReleaseScene(g->straight);
    free((void *)(uintptr_t)g->tree.nodes);
    free(g->few);
    if (g->device) rtcReleaseDevice(g->device);
    free(g);
}

extern const cpm_curve_code cpm_curve_code_baseline;
#if CPM_ISA_COUNT > 1
extern const cpm_curve_code cpm_curve_code_v3, cpm_curve_code_v4;
#endif

static const cpm_curve_code *curve_code_for(cpm_isa isa) {
#if CPM_ISA_COUNT > 1
    if (isa == CPM_ISA_V4) return &cpm_curve_code_v4;
    if (isa == CPM_ISA_V3) return &cpm_curve_code_v3;
#endif
    (void)isa;
    return &cpm_curve_code_baseline;
}

void cpm_geometry_curve(const cpm_geometry *g, const cpm_curve *curve, double theta_end, int32_t left, double slack,
                        const cpm_filter *filter, cpm_hit *hit) {
    hit->primitive = -1;
    if (g->tree.nodes) g->curve_code->first_hit(&g->tree, curve, theta_end, left, slack, filter, hit);
}

void cpm_geometry_curves(const cpm_geometry *g, const cpm_curve *curves, const double *from, const int32_t *left,
                         size_t count, cpm_hit *hits) {
    for (size_t i = 0; i < count; i++) hits[i].primitive = -1;
    if (g->tree.nodes) g->curve_code->first_hits(&g->tree, g->few, curves, from, left, count, hits);
}

/* An affine function of position as the tree has it: slope . (r - point) with r = center + q/unit. */
static void set_row(const cpm_geometry *g, float *row, cpm_vec slope, cpm_vec point) {
    row[0] = (float)(slope.x / g->tree.frame.unit), row[1] = (float)(slope.y / g->tree.frame.unit),
    row[2] = (float)(slope.z / g->tree.frame.unit);
    row[3] = (float)cpm_vdot(slope, cpm_sub(g->center, point));
}

/* In units of the scene; CPM_WALK_ROUNDING covers what float does to it. */
static void set_leaf(const cpm_geometry *g, size_t primitive, cpm_bvh_leaf *leaf) {
    const double center[3] = {g->center.x, g->center.y, g->center.z};
    double low[3], high[3];
    memset(leaf, 0, sizeof *leaf);
    cpm_primitive_box(g, primitive, low, high);
    for (int k = 0; k < 3; k++) {
        leaf->box[k] = (float)((low[k] - center[k]) * g->tree.frame.unit);
        leaf->box[3 + k] = (float)((high[k] - center[k]) * g->tree.frame.unit);
    }
    if (primitive >= g->triangle_count) return;
    const cpm_triangle *t = &g->tree.triangles[primitive];
    const cpm_vec corner = cpm_v(t->corner[0], t->corner[1], t->corner[2]);
    const cpm_vec e1 = cpm_v(t->edge1[0], t->edge1[1], t->edge1[2]), e2 = cpm_v(t->edge2[0], t->edge2[1], t->edge2[2]);
    const cpm_vec n = cpm_v(t->normal[0], t->normal[1], t->normal[2]);
    set_row(g, &leaf->face[CPM_FACE_PLANE], cpm_scaled(g->tree.frame.unit / t->normal_length, n), corner);
    set_row(g, &leaf->face[CPM_FACE_U], cpm_scaled(t->inverse_area2, cpm_cross(e2, n)), corner);
    set_row(g, &leaf->face[CPM_FACE_V], cpm_scaled(t->inverse_area2, cpm_cross(n, e1)), corner);
}

static cpm_status build_curved(cpm_context *context, cpm_geometry *g) {
    const size_t count = g->triangle_count + g->sphere_count;
    const char *why = "no memory to build the tree of the scene's primitives";
    cpm_bvh_leaf *leaves = malloc(count * sizeof *leaves);
    g->curve_code = curve_code_for(cpm_isa_chosen());
    if (leaves) {
        for (size_t i = 0; i < count; i++) set_leaf(g, i, &leaves[i]);
        g->tree.nodes = cpm_bvh_build(g->device, leaves, count, &g->node_count, &why);
        if (count <= CPM_FEW)
            g->few = leaves;
        else
            free(leaves);
    }
    return g->tree.nodes ? CPM_OK : cpm_fail(context, CPM_ERROR_BACKEND, "%s", why);
}

cpm_status cpm_geometry_prepare(cpm_context *context, cpm_geometry *g, int straight, int curved) {
    if (!(g->triangle_count + g->sphere_count)) return CPM_OK;
    if (!g->device) {
        char config[32];
        snprintf(config, sizeof config, "threads=%d", (int)context->threads);
        g->device = rtcNewDevice(config);
        if (!g->device) return cpm_fail(context, CPM_ERROR_BACKEND, "Embree gave no device");
    }
    /* straight rays fall back on the curves' tree near edges, and everywhere where float is too coarse */
    if ((curved || straight) && !g->tree.nodes) {
        cpm_status status = build_curved(context, g);
        if (status) return status;
    }
    return straight && !g->straight && !is_coarse(g) ? cpm_straight_build(context, g) : CPM_OK;
}

cpm_vec cpm_geometry_step_back(const cpm_geometry *g, const cpm_hit *hit, cpm_vec start, cpm_vec came) {
    return scatter_step_back(hit->position, start, came, g->tree.frame.scale);
}

int cpm_geometry_near_edge(const cpm_geometry *g, const cpm_hit *hit) {
    return cpm_is_near_edge(&g->tree, hit);
}

const char *cpm_geometry_embree_version(void) {
    static const char version[] = RTC_VERSION_STRING;
    return version;
}
