/* shared/map_select.h: the k-th smallest of a list: of distances by counting, of ties' orders by halving. */
#ifndef CPM_SHARED_MAP_SELECT_H
#define CPM_SHARED_MAP_SELECT_H
#include "map_lanes.h"

#define CPM_WINDOW 32 /* distances among which the k-th is found by comparing all with all */

/* Floats from 0 up are ordered as their bits. */
CPM_INLINE cpm_i32 cpm_distance_bits(float x) {
    cpm_float_bits b;
    b.value = x;
    return (cpm_i32)b.bits;
}
CPM_INLINE float cpm_distance_of_bits(cpm_i32 bits) {
    cpm_float_bits b;
    b.bits = (cpm_u32)bits;
    return b.value;
}
CPM_INLINE float cpm_least(float a, float b) { return a < b ? a : b; }
CPM_INLINE float cpm_most(float a, float b) { return a > b ? a : b; }

/* The k-th smallest of n distances of at most `high`, 1 <= k <= n; *below: how many are smaller still.
 * Invariant: at most `low` are c_low < k, at most `high` are c_high >= k. */
CPM_INLINE float cpm_kth_distance(CPM_GLOBAL float *distance, size_t n, size_t k, float high, size_t *below) {
    float low = -1.0f;
    size_t c_low = 0, c_high = n;
    for (int i = 0; i < CPM_PAD; i++) distance[n + (size_t)i] = INFINITY;
    for (int round = 0; c_high - c_low > CPM_WINDOW; round++) {
        float a, b;
        /* all the same? */
        if (low >= 0.0f ? cpm_distance_bits(high) - cpm_distance_bits(low) == 1 : high == 0.0f) {
            *below = c_low;
            return high;
        }
        if (round < 6) { /* on a surface squared distances are evenly spread: aim on both sides of the k-th */
            const float from = cpm_most(low, 0.0f), step = (high - from) / (float)(c_high - c_low);
            const float margin = 0.3f * CPM_WINDOW, aim = (float)(k - c_low);
            a = cpm_least(cpm_most(from + step * (aim - margin), low), high);
            b = cpm_least(cpm_most(from + step * (aim + margin), low), high);
        } else { /* halving the bits always ends */
            const cpm_i32 bottom = low >= 0.0f ? cpm_distance_bits(low) : -1;
            a = b = cpm_distance_of_bits(bottom + (cpm_distance_bits(high) - bottom) / 2);
        }
        size_t c_a, c_b;
        lanes_count(distance, n, a, b, &c_a, &c_b);
        if (k <= c_a)
            high = a, c_high = c_a;
        else if (k <= c_b)
            low = a, c_low = c_a, high = b, c_high = c_b;
        else
            low = b, c_low = c_b;
    }
    float window[CPM_WINDOW + CPM_PAD];
    const size_t m = lanes_between(distance, n, low, high, window);
    for (int i = 0; i < 8; i++) window[m + (size_t)i] = INFINITY;
    for (size_t i = 0; i < m; i++) {
        size_t smaller_ones = 0, as_large = 0;
        for (size_t j = 0; j < m; j += 8) {
            const wide w = wide_any(window + j);
            smaller_ones += cpm_count_bits(wide_bits(w < wide_all(window[i])));
            as_large += cpm_count_bits(wide_bits(w <= wide_all(window[i])));
        }
        if (c_low + smaller_ones < k && k <= c_low + as_large) {
            *below = c_low + smaller_ones;
            return window[i];
        }
    }
    *below = 0; /* not reached */
    return high;
}

/* The k-th smallest of n orders, 1 <= k <= n. */
CPM_INLINE cpm_u64 cpm_kth_order(CPM_GLOBAL const cpm_u64 *order, size_t n, size_t k) {
    cpm_u64 low = 0, high = ~(cpm_u64)0;
    while (low < high) {
        const cpm_u64 middle = low + (high - low) / 2;
        size_t at_most_middle = 0;
        for (size_t i = 0; i < n; i++) at_most_middle += order[i] <= middle;
        if (at_most_middle < k)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}
#endif
