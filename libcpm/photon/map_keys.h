/* photon/map_keys.h: Morton keys of photons, and runs of them. Internal to the builder.
 *
 * A key, from the left: 3 bits for the main axis of the normal, so that the two sides of a wall never share a leaf; the
 * Morton code of the position; and in the last index_bits the photon's number in the order given. */
#ifndef CPM_PHOTON_MAP_KEYS_H
#define CPM_PHOTON_MAP_KEYS_H
#include "tree.h"

typedef struct cpm_cells { /* a cube of 2^axis_bits cells a side */
    double low[3];         /* of the photons, scaled */
    double cells, offset;  /* cell = (x - low) cells + offset */
    float unit;
    int axis_bits, index_bits;
} cpm_cells;

int cpm_index_bits(size_t count);
/* Around the box [low, high] (metres) of photons numbered with so many bits. */
cpm_cells cpm_cells_make(const float *low, const float *high, float unit, int index_bits);
uint64_t cpm_cells_key(const cpm_cells *grid, const cpm_photon *photon, uint64_t index);

/* Orders keys by the bits from index_bits up, to the point where no unordered run is longer than CPM_LEAF; `scratch`
 * has room for as many. */
void cpm_keys_sort(uint64_t *keys, uint64_t *scratch, size_t count, int index_bits);

/* The functions below see the bits from `low_bit` up, and the keys are ordered by them. */

/* Splits a run into at most CPM_WIDE parts, always the largest and where its highest differing bit changes, until none
 * is larger than `target` or can be split. Part i is [starts[i], starts[i + 1]). Returns their number. */
int cpm_keys_parts(const uint64_t *keys, size_t count, int low_bit, size_t target, size_t starts[CPM_WIDE + 1]);
static inline int cpm_keys_agree(const uint64_t *keys, size_t count, int low_bit) {
    return (keys[0] ^ keys[count - 1]) >> low_bit == 0;
}
/* How large the parts under a node over `count` photons may be, so that it is the lowest nodes that are full. */
size_t cpm_part_target(size_t count);
#endif
