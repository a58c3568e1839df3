/* backend/native/follow_parabolas.c: many flights in a medium of linear n^2, a lot at a time, so that their arithmetic
 * overlaps: starts in lanes, then candidates, then roots and ends. Compiled once for each instruction set.
 *
 * Only what most photons are: one parabola, one chord, one hit. Whatever else may be (a cut-off, a start that looks
 * back, nothing met, the extent crossed) is left to cpm_follow_exact, which asks anew. */
#include <math.h>
#include <string.h>

#include "isa.h"
#include "parabolas.h"
#include "piece_end.h"

#define LOT CPM_PARABOLAS

typedef struct lot {
    size_t which[LOT];
    double position[3][LOT], direction[3][LOT];
    double gradient[3][LOT]; /* of n^2/2: dp/dsigma */
    double n[LOT];
    double h[LOT];    /* sigma of the piece; NaN: not for here */
    double from[LOT]; /* theta before which nothing can be met */
    double c1[3][LOT], c2[3][LOT];
    int32_t left[LOT];
    cpm_curve curve[LOT];
    cpm_hit hit[LOT];
    size_t count;
    int32_t medium, outside; /* does any start outside of the geometry's box? */
} lot;

/* Both loops are in lanes: no branch, no choice between places in memory.
 *
 * How far to go: out of the geometry's box, or as far as the scene is large. A parabola that turns before a face goes
 * out at another, or is longer than it need be. */
static void lengths(const cpm_pass *pass, lot *l) {
    memset(l->from, 0, sizeof l->from);
    const double far2 = pass->reach * pass->reach, center[3] = {pass->center.x, pass->center.y, pass->center.z};
    for (int i = 0; i < LOT; i++) {
        double leave = INFINITY, away2 = 0.0, pg = 0.0, gg = 0.0;
        const double n = l->n[i];
        for (int k = 0; k < 3; k++) {
            const double r = l->position[k][i], p = n * l->direction[k][i], a = l->gradient[k][i];
            /* p t + a t^2/2 = way to the face, the first crossing ahead */
            const double low = pass->box.low[k] - r, high = pass->box.high[k] - r, way = p > 0.0 ? high : low;
            const double d = p * p + 2.0 * a * way, bent = sqrt(cpm_max(d, 0.0));
            const double t = 2.0 * way / (p + (p > 0.0 ? bent : -bent));
            leave = ((d >= 0.0) & (t >= 0.0) & (t < leave)) ? t : leave;
            away2 += (r - center[k]) * (r - center[k]);
            pg += p * a, gg += a * a;
        }
        const double least = 1e-6 * n, limit = sqrt(cpm_max(away2, far2)) / n, margin = 1e-6 * pass->reach / n;
        const int cut = (pg < 0.0) & (pg * pg > (n * n - least * least) * gg); /* |p| may fall to 0 */
        const double h = cpm_min(limit, leave * (1.0 + 1e-6) + margin);
        l->h[i] = ((n > 0.0) & !cut) ? h : NAN;
        for (int k = 0; k < 3; k++) {
            l->c1[k][i] = h * (n * l->direction[k][i]);
            l->c2[k][i] = 0.5 * h * h * l->gradient[k][i];
        }
    }
}

/* Where those that start outside come into the box. */
static void entries(const cpm_pass *pass, lot *l) {
    for (int i = 0; i < LOT; i++) {
        double enter = 0.0;
        const double n = l->n[i];
        for (int k = 0; k < 3; k++) {
            const double p = n * l->direction[k][i], a = l->gradient[k][i];
            const double low = pass->box.low[k] - l->position[k][i], high = pass->box.high[k] - l->position[k][i];
            const double way = p > 0.0 ? low : high;
            const double d = p * p + 2.0 * a * way, bent = sqrt(cpm_max(d, 0.0));
            const double t = 2.0 * way / (p + (p > 0.0 ? bent : -bent));
            enter = ((d >= 0.0) & (t > enter)) ? t : enter;
        }
        const double from = cpm_max(enter * (1.0 - 1e-6) - 1e-6 * pass->reach / n, 0.0) / l->h[i];
        l->from[i] = from < 1.0 ? from : 0.0;
    }
}

static int within(const cpm_box *box, cpm_vec r) {
    return (r.x >= box->low[0]) & (r.x <= box->high[0]) & (r.y >= box->low[1]) & (r.y <= box->high[1]) &
           (r.z >= box->low[2]) & (r.z <= box->high[2]);
}

