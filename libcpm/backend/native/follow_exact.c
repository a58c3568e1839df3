/* backend/native/follow_exact.c: rays whose path is a closed form, piece after piece: cl/shared/follow_exact.h, with
 * lengths and pieces for those who want them. */
#include "host.h"
/* after the host's */
#include "cl/shared/follow_exact.h"
#include "piece_end.h"

void cpm_follow_exact(const cpm_pass *pass, const cpm_flight *flight, const cpm_follow_options *options, size_t number,
                      cpm_arrival *arrival) {
    const cpm_world *w = &pass->world;
    const int32_t medium = cpm_region_medium(&flight->region);
    const cpm_medium_data *m = &w->media[medium];
    const double *table = cpm_table_of(w->tables, medium);
    cpm_exact_way way;
    if (!options) {
        world_follow_exact(w, medium, m, table, flight, arrival);
        return;
    }
    double column = 0.0;
    if (world_exact_begin(w, medium, m, table, flight, &way, arrival)) return;
    while (world_exact_piece(w, m, table, 1, &way, arrival)) {
        const double theta = world_end_of_piece(w, flight, &way.curve, arrival);
        if (options->sink) options->sink(options->user, number, &way.piece, way.degree, theta < 0.0 ? 1.0 : theta);
        if (theta >= 0.0 || arrival->status == CPM_RAY_HIT) cpm_add_length(arrival, &way.piece, way.degree, theta);
        if (pass->extinction) column += cpm_column_of(&way.curve, way.piece.h, theta < 0.0 ? 1.0 : theta);
        const int over = world_exact_after(&way, theta, arrival);
        arrival->optical_path = arrival->length + column;
        if (over) return;
        if (cpm_beyond(options, arrival->length)) {
            arrival->status = CPM_RAY_LEFT;
            return;
        }
    }
}
