/* bench/straight.c: rays through the fibre as a plain loop over lanes, what the tracer's rays per second are held
 * against.
 *
 * straight STARTS ENDS STEPS ORDER SIGMA [repeats]
 *
 * STARTS: float64, six a ray: position, momentum. ENDS: written, eight a ray: position, momentum, arc length, optical
 * path after STEPS equal steps to SIGMA. ORDER 6 or 8: which pair. Prints one JSON object: the fastest of `repeats`
 * passes over all rays, in seconds, and the doubles of a vector.
 *
 * The arithmetic of an integrated ray and nothing else: the stages of the pair, the field of a fibre along any axis,
 * the four sums of a step. No estimate, no control, no ends, no dispersion. One ray a lane, a vector as wide as the
 * instruction set's. The coefficients are the library's, the loop is not. Flags are the library's too, so that a
 * difference is one of work, not of fused operations. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cl/shared/step_nystrom.h"

#if defined __AVX512F__
#define WIDTH 8
#elif defined __AVX__
#define WIDTH 4
#else
#define WIDTH 2
#endif
typedef double lanes __attribute__((vector_size(8 * WIDTH)));
typedef struct state {
    lanes r[3], p[3], g[3], n, way, path;
} state;

/* n^2 = n0^2 (1 - alpha^2 rho^2) about an axis: n, and g = half its gradient. */
typedef struct fibre {
    double square, pull, axis[3];
} fibre;

static inline lanes root_of(lanes x) {
    for (int i = 0; i < WIDTH; i++) x[i] = __builtin_sqrt(x[i]);
    return x;
}

static inline lanes field(const fibre *f, const lanes r[3], lanes g[3]) {
    const lanes along = r[0] * f->axis[0] + r[1] * f->axis[1] + r[2] * f->axis[2];
    lanes rho2 = along * 0.0;
    for (int k = 0; k < 3; k++) {
        const lanes y = r[k] - along * f->axis[k];
        rho2 += y * y;
        g[k] = y * -f->pull;
    }
    return root_of(f->square - f->pull * rho2);
}

/* One step of h in sigma by the pair whose tables are given; unrolled, as they are constants. */
#define STEP(name, stages, table)                                                                                      \
    static inline void name(const fibre *f, state *s, double h) {                                                      \
        lanes g[stages][3], n[stages], at[3];                                                                          \
        const lanes none = s->n * 0.0;                                                                                 \
        memcpy(g[0], s->g, sizeof g[0]), n[0] = s->n;                                                                  \
        _Pragma("GCC unroll 16") for (int i = 1; i < stages; i++) {                                                    \
            lanes move[3] = {none, none, none};                                                                        \
            _Pragma("GCC unroll 16") for (int j = 0; j < i; j++) if (table##_A[i][j] != 0.0) for (int k = 0; k < 3;    \
                                                                                                  k++) move[k] +=      \
                table##_A[i][j] * g[j][k];                                                                             \
            for (int k = 0; k < 3; k++) at[k] = s->r[k] + (h * table##_c[i]) * s->p[k] + (h * h) * move[k];            \
            n[i] = field(f, at, g[i]);                                                                                 \
        }                                                                                                              \
        lanes turn[3] = {none, none, none}, way = none, path = none;                                                   \
        _Pragma("GCC unroll 16") for (int i = 0; i < stages; i++) if (table##_b[i] != 0.0) {                           \
            for (int k = 0; k < 3; k++) turn[k] += table##_b[i] * g[i][k];                                             \
            way += table##_b[i] * n[i], path += table##_b[i] * (n[i] * n[i]);                                          \
        }                                                                                                              \
        for (int k = 0; k < 3; k++) s->r[k] = at[k], s->p[k] += h * turn[k], s->g[k] = g[stages - 1][k];               \
        s->n = n[stages - 1], s->way += h * way, s->path += h * path;                                                  \
    }
STEP(step6, 6, cpm_rkn6)
STEP(step8, 9, cpm_rkn8)

static void trace(const fibre *f, const double *starts, double *ends, size_t count, long steps, int order, double h) {
    for (size_t first = 0; first < count; first += WIDTH) {
        state s;
        memset(&s, 0, sizeof s);
        for (int i = 0; i < WIDTH; i++) {
            const double *start = starts + 6 * (first + (size_t)i < count ? first + (size_t)i : count - 1);
            for (int k = 0; k < 3; k++) s.r[k][i] = start[k], s.p[k][i] = start[3 + k];
        }
        s.n = field(f, s.r, s.g);
        if (order == 6)
            for (long i = 0; i < steps; i++) step6(f, &s, h);
        else
            for (long i = 0; i < steps; i++) step8(f, &s, h);
        for (int i = 0; i < WIDTH && first + (size_t)i < count; i++) {
            double *end = ends + 8 * (first + (size_t)i);
            for (int k = 0; k < 3; k++) end[k] = s.r[k][i], end[3 + k] = s.p[k][i];
            end[6] = s.way[i], end[7] = s.path[i];
        }
    }
}

static double seconds(void) { /* of this process: a neighbour's load is not ours */
    return (double)clock() / CLOCKS_PER_SEC;
}

int main(int argc, char **argv) {
    if (argc < 6) return fprintf(stderr, "straight STARTS ENDS STEPS ORDER SIGMA [repeats]\n"), 2;
    FILE *file = fopen(argv[1], "rb");
    if (!file || fseek(file, 0, SEEK_END)) return perror(argv[1]), 1;
    const long bytes = ftell(file);
    rewind(file);
    const size_t count = bytes > 0 ? (size_t)bytes / (6 * sizeof(double)) : 0;
    double *starts = malloc(6 * sizeof *starts * (count + 1)), *ends = malloc(8 * sizeof *ends * (count + 1));
    if (!count || !starts || !ends || fread(starts, 6 * sizeof *starts, count, file) != count)
        return fprintf(stderr, "straight: %s cannot be read\n", argv[1]), 1;
    fclose(file);
    const long steps = atol(argv[3]);
    const int order = atoi(argv[4]), repeats = argc > 6 ? atoi(argv[6]) : 5;
    const fibre f = {.square = 2.25, .pull = 2.25, .axis = {0.0, 0.0, 1.0}};
    double best = 1e300;
    for (int i = 0; i < repeats; i++) {
        const double begun = seconds();
        trace(&f, starts, ends, count, steps, order, atof(argv[5]) / (double)steps);
        const double took = seconds() - begun;
        if (took < best) best = took;
    }
    file = fopen(argv[2], "wb");
    if (!file || fwrite(ends, 8 * sizeof *ends, count, file) != count || fclose(file)) return perror(argv[2]), 1;
    printf("{\"seconds\": %.9g, \"width\": %d}\n", best, WIDTH);
    return 0;
}
