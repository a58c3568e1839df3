/* photon/far.c: photons of suns and environments. They come from beyond the extent, but are made where they cross a box
 * about what they may light, which fills a small part of the extent (of an atmosphere, next to none of it).
 *
 * Rays carry n^2 dA dOmega unchanged and basic radiance L with it. So what crosses the box from outside for the first
 * time is sampled there, position on the shadow that the box throws and direction, with power n^2 L dA dOmega; L is
 * what the path traced back to the extent sees (paths are reversible). Where light bends, a path may cross the box,
 * leave it and come back. Each time is sampled as a start of its own; so none is followed beyond the box before it has
 * met something (`confined`), and a start counts if nothing was met on the way back.
 *
 * A sun fills 7e-5 sr. Where light bends little on its way (air) directions are drawn from a cone
 * about those in which the sun is seen from the box's corners, faces and middle; where it bends much, paths start at
 * the extent, in the sun's own directions, and nothing is traced back. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/shared/sampling.h"
#include "photons.h"

#define MARGIN 1e-4  /* of the geometry's diagonal: surfaces lie inside the box */
#define PLANET 1e6   /* metres of diagonal: only what is near the camera is lit ... */
#define NEAR_BY 25e3 /* ... so near, unless the light has an aim of its own */
#define ROWS 32      /* of directions, of an environment that is no image */
#define COLUMNS 64
#define DEFENSIVE 0.1  /* of the paths, over all directions alike: no power grows by more than 1/DEFENSIVE */
#define SUFFICES 100.0 /* the extent's shadow over the box's: up to there a sun's paths may start at the extent */
#define CLOSE 1e-3     /* of the sun's radius: how well its direction is found */
#define ROUNDS 40      /* in which it must be found */
#define WIDEST 0.2     /* radians: half of the widest cone */

static int is_curved(const cpm_pass *pass) { return pass->way[0] != CPM_WAY_STRAIGHT; }

/* What the light is to shine on; 0: nothing. */
static int find_box(const cpm_pass *pass, cpm_emitter *e, int32_t project) {
    const cpm_scene *scene = pass->scene;
    cpm_box box = pass->box;
    double diagonal2 = 0.0;
    if (!(box.low[0] <= box.high[0])) return 0; /* no shapes */
    for (int k = 0; k < 3; k++) diagonal2 += (box.high[k] - box.low[k]) * (box.high[k] - box.low[k]);
    const double diagonal = sqrt(diagonal2), margin = MARGIN * (diagonal > 0.0 ? diagonal : 1.0);
    const double wider = project || pass->bounded ? margin : 0.5 * diagonal + margin;
    for (int k = 0; k < 3; k++) box.low[k] -= wider, box.high[k] += wider;
    e->traced_back = is_curved(pass);
    if (e->light->has_aim) {
        box = e->light->aim;
        e->traced_back = 1;
    } else if (!project && pass->bounded) {
        box = pass->extent;
        e->traced_back = 0;
    } else if (diagonal > PLANET && scene->has_camera) {
        const double *at = scene->camera.origin;
        for (int k = 0; k < 3; k++) {
            box.low[k] = cpm_max(box.low[k], at[k] - NEAR_BY), box.high[k] = cpm_min(box.high[k], at[k] + NEAR_BY);
            if (!(box.low[k] < box.high[k])) return 0;
        }
        e->traced_back = 1;
    }
    e->box = box;
    memcpy(e->data.low, box.low, sizeof box.low);
    memcpy(e->data.high, box.high, sizeof box.high);
    return 1;
}

/* Of a box, across d. */
static double shadow_of(const cpm_box *box, cpm_vec d) {
    const double x = box->high[0] - box->low[0], y = box->high[1] - box->low[1], z = box->high[2] - box->low[2];
    return fabs(d.x) * y * z + fabs(d.y) * z * x + fabs(d.z) * x * y;
}

/* ------------------------------------------------------------------------------------------------- environments */

