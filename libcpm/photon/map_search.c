/* photon/map_search.c: cl/shared/map_search.h, compiled once for each instruction set, with its own instructions for
 * what is done to many photons at a time. */
#include <math.h>
#include <string.h>

#include "tree.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__AVX512BW__)
#include "lanes_v4.h"
#elif defined(__AVX2__) && defined(__F16C__)
#include "lanes_v3.h"
#else
#include "lanes_any.h"
#endif
#include "cl/shared/map_search.h"

static cpm_map_found nearest(cpm_map_search *search, const float *point, const float *normal, uint32_t k, float limit) {
    return cpm_map_nearest(search, point, normal, k, limit);
}

static void sum(const cpm_map_search *search, uint32_t count) { cpm_map_sum(search, count); }

extern const cpm_search CPM_ISA_NAME(cpm_search);
const cpm_search CPM_ISA_NAME(cpm_search) = {.nearest = nearest, .sum = sum};
