/* shared/exact.h: closed forms of whole paths: straight, parabola, catenary, layers flat and round. Scalar double on both sides.
 *
 * A path is a chain of segments, each exact over any part of it; only layered media need more than one. cpm_exact_next
 * gives it in the pieces of types/ray.h for geometry, cpm_exact_trace ends it at an arc length or a plane. */
#ifndef CPM_SHARED_EXACT_H
#define CPM_SHARED_EXACT_H
#include "../types/lanes.h"
#include "../types/trace.h"
#include "exact_catenary.h"
#include "exact_layers.h"
#include "exact_shells.h"

typedef struct cpm_segment {
    double r[3], p[3], g[3]; /* start; g: half grad n^2, or grad n of a catenary */
    double sigma;            /* where it ends naturally; CPM_EXACT_INFINITE */
    double face;             /* height of the face there, CPM_EXACT_INFINITE: none */
    int catenary, counted;   /* counted: 1 where it is one of many (an evaluation) */
    int round;               /* a spherical layer: `harmonic`, not `split` */
    cpm_split split;
    cpm_harmonic harmonic;
} cpm_segment;

/* 0, or 1 where this medium has no closed form. p may be turned by Snell's law at a discrete face. */
CPM_INLINE int cpm_segment_start(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                                 const double r[3], double p[3], double sigma_limit, cpm_segment *s) {
    s->sigma = sigma_limit;
    s->face = CPM_EXACT_INFINITE;
    s->catenary = s->counted = s->round = 0;
    s->harmonic.c = s->harmonic.w = 0.0;
    for (int k = 0; k < 3; k++) s->g[k] = 0.0;
    if (!m->uniform) {
        if (m->kind == CPM_MEDIUM_LINEAR_SQUARED || m->kind == CPM_MEDIUM_LINEAR) {
            s->catenary = m->kind == CPM_MEDIUM_LINEAR;
            for (int k = 0; k < 3; k++) s->g[k] = (s->catenary ? scale : 0.5 * scale) * m->axis[k];
        } else if (m->kind == CPM_MEDIUM_LAYERED && m->interpolation != CPM_FIELD_CUBIC) {
            s->sigma = cpm_layer_parabola(m, table, scale, r, p, s->g, sigma_limit, &s->face);
            s->counted = 1;
        } else if (m->kind == CPM_MEDIUM_SHELLS && m->interpolation != CPM_FIELD_CUBIC) {
            s->harmonic = cpm_shell_path(m, table, scale, r, p, sigma_limit, &s->sigma, &s->face);
            s->counted = s->round = 1;
            for (int k = 0; k < 3; k++) s->g[k] = s->harmonic.c * s->harmonic.out[k];
        } else
            return 1;
    }
    for (int k = 0; k < 3; k++) s->r[k] = r[k], s->p[k] = p[k];
    s->split = cpm_split_along(p, s->g);
    return 0;
}

/* Moves the end of a segment onto the face where it ends, to rounding. */
CPM_INLINE void cpm_segment_snap(const cpm_medium_data *m, const cpm_segment *s, double r[3]) {
    double rounding;
    if (!(s->face < CPM_EXACT_INFINITE)) return;
    if (s->round) {
        cpm_shell_snap(m, s->face, r);
        return;
    }
    double off = s->face - cpm_height_of(m, r, &rounding);
    for (int k = 0; k < 3; k++) r[k] += off * m->axis[k];
}

/* Documented in libcpm/backend/native/advance.h. */
CPM_INLINE int cpm_exact_next(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale, const double r[3],
                              double p[3], double sigma_limit, double length0, cpm_piece *piece, double *evaluations) {
    cpm_segment s;
    if (cpm_segment_start(m, table, scale, r, p, sigma_limit, &s)) return 1;
    double h = s.sigma, length;
    if (s.counted) *evaluations += 1.0;
    for (int k = 0; k < 3; k++) piece->r0[k] = r[k], piece->p0[k] = p[k];
    if (s.catenary) {
        h = fmin(h, CPM_CATENARY_PIECE / s.split.gamma);
        length = cpm_catenary_after(&s.split, r, h, piece->r1, piece->p1);
    } else if (s.round) {
        double most = s.harmonic.w > 0.0 ? CPM_HARMONIC_PIECE / s.harmonic.w : CPM_EXACT_INFINITE;
        if (h > most) h = most, s.face = CPM_EXACT_INFINITE;
        cpm_harmonic_at(&s.harmonic, r, p, h, piece->r1, piece->p1);
        cpm_segment_snap(m, &s, piece->r1);
        length = cpm_harmonic_length(&s.harmonic, h);
    } else {
        cpm_parabola_at(r, p, s.g, h, piece->r1, piece->p1);
        cpm_segment_snap(m, &s, piece->r1);
        length = cpm_momentum_integral(&s.split, h);
    }
    piece->h = h;
    piece->length0 = length0;
    piece->length1 = length0 + length;
    piece->n0 = s.split.e;
    piece->n1 = cpm_sqrt(cpm_dot(piece->p1, piece->p1));
    for (int k = 0; k < 3; k++) {
        piece->g0[k] = s.catenary ? piece->n0 * s.g[k] : s.g[k];
        piece->g1[k] = s.catenary ? piece->n1 * s.g[k] : s.g[k];
        if (s.round) piece->g1[k] = s.g[k] + s.harmonic.c * (piece->r1[k] - r[k]);
    }
    return 0;
}

