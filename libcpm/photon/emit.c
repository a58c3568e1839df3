/* photon/emit.c: how paths start. Paths are shared out over the lights by power, in consecutive numbers; what one path
 * does is cl/shared/emit.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/emit.h"
#include "photons.h"

#define AREA_SAMPLES 64 /* points at which an area light's n^2 is looked at */

/* n^2 on the light, which its power carries (basic radiance L: a surface in index n emits pi n^2 L A). */
static double squared_index(const cpm_pass *pass, const cpm_region *region, cpm_vec point) {
    double n = cpm_pass_index(pass, cpm_region_medium(region), -1, point);
    return n > 0.0 ? n * n : 0.0;
}

static const cpm_triangle *triangles_of(const cpm_pass *pass, const cpm_emitter *e) {
    return e->data.triangles ? &pass->scene->triangles[e->data.primitive] : NULL;
}

static void describe_area(const cpm_scene *scene, const shape *s, cpm_emitter_data *d) {
    if (s->is_sphere) {
        const cpm_sphere *ball = &scene->spheres[s->first];
        memcpy(d->position, ball->center, sizeof d->position);
        d->radius = ball->radius;
        d->primitive = (int32_t)(scene->triangle_count + s->first);
    } else {
        d->primitive = (int32_t)s->first;
        d->triangles = (int32_t)s->count;
    }
}

static cpm_status prepare_area(const cpm_pass *pass, cpm_emitter *e, uint64_t seed, double *mean_squared) {
    const cpm_scene *scene = pass->scene;
    const shape *s = &scene->shapes[e->light->shape];
    describe_area(scene, s, &e->data);
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
        emit_area_point(&e->data, triangles_of(pass, e), e->area, cpm_uniform(r.v[2]), cpm_uniform(r.v[0]),
                        cpm_uniform(r.v[1]), &point, &normal, &primitive);
        cpm_region region = cpm_region_at(pass, point, normal);
        sum += squared_index(pass, &region, point);
    }
    *mean_squared = sum / AREA_SAMPLES;
    e->power_factor = *mean_squared > 0.0 ? 1.0 / *mean_squared : 0.0;
    return CPM_OK;
}

static cpm_vec of_block(double (*p)[CPM_BLOCK], size_t i) { return cpm_v(p[0][i], p[1][i], p[2][i]); }

size_t cpm_emit(const cpm_pass *pass, const cpm_emitter *e, uint64_t path, size_t count, cpm_emissions *made,
                cpm_flight *flights, uint32_t *paths, float *weights) {
    const cpm_pass_code *code = cpm_pass_code_chosen();
    const cpm_projection *p = &e->projection;
    const uint64_t index = path - e->first;
    const int area = e->light->kind == CPM_LIGHT_AREA;
    size_t carrying = 0;
    if (area)
        code->emit_area(&e->data, triangles_of(pass, e), e->area, index, count, made);
    else
        code->emit_delta(&e->data, p->cumulative, p->guide, p->weight, index, count, made);
    for (size_t i = 0; i < count; i++) {
        cpm_flight *f = &flights[carrying];
        f->direction = of_block(made->direction, i);
        f->position = area ? of_block(made->position, i) : e->light->position;
        f->region = area ? cpm_region_at(pass, f->position, of_block(made->normal, i)) : e->region;
        f->left = area ? made->primitive[i] : -1;
        f->exact = area;
        f->bin = -1;
        f->crossing = 0;
        weights[carrying] =
            (float)(area ? squared_index(pass, &f->region, f->position) * e->power_factor : made->weight[i]);
        paths[carrying] = (uint32_t)(path + i);
        carrying += weights[carrying] > 0.0f;
    }
    return carrying;
}

/* A surface emits n^2 L: a path's weight has the middle bin's n, the others have their own where a medium disperses. */
const float *cpm_emit_spectrum(const cpm_pass *pass, const cpm_emitter *e, const cpm_flight *flight, float *own) {
    const int32_t medium = cpm_region_medium(&flight->region);
    if (e->light->kind != CPM_LIGHT_AREA || !pass->disperses[medium]) return e->weight;
    const double middle = squared_index(pass, &flight->region, flight->position);
    for (size_t b = 0; b < pass->bins; b++) {
        const double n = cpm_pass_index(pass, medium, (int32_t)b, flight->position);
        own[b] = emit_own(e->weight[b], n > 0.0 ? n * n : 0.0, middle);
    }
    return own;
}

/* N paths over a solid angle, or over an area and its hemisphere: k of them fill a circle of angular radius
 * sqrt(k angle/(pi N)), or sqrt(k area/(pi N)) metres on the light and sqrt(k/N) more for each metre away. */
