/* bytes.h: the fuzzer's bytes as numbers. Every call takes what it needs; past the end come zeros. */
#ifndef CPM_FUZZ_BYTES_H
#define CPM_FUZZ_BYTES_H
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Holds for any input, or the fuzzer has found something. */
#define require(condition)                                                                                             \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                    \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

typedef struct bytes {
    const uint8_t *next, *end;
    int wild; /* a number beyond 1e7 has been taken: its square may overflow where it is summed, and NaN be the answer
               */
} bytes;

static inline uint8_t take_byte(bytes *b) { return b->next < b->end ? *b->next++ : 0; }

/* 0..count-1 */
static inline uint32_t take_below(bytes *b, uint32_t count) { return take_byte(b) % count; }

/* Mostly numbers of the everyday, now and then any double at all: NaN, infinities, denormals, 1e300. */
static inline double take_number(bytes *b) {
    const uint8_t kind = take_byte(b);
    if (kind < 200) return ((double)take_byte(b) - 128.0) / 32.0;
    if (kind < 225) return (double)take_byte(b) * 1e-6;
    if (kind < 250) return (double)take_byte(b) * 1e4;
    uint8_t raw[sizeof(double)];
    for (size_t i = 0; i < sizeof raw; i++) raw[i] = take_byte(b);
    double any;
    memcpy(&any, raw, sizeof any);
    b->wild |= !(fabs(any) <= 1e7);
    return any;
}

static inline void take_point(bytes *b, double *point) {
    for (int k = 0; k < 3; k++) point[k] = take_number(b);
}

/* An index near 1 most of the time. */
static inline double take_index(bytes *b) {
    const double x = take_number(b);
    return fabs(x) <= 4.0 ? 1.0 + 0.125 * (x + 4.0) : x;
}
#endif