/* Cells of directions: the image's own, by what they shine, or a plain grid. */
static cpm_status prepare_environment(const cpm_pass *pass, cpm_emitter *e) {
    const cpm_sky *sky = &pass->sky[e->number];
    const int image = sky->data.kind == CPM_SKY_IMAGE;
    const size_t rows = image ? (size_t)sky->data.height : ROWS, columns = image ? (size_t)sky->data.width : COLUMNS;
    const size_t cells = rows * columns, bins = pass->bins;
    double *share = malloc(cells * sizeof *share), sum = 0.0, so_far = 0.0;
    cpm_projection *p = &e->projection;
    p->cumulative = malloc((cells + rows + 2) * sizeof *p->cumulative);
    p->weight = malloc(cells * sizeof *p->weight);
    if (!share || !p->cumulative || !p->weight) {
        free(share);
        return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for an environment's photons");
    }
    double *edges = p->cumulative + cells + 1;
    for (size_t r = 0; r <= rows; r++) edges[r] = cpm_cos(CPM_PI * (double)r / (double)rows);
    for (size_t i = 0; i < cells; i++) {
        const size_t r = i / columns;
        const double part = 0.5 * (edges[r] - edges[r + 1]) / (double)columns; /* of all directions */
        double shine = image ? 0.0 : 1.0;
        for (size_t b = 0; image && b < bins; b++) shine += (double)sky->pixels[i * bins + b];
        share[i] = shine * part;
        sum += share[i];
    }
    p->cumulative[0] = 0.0;
    for (size_t i = 0; i < cells; i++) {
        const size_t r = i / columns;
        const double part = 0.5 * (edges[r] - edges[r + 1]) / (double)columns;
        /* between the centres of pixels the image is linear: a dark pixel beside a bright one shines too */
        const double probability = DEFENSIVE * part + (1.0 - DEFENSIVE) * (sum > 0.0 ? share[i] / sum : part);
        p->weight[i] = (float)(part / probability);
        p->cumulative[i + 1] = so_far += probability;
    }
    p->cumulative[cells] = 1.0;
    free(share);
    const cpm_vec up = e->light->axis, north = e->light->north;
    memcpy(e->data.axis, (const double[3]){up.x, up.y, up.z}, sizeof e->data.axis);
    memcpy(e->data.position, (const double[3]){north.x, north.y, north.z}, sizeof e->data.position);
    e->data.rows = (int32_t)rows, e->data.columns = (int32_t)columns;
    return CPM_OK;
}

/* --------------------------------------------------------------------------------------------------------- suns */

/* The direction from which a path that comes straight from the sun's centre reaches a point: s <- s + (sun - what s
 * sees) until that is small. 0: not found, or hidden. */
static int seen_from(const cpm_pass *pass, cpm_vec point, cpm_vec sun, double close, int32_t bin, cpm_vec *seen) {
    const cpm_follow_options options = {.far = INFINITY};
    cpm_vec s = sun;
    for (int i = 0; i < ROUNDS; i++) {
        cpm_flight f = {.position = point, .direction = s, .left = -1, .bin = bin};
        cpm_arrival a;
        f.region = cpm_region_at(pass, point, s);
        cpm_follow(pass, &f, 1, &options, &a);
        if (a.status != CPM_RAY_LEFT) return 0;
        const cpm_vec off = cpm_sub(sun, a.direction);
        if (cpm_norm(off) <= close) {
            *seen = s;
            return 1;
        }
        s = cpm_unit(cpm_add(s, off));
    }
    return 0;
}

