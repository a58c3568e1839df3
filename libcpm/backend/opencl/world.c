/* backend/opencl/world.c: see world.h. */
#include "world.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geometry/parts.h"

typedef struct part {
    const char *what; /* for messages */
    const void *from;
    size_t size;
} part;

/* All media's tables in one, and where each begins, in doubles. NULL: no memory. */
static double *join_tables(const cpm_scene *scene, cl_long *first, size_t *size) {
    size_t count = 0;
    for (size_t m = 0; m < scene->medium_count; m++) {
        first[m] = (cl_long)count;
        count += (scene->media[m].medium->table_count + 7) / 8 * 8;
    }
    double *all = calloc(count + 1, sizeof *all);
    for (size_t m = 0; all && m < scene->medium_count; m++) {
        const cpm_medium *medium = scene->media[m].medium;
        if (medium->table_count) memcpy(all + first[m], medium->table, medium->table_count * sizeof *all);
    }
    *size = count * sizeof *all;
    return all;
}

static cpm_status upload(cpm_context *context, const part parts[CPM_WORLD_BUFFERS], cpm_opencl_world *world) {
    const cpm_opencl *o = context->opencl;
    for (int i = 0; i < CPM_WORLD_BUFFERS; i++) {
        cl_int code = CL_SUCCESS;
        if (parts[i].size > o->largest)
            return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY,
                            "the scene's %s take %.1f MB; a buffer of OpenCL device '%s' holds at most %.1f MB: use "
                            "another device or the native backend",
                            parts[i].what, 1e-6 * (double)parts[i].size, o->name, 1e-6 * (double)o->largest);
        world->buffers[i] = cpm_opencl_buffer(o, CL_MEM_READ_ONLY, parts[i].size, parts[i].from, &code);
        if (code != CL_SUCCESS) return cpm_opencl_failed(context, o, "making a scene's buffers", code);
        world->bytes += parts[i].size;
    }
    return CPM_OK;
}

cpm_status cpm_opencl_world_open(const cpm_pass *pass, cpm_opencl_world *world) {
    const cpm_scene *scene = pass->scene;
    const cpm_world *w = &pass->world;
    const cpm_geometry *g = pass->geometry;
    const size_t media = scene->medium_count;
    size_t table_size = 0;
    memset(world, 0, sizeof *world);
    world->pass = pass;
    cl_long *first = calloc(media + 1, sizeof *first);
    double *tables = first ? join_tables(scene, first, &table_size) : NULL;
    cpm_status status = CPM_OK;
    if (!tables) status = cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a scene on a device");
    if (!status) {
        const part parts[CPM_WORLD_BUFFERS] = {
            {"frame", &w->frame, sizeof w->frame},
            {"tree's frame", &g->tree.frame, sizeof g->tree.frame},
            {"tree nodes", g->tree.nodes, g->node_count * sizeof(cpm_tree_node)},
            {"triangles", g->tree.triangles, g->triangle_count * sizeof(cpm_triangle)},
            {"spheres", g->tree.spheres, g->sphere_count * sizeof(cpm_sphere)},
            {"media", w->media, media * sizeof *w->media},
            {"media's tables", tables, table_size},
            {"tables' places", first, media * sizeof *first},
            {"media's places", w->places, media * sizeof *w->places},
            {"dispersion factors", w->scale, media * pass->bins * sizeof *w->scale},
            {"indices", w->index, media * pass->bins * sizeof *w->index},
            {"shapes of triangles", w->triangle_shape, g->triangle_count * sizeof(int32_t)},
            {"shapes of spheres", w->sphere_shape, g->sphere_count * sizeof(int32_t)},
            {"surfaces", w->surfaces, scene->shape_count * sizeof *w->surfaces},
            {"normals", w->normals, w->normals ? 9 * g->triangle_count * sizeof(float) : 0}};
        status = upload(pass->context, parts, world);
    }
    free(first), free(tables);
    if (status) cpm_opencl_world_close(world);
    return status;
}

void cpm_opencl_world_close(cpm_opencl_world *world) {
    const cpm_opencl *o = world->pass ? world->pass->context->opencl : NULL;
    for (int i = 0; o && i < CPM_WORLD_BUFFERS; i++)
        if (world->buffers[i]) o->cl->ReleaseMemObject(world->buffers[i]);
    memset(world, 0, sizeof *world);
}

cl_int cpm_opencl_world_give(const cpm_opencl_world *world, cl_kernel kernel) {
    const cpm_opencl *o = world->pass->context->opencl;
    cl_int code = CL_SUCCESS;
    for (cl_uint i = 0; i < CPM_WORLD_BUFFERS && code == CL_SUCCESS; i++)
        code = o->cl->SetKernelArg(kernel, i, sizeof(cl_mem), &world->buffers[i]);
    return code;
}

void cpm_opencl_options(const cpm_opencl *o, int width, const char *more, char *options, size_t size) {
    snprintf(options, size, "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -DCPM_WIDTH=%d %s",
             o->is_cpu ? width : 1, more);
}

cl_int cpm_opencl_run(const cpm_opencl *o, cl_kernel kernel, size_t items) {
    const size_t one = 1;
    return o->cl->EnqueueNDRangeKernel(o->queue, kernel, 1, NULL, &items, o->is_cpu ? &one : NULL, 0, NULL, NULL);
}
#endif
