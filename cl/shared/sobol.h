/* shared/sobol.h: four dimensions of Sobol's sequence, Owen-scrambled: points that cover evenly without a lattice's
 * moire.
 *
 * Direction numbers: Joe and Kuo, Constructing Sobol sequences with better two-dimensional projections. SIAM J. Sci.
 * Comput. 30(5), 2008: (s, a, m) = van der Corput; (1, 0, 1); (2, 1, 1 3); (3, 1, 1 3 1). Scrambling: nested, by a hash
 * of the higher bits (Laine and Karras, Stratified sampling for stochastic transparency. EGSR 2011; constants: Vegdahl
 * 2021). */
#ifndef CPM_SHARED_SOBOL_H
#define CPM_SHARED_SOBOL_H
#include "../dialect.h"

#define CPM_SOBOL_DIMENSIONS 4

CPM_CONSTANT_TABLE cpm_u32 cpm_sobol_directions[CPM_SOBOL_DIMENSIONS][32] = {
    {0x80000000u, 0x40000000u, 0x20000000u, 0x10000000u, 0x08000000u, 0x04000000u, 0x02000000u, 0x01000000u,
     0x00800000u, 0x00400000u, 0x00200000u, 0x00100000u, 0x00080000u, 0x00040000u, 0x00020000u, 0x00010000u,
     0x00008000u, 0x00004000u, 0x00002000u, 0x00001000u, 0x00000800u, 0x00000400u, 0x00000200u, 0x00000100u,
     0x00000080u, 0x00000040u, 0x00000020u, 0x00000010u, 0x00000008u, 0x00000004u, 0x00000002u, 0x00000001u},
    {0x80000000u, 0xc0000000u, 0xa0000000u, 0xf0000000u, 0x88000000u, 0xcc000000u, 0xaa000000u, 0xff000000u,
     0x80800000u, 0xc0c00000u, 0xa0a00000u, 0xf0f00000u, 0x88880000u, 0xcccc0000u, 0xaaaa0000u, 0xffff0000u,
     0x80008000u, 0xc000c000u, 0xa000a000u, 0xf000f000u, 0x88008800u, 0xcc00cc00u, 0xaa00aa00u, 0xff00ff00u,
     0x80808080u, 0xc0c0c0c0u, 0xa0a0a0a0u, 0xf0f0f0f0u, 0x88888888u, 0xccccccccu, 0xaaaaaaaau, 0xffffffffu},
    {0x80000000u, 0xc0000000u, 0x60000000u, 0x90000000u, 0xe8000000u, 0x5c000000u, 0x8e000000u, 0xc5000000u,
     0x68800000u, 0x9cc00000u, 0xee600000u, 0x55900000u, 0x80680000u, 0xc09c0000u, 0x60ee0000u, 0x90550000u,
     0xe8808000u, 0x5cc0c000u, 0x8e606000u, 0xc5909000u, 0x6868e800u, 0x9c9c5c00u, 0xeeee8e00u, 0x5555c500u,
     0x8000e880u, 0xc0005cc0u, 0x60008e60u, 0x9000c590u, 0xe8006868u, 0x5c009c9cu, 0x8e00eeeeu, 0xc5005555u},
    {0x80000000u, 0xc0000000u, 0x20000000u, 0x50000000u, 0xf8000000u, 0x74000000u, 0xa2000000u, 0x93000000u,
     0xd8800000u, 0x25400000u, 0x59e00000u, 0xe6d00000u, 0x78080000u, 0xb40c0000u, 0x82020000u, 0xc3050000u,
     0x208f8000u, 0x51474000u, 0xfbea2000u, 0x75d93000u, 0xa0858800u, 0x914e5400u, 0xdbe79e00u, 0x25db6d00u,
     0x58800080u, 0xe54000c0u, 0x79e00020u, 0xb6d00050u, 0x800800f8u, 0xc00c0074u, 0x200200a2u, 0x50050093u},
};

/* Words of 32 bits in lanes of 64. */
#define CPM_32(x) ((x)&CPM_U64(0xffffffff))

CPM_INLINE word reverse_bits(word x) {
    x = (x >> 16) | CPM_32(x << 16);
    x = ((x & CPM_U64(0xff00ff00)) >> 8) | ((x & CPM_U64(0x00ff00ff)) << 8);
    x = ((x & CPM_U64(0xf0f0f0f0)) >> 4) | ((x & CPM_U64(0x0f0f0f0f)) << 4);
    x = ((x & CPM_U64(0xcccccccc)) >> 2) | ((x & CPM_U64(0x33333333)) << 2);
    return ((x & CPM_U64(0xaaaaaaaa)) >> 1) | ((x & CPM_U64(0x55555555)) << 1);
}

/* Each bit is flipped or not by a hash of the bits above it: strata of every power of two stay strata. `reversed`: the
 * bits of x, from the last to the first. */
CPM_INLINE word owen_scramble(word reversed, cpm_u32 seed) {
    word x = reversed;
    x ^= CPM_32(word_product(x, CPM_U64(0x3d20adea)));
    x = CPM_32(x + (cpm_u64)seed);
    x = CPM_32(word_product(x, (cpm_u64)((seed >> 16) | 1u)));
    x ^= CPM_32(word_product(x, CPM_U64(0x05526c56)));
    x ^= CPM_32(word_product(x, CPM_U64(0x53a22864)));
    return reverse_bits(x);
}

/* The second dimension's matrix is Pascal's triangle modulo 2: column k has row j where the bits of j are among those
 * of k (Lucas). So the product is a sum over supersets, five steps for 32 bits; the sequence's bits come out reversed.
 */
CPM_INLINE word pascal_product(word x) {
    x ^= (x >> 1) & CPM_U64(0x55555555);
    x ^= (x >> 2) & CPM_U64(0x33333333);
    x ^= (x >> 4) & CPM_U64(0x0f0f0f0f);
    x ^= (x >> 8) & CPM_U64(0x00ff00ff);
    return x ^ ((x >> 16) & CPM_U64(0x0000ffff));
}

/* Point `index` (below 2^32) in one dimension, as 32 bits of a fraction. */
CPM_INLINE word sobol_lanes(word index, int dimension, cpm_u32 seed) {
    if (dimension == 0) return owen_scramble(index, seed); /* van der Corput: the bits reversed */
    if (dimension == 1) return owen_scramble(pascal_product(index), seed);
    word x = splat_word(0);
    for (int bit = 0; bit < 32; bit++) /* 0 - 1 is all ones */
        x ^= (CPM_U64(0) - ((index >> bit) & CPM_U64(1))) & (cpm_u64)cpm_sobol_directions[dimension][bit];
    return owen_scramble(reverse_bits(x), seed);
}
#endif