/* A cone about all directions in which the sun is seen from the box; 0: there is none. */
static int find_cone(const cpm_pass *pass, cpm_emitter *e) {
    cpm_vec seen[3 * 27], mean = cpm_v(0.0, 0.0, 0.0);
    size_t found = 0;
    double widest = 0.0;
    const double radius = e->light->cutoff;
    const int32_t bins[3] = {0, pass->middle, (int32_t)pass->bins - 1};
    for (int i = 0; i < 27; i++) {
        const int at[3] = {i % 3, i / 3 % 3, i / 9};
        double r[3];
        for (int k = 0; k < 3; k++) r[k] = e->box.low[k] + 0.5 * at[k] * (e->box.high[k] - e->box.low[k]);
        for (int b = 0; b < (pass->disperses[0] ? 3 : 1); b++)
            if (seen_from(pass, cpm_v(r[0], r[1], r[2]), e->light->axis, CLOSE * radius,
                          pass->disperses[0] ? bins[b] : -1, &seen[found])) {
                mean = cpm_add(mean, seen[found]);
                found++;
            }
    }
    if (!found || !(cpm_norm(mean) > 0.5 * (double)found)) return 0;
    mean = cpm_unit(mean);
    for (size_t i = 0; i < found; i++) widest = cpm_max(widest, asin(cpm_norm(cpm_cross(mean, seen[i]))));
    const double cone = 1.5 * widest + 1.25 * radius;
    if (cone > WIDEST + 1.25 * radius) return 0;
    memcpy(e->data.axis, (const double[3]){mean.x, mean.y, mean.z}, sizeof e->data.axis);
    e->data.cutoff = 1.0 - cpm_cos(cone);
    return 1;
}

static void prepare_sun(const cpm_pass *pass, cpm_emitter *e) {
    if (!is_curved(pass) || !e->traced_back) return;
    if (shadow_of(&pass->extent, e->light->axis) > SUFFICES * shadow_of(&e->box, e->light->axis) && find_cone(pass, e))
        return;
    e->box = pass->extent;
    memcpy(e->data.low, e->box.low, sizeof e->box.low);
    memcpy(e->data.high, e->box.high, sizeof e->box.high);
    e->traced_back = 0;
}

