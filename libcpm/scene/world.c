/* scene/world.c: see world.h. */
#include "world.h"

#include <stdlib.h>
#include <string.h>

#include "cpm/status.h"
#include "geometry/parts.h"

_Static_assert(CPM_SURFACE_BLACK == CPM_MATERIAL_BLACK && CPM_SURFACE_DIFFUSE == CPM_MATERIAL_DIFFUSE &&
                   CPM_SURFACE_MIRROR == CPM_MATERIAL_MIRROR && CPM_SURFACE_DIELECTRIC == CPM_MATERIAL_DIELECTRIC,
               "surfaces are materials");
_Static_assert(CPM_ARRIVAL_HIT == CPM_RAY_HIT && CPM_ARRIVAL_LEFT == CPM_RAY_LEFT &&
                   CPM_ARRIVAL_EXHAUSTED == CPM_RAY_EVALUATIONS_EXHAUSTED && CPM_ARRIVAL_CUTOFF == CPM_RAY_CUTOFF,
               "arrivals have a ray's status");

static cpm_world_frame frame_of(const cpm_pass *pass) {
    cpm_world_frame f = {.reach = pass->reach,
                         .bins = (int32_t)pass->bins,
                         .middle = pass->middle,
                         .nudge = pass->nudge,
                         .media = (int32_t)pass->scene->medium_count,
                         .bounded = pass->bounded,
                         .coarse = !pass->geometry->straight};
    memcpy(f.low, pass->extent.low, sizeof f.low), memcpy(f.high, pass->extent.high, sizeof f.high);
    memcpy(f.box_low, pass->box.low, sizeof f.box_low), memcpy(f.box_high, pass->box.high, sizeof f.box_high);
    f.center[0] = pass->center.x, f.center[1] = pass->center.y, f.center[2] = pass->center.z;
    return f;
}

static void describe_media(const cpm_pass *pass, cpm_medium_data *media, const double **tables, cpm_place *places) {
    const cpm_scene *scene = pass->scene;
    for (size_t m = 0; m < scene->medium_count; m++) {
        media[m] = scene->media[m].medium->data;
        tables[m] = scene->media[m].medium->table;
        places[m] = (cpm_place){.way = pass->way[m],
                                .method = pass->method[m],
                                .also = scene->media[m].also,
                                .disperses = pass->disperses[m]};
        if (scene->media[m].shape < 0) continue;
        const shape *s = &scene->shapes[scene->media[m].shape];
        places[m].is_sphere = s->is_sphere;
        places[m].first = (int32_t)s->first, places[m].count = (int32_t)s->count;
        memcpy(places[m].low, s->box.low, sizeof places[m].low);
        memcpy(places[m].high, s->box.high, sizeof places[m].high);
    }
}

static void describe_surfaces(const cpm_scene *scene, cpm_surface *surfaces) {
    for (size_t i = 0; i < scene->shape_count; i++) {
        const shape *s = &scene->shapes[i];
        surfaces[i] = (cpm_surface){.kind = s->material == CPM_NO_MATERIAL ? CPM_SURFACE_NONE
                                                                           : scene->materials[s->material].kind,
                                    .material = s->material,
                                    .medium = s->medium,
                                    .has_normals = s->has_normals && scene->normals};
    }
}

int cpm_world_begin(cpm_pass *pass) {
    const cpm_scene *scene = pass->scene;
    cpm_world *w = &pass->world;
    cpm_medium_data *media = calloc(scene->medium_count + 1, sizeof *media);
    const double **tables = calloc(scene->medium_count + 1, sizeof *tables);
    cpm_place *places = calloc(scene->medium_count + 1, sizeof *places);
    cpm_surface *surfaces = calloc(scene->shape_count + 1, sizeof *surfaces);
    w->media = media, w->tables.of = tables, w->places = places, w->surfaces = surfaces;
    if (!media || !tables || !places || !surfaces) return 0;
    describe_media(pass, media, tables, places);
    describe_surfaces(scene, surfaces);
    w->tree = pass->geometry->tree;
    w->frame = frame_of(pass);
    w->scale = pass->scale, w->index = pass->index;
    w->triangle_shape = scene->triangle_shape, w->sphere_shape = scene->sphere_shape;
    w->normals = scene->normals;
    w->geometry = pass->geometry;
    return 1;
}

void cpm_world_end(cpm_pass *pass) {
    cpm_world *w = &pass->world;
    free((void *)(uintptr_t)w->media), free((void *)(uintptr_t)w->tables.of);
    free((void *)(uintptr_t)w->places), free((void *)(uintptr_t)w->surfaces);
}
