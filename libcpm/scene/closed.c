/* scene/closed.c: is a mesh a closed surface, oriented outward? A dielectric's inside is defined by it.
 *
 * Closed and consistently oriented: every directed edge has its opposite as often as itself. Corners that share a
 * position count as one vertex, so that meshes with split normals or per-face corners serve. Outward: positive volume. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

#define GRID 33554432.0 /* 2^25 cells across the shape: far above the rounding of corner + edge, far below its detail */

typedef struct corner {
    int32_t cell[3];
    uint32_t slot;
} corner;

static int compare_corners(const void *a, const void *b) {
    const corner *x = a, *y = b;
    for (int k = 0; k < 3; k++) {
        if (x->cell[k] < y->cell[k]) return -1;
        if (x->cell[k] > y->cell[k]) return 1;
    }
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Numbers the corners by their cell in a grid over the box, moved by `shift` of a cell. vertex[3 triangle + corner]. */
static int number_corners(const cpm_triangle *triangles, size_t count, const cpm_box *box, double shift,
                          uint32_t *vertex) {
    double size = 0.0;
    for (int k = 0; k < 3; k++) size = fmax(size, box->high[k] - box->low[k]);
    corner *corners = malloc(3 * count * sizeof *corners);
    if (!corners) return 0;
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) {
            corner *to = &corners[3 * i + (size_t)c];
            to->slot = (uint32_t)(3 * i + (size_t)c);
            for (int k = 0; k < 3; k++) {
                double r = triangles[i].corner[k];
                if (c == 1) r += triangles[i].edge1[k];
                if (c == 2) r += triangles[i].edge2[k];
                to->cell[k] = (int32_t)floor((r - box->low[k]) / size * GRID + shift);
            }
        }
    qsort(corners, 3 * count, sizeof *corners, compare_corners);
    uint32_t number = 0;
    for (size_t i = 0; i < 3 * count; i++) {
        if (i && compare_corners(&corners[i - 1], &corners[i])) number++;
        vertex[corners[i].slot] = number;
    }
    free(corners);
    return 1;
}

/* The first directed edge without its opposite: its triangle; -1: closed; -2: out of memory. */
static int64_t first_open_edge(const uint32_t *vertex, size_t count) {
    uint64_t *edges = malloc(3 * count * sizeof *edges), *opposite = malloc(3 * count * sizeof *opposite);
    int64_t open = -1;
    if (!edges || !opposite) {
        open = -2;
    } else {
        size_t used = 0;
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 3; c++) {
                uint64_t a = vertex[3 * i + c], b = vertex[3 * i + (c + 1) % 3];
                if (a == b) continue;
                edges[used] = a << 32 | b;
                opposite[used++] = b << 32 | a;
            }
        qsort(edges, used, sizeof *edges, compare_edges);
        qsort(opposite, used, sizeof *opposite, compare_edges);
        for (size_t i = 0; i < used && open == -1; i++)
            if (edges[i] != opposite[i]) open = (int64_t)i;
    }
    free(edges), free(opposite);
    return open;
}

cpm_status cpm_shape_require_closed(cpm_scene *scene, int32_t index) {
    shape *s = &scene->shapes[index];
    if (s->closed == 1) return CPM_OK;
    const cpm_triangle *t = &scene->triangles[s->first];
    uint32_t *vertex = malloc(3 * s->count * sizeof *vertex);
    int64_t open = 0;
    /* one vertex may round to either side of a cell's face; four grids have no face in common */
    for (double shift = 0.5; open >= 0 && shift < 1.5; shift += 0.27)
        open = vertex && number_corners(t, s->count, &s->box, shift, vertex) ? first_open_edge(vertex, s->count) : -2;
    free(vertex);
    if (open == -2)
        return cpm_fail(scene->context, CPM_ERROR_OUT_OF_MEMORY, "no memory to check that shape '%s' is closed", s->name);
    if (open >= 0)
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT,
                        "shape '%s' is open or its triangles are not oriented alike; what bounds a medium (a dielectric "
                        "too) must be closed, with outward normals", s->name);
    double volume = 0.0;
    for (size_t i = 0; i < s->count; i++)
        for (int k = 0; k < 3; k++) volume += (t[i].corner[k] - t[0].corner[k]) * t[i].normal[k] / 6.0;
    if (!(volume > 0.0))
        return cpm_fail(scene->context, CPM_ERROR_INVALID_ARGUMENT,
                        "shape '%s' is inside out: its normals point inward (volume %g m3); turn the faces round", s->name,
                        volume);
    s->closed = 1;
    return CPM_OK;
}
