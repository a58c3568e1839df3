/* backend/native/follow_parabolas.c: many flights in a medium of linear n^2 (cl/shared/follow_parabolas.h), a lot at a
 * time, so that their arithmetic overlaps: starts in lanes, then candidates, then roots and ends. Compiled once for
 * each instruction set. */
#if defined(__AVX512F__)
#define CPM_WIDTH 8
#elif defined(__AVX2__)
#define CPM_WIDTH 4
#else
#define CPM_WIDTH 2
#endif
#include "host.h"
/* after the host's */
#include "cl/shared/follow_parabolas.h"
#include "isa.h"
#include "parabolas.h"
#include "piece_end.h"

#define LOT CPM_PARABOLAS

typedef struct lot {
    cpm_parabola_lot packets[LOT / CPM_WIDTH];
    size_t which[LOT];
    double h[LOT];    /* sigma of the piece */
    double from[LOT]; /* theta before which nothing can be met */
    int32_t left[LOT];
    cpm_curve curve[LOT];
    cpm_hit hit[LOT];
    size_t count;
    int32_t medium;
} lot;

static void follow_lot(const cpm_pass *pass, const cpm_flight *flights, lot *l, cpm_arrival *arrivals) {
    const cpm_world *w = &pass->world;
    size_t asked = 0;
    for (size_t p = 0; p * CPM_WIDTH < l->count; p++) {
        cpm_parabola_lot *packet = &l->packets[p];
        world_start_parabolas(w, packet);
        for (int i = 0; i < packet->count; i++) {
            const size_t which = (size_t)packet->which[i];
            if (!(packet->h[i] > 0.0)) {
                cpm_follow_exact(pass, &flights[which], NULL, which, &arrivals[which]);
                continue;
            }
            l->curve[asked] = cpm_parabola_curve(packet, i);
            l->left[asked] = flights[which].left, l->which[asked] = which;
            l->h[asked] = packet->h[i], l->from[asked] = packet->from[i];
            asked++;
        }
        packet->count = 0, packet->outside = 0;
    }
    cpm_geometry_curves(pass->geometry, l->curve, l->from, l->left, asked, l->hit);
    for (size_t i = 0; i < asked; i++) {
        const size_t which = l->which[i];
        cpm_flight on;
        int stepped;
        if (world_end_of_parabola(w, l->medium, &flights[which], &l->curve[i], l->h[i], &l->hit[i], &arrivals[which],
                                  &on, &stepped))
            continue;
        cpm_follow_exact(pass, &on, NULL, which, &arrivals[which]);
        arrivals[which].steps += stepped ? 1.0 : 0.0;
    }
    l->count = 0;
}

static void follow_parabolas(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                             cpm_arrival *arrivals) {
    const cpm_world *w = &pass->world;
    const cpm_medium_data *data = &w->media[medium];
    lot l;
    l.count = 0;
    l.medium = medium;
    for (int p = 0; p < LOT / CPM_WIDTH; p++) l.packets[p].count = l.packets[p].outside = 0;
    for (size_t i = 0; i < count; i++) {
        const cpm_flight *flight = &flights[i];
        if (cpm_region_medium(&flight->region) != medium) continue;
        if (flight->crossing) { /* looks back */
            cpm_follow_exact(pass, flight, NULL, i, &arrivals[i]);
            continue;
        }
        cpm_parabola_lot *packet = &l.packets[l.count / CPM_WIDTH];
        const double n_squared = world_add_parabola(w, medium, data, flight, packet);
        if (world_has_left(w, flight, medium, &arrivals[i])) {
            cpm_arrival_begin(flight, &arrivals[i]);
            arrivals[i].status = CPM_RAY_LEFT;
            arrivals[i].n = sqrt(n_squared);
            continue;
        }
        packet->outside |= !world_box_holds(w->frame.box_low, w->frame.box_high, flight->position);
        packet->which[packet->count++] = (cpm_i64)i;
        if (++l.count == LOT) follow_lot(pass, flights, &l, arrivals);
    }
    if (l.count) follow_lot(pass, flights, &l, arrivals);
}

extern const cpm_parabolas CPM_ISA_NAME(cpm_follow_parabolas);
const cpm_parabolas CPM_ISA_NAME(cpm_follow_parabolas) = follow_parabolas;
