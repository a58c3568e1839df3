/* shared/philox.h: counter-based random numbers, Philox 4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers:
 * as easy as 1, 2, 3. SC11, 2011).
 *
 * Key: the seed. Counter: (path, block, stream, bin). A number depends on these alone: not on threads, batches,
 * machines or backend. One block is four numbers; a path uses one block a surface. */
#ifndef CPM_SHARED_PHILOX_H
#define CPM_SHARED_PHILOX_H
#include "../dialect.h"

#define CPM_STREAM_EMIT 0u    /* where and whither a photon starts */
#define CPM_STREAM_SCATTER 1u /* what happens to it at a surface */
#define CPM_STREAM_EYE 2u     /* where in its pixel an eye ray starts */

/* The ten rounds, of 64-bit integers that hold 32 bits each: `type` is cpm_u64 or word. */
#define CPM_PHILOX_ROUNDS(type, product, seed, c0, c1, c2, c3)                                                         \
    cpm_u32 key0 = (cpm_u32)(seed), key1 = (cpm_u32)((seed) >> 32);                                                    \
    for (int round = 0; round < 10; round++) {                                                                         \
        type low = product(c0, CPM_U64(0xD2511F53)), high = product(c2, CPM_U64(0xCD9E8D57));                          \
        c0 = (high >> 32) ^ c1 ^ (cpm_u64)key0;                                                                        \
        c1 = high & CPM_U64(0xFFFFFFFF);                                                                               \
        c2 = (low >> 32) ^ c3 ^ (cpm_u64)key1;                                                                         \
        c3 = low & CPM_U64(0xFFFFFFFF);                                                                                \
        key0 += 0x9E3779B9u;                                                                                           \
        key1 += 0xBB67AE85u;                                                                                           \
    }

#define CPM_PRODUCT(a, b) ((a) * (b))

typedef struct cpm_random {
    cpm_u32 v[4];
} cpm_random;

CPM_INLINE cpm_random cpm_philox(cpm_u64 seed, cpm_u32 path, cpm_u32 block, cpm_u32 stream, cpm_u32 bin) {
    cpm_u64 c0 = path, c1 = block, c2 = stream, c3 = bin;
    CPM_PHILOX_ROUNDS(cpm_u64, CPM_PRODUCT, seed, c0, c1, c2, c3)
    cpm_random r;
    r.v[0] = (cpm_u32)c0, r.v[1] = (cpm_u32)c1, r.v[2] = (cpm_u32)c2, r.v[3] = (cpm_u32)c3;
    return r;
}

/* In (0, 1): the middle of one of 2^32 cells, so neither end is met. */
CPM_INLINE double cpm_uniform(cpm_u32 bits) { return ((double)bits + 0.5) * (1.0 / 4294967296.0); }

/* Both of lanes; every counter below 2^32. */
CPM_INLINE void philox_lanes(cpm_u64 seed, word path, word block, cpm_u32 stream, word bin, word random[4]) {
    word c0 = path, c1 = block, c2 = splat_word(stream), c3 = bin;
    CPM_PHILOX_ROUNDS(word, word_product, seed, c0, c1, c2, c3)
    random[0] = c0, random[1] = c1, random[2] = c2, random[3] = c3;
}
#if CPM_SINGLE /* 2^23 cells: their middles are floats */
CPM_INLINE real uniform_lanes(word bits) { return (word_reals(bits >> 9) + R(0.5)) * R(1.0 / 8388608.0); }
#else
CPM_INLINE real uniform_lanes(word bits) { return (word_reals(bits) + R(0.5)) * R(1.0 / 4294967296.0); }
#endif
#endif
