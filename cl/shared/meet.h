/* shared/meet.h: paths at diffuse and black surfaces, lanes abreast. */
#ifndef CPM_SHARED_MEET_H
#define CPM_SHARED_MEET_H
#include "settle.h"

typedef struct cpm_encounter {
    real3 came, start, hit;
    real3 normal;          /* geometric, of any length */
    real factor;           /* 1/length^2 of it */
    word path, block, bin; /* counters of the random numbers */
} cpm_encounter;

typedef struct cpm_outcome {
    real3 toward, from;               /* direction and start of a survivor */
    real chance;                      /* the roulette's number */
    word direction_code, normal_code; /* of arrival, and of the side that was hit */
} cpm_outcome;

CPM_INLINE cpm_outcome scatter_meet(cpm_u64 seed, double scale, const cpm_encounter *e) {
    const real3 facing = scatter_facing(scale3(root(e->factor), e->normal), e->came);
    cpm_outcome o;
    word random[4];
    philox_lanes(seed, e->path, e->block, CPM_STREAM_SCATTER, e->bin, random);
    o.toward = scatter_diffuse(facing, random);
    o.from = scatter_step_back(e->hit, e->start, e->came, scale);
    o.chance = uniform_lanes(random[2]);
    o.direction_code = octahedral_encode(e->came);
    o.normal_code = octahedral_encode(facing);
    return o;
}
#endif
