/* photon/map_select.h: the k-th smallest of a list of distances, by counting. For map_search.c, after its lanes. */
#ifndef CPM_PHOTON_MAP_SELECT_H
#define CPM_PHOTON_MAP_SELECT_H
#include <math.h>
#include <string.h>

#include "tree.h"

#define WINDOW 32 /* distances among which the k-th is found by comparing all with all */

/* Floats from 0 up are ordered as their bits. */
static int32_t distance_bits(float x) {
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static float distance_of_bits(int32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The k-th smallest of n distances of at most `high`, 1 <= k <= n; *below: how many are smaller still.
 * Invariant: at most `low` are c_low < k, at most `high` are c_high >= k. */
static float kth_distance(float *distance, size_t n, size_t k, float high, size_t *below) {
    float low = -1.0f;
    size_t c_low = 0, c_high = n;
    for (int i = 0; i < CPM_PAD; i++) distance[n + (size_t)i] = INFINITY;
    for (int round = 0; c_high - c_low > WINDOW; round++) {
        float a, b;
        if (low >= 0.0f ? distance_bits(high) - distance_bits(low) == 1 : high == 0.0f) { /* all the same */
            *below = c_low;
            return high;
        }
        if (round < 6) { /* on a surface squared distances are evenly spread: aim on both sides of the k-th */
            const float from = fmaxf(low, 0.0f), step = (high - from) / (float)(c_high - c_low);
            const float margin = 0.3f * WINDOW, aim = (float)(k - c_low);
            a = fminf(fmaxf(from + step * (aim - margin), low), high);
            b = fminf(fmaxf(from + step * (aim + margin), low), high);
        } else { /* halving the bits always ends */
            const int32_t bottom = low >= 0.0f ? distance_bits(low) : -1;
            a = b = distance_of_bits(bottom + (distance_bits(high) - bottom) / 2);
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
    float window[WINDOW + CPM_PAD];
    const size_t m = lanes_between(distance, n, low, high, window);
    for (size_t i = 0; i < m; i++) {
        size_t smaller = 0, equal = 0;
        for (size_t j = 0; j < m; j++) smaller += window[j] < window[i], equal += window[j] == window[i];
        if (c_low + smaller < k && k <= c_low + smaller + equal) {
            *below = c_low + smaller;
            return window[i];
        }
    }
    *below = 0; /* not reached */
    return high;
}
#endif
