/* photon/project.c: projection maps (Jensen; Gutierrez et al. with curved rays through the corners of the cells).
 *
 * A cell is active when any of the curved rays through its corners meets a surface; it is a caustic cell when any of
 * them meets something specular first. Corners alone miss an object that lies within one cell: active cells are dilated
 * by their neighbours, and every cell keeps a share of DEFENSIVE of the paths. Each path's power is divided by the
 * probability of its cell, so the mean is that of emission over all directions. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/backend.h"
#include "cl/shared/sampling.h"
#include "photons.h"

#define ROWS 64
#define COLUMNS 64
#define DEFENSIVE 0.1     /* of the paths, over all cells alike: no power grows by more than 1/DEFENSIVE */
#define CAUSTIC_SHARE 0.5 /* of the paths go to caustic cells, if they need not be denser than CAUSTIC_DENSER */
#define CAUSTIC_DENSER 8.0
#define MAX_BOUNDARIES 64

enum { SEES_SURFACE = 1, SEES_SPECULAR = 2 };

/* One ray has arrived: what it sees, and, where that is only a boundary, its flight beyond. 0: it ends. */
static int goes_on(const cpm_pass *pass, cpm_flight *flight, const cpm_arrival *a, uint8_t *seen) {
    const cpm_scene *scene = pass->scene;
    cpm_passage passage;
    if (a->status != CPM_RAY_HIT) return 0;
    const shape *s = &scene->shapes[cpm_primitive_shape(scene, a->hit.primitive)];
    if (s->material != CPM_NO_MATERIAL) {
        const int32_t kind = scene->materials[s->material].kind;
        *seen |= SEES_SURFACE;
        if (kind == CPM_MATERIAL_MIRROR || kind == CPM_MATERIAL_DIELECTRIC) *seen |= SEES_SPECULAR;
        return 0;
    }
    if (!cpm_pass_boundary(pass, flight, a, &passage)) return 0;
    if (passage.jumps) *seen |= SEES_SPECULAR;
    *flight = passage.total ? passage.reflected : passage.transmitted;
    return 1;
}

/* What the rays through all corners see: boundaries are passed by refraction until a surface ends the ray. All are
 * followed to what they meet next, then those that go on, which are moved to the front. */
static cpm_status look(const cpm_pass *pass, cpm_flight *flights, uint8_t *seen, size_t count) {
    cpm_arrival *arrivals = malloc(count * sizeof *arrivals);
    size_t *which = malloc(count * sizeof *which);
    cpm_status status =
        arrivals && which ? CPM_OK : cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a projection map");
    for (size_t i = 0; i < count && !status; i++) which[i] = i;
    for (int b = 0; b < MAX_BOUNDARIES && count && !status; b++) {
        size_t on = 0;
        status = cpm_backend_of(pass->context)->follow(pass, flights, count, arrivals);
        for (size_t i = 0; i < count && !status; i++)
            if (goes_on(pass, &flights[i], &arrivals[i], &seen[which[i]])) {
                flights[on] = flights[i];
                which[on++] = which[i];
            }
        count = on;
    }
    free(arrivals), free(which);
    return status;
}

/* A cell takes the flags of its neighbours; azimuth wraps, and a pole is one point shared by its whole row. */
static void dilate(const uint8_t *from, uint8_t *to) {
    for (int r = 0; r < ROWS; r++)
        for (int c = 0; c < COLUMNS; c++) {
            uint8_t flags = 0;
            for (int dr = -1; dr <= 1; dr++)
                for (int dc = -1; dc <= 1; dc++)
                    if (r + dr >= 0 && r + dr < ROWS) flags |= from[(r + dr) * COLUMNS + (c + dc + COLUMNS) % COLUMNS];
            to[r * COLUMNS + c] = flags;
        }
    for (int pole = 0; pole < 2; pole++) {
        uint8_t *row = &to[(pole ? ROWS - 1 : 0) * COLUMNS], flags = 0;
        for (int c = 0; c < COLUMNS; c++) flags |= row[c];
        for (int c = 0; c < COLUMNS; c++) row[c] = flags;
    }
}