cpm_leeway cpm_emitter_leeway(const cpm_pass *pass, const cpm_emitter *e, float weight) {
    const double share = pass->nearest * (double)weight / (double)e->count;
    cpm_leeway leeway = {0.0, 0.0};
    if (e->light->kind == CPM_LIGHT_AREA) {
        leeway.size = pass->bundle_tolerance * sqrt(share / CPM_PI * pass->scene->shapes[e->light->shape].area);
        leeway.angle = pass->bundle_tolerance * sqrt(share);
    } else if (cpm_light_is_far(e->light)) { /* over the shadow of the box that they cross: a quarter of its surface */
        const double x = e->box.high[0] - e->box.low[0], y = e->box.high[1] - e->box.low[1];
        const double z = e->box.high[2] - e->box.low[2];
        leeway.size = pass->bundle_tolerance * sqrt(share / CPM_PI * 0.5 * (x * y + y * z + z * x));
    } else {
        const double solid = CPM_TWO_PI * (1.0 - cpm_cos(e->light->cutoff));
        leeway.angle = pass->bundle_tolerance * sqrt(share * solid / CPM_PI);
    }
    return leeway;
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

/* Path numbers in proportion to power; every light that shines gets one at least where there are enough. Where there
 * are not, chance decides which lights do: systematic sampling with one offset u in [0, 1), so that each gets as many
 * as its share on average, and a path weighs what one of that many would. `expected` is what weights are divided by:
 * the count itself where every light has some (no noise in the power emitted), else the share. */
static void share_out(cpm_emitter *e, size_t count, const double *power, uint64_t photons, double u, double *expected) {
    double total = 0.0, so_far = 0.0;
    uint64_t shining = 0, first = 0;
    for (size_t i = 0; i < count; i++) total += power[i], shining += power[i] > 0.0;
    const int enough = photons >= shining;
    for (size_t i = 0; i < count; i++) {
        so_far += power[i];
        const double paths = total > 0.0 ? so_far / total * (double)photons : 0.0;
        uint64_t end = enough ? (uint64_t)llround(paths) : (uint64_t)floor(paths + u);
        if (power[i] > 0.0) shining--;
        const uint64_t most = enough ? photons - shining : photons; /* one is left for each that is still to come */
        if (enough && power[i] > 0.0 && end <= first) end = first + 1;
        if (end > most) end = most;
        if (end < first) end = first;
        e[i].first = first;
        e[i].count = end - first;
        expected[i] = enough ? (double)e[i].count : power[i] / total * (double)photons;
        first = end;
    }
}

cpm_status cpm_emitters_create(const cpm_pass *pass, uint64_t photons, uint64_t seed, int32_t project,
                               cpm_emitter **emitters, size_t *count, double *scale, cpm_stats *stats) {
    const cpm_scene *scene = pass->scene;
    size_t lights = scene->light_count;
    cpm_emitter *e = calloc(lights + 1, sizeof *e);
    double *power = calloc(lights + 1, sizeof *power), *factor = calloc(lights + 1, sizeof *factor), total = 0.0;
    double *expected = calloc(lights + 1, sizeof *expected);
    cpm_status status = e && power && factor && expected
                            ? CPM_OK
                            : cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for %zu lights", lights);
    for (size_t i = 0; i < lights && !status; i++) {
        double mean_squared = 0.0;
        e[i].light = &scene->lights[i];
        e[i].number = i;
        e[i].data.cutoff = 1.0 - cpm_cos(scene->lights[i].cutoff);
        const cpm_vec at = scene->lights[i].position, axis = scene->lights[i].axis;
        memcpy(e[i].data.position, (const double[3]){at.x, at.y, at.z}, sizeof e[i].data.position);
        memcpy(e[i].data.axis, (const double[3]){axis.x, axis.y, axis.z}, sizeof e[i].data.axis);
        e[i].weight = calloc(pass->bins, sizeof(float));
        if (!e[i].weight)
            status = cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a light");
        else if (scene->lights[i].kind == CPM_LIGHT_AREA)
            status = prepare_area(pass, &e[i], seed, &mean_squared);
        else if (cpm_light_is_far(&scene->lights[i]))
            status = cpm_far_begin(pass, &e[i], project, &factor[i]);
        else {
            e[i].region = cpm_region_at(pass, scene->lights[i].position, scene->lights[i].axis);
            double n = cpm_pass_index(pass, cpm_region_medium(&e[i].region), -1, scene->lights[i].position);
            if (!(n > 0.0))
                status = cpm_fail(
                    pass->context, CPM_ERROR_INVALID_ARGUMENT, "light %zu, at (%g, %g, %g): n^2 is not positive there",
                    i, scene->lights[i].position.x, scene->lights[i].position.y, scene->lights[i].position.z);
        }
        cpm_random r = cpm_philox(seed, (uint32_t)i, 3, CPM_STREAM_EMIT, 0);
        memcpy(e[i].data.shift, r.v, sizeof e[i].data.shift);
        if (!cpm_light_is_far(&scene->lights[i])) factor[i] = power_of(pass, &scene->lights[i], mean_squared);
        total += power[i] = factor[i] * mean_emission(pass, i);
    }
    if (!status) {
        const cpm_random r = cpm_philox(seed, 0, 5, CPM_STREAM_EMIT, 0);
        share_out(e, lights, power, photons, cpm_uniform(r.v[0]), expected);
        *scale = photons && total > 0.0 ? total / (double)photons : 0.0;
    }
    for (size_t i = 0; i < lights && !status; i++) {
        if (!e[i].count) continue;
        e[i].data.count = (double)e[i].count;
        for (size_t b = 0; b < pass->bins; b++)
            e[i].weight[b] = (float)(factor[i] * pass->emission[i * pass->bins + b] / (expected[i] * *scale));
        if (cpm_light_is_far(&scene->lights[i])) {
            e[i].power_factor /= expected[i] * *scale;
            continue;
        }
        if (project && scene->lights[i].kind != CPM_LIGHT_AREA) status = cpm_project(pass, &e[i], stats);
        e[i].data.rows = e[i].projection.rows, e[i].data.columns = e[i].projection.columns;
    }
    free(power), free(factor), free(expected);
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
        free(emitters[i].weight), free(emitters[i].area), free(emitters[i].inside);
        free(emitters[i].projection.cumulative), free(emitters[i].projection.weight);
        free(emitters[i].projection.guide);
    }
    free(emitters);
}
