/* photon/search_host.h: cl/shared/map_search.h on the host: a query runs on the instruction set that it was made for.
 * Include it before anything that includes that. */
#ifndef CPM_PHOTON_SEARCH_HOST_H
#define CPM_PHOTON_SEARCH_HOST_H
#include "tree.h"

static inline const cpm_search *cpm_search_of(const cpm_map_search *state) {
    return ((const cpm_map_query *)(const void *)((const char *)state - offsetof(cpm_map_query, state)))->search;
}
#define CPM_MAP_NEAREST(state_, point, normal, k, limit) cpm_search_of(state_)->nearest(state_, point, normal, k, limit)
#define CPM_MAP_SUM(state_, count) cpm_search_of(state_)->sum(state_, count)
#endif
