/* Bundles of wavelengths in media that disperse: every bin is within its leeway of where a closed form puts it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/bundles.h"
#include "check.h"

#define BINS 32
#define FLIGHTS 200
#define N_SQUARED 1.69
static const double gradient[3] = {0.03, -0.10, 0.02}, cauchy[3] = {1.45, 0.012, 2e-4};

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }

/* A floor at y = 0 of 2 km under a medium of linear n^2 that disperses. */
typedef struct floor_scene {
    cpm_context *context;
    cpm_scene *scene;
    cpm_pass pass;
    double wavelengths[BINS];
} floor_scene;

static void build(floor_scene *f, size_t bins, int glass) {
    cpm_dispersion d = {.struct_size = sizeof d, .kind = CPM_DISPERSION_CAUCHY, .count = 3};
    memcpy(d.coefficients, cauchy, sizeof cauchy);
    f->context = new_context();
    cpm_medium *medium = NULL, *interior = NULL;
    assert_ok(f->context, cpm_medium_create_linear_squared(f->context, N_SQUARED, gradient, NULL, &d, &medium));
    const cpm_scene_options options = {.struct_size = sizeof options, .medium = glass ? NULL : medium};
    assert_ok(f->context, cpm_scene_create(f->context, &options, &f->scene));
    static const double corners[12] = {-1e3, 0, -1e3, -1e3, 0, 1e3, 1e3, 0, 1e3, 1e3, 0, -1e3};
    static const uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
    const cpm_material black = {.struct_size = sizeof black, .kind = CPM_MATERIAL_BLACK};
    const cpm_mesh_desc mesh = {.struct_size = sizeof mesh,
                                .vertices = corners,
                                .vertex_count = 4,
                                .faces = faces,
                                .face_count = 2,
                                .material = &black};
    assert_ok(f->context, cpm_scene_add_mesh(f->scene, &mesh, NULL));
    if (glass) {
        assert_ok(f->context, cpm_medium_create_dispersive(f->context, &d, &interior));
        const cpm_material ball = {.struct_size = sizeof ball, .kind = CPM_MATERIAL_DIELECTRIC, .interior = interior};
        const double center[3] = {0.0, 2.0, 0.0};
        assert_ok(f->context, cpm_scene_add_sphere(f->scene, center, 1.0, &ball, "ball", NULL));
        cpm_medium_release(interior);
    }
    cpm_medium_release(medium);
    for (size_t b = 0; b < bins; b++) f->wavelengths[b] = 400.0 + 300.0 * ((double)b + 0.5) / (double)bins;
    assert_ok(f->context, cpm_pass_begin(f->context, f->scene, f->wavelengths, bins, &f->pass));
}

static void demolish(floor_scene *f) {
    cpm_pass_end(&f->pass);
    cpm_scene_release(f->scene);
    cpm_context_release(f->context);
}

static long double n_of_cauchy(double wavelength) {
    const long double w = 1e-3L * wavelength;
    return cauchy[0] + cauchy[1] / (w * w) + cauchy[2] / (w * w * w * w);
}

/* Where the parabola r + p sigma + g sigma^2/2, p = n d, g = grad n^2/2, first comes down to y = 0. */
static cpm_vec falls_at(const cpm_flight *f, double wavelength) {
    const long double n = n_of_cauchy(wavelength), d = n_of_cauchy(587.5618), s = (n * n - 1.0L) / (d * d - 1.0L);
    const cpm_vec r = f->position, u = f->direction;
    const long double squared =
        1.0L + s * (N_SQUARED - 1.0L + gradient[0] * r.x + gradient[1] * r.y + gradient[2] * r.z);
    const long double p = sqrtl(squared), g = 0.5L * s * gradient[1], py = p * u.y;
    const long double sigma = (-py - sqrtl(py * py - 2.0L * g * r.y)) / g; /* g < 0: up and down again, or down */
    return cpm_v((double)(r.x + sigma * (p * u.x + 0.25L * s * gradient[0] * sigma)), 0.0,
                 (double)(r.z + sigma * (p * u.z + 0.25L * s * gradient[2] * sigma)));
}

static void random_flights(cpm_flight *flights) {
    for (int i = 0; i < FLIGHTS; i++) {
        memset(&flights[i], 0, sizeof flights[i]);
        flights[i].position = cpm_v(2.0 * uniform() - 1.0, 0.5 + 3.0 * uniform(), 2.0 * uniform() - 1.0);
        flights[i].direction = cpm_unit(cpm_v(uniform() - 0.5, uniform() - 0.8, uniform() - 0.5));
        flights[i].region.count = 1;
        flights[i].left = flights[i].bin = -1;
    }
}

