/* backend/native/piece_end.h: what the host's straight, exact and integrated rays share, beside cl/shared/piece_end.h.
 */
#ifndef CPM_NATIVE_PIECE_END_H
#define CPM_NATIVE_PIECE_END_H
#include "cross.h"

/* int (n - 1) ds up to theta of an integrated piece, given it at both ends; and of a piece of a closed form. */
double cpm_column_between(double before, double after, double h, double n0, double n1, double theta);
double cpm_column_of(const cpm_curve *curve, double h, double theta);

/* The arrival's length, at theta of its last piece. */
void cpm_add_length(cpm_arrival *arrival, const cpm_piece *piece, int degree, double theta);

/* Has a path gone so far that its rest is of no interest? With a margin: lengths are found by two ways. */
static inline int cpm_beyond(const cpm_follow_options *options, double length) {
    return options->longest > 0.0 && length > options->longest * (1.0 + 1e-6);
}

/* follow_exact.c: one flight by its closed form; `number` is for the sink. */
void cpm_follow_exact(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options, size_t number,
                      cpm_arrival *arrival);
/* follow_integrated.c: all flights that start in `medium`, eight abreast. */
void cpm_follow_integrated(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                           const cpm_follow_options *options, cpm_arrival *arrivals);
#endif
