/* photon/emit.c: how paths start. Paths are shared out over the lights by power, in consecutive numbers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/philox.h"
#include "cl/shared/sampling.h"
#include "cl/shared/sobol.h"
#include "photons.h"

#define AREA_SAMPLES 64 /* points at which an area light's n^2 is looked at */

/* A light's paths follow Sobol's sequence, scrambled by the seed: point and spot lights walk through the cells of their
 * projection map in order, area lights through their triangles, and both cover what they walk through evenly. Lit areas
 * come out with far less noise than independent numbers would give. */
static double even(const cpm_emitter *e, uint64_t index, int dimension) {
    return cpm_uniform(cpm_sobol((uint32_t)index, dimension, e->shift[dimension]));
}
/* The walk itself: path i of N is somewhere in [i, i + 1)/N. */
static double walked(const cpm_emitter *e, uint64_t index) {
    return ((double)index + cpm_uniform(e->shift[0])) / (double)e->count;
}

/* ------------------------------------------------------------------------------------------------ area lights */

/* A point uniform over the light: `along` its triangles, (u, v) within one. */
static void point_of_area(const cpm_scene *scene, const cpm_emitter *e, double along, double u, double v, cpm_vec *point,
                          cpm_vec *normal, int32_t *primitive) {
    const shape *s = &scene->shapes[e->light->shape];
    if (s->is_sphere) {
        const cpm_sphere *ball = &scene->spheres[s->first];
        *normal = cpm_sample_cone(cpm_v(0.0, 0.0, 1.0), -1.0, u, v);
        *point = cpm_along(cpm_v(ball->center[0], ball->center[1], ball->center[2]), ball->radius, *normal);
        *primitive = (int32_t)(scene->triangle_count + s->first);
        return;
    }
    double wanted = along * e->area[s->count];
    size_t low = 0, high = s->count;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (e->area[middle] <= wanted) low = middle;
        else high = middle;
    }
    const cpm_triangle *t = &scene->triangles[s->first + low];
    double a, b;
    cpm_sample_triangle(u, v, &a, &b);
    *point = cpm_v(t->corner[0] + a * t->edge1[0] + b * t->edge2[0], t->corner[1] + a * t->edge1[1] + b * t->edge2[1],
                   t->corner[2] + a * t->edge1[2] + b * t->edge2[2]);
    *normal = cpm_scaled(sqrt(t->inverse_area2), cpm_v(t->normal[0], t->normal[1], t->normal[2]));
    *primitive = (int32_t)(s->first + low);
}

/* n^2 on the light, which its power carries (basic radiance L: a surface in index n emits pi n^2 L A). */
static double squared_index(const cpm_pass *pass, const cpm_region *region, cpm_vec point) {
    double n = cpm_pass_index(pass, cpm_region_medium(region), -1, point);
    return n > 0.0 ? n * n : 0.0;
}

static cpm_status prepare_area(const cpm_pass *pass, cpm_emitter *e, uint64_t seed, double *mean_squared) {
    const cpm_scene *scene = pass->scene;
    const shape *s = &scene->shapes[e->light->shape];
    if (!s->is_sphere) {
        e->area = malloc((s->count + 1) * sizeof *e->area);
        if (!e->area) return cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an area light");
        e->area[0] = 0.0;
        for (size_t i = 0; i < s->count; i++)
            e->area[i + 1] = e->area[i] + 0.5 / sqrt(scene->triangles[s->first + i].inverse_area2);
    }
    double sum = 0.0;
    for (uint32_t i = 0; i < AREA_SAMPLES; i++) {
        cpm_random r = cpm_philox(seed, i, 1, CPM_STREAM_EMIT, 0);
        cpm_vec point, normal;
        int32_t primitive;
        point_of_area(scene, e, cpm_uniform(r.v[2]), cpm_uniform(r.v[0]), cpm_uniform(r.v[1]), &point, &normal,
                      &primitive);
        cpm_region region = cpm_region_at(pass, point, normal);
        sum += squared_index(pass, &region, point);
    }
    *mean_squared = sum / AREA_SAMPLES;
    e->power_factor = *mean_squared > 0.0 ? 1.0 / *mean_squared : 0.0;
    return CPM_OK;
}

static int emit_area(const cpm_pass *pass, const cpm_emitter *e, uint64_t index, cpm_flight *flight, double *weight) {
    cpm_vec normal;
    point_of_area(pass->scene, e, walked(e, index), even(e, index, 0), even(e, index, 1), &flight->position, &normal,
                  &flight->left);
    flight->direction = cpm_sample_cosine(normal, even(e, index, 2), even(e, index, 3));
    flight->region = cpm_region_at(pass, flight->position, normal);
    flight->exact = 1;
    *weight = squared_index(pass, &flight->region, flight->position) * e->power_factor;
    return *weight > 0.0;
}

/* ------------------------------------------------------------------------------------- point and spot lights */

static void emit_delta(const cpm_emitter *e, uint64_t index, cpm_flight *flight, double *weight) {
    const cpm_projection *p = &e->projection;
    double u = even(e, index, 0), v = even(e, index, 1);
    const double cutoff = e->cutoff;
    *weight = 1.0;
    if (p->rows) {
        double wanted = walked(e, index);
        size_t cells = (size_t)p->rows * (size_t)p->columns, part = (size_t)(wanted * (double)cells);
        size_t low = (size_t)p->guide[part < cells ? part : cells - 1];
        while (p->cumulative[low + 1] <= wanted) low++;
        *weight = (double)p->weight[low];
        u = ((double)(low / (size_t)p->columns) + u) / p->rows;
        v = ((double)(low % (size_t)p->columns) + v) / p->columns;
    }
    flight->position = e->light->position;
    flight->direction = cpm_direction_about(e->light->axis, cpm_max(1.0 - u * cutoff, -1.0), v);
    flight->region = e->region;
    flight->left = -1;
}

