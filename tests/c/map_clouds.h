/* map_clouds.h: eleven kinds of photon cloud, and queries among them, for test_map.c. */
#ifndef CPM_TESTS_MAP_CLOUDS_H
#define CPM_TESTS_MAP_CLOUDS_H
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "cl/shared/gather.h"
#include "cl/shared/half.h"
#include "cl/shared/philox.h"
#include "photon/tree.h"

#define PI 3.14159265358979323846

typedef struct cloud {
    size_t count, bins, spectra_count;
    cpm_photon *photons;
    uint16_t *spectra;
} cloud;

typedef struct ask {
    float point[3], normal[3];
} ask;

/* --- clouds ---------------------------------------------------------------------------------------------------- */

static double uniform(uint32_t i, uint32_t what) { return cpm_uniform(cpm_philox(42, i, what / 4, 7, 0).v[what % 4]); }

typedef enum shape { VOLUME, CUBE, SHELL, CLUSTERS, OUTLIER, LATTICE, WALL, POINT, HUGE_CUBE, TINY_CUBE, LINE } shape;
static const char *const shape_names[] = {"volume", "cube",  "shell",     "clusters",  "outlier", "lattice",
                                          "wall",   "point", "huge cube", "tiny cube", "line"};

/* Position and normal of photon i (or query i, with another stream). */
static void place(shape s, uint32_t i, uint32_t stream, double *p, double *n) {
    const double u = uniform(i, stream), v = uniform(i, stream + 1), w = uniform(i, stream + 2);
    n[0] = n[1] = 0.0, n[2] = 1.0;
    p[0] = u, p[1] = v, p[2] = w;
    switch (s) {
    case VOLUME: break;
    case CUBE:
    case HUGE_CUBE:
    case TINY_CUBE: {
        const int face = (int)(6.0 * uniform(i, stream + 3)), a = face / 2;
        p[a] = face & 1;
        n[0] = n[1] = n[2] = 0.0, n[a] = face & 1 ? -1.0 : 1.0;
        const double size = s == HUGE_CUBE ? 2e37 : s == TINY_CUBE ? 1e-30 : 1.0;
        for (int b = 0; b < 3; b++) p[b] *= size;
        break;
    }
    case SHELL: { /* both sides of a thin sphere */
        const double z = 2.0 * u - 1.0, r = sqrt(1.0 - z * z), side = w < 0.5 ? 1.0 : -1.0;
        p[0] = r * cos(2.0 * PI * v), p[1] = r * sin(2.0 * PI * v), p[2] = z;
        for (int a = 0; a < 3; a++) n[a] = side * p[a];
        break;
    }
    case CLUSTERS: { /* of very different sizes and densities */
        const int cluster = (int)(8.0 * uniform(i, stream + 3));
        const double size = pow(10.0, -cluster);
        for (int a = 0; a < 3; a++) p[a] = cos(5.0 * cluster + a) + size * (p[a] + u * v * w);
        break;
    }
    case OUTLIER: /* nearly everything in one cell of any grid over the whole */
        for (int a = 0; a < 3; a++) p[a] = i % 1000 == 0 ? 1e6 * p[a] : 1e-3 * p[a];
        break;
    case LATTICE: /* many in one point, most distances shared by many */
        for (int a = 0; a < 3; a++) p[a] = floor(6.0 * p[a]);
        break;
    case WALL: /* both sides of a wall, in the middle of the box, wrong in the last bit */
        p[2] = i % 97 == 0 ? 2.0 * w - 1.0 : (w - 0.5) * 1e-7;
        n[2] = i & 1 ? 1.0 : -1.0;
        break;
    case POINT: p[0] = 0.25, p[1] = -3.5, p[2] = 1.0; break;
    case LINE: p[1] = p[2] = 0.5; break;
    }
}