static void follow_lot(const cpm_pass *pass, const cpm_flight *flights, lot *l, cpm_arrival *arrivals) {
    for (size_t i = l->count; i < LOT; i++) { /* lanes that nobody uses: as the first */
        for (int k = 0; k < 3; k++) {
            l->position[k][i] = l->position[k][0], l->direction[k][i] = l->direction[k][0];
            l->gradient[k][i] = l->gradient[k][0];
        }
        l->n[i] = l->n[0];
    }
    for (int i = 0; i < LOT; i++) l->n[i] = sqrt(l->n[i]); /* it was n^2 */
    lengths(pass, l);
    if (l->outside) entries(pass, l);
    size_t asked = 0;
    for (size_t i = 0; i < l->count; i++) {
        if (!(l->h[i] > 0.0)) {
            cpm_follow_exact(pass, &flights[l->which[i]], NULL, l->which[i], &arrivals[l->which[i]]);
            continue;
        }
        cpm_curve *c = &l->curve[asked];
        c->degree = 2;
        c->c[0] = cpm_v(l->position[0][i], l->position[1][i], l->position[2][i]);
        c->c[1] = cpm_v(l->c1[0][i], l->c1[1][i], l->c1[2][i]);
        c->c[2] = cpm_v(l->c2[0][i], l->c2[1][i], l->c2[2][i]);
        l->left[asked] = l->left[i], l->which[asked] = l->which[i], l->h[asked] = l->h[i];
        l->from[asked] = l->from[i];
        asked++;
    }
    cpm_geometry_curves(pass->geometry, l->curve, l->from, l->left, asked, l->hit);
    for (size_t i = 0; i < asked; i++) {
        const size_t which = l->which[i];
        cpm_arrival *arrival = &arrivals[which];
        const cpm_curve *c = &l->curve[i];
        const cpm_vec end = cpm_add(c->c[0], cpm_add(c->c[1], c->c[2]));
        const int hits = l->hit[i].primitive >= 0, stays = within(&pass->extent, end);
        const double t = hits ? l->hit[i].t : 1.0;
        const cpm_vec tangent = cpm_along(c->c[1], 2.0 * t, c->c[2]);
        const double speed = cpm_norm(tangent);
        cpm_arrival_begin(&flights[which], arrival);
        arrival->n = speed / l->h[i]; /* |p| */
        arrival->steps = 1.0;
        if (hits && stays) {
            arrival->status = CPM_RAY_HIT;
            arrival->hit = l->hit[i];
            arrival->direction = cpm_scaled(1.0 / speed, tangent);
        } else if (!stays) {
            cpm_follow_exact(pass, &flights[which], NULL, which, arrival);
        } else if (!cpm_leaves_after(pass, &flights[which], l->medium, end, tangent, arrival)) {
            cpm_flight on = flights[which]; /* nothing met so far: on from there, with a look back at the seam */
            on.position = end, on.direction = cpm_scaled(1.0 / speed, tangent);
            on.left = -1, on.crossing = 1;
            cpm_follow_exact(pass, &on, NULL, which, arrival);
            arrival->steps += 1.0;
        }
    }
    l->count = 0, l->outside = 0;
}

static void follow_parabolas(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                             cpm_arrival *arrivals) {
    const cpm_medium_data *data = &pass->scene->media[medium].medium->data;
    lot l;
    l.count = 0;
    l.medium = medium, l.outside = 0;
    for (size_t i = 0; i < count; i++) {
        const cpm_flight *flight = &flights[i];
        if (cpm_region_medium(&flight->region) != medium) continue;
        if (flight->crossing || flight->within) { /* looks back, or leaves elsewhere */
            cpm_follow_exact(pass, flight, NULL, i, &arrivals[i]);
            continue;
        }
        const int32_t bin = flight->bin < 0 ? pass->middle : flight->bin;
        const double scale = pass->scale[(size_t)medium * pass->bins + (size_t)bin];
        const double r[3] = {flight->position.x, flight->position.y, flight->position.z};
        const double d[3] = {flight->direction.x, flight->direction.y, flight->direction.z};
        double susceptibility = data->value;
        for (int k = 0; k < 3; k++) {
            l.position[k][l.count] = r[k], l.direction[k][l.count] = d[k];
            l.gradient[k][l.count] = 0.5 * scale * data->axis[k];
            susceptibility += data->axis[k] * (r[k] - data->origin[k]);
        }
        const double n_squared = 1.0 + scale * susceptibility;
        if (cpm_has_left(pass, flight, medium, NULL, &arrivals[i])) {
            cpm_arrival_begin(flight, &arrivals[i]);
            arrivals[i].status = CPM_RAY_LEFT;
            arrivals[i].n = sqrt(n_squared);
            continue;
        }
        l.n[l.count] = n_squared;
        l.outside |= !within(&pass->box, flight->position);
        l.left[l.count] = flight->left;
        l.which[l.count] = i;
        if (++l.count == LOT) follow_lot(pass, flights, &l, arrivals);
    }
    if (l.count) follow_lot(pass, flights, &l, arrivals);
}

extern const cpm_parabolas CPM_ISA_NAME(cpm_follow_parabolas);
const cpm_parabolas CPM_ISA_NAME(cpm_follow_parabolas) = follow_parabolas;