static void every_bin_is_within_its_leeway(void **state) {
    (void)state;
    static const double sizes[] = {0.0, 1e-6, 1e-4, 3e-3, 0.05, 1e4}, angles[] = {0.0, 0.0, 1e-4, 0.0, 0.01, 0.0};
    static cpm_flight flights[FLIGHTS];
    static cpm_leeway leeways[FLIGHTS];
    floor_scene f;
    cpm_bundles b = {0};
    build(&f, BINS, 0);
    srand(1);
    random_flights(flights);
    uint64_t followed_before = UINT64_MAX;
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < FLIGHTS; i++) leeways[i] = (cpm_leeway){sizes[k], angles[k]};
        assert_true(cpm_follow_bundles(&b, &f.pass, CPM_BUNDLES_OF_PHOTONS, flights, leeways, FLIGHTS, NULL));
        size_t at = 0;
        for (size_t i = 0; i < FLIGHTS; i++)
            for (int32_t next = 0; next < BINS; at++) {
                assert_true(at < b.count);
                const cpm_parted *p = &b.parted[at];
                const int32_t first = cpm_bins_first(p->bin), count = cpm_bins_count(p->bin, BINS);
                assert_int_equal(p->from, i); /* all bins, once each, in order */
                assert_int_equal(first, next);
                next += count;
                assert_int_equal(p->arrival.status, CPM_RAY_HIT);
                const cpm_vec start = flights[i].position, end = p->arrival.hit.position;
                const double room = sizes[k] + angles[k] * cpm_norm(cpm_sub(end, start));
                for (int32_t bin = first; bin < first + count; bin++) {
                    const cpm_vec exact = falls_at(&flights[i], f.wavelengths[bin]);
                    const double off = cpm_norm(cpm_sub(end, exact));
                    if (!(off <= room + 1e-9 * (1.0 + cpm_norm(exact))))
                        fail_msg("flight %zu, bin %d of %d: %g m off, %g allowed", i, bin, count, off, room);
                }
                if (sizes[k] == 0.0) assert_int_equal(count, 1);
                if (sizes[k] == 1e4) assert_int_equal(p->bin, -1);
            }
        assert_int_equal(at, b.count);
        if (k == 0) assert_int_equal(b.followed, BINS * FLIGHTS); /* no path twice */
        if (k == 5) assert_int_equal(b.followed, 3 * FLIGHTS);
        assert_true(k < 2 ? b.followed <= followed_before : b.followed < followed_before);
        followed_before = b.followed;
    }
    cpm_bundles_free(&b);
    demolish(&f);
}

/* A flight alone and one in a crowd part alike; a run of bins parts as part of the bundle does. */
static void what_is_beside_a_flight_does_not_matter(void **state) {
    (void)state;
    static cpm_flight flights[FLIGHTS];
    static cpm_leeway leeways[FLIGHTS];
    floor_scene f;
    cpm_bundles all = {0}, one = {0};
    build(&f, BINS, 0);
    srand(2);
    random_flights(flights);
    for (int i = 0; i < FLIGHTS; i++) {
        leeways[i] = (cpm_leeway){2e-3, 1e-3 * uniform()};
        if (i % 3 == 1) flights[i].bin = cpm_bins_run(5, 20, BINS);
        if (i % 3 == 2) flights[i].bin = i % BINS;
    }
    assert_true(cpm_follow_bundles(&all, &f.pass, CPM_BUNDLES_OF_EYE, flights, leeways, FLIGHTS, NULL));
    size_t at = 0, runs = 0;
    for (size_t i = 0; i < FLIGHTS; i++) {
        assert_true(cpm_follow_bundles(&one, &f.pass, CPM_BUNDLES_OF_EYE, &flights[i], &leeways[i], 1, NULL));
        int32_t next = cpm_bins_first(flights[i].bin);
        for (size_t j = 0; j < one.count; j++, at++) {
            assert_int_equal(all.parted[at].from, i);
            assert_int_equal(all.parted[at].bin, one.parted[j].bin);
            assert_memory_equal(&all.parted[at].arrival.hit, &one.parted[j].arrival.hit, sizeof(cpm_hit));
            assert_int_equal(cpm_bins_first(one.parted[j].bin), next);
            next += cpm_bins_count(one.parted[j].bin, BINS);
            runs += cpm_bins_count(one.parted[j].bin, BINS) > 1;
        }
        assert_int_equal(next, cpm_bins_first(flights[i].bin) + cpm_bins_count(flights[i].bin, BINS));
    }
    assert_int_equal(at, all.count);
    assert_true(runs > FLIGHTS / 2);
    cpm_bundles_free(&all), cpm_bundles_free(&one);
    demolish(&f);
}