/* The arc length at which |p| falls to 1e-6 of n_start (p turning back through 0), else CPM_EXACT_INFINITE. */
CPM_INLINE double cpm_segment_cutoff(const cpm_segment *s, double n_start) {
    double least = 1e-6 * n_start;
    if (s->round) {
        const cpm_harmonic *h = &s->harmonic;
        if (h->c == 0.0) return CPM_EXACT_INFINITE;
        double rise = (least * least - h->square) / h->c, x = CPM_EXACT_INFINITE;
        if (h->rho2 + rise > 0.0) x = cpm_harmonic_reach(h, rise, 0);
        return x < CPM_EXACT_INFINITE && x <= s->sigma ? cpm_harmonic_length(h, x) : CPM_EXACT_INFINITE;
    }
    if (!(s->split.q2 < least * least) || s->split.s >= 0.0 || s->split.gamma == 0.0) return CPM_EXACT_INFINITE;
    double x = (-cpm_sqrt(least * least - s->split.q2) - s->split.s) / s->split.gamma;
    if (!(x > 0.0)) return CPM_EXACT_INFINITE;
    return s->catenary ? x : cpm_momentum_integral(&s->split, x);
}
/* Arc length of the whole segment. */
CPM_INLINE double cpm_segment_length(const cpm_segment *s) {
    if (!(s->sigma < CPM_EXACT_INFINITE)) return CPM_EXACT_INFINITE;
    if (s->round) return cpm_harmonic_length(&s->harmonic, s->sigma);
    return cpm_momentum_integral(&s->split, s->sigma); /* never asked of a catenary: endless */
}
/* Point and momentum after an arc length; returns the optical path up to there. `whole`: to its natural end. */
CPM_INLINE double cpm_segment_at(const cpm_medium_data *m, const cpm_segment *s, double length, int whole, double r[3],
                                 double p[3]) {
    if (s->catenary) {
        cpm_catenary_at(&s->split, s->r, length, r, p);
        return cpm_momentum_integral(&s->split, length);
    }
    if (s->round) {
        double x = whole ? s->sigma : cpm_harmonic_inverse(&s->harmonic, length, s->sigma);
        cpm_harmonic_at(&s->harmonic, s->r, s->p, x, r, p);
        if (whole) cpm_segment_snap(m, s, r);
        return cpm_harmonic_path(&s->harmonic, x);
    }
    double x = whole ? s->sigma : cpm_momentum_inverse(&s->split, length);
    cpm_parabola_at(s->r, s->p, s->g, x, r, p);
    if (whole) cpm_segment_snap(m, s, r);
    return cpm_parabola_path(s->p, s->g, x);
}
/* Arc length of the first crossing of a plane within the segment (`most` metres), else -1. */
CPM_INLINE double cpm_segment_plane(const cpm_segment *s, const double point[3], const double normal[3], double most) {
    if (s->catenary) return cpm_catenary_plane(&s->split, s->r, s->p, point, normal, most);
    if (s->round) {
        double x = cpm_harmonic_plane(&s->harmonic, s->r, s->p, point, normal);
        if (!(x <= s->sigma) || !(x < CPM_EXACT_INFINITE)) return -1.0;
        double length = cpm_harmonic_length(&s->harmonic, x);
        return length <= most ? length : -1.0;
    }
    double x = cpm_parabola_plane(s->r, s->p, s->g, point, normal, s->sigma);
    if (x < 0.0) return -1.0;
    double length = cpm_momentum_integral(&s->split, x);
    return length <= most ? length : -1.0;
}

/* n at r, on the side that d enters where r lies on a face of discrete layers. NaN where n^2 <= 0. Media with a closed
 * form only; otherwise the same bits as cpm_field. */
