/* backend/native/piece_end.h: where a piece of a ray ends in a scene: what straight, exact and integrated rays share.
 */
#ifndef CPM_NATIVE_PIECE_END_H
#define CPM_NATIVE_PIECE_END_H
#include "cross.h"

/* An arrival that has not arrived. */
void cpm_arrival_begin(const cpm_flight *flight, cpm_arrival *arrival);

/* How far behind its start a flight looks, metres; `first`: the piece that begins where the flight does. */
double cpm_slack_of(const cpm_pass *pass, const cpm_flight *flight, int first);

/* A cpm_counts of geometry/geometry.h, with a cpm_start as its user. */
typedef struct cpm_start {
    const cpm_pass *pass;
    const cpm_flight *flight;
} cpm_start;
int cpm_start_counts(void *user, int32_t primitive, cpm_vec position, cpm_vec direction);

/* Does the piece hit or leave? theta of its end, with the arrival filled in, or a negative number to go on. */
double cpm_end_of_piece(const cpm_pass *pass, const cpm_flight *flight, const cpm_curve *curve, cpm_arrival *arrival);

/* int (n - 1) ds up to theta of an integrated piece, given it at both ends; and of a piece of a closed form. */
double cpm_column_between(double before, double after, double h, double n0, double n1, double theta);
double cpm_column_of(const cpm_curve *curve, double h, double theta);

/* The arrival's length, at theta of its last piece. */
void cpm_add_length(cpm_arrival *arrival, const cpm_piece *piece, int degree, double theta);

/* 1, and the arrival has LEFT, where the flight cannot come back to any surface. Not asked where options want lengths.
 */
int cpm_has_left(const cpm_pass *pass, const cpm_flight *flight, int32_t medium, const cpm_follow_options *options,
                 cpm_arrival *arrival);

/* The same where a piece without a hit ends. */
int cpm_leaves_after(const cpm_pass *pass, const cpm_flight *flight, int32_t medium, cpm_vec end, cpm_vec tangent,
                     cpm_arrival *arrival);

/* follow_exact.c: one flight by its closed form; `number` is for the sink. */
void cpm_follow_exact(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options, size_t number,
                      cpm_arrival *arrival);
/* follow_integrated.c: all flights that start in `medium`, eight abreast. */
void cpm_follow_integrated(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                           const cpm_follow_options *options, cpm_arrival *arrivals);
#endif