int cpm_emit(const cpm_pass *pass, const cpm_emitter *e, uint64_t path, cpm_flight *flight, float *powers) {
    double weight;
    memset(flight, 0, sizeof *flight);
    flight->bin = -1;
    if (e->light->kind == CPM_LIGHT_AREA) {
        if (!emit_area(pass, e, path - e->first, flight, &weight)) return 0;
    } else {
        emit_delta(e, path - e->first, flight, &weight);
    }
    for (size_t b = 0; b < pass->bins; b++) powers[b] = (float)weight * e->weight[b];
    return 1;
}

/* --------------------------------------------------------------------------------------------- sharing out paths */

/* Power of a light over its emission spectrum: what W/sr/nm or basic radiance is multiplied by. */
static double power_of(const cpm_pass *pass, const light *l, double mean_squared) {
    if (l->kind == CPM_LIGHT_AREA) return CPM_PI * mean_squared * pass->scene->shapes[l->shape].area;
    return CPM_TWO_PI * (1.0 - cpm_cos(l->cutoff));
}

static double mean_emission(const cpm_pass *pass, size_t l) {
    double sum = 0.0;
    for (size_t b = 0; b < pass->bins; b++) sum += pass->emission[l * pass->bins + b];
    return sum / (double)pass->bins;
}

/* Path numbers in proportion to power; every light that shines gets one at least where there are enough. */
static void share_out(cpm_emitter *e, size_t count, const double *power, uint64_t photons) {
    double total = 0.0, so_far = 0.0;
    for (size_t i = 0; i < count; i++) total += power[i];
    uint64_t first = 0;
    for (size_t i = 0; i < count; i++) {
        so_far += power[i];
        uint64_t end = total > 0.0 ? (uint64_t)llround(so_far / total * (double)photons) : 0;
        if (power[i] > 0.0 && end <= first && first < photons) end = first + 1;
        if (end > photons) end = photons;
        if (end < first) end = first;
        e[i].first = first;
        e[i].count = end - first;
        first = end;
    }
}

cpm_status cpm_emitters_create(const cpm_pass *pass, uint64_t photons, uint64_t seed, int32_t project,
                               cpm_emitter **emitters, size_t *count, double *scale, cpm_stats *stats) {
    const cpm_scene *scene = pass->scene;
    size_t lights = scene->light_count;
    cpm_emitter *e = calloc(lights + 1, sizeof *e);
    double *power = calloc(lights + 1, sizeof *power), *factor = calloc(lights + 1, sizeof *factor), total = 0.0;
    cpm_status status = e && power && factor
                            ? CPM_OK
                            : cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for %zu lights", lights);
    for (size_t i = 0; i < lights && !status; i++) {
        double mean_squared = 0.0;
        e[i].light = &scene->lights[i];
        e[i].cutoff = 1.0 - cpm_cos(scene->lights[i].cutoff);
        e[i].weight = calloc(pass->bins, sizeof(float));
        if (!e[i].weight) status = cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a light");
        else if (scene->lights[i].kind == CPM_LIGHT_AREA) status = prepare_area(pass, &e[i], seed, &mean_squared);
        else {
            e[i].region = cpm_region_at(pass, scene->lights[i].position, scene->lights[i].axis);
            double n = cpm_pass_index(pass, cpm_region_medium(&e[i].region), -1, scene->lights[i].position);
            if (!(n > 0.0))
                status = cpm_fail(pass->context, CPM_ERROR_INVALID_ARGUMENT,
                                  "light %zu, at (%g, %g, %g): n^2 is not positive there", i,
                                  scene->lights[i].position.x, scene->lights[i].position.y, scene->lights[i].position.z);
        }
        cpm_random r = cpm_philox(seed, (uint32_t)i, 3, CPM_STREAM_EMIT, 0);
        memcpy(e[i].shift, r.v, sizeof e[i].shift);
        factor[i] = power_of(pass, &scene->lights[i], mean_squared);
        total += power[i] = factor[i] * mean_emission(pass, i);
    }
    if (!status) {
        share_out(e, lights, power, photons);
        *scale = photons && total > 0.0 ? total / (double)photons : 0.0;
    }
    for (size_t i = 0; i < lights && !status; i++) {
        if (!e[i].count) continue;
        for (size_t b = 0; b < pass->bins; b++)
            e[i].weight[b] = (float)(factor[i] * pass->emission[i * pass->bins + b] / ((double)e[i].count * *scale));
        if (project && scene->lights[i].kind != CPM_LIGHT_AREA) status = cpm_project(pass, &e[i], stats);
    }
    free(power), free(factor);
    *emitters = e;
    *count = lights;
    if (status) {
        cpm_emitters_free(e, lights);
        *emitters = NULL;
    }
    return status;
}

void cpm_emitters_free(cpm_emitter *emitters, size_t count) {
    for (size_t i = 0; emitters && i < count; i++) {
        free(emitters[i].weight), free(emitters[i].area);
        free(emitters[i].projection.cumulative), free(emitters[i].projection.weight);
        free(emitters[i].projection.guide);
    }
    free(emitters);
}