/* The same pass whose extent is the box. */
static cpm_status confine(const cpm_pass *pass, cpm_emitter *e) {
    e->inside = malloc(sizeof *e->inside);
    if (!e->inside) return cpm_fail(pass->context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a light's photons");
    *e->inside = *pass;
    e->inside->extent = e->box;
    e->inside->bounded = 1;
    memcpy(e->inside->world.frame.low, e->box.low, sizeof e->box.low);
    memcpy(e->inside->world.frame.high, e->box.high, sizeof e->box.high);
    e->inside->world.frame.bounded = 1;
    return CPM_OK;
}

cpm_status cpm_far_begin(const cpm_pass *pass, cpm_emitter *e, int32_t project, double *factor) {
    const int sun = e->light->kind == CPM_LIGHT_SUN;
    cpm_status status = CPM_OK;
    *factor = 0.0;
    if (!find_box(pass, e, project)) return CPM_OK;
    if (sun)
        prepare_sun(pass, e);
    else
        status = prepare_environment(pass, e);
    if (!status && e->traced_back && is_curved(pass)) status = confine(pass, e);
    const double solid = sun ? CPM_TWO_PI * (1.0 - cpm_cos(e->light->cutoff)) : 2.0 * CPM_TWO_PI;
    e->power_factor = sun ? CPM_TWO_PI * e->data.cutoff : solid;
    double shadow = 0.0, middle[3];
    for (int k = 0; k < 3; k++) {
        const cpm_vec along = cpm_v(k == 0, k == 1, k == 2);
        shadow += 0.5 * shadow_of(&e->box, along); /* of a convex body the mean is a quarter of its surface */
        middle[k] = 0.5 * (e->box.low[k] + e->box.high[k]);
    }
    if (sun) shadow = shadow_of(&e->box, e->light->axis);
    /* n in the middle decides only how paths are shared out */
    const double n = cpm_pass_index(pass, 0, -1, cpm_v(middle[0], middle[1], middle[2]));
    *factor = solid * shadow * (n > 0.0 ? n * n : 1.0);
    return status;
}

/* -------------------------------------------------------------------------------------------------------- paths */

static cpm_vec of_block(double (*p)[CPM_BLOCK], size_t i) { return cpm_v(p[0][i], p[1][i], p[2][i]); }

/* Turns flights around and looks where they come from: directions towards the sky; status HIT: from nowhere. */
static void look_back(const cpm_pass *pass, cpm_flight *flights, cpm_arrival *arrivals, size_t count) {
    const cpm_follow_options options = {.far = INFINITY};
    for (size_t i = 0; i < count; i++) flights[i].direction = cpm_scaled(-1.0, flights[i].direction);
    cpm_follow(pass, flights, count, &options, arrivals);
    for (size_t i = 0; i < count; i++) flights[i].direction = cpm_scaled(-1.0, flights[i].direction);
}

/* Keeps the paths that meet something before they leave the box. */
static size_t keep_confined(const cpm_emitter *e, size_t bins, cpm_flight *flights, cpm_arrival *arrivals,
                            uint32_t *paths, float *powers, size_t count) {
    size_t kept = 0;
    cpm_follow(e->inside, flights, count, NULL, arrivals);
    for (size_t i = 0; i < count; i++) {
        if (arrivals[i].status != CPM_RAY_HIT) continue;
        flights[kept] = flights[i], paths[kept] = paths[i];
        if (kept != i) memcpy(&powers[kept * bins], &powers[i * bins], bins * sizeof *powers);
        kept++;
    }
    return kept;
}

size_t cpm_far_emit(const cpm_pass *pass, const cpm_emitter *e, uint64_t path, size_t count, cpm_emissions *made,
                    cpm_flight *flights, cpm_arrival *arrivals, uint32_t *paths, float *powers) {
    const size_t bins = pass->bins;
    size_t starts = 0, carrying = 0;
    cpm_pass_code_chosen()->emit_far(&e->data, e->projection.cumulative, e->projection.weight, path - e->first, count,
                                     made);
    for (size_t i = 0; i < count; i++) {
        cpm_flight f = {.position = of_block(made->position, i), .direction = of_block(made->direction, i), .left = -1};
        f.region = cpm_region_at(pass, f.position, f.direction);
        const int splits = pass->disperses[cpm_region_medium(&f.region)];
        for (size_t b = 0; b < (splits ? bins : 1); b++) {
            f.bin = splits ? (int32_t)b : -1;
            paths[starts] = (uint32_t)i; /* for now */
            flights[starts++] = f;
        }
    }
    if (e->traced_back) look_back(pass, flights, arrivals, starts);
    for (size_t i = 0; i < starts; i++) {
        cpm_flight f = flights[i];
        const size_t first = f.bin < 0 ? 0 : (size_t)f.bin, carries = f.bin < 0 ? bins : 1;
        double radiance[CPM_MAX_BINS], most = 0.0;
        if (e->traced_back && arrivals[i].status != CPM_RAY_LEFT) continue;
        const cpm_vec toward = e->traced_back ? arrivals[i].direction : cpm_scaled(-1.0, f.direction);
        if (!cpm_sky_radiance(pass, e->number, toward, first, carries, radiance)) continue;
        const double n = cpm_pass_index(pass, cpm_region_medium(&f.region), f.bin, f.position);
        const double factor = made->weight[paths[i]] * e->power_factor * n * n;
        float *to = &powers[carrying * bins];
        for (size_t b = 0; b < carries; b++) {
            to[b] = (float)(radiance[b] * factor);
            if (e->traced_back && pass->extinction)
                to[b] *= (float)cpm_transmittance(pass, &f, &arrivals[i], first + b);
            most = cpm_max(most, (double)to[b]);
        }
        if (!(most > 0.0)) continue;
        paths[carrying] = (uint32_t)(path + paths[i]);
        flights[carrying++] = f;
    }
    return e->inside ? keep_confined(e, bins, flights, arrivals, paths, powers, carrying) : carrying;
}