/* Into a ball of glass: runs whose refracted directions, by Snell, are within the angle of their middle's; the run
 * twice as long is not. */
static void a_bundle_parts_at_glass(void **state) {
    (void)state;
    floor_scene f;
    build(&f, BINS, 1);
    for (int trial = 0; trial < 60; trial++) {
        const double angle = trial % 3 == 0 ? 0.0 : trial % 3 == 1 ? 1e-4 : 1e-3, offset = 0.9 * (trial + 1) / 60;
        const cpm_flight flight = {.position = cpm_v(offset, 5.0, 0.0),
                                   .direction = cpm_v(0.0, -1.0, 0.0),
                                   .region = {.count = 1},
                                   .left = -1,
                                   .bin = -1};
        cpm_arrival arrival;
        cpm_follow(&f.pass, &flight, 1, NULL, &arrival);
        assert_int_equal(arrival.status, CPM_RAY_HIT);
        cpm_flight stack[BINS];
        cpm_arrival there[BINS];
        int32_t next = 0;
        int depth = 1, parts = 0;
        stack[0] = flight, there[0] = arrival;
        while (depth) { /* lower halves first */
            const cpm_flight part = stack[--depth];
            const cpm_arrival at = there[depth];
            const int32_t first = cpm_bins_first(part.bin), count = cpm_bins_count(part.bin, BINS);
            const double middle = asin(offset / (double)n_of_cauchy(f.wavelengths[cpm_bins_middle(part.bin, BINS)]));
            double apart = 0.0, least = 1.0, most = 0.0;
            for (int32_t bin = first; bin < first + count; bin++) {
                const double n = (double)n_of_cauchy(f.wavelengths[bin]), bent = asin(offset / n);
                const double si = offset, ci = sqrt(1.0 - si * si), ct = cos(bent);
                const double s = (ci - n * ct) / (ci + n * ct), p = (n * ci - ct) / (n * ci + ct);
                apart = fmax(apart, 2.0 * fabs(sin(0.5 * (bent - middle))));
                least = fmin(least, 0.5 * (s * s + p * p)), most = fmax(most, 0.5 * (s * s + p * p));
            }
            const int parted = cpm_bundle_parts(&f.pass, &part, &at, angle);
            if (count == 1) assert_false(parted);
            if (!parted && count > 1) assert_true(apart <= angle + 1e-12 && most - least <= 2e-3);
            if (parted && angle > 0.0) assert_true(apart > 0.999 * angle || most - least > 0.9e-3);
            if (parted) {
                for (int upper = 1; upper >= 0; upper--, depth++)
                    cpm_bundle_half(&f.pass, &part, &at, upper, &stack[depth], &there[depth]);
                continue;
            }
            assert_int_equal(first, next);
            next += count;
            parts++;
        }
        assert_int_equal(next, BINS);
        if (angle == 0.0) assert_int_equal(parts, BINS);
        if (trial == 2) assert_true(parts > 1 && parts < BINS); /* nearly head on: apart by what they reflect */
    }
    demolish(&f);
}

static void every_run_has_a_number_of_its_own(void **state) {
    (void)state;
    static uint8_t seen[65536];
    for (int32_t first = 0; first < 256; first++)
        for (int32_t count = 1; first + count <= 256; count++) {
            const int32_t bin = cpm_bins_run(first, count, 256);
            assert_int_equal(cpm_bins_first(bin), first);
            assert_int_equal(cpm_bins_count(bin, 256), count);
            assert_int_equal(cpm_bins_middle(bin, 256), first + count / 2);
            assert_int_equal(bin >= 0, count == 1);
            const cpm_u32 stored = cpm_bins_stored(bin);
            assert_true(stored < 65536 && !seen[stored]++);
            assert_int_equal(cpm_photon_first(stored), first);
            assert_int_equal(cpm_photon_count(stored, 256), count);
            assert_int_equal(stored == CPM_ALL_BINS, count == 256);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_run_has_a_number_of_its_own),
        cmocka_unit_test(every_bin_is_within_its_leeway),
        cmocka_unit_test(what_is_beside_a_flight_does_not_matter),
        cmocka_unit_test(a_bundle_parts_at_glass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