/* Probabilities and weights from the cells' flags. */
static void weigh(cpm_projection *p, const uint8_t *flags) {
    const int cells = ROWS * COLUMNS;
    for (int i = 0; i < cells; i++) {
        p->active += (flags[i] & SEES_SURFACE) != 0 || (flags[i] & SEES_SPECULAR) != 0;
        p->caustic += (flags[i] & SEES_SPECULAR) != 0;
    }
    double plain = (double)(p->active - p->caustic), caustic = (double)p->caustic, denser = 1.0;
    if (p->caustic && plain > 0.0)
        denser = cpm_min(cpm_max(plain / caustic * CAUSTIC_SHARE / (1.0 - CAUSTIC_SHARE), 1.0), CAUSTIC_DENSER);
    double share = p->active == (uint64_t)cells ? 0.0 : p->active ? DEFENSIVE : 1.0;
    double aimed = plain + denser * caustic, sum = 0.0;
    p->cumulative[0] = 0.0;
    for (int i = 0; i < cells; i++) {
        double target = flags[i] & SEES_SPECULAR ? denser : flags[i] & SEES_SURFACE ? 1.0 : 0.0;
        double probability = share / cells + (aimed > 0.0 ? (1.0 - share) * target / aimed : 0.0);
        p->weight[i] = (float)(1.0 / (cells * probability));
        p->cumulative[i + 1] = sum += probability;
    }
    p->cumulative[cells] = 1.0;
    for (int i = 0, cell = 0; i < cells; i++) {
        while (p->cumulative[cell + 1] <= (double)i / cells) cell++;
        p->guide[i] = cell;
    }
}

cpm_status cpm_project(const cpm_pass *pass, cpm_emitter *emitter, cpm_stats *stats) {
    const size_t corners = (size_t)(ROWS + 1) * COLUMNS, cells = (size_t)ROWS * COLUMNS;
    cpm_projection *p = &emitter->projection;
    cpm_flight *flights = calloc(corners, sizeof *flights);
    uint8_t *seen = calloc(corners, 1), *flags = calloc(cells, 1), *dilated = calloc(cells, 1);
    p->cumulative = calloc(cells + 1, sizeof *p->cumulative);
    p->weight = calloc(cells, sizeof *p->weight);
    p->guide = calloc(cells, sizeof *p->guide);
    const int fine = flights && seen && flags && dilated && p->cumulative && p->weight && p->guide;
    cpm_status status =
        fine ? CPM_OK : cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a projection map");
    if (!status) {
        double cutoff = 1.0 - cpm_cos(emitter->light->cutoff);
        for (int r = 0; r <= ROWS; r++)
            for (int c = 0; c < COLUMNS; c++) {
                cpm_flight *f = &flights[r * COLUMNS + c];
                double cosine = cpm_max(1.0 - cutoff * r / ROWS, -1.0);
                f->position = emitter->light->position;
                f->direction = direction_about(emitter->light->axis, cosine, (double)c / COLUMNS);
                f->region = emitter->region;
                f->left = -1;
                f->bin = pass->middle;
            }
        status = look(pass, flights, seen, corners);
    }
    if (!status) {
        for (int r = 0; r < ROWS; r++)
            for (int c = 0; c < COLUMNS; c++) {
                int next = (c + 1) % COLUMNS;
                flags[r * COLUMNS + c] = seen[r * COLUMNS + c] | seen[r * COLUMNS + next] |
                                         seen[(r + 1) * COLUMNS + c] | seen[(r + 1) * COLUMNS + next];
            }
        dilate(flags, dilated);
        p->rows = ROWS, p->columns = COLUMNS;
        weigh(p, dilated);
        stats->projection_cells += cells;
        stats->projection_active += p->active;
        if (pass->features & CPM_FEATURE_SPECULAR) {
            stats->projection_caustic_cells += cells;
            stats->projection_caustic_active += p->caustic;
        }
    }
    free(flights), free(seen), free(flags), free(dilated);
    return status;
}