/* Every `split`-th photon carries one bin (0: none does). The order is a permutation that `order` chooses. */
static cloud cloud_make(shape s, size_t count, size_t bins, unsigned split, uint64_t order) {
    cloud c = {.count = count, .bins = bins};
    c.photons = malloc((count + 1) * sizeof *c.photons);
    c.spectra = malloc((count * bins + 1) * sizeof *c.spectra);
    assert_non_null(c.photons);
    assert_non_null(c.spectra);
    uint32_t *number = malloc((count + 1) * sizeof *number);
    assert_non_null(number);
    for (size_t i = 0; i < count; i++) number[i] = (uint32_t)i;
    for (size_t i = count; order && i > 1; i--) {
        const size_t j = cpm_philox(order, (uint32_t)i, 0, 1, 0).v[0] % i;
        const uint32_t swap = number[i - 1];
        number[i - 1] = number[j], number[j] = swap;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t id = number[i];
        double p[3], n[3];
        place(s, id, 0, p, n);
        cpm_photon *photon = &c.photons[i];
        *photon = (cpm_photon){.position = {(float)p[0], (float)p[1], (float)p[2]},
                               .normal = cpm_octahedral_encode(cpm_v(n[0], n[1], n[2])),
                               .spectrum = (uint32_t)c.spectra_count,
                               .path = id / 3, /* three to a path: ties are decided by bounce and bin as well */
                               .bounce = (unsigned short)(id % 3),
                               .bin = CPM_ALL_BINS};
        size_t carried = bins;
        if (split && id % split == 0) { /* one bin, two, three, ... or as many as there are from there on */
            const size_t first = id / split % bins, wanted = 1 + id / split / bins % 4;
            carried = first + wanted > bins ? bins - first : wanted;
            photon->bin = (unsigned short)(first + 256 * (carried - 1));
        }
        for (size_t b = 0; b < carried; b++)
            c.spectra[c.spectra_count++] = cpm_half_from_float((float)(uniform(id, 8 + (uint32_t)b) * 3.0));
    }
    free(number);
    return c;
}

static cloud cloud_copy(const cloud *c) {
    cloud d = *c;
    d.photons = malloc((c->count + 1) * sizeof *c->photons);
    d.spectra = malloc((c->spectra_count + 1) * sizeof *c->spectra);
    assert_non_null(d.photons);
    assert_non_null(d.spectra);
    memcpy(d.photons, c->photons, c->count * sizeof *c->photons);
    memcpy(d.spectra, c->spectra, c->spectra_count * sizeof *c->spectra);
    return d;
}

static void cloud_free(cloud *c) {
    free(c->photons);
    free(c->spectra);
}

#define SCALE 0.125

/* The tree takes the cloud's arrays. */
static cpm_map_tree *tree_of(cloud *c, int32_t threads) {
    const cpm_context_options options = {.struct_size = sizeof options, .threads = threads};
    cpm_context *context = NULL;
    assert_int_equal(cpm_context_create(&options, &context), CPM_OK);
    cpm_map_tree *tree = NULL;
    assert_ok(context,
              cpm_tree_build(context, c->photons, c->spectra, c->count, c->spectra_count, free, c->bins, SCALE, &tree));
    cpm_context_release(context);
    assert_non_null(tree);
    assert_int_equal(cpm_tree_count(tree), c->count);
    c->photons = NULL, c->spectra = NULL;
    return tree;
}

/* Queries where photons are, near them, and elsewhere. */
static ask ask_make(shape s, uint32_t i, const cloud *c) {
    double p[3], n[3];
    place(s, i, 200, p, n);
    if (i % 4 == 1 && c->count) /* exactly at a photon */
        for (int a = 0; a < 3; a++) p[a] = (double)c->photons[i % c->count].position[a];
    if (i % 16 == 2)
        for (int a = 0; a < 3; a++) p[a] *= 3.0 * uniform(i, 300 + (uint32_t)a);
    if (s == SHELL && i % 2) { /* about 60 degrees from the photons' normals: just in, just out */
        cpm_vec t, b;
        frame3(cpm_v(n[0], n[1], n[2]), &t, &b);
        const cpm_vec tilted = cpm_unit(cpm_along(cpm_v(n[0], n[1], n[2]), sqrt(3.0), t));
        n[0] = tilted.x, n[1] = tilted.y, n[2] = tilted.z;
    }
    return (ask){{(float)p[0], (float)p[1], (float)p[2]}, {(float)n[0], (float)n[1], (float)n[2]}};
}
#endif