CPM_INLINE double cpm_exact_index(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                                  const double r[3], const double d[3]) {
    double value = m->value;
    int square = m->kind == CPM_MEDIUM_LINEAR_SQUARED;
    if (m->kind == CPM_MEDIUM_LAYERED) {
        double rounding, height = cpm_height_of(m, r, &rounding);
        square = m->interpolation == CPM_FIELD_LINEAR_SQUARED;
        int layer = cpm_layer_at(m, table, square ? height : height + rounding);
        if (!square && layer > 0 && height - table[m->heights + layer - 1] <= rounding && cpm_dot(d, m->axis) < 0.0)
            layer--;
        double t = square && layer > 0 ? height - table[m->heights + layer - 1] : 0.0;
        value = cpm_layer_record(m, table, layer, 0) + t * cpm_layer_record(m, table, layer, 1);
    } else if (m->kind == CPM_MEDIUM_SHELLS) {
        double rounding, out[3], height = cpm_shell_height(m, r, out, &rounding);
        square = m->interpolation == CPM_FIELD_LINEAR_SQUARED;
        int layer = cpm_layer_at(m, table, square ? height : height + rounding);
        if (!square && layer > 0 && height - table[m->heights + layer - 1] <= rounding && cpm_dot(d, out) < 0.0)
            layer--;
        double start = cpm_layer_record(m, table, layer, 4), t = square ? height - start : 0.0;
        value = cpm_layer_record(m, table, layer, 0) +
                t * (2.0 * m->radius + height + start) * cpm_layer_record(m, table, layer, 1);
    } else if (m->kind == CPM_MEDIUM_LINEAR_SQUARED || m->kind == CPM_MEDIUM_LINEAR) {
        value += (r[0] - m->origin[0]) * m->axis[0] + (r[1] - m->origin[1]) * m->axis[1] +
                 (r[2] - m->origin[2]) * m->axis[2];
    }
    double n = 1.0 + scale * value;
    return square ? cpm_sqrt(n) : n;
}

/* The exact path from r with momentum p to its goal. A plane that is never crossed: status LEFT, at the last place
 * where something happened (the start, or a layer's face). `samples` may be a null pointer. */
CPM_INLINE int cpm_exact_trace(const cpm_medium_data *m, CPM_GLOBAL const double *table, double scale,
                               const double r0[3], const double p0[3], const cpm_ray_goal *goal, cpm_samples *samples,
                               cpm_ray_end *end) {
    double r[3], p[3], n_start = cpm_sqrt(cpm_dot(p0, p0)), evaluations = 0.0, steps = 0.0, length = 0.0, path = 0.0;
    int status = CPM_ENDED_GOING;
    for (int k = 0; k < 3; k++) r[k] = r0[k], p[k] = p0[k];
    while (status == CPM_ENDED_GOING) {
        cpm_segment s;
        if (evaluations + 1.0 > goal->max_evaluations) {
            status = CPM_ENDED_EXHAUSTED;
            break;
        }
        if (cpm_segment_start(m, table, scale, r, p, CPM_EXACT_INFINITE, &s)) return 1;
        evaluations += s.counted;
        double most = s.catenary ? CPM_EXACT_INFINITE : cpm_segment_length(&s), natural = most, stop = -1.0;
        double cutoff = cpm_segment_cutoff(&s, n_start);
        if (cutoff < most) most = cutoff;
        if (goal->length >= 0.0) {
            if (goal->length - length <= most) stop = goal->length - length, status = CPM_ENDED_ARRIVED;
        } else {
            stop = cpm_segment_plane(&s, goal->point, goal->normal, most);
            if (stop >= 0.0) status = CPM_ENDED_ARRIVED;
        }
        if (status == CPM_ENDED_GOING) {
            stop = most;
            if (cutoff <= most && cutoff < CPM_EXACT_INFINITE)
                status = CPM_ENDED_CUTOFF;
            else if (!(most < CPM_EXACT_INFINITE))
                status = CPM_ENDED_LEFT;
        }
        while (samples && samples->next < samples->count && status != CPM_ENDED_LEFT) {
            double at[3], ignored[3], wanted = samples->step * (double)samples->next - length;
            if (wanted > stop && !(status >= 0 && samples->next + 1 == samples->count)) break;
            cpm_segment_at(m, &s, wanted < stop ? wanted : stop, 0, at, ignored);
            for (int k = 0; k < 3; k++) samples->position[3 * samples->next + k] = at[k];
            samples->next++;
        }
        if (status == CPM_ENDED_LEFT) break;
        steps += 1.0;
        path += cpm_segment_at(m, &s, stop, status == CPM_ENDED_GOING && stop == natural, r, p);
        length += stop;
    }
    for (int k = 0; k < 3; k++) end->r[k] = r[k], end->p[k] = p[k];
    end->length = status == CPM_ENDED_ARRIVED && goal->length >= 0.0 ? goal->length : length;
    end->optical_path = path;
    end->drift = end->error = end->rejected = 0.0;
    end->evaluations = evaluations;
    end->steps = steps;
    end->status = status;
    end->reserved = 0;
    return 0;
}
#endif
