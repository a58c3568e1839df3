/* shared/philox.h: counter-based random numbers, Philox 4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as
 * easy as 1, 2, 3. SC11, 2011).
 *
 * Key: the seed. Counter: (path, block, stream, bin). A number depends on these alone: not on threads, batches, machines
 * or backend. One block is four numbers; a path uses one block a surface. */
#ifndef CPM_SHARED_PHILOX_H
#define CPM_SHARED_PHILOX_H
#include "../dialect.h"

#define CPM_STREAM_EMIT 0u    /* where and whither a photon starts */
#define CPM_STREAM_SCATTER 1u /* what happens to it at a surface */
#define CPM_STREAM_EYE 2u     /* where in its pixel an eye ray starts */

typedef struct cpm_random {
    cpm_u32 v[4];
} cpm_random;

CPM_INLINE cpm_random cpm_philox(cpm_u64 seed, cpm_u32 path, cpm_u32 block, cpm_u32 stream, cpm_u32 bin) {
    cpm_u32 k0 = (cpm_u32)seed, k1 = (cpm_u32)(seed >> 32);
    cpm_u32 c0 = path, c1 = block, c2 = stream, c3 = bin;
    for (int round = 0; round < 10; round++) {
        cpm_u64 a = (cpm_u64)0xD2511F53u * c0, b = (cpm_u64)0xCD9E8D57u * c2;
        c0 = (cpm_u32)(b >> 32) ^ c1 ^ k0;
        c1 = (cpm_u32)b;
        c2 = (cpm_u32)(a >> 32) ^ c3 ^ k1;
        c3 = (cpm_u32)a;
        k0 += 0x9E3779B9u;
        k1 += 0xBB67AE85u;
    }
    cpm_random r;
    r.v[0] = c0, r.v[1] = c1, r.v[2] = c2, r.v[3] = c3;
    return r;
}

/* In (0, 1): the middle of one of 2^32 cells, so neither end is met. */
CPM_INLINE double cpm_uniform(cpm_u32 bits) { return ((double)bits + 0.5) * (1.0 / 4294967296.0); }
#endif
