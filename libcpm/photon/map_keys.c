/* photon/map_keys.c: Morton keys of photons, and runs of them. */
#include "map_keys.h"

#include <string.h>

#include "cl/shared/octahedral.h"

int cpm_index_bits(size_t count) {
    int bits = 1;
    while (bits < 32 && (count - 1) >> bits) bits++;
    return bits;
}

cpm_cells cpm_cells_make(const float *low, const float *high, float unit, int index_bits) {
    cpm_cells grid = {.unit = unit, .index_bits = index_bits, .axis_bits = (61 - index_bits) / 3};
    if (grid.axis_bits > 20) grid.axis_bits = 20;
    double extent = 0.0;
    for (int a = 0; a < 3; a++) {
        grid.low[a] = (double)(low[a] * unit);
        double side = (double)(high[a] * unit) - grid.low[a];
        extent = side > extent ? side : extent;
    }
    /* Scenes are symmetrical: a wall in the very middle, its photons' coordinates wrong in the last bit, would lie on
     * both sides of a cell's face. Hence the odd offset and size. */
    double cells = (double)(UINT64_C(1) << grid.axis_bits);
    grid.cells = extent > 0.0 ? 0.961803 * cells / extent : 0.0;
    grid.offset = 0.0137142 * cells;
    return grid;
}

/* Bits of a number below 2^20, two zeros between each. */
static uint64_t spread(uint64_t x) {
    x = (x | x << 32) & UINT64_C(0x001f00000000ffff);
    x = (x | x << 16) & UINT64_C(0x001f0000ff0000ff);
    x = (x | x << 8) & UINT64_C(0x100f00f00f00f00f);
    x = (x | x << 4) & UINT64_C(0x10c30c30c30c30c3);
    return (x | x << 2) & UINT64_C(0x1249249249249249);
}

/* 0..5: the axis that is longest in the normal, and its sign. */
static uint64_t side_of(uint32_t code) {
    cpm_octahedral p = cpm_octahedral_point(code);
    int x = p.x < 0 ? -p.x : p.x, y = p.y < 0 ? -p.y : p.y, z = p.z < 0 ? -p.z : p.z;
    if (x >= y && x >= z) return p.x < 0;
    if (y >= z) return 2u + (p.y < 0);
    return 4u + (p.z < 0);
}

uint64_t cpm_cells_key(const cpm_cells *grid, const cpm_photon *photon, uint64_t index) {
    uint64_t code = 0;
    for (int a = 0; a < 3; a++) {
        double x = (double)(photon->position[a] * grid->unit) - grid->low[a];
        code |= spread((uint64_t)(int64_t)(x * grid->cells + grid->offset)) << a;
    }
    return side_of(photon->normal) << 61 | code << (61 - 3 * grid->axis_bits) | index;
}

#define DIGIT_MAX 9

void cpm_keys_sort(uint64_t *keys, uint64_t *scratch, size_t count, int index_bits) {
    if (count <= CPM_LEAF) return;
    uint64_t differ = 0;
    for (size_t i = 1; i < count; i++) differ |= keys[i] ^ keys[0];
    differ >>= index_bits;
    if (!differ) return;
    int high = 64 - __builtin_clzll(differ); /* bits that matter */
    /* On a surface a third of a code's bits is idle: 1.5 bits of digit for a factor of 2. */
    int digit = 3;
    while (digit < DIGIT_MAX && (size_t)CPM_LEAF << (2 * digit / 3) < count) digit++;
    if (digit > high) digit = high;
    int shift = index_bits + high - digit;
    uint64_t last = (UINT64_C(1) << digit) - 1;

    size_t start[(1 << DIGIT_MAX) + 1];
    memset(start, 0, ((size_t)last + 2) * sizeof *start);
    for (size_t i = 0; i < count; i++) start[(keys[i] >> shift & last) + 1]++;
    for (uint64_t d = 1; d <= last; d++) start[d + 1] += start[d];
    for (size_t i = 0; i < count; i++) scratch[start[keys[i] >> shift & last]++] = keys[i];
    memcpy(keys, scratch, count * sizeof *keys);
    /* start[d] is now where digit d ends */
    for (uint64_t d = 0, from = 0; d <= last; from = start[d], d++)
        cpm_keys_sort(keys + from, scratch + from, start[d] - from, index_bits);
}

/* First key with the highest differing bit set: between 1 and count - 1; 0 where there is no such bit. */
static size_t split(const uint64_t *keys, size_t count, int low_bit) {
    if (cpm_keys_agree(keys, count, low_bit)) return 0;
    uint64_t bit = UINT64_C(1) << (63 - __builtin_clzll(keys[0] ^ keys[count - 1]));
    size_t zero = 0, one = count - 1;
    while (one - zero > 1) {
        size_t middle = zero + (one - zero) / 2;
        if (keys[middle] & bit)
            one = middle;
        else
            zero = middle;
    }
    return one;
}

int cpm_keys_parts(const uint64_t *keys, size_t count, int low_bit, size_t target, size_t starts[CPM_WIDE + 1]) {
    int n = 1, settled[CPM_WIDE] = {0};
    starts[0] = 0, starts[1] = count;
    while (n < CPM_WIDE) {
        int largest = -1;
        size_t most = target;
        for (int i = 0; i < n; i++) {
            if (settled[i] || starts[i + 1] - starts[i] <= most) continue;
            most = starts[i + 1] - starts[i];
            largest = i;
        }
        if (largest < 0) break;
        size_t at = split(keys + starts[largest], most, low_bit);
        if (at == 0) {
            settled[largest] = 1;
            continue;
        }
        for (int i = n; i > largest; i--) starts[i + 1] = starts[i];
        for (int i = n; i > largest + 1; i--) settled[i] = settled[i - 1];
        starts[largest + 1] = starts[largest] + at;
        settled[largest + 1] = 0;
        n++;
    }
    return n;
}

size_t cpm_part_target(size_t count) {
    const size_t lowest = CPM_LEAF * CPM_WIDE * 11 / 16; /* what eight leaves hold: halving fills them to 11/16 */
    if (count <= lowest) return CPM_LEAF;
    size_t target = lowest;
    while (target < count / CPM_WIDE) target *= CPM_WIDE;
    return target;
}
