/* test_map.c: the photon map's tree against two oracles that sort all distances. One in double: for the radius, and for
 * sums where no other photon is nearly as far as the k-th. One in the map's own single-precision arithmetic, which the
 * radius has to meet bit for bit. Then what must not matter: order, threads, the last query, the instruction set. */
#include "map_clouds.h"

/* --- oracles --------------------------------------------------------------------------------------------------- */

typedef struct candidate {
    double distance2;
    uint64_t order;
    const cpm_photon *photon;
} candidate;

static int nearer(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->distance2 != y->distance2) return x->distance2 < y->distance2 ? -1 : 1;
    return (x->order > y->order) - (x->order < y->order);
}

/* Irradiance and radius; distances in the map's arithmetic (`single`, scaled by the map's power of two) or in double.
 * Returns whether the k-th distance is clear of its neighbours, so that rounding cannot exchange them. */
static int oracle(const cloud *c, const ask *q, size_t k, double max_radius, int single, float unit, double *irradiance,
                  double *radius) {
    candidate *all = malloc((c->count + 1) * sizeof *all);
    assert_non_null(all);
    size_t n = 0;
    const float limit = (float)fmin(max_radius * (double)unit * max_radius * (double)unit, (double)FLT_MAX);
    for (size_t i = 0; i < c->count; i++) {
        const cpm_photon *p = &c->photons[i];
        if (!cpm_same_side(p->normal, q->normal[0], q->normal[1], q->normal[2])) continue;
        double d2 = 0.0;
        if (single) {
            float d[3];
            for (int a = 0; a < 3; a++) d[a] = p->position[a] * unit - q->point[a] * unit;
            const float f = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2];
            if (!(f <= limit)) continue;
            d2 = (double)f;
        } else {
            for (int a = 0; a < 3; a++) d2 += pow((double)p->position[a] - (double)q->point[a], 2.0);
            if (!(d2 <= max_radius * max_radius)) continue;
        }
        all[n++] = (candidate){d2, (uint64_t)p->path << 32 | (uint64_t)p->bounce << 16 | p->bin, p};
    }
    qsort(all, n, sizeof *all, nearer);
    const size_t summed = n >= k ? k - 1 : n;
    *radius = max_radius;
    if (n >= k) *radius = sqrt(all[k - 1].distance2) / (single ? (double)unit : 1.0);
    int clear = n < k || ((k < 2 || all[k - 1].distance2 > all[k - 2].distance2 * (1.0 + 2e-6)) &&
                          (k >= n || all[k].distance2 > all[k - 1].distance2 * (1.0 + 2e-6)));
    double *sum = calloc(c->bins, sizeof *sum);
    assert_non_null(sum);
    for (size_t i = 0; i < summed; i++) {
        const cpm_photon *p = all[i].photon;
        const uint16_t *s = c->spectra + p->spectrum;
        for (size_t b = 0; b < c->bins; b++)
            if (p->bin == CPM_ALL_BINS)
                sum[b] += (double)cpm_half_to_float(s[b]);
            else if (b >= p->bin % 256u && b <= p->bin % 256u + p->bin / 256u)
                sum[b] += (double)cpm_half_to_float(s[b - p->bin % 256u]);
    }
    double radius2 =
        n >= k ? all[k - 1].distance2 / (single ? (double)unit * (double)unit : 1.0) : max_radius * max_radius;
    double largest = 0.0;
    for (int a = 0; a < 3; a++) largest = fmax(largest, fabs((double)(q->point[a] * unit)));
    const double least = 0x1p-24 * fmax(largest, 0x1p-24) / (double)unit;
    radius2 = fmax(radius2, least * least);
    for (size_t b = 0; b < c->bins; b++) irradiance[b] += summed ? SCALE / (PI * radius2) * sum[b] : 0.0;
    free(sum);
    free(all);
    return clear;
}

static void close_to(double got, double wanted, double relative, const char *what, shape s, uint32_t i) {
    if (got != wanted && !(fabs(got - wanted) <= relative * fabs(wanted))) /* both infinite is well */
        fail_msg("%s, query %u: %s is %.17g, wanted %.17g", shape_names[s], i, what, got, wanted);
}

static void check_queries(const cloud *c, const cpm_map_tree *tree, shape s, uint32_t queries, int32_t k,
                          double max_radius) {
    cpm_map_query *query = cpm_query_create(tree);
    assert_non_null(query);
    double got[64], wanted[64];
    for (uint32_t i = 0; i < queries; i++) {
        const ask q = ask_make(s, i, c);
        double radius;
        memset(got, 0, sizeof got);
        memset(wanted, 0, sizeof wanted);
        const double used = cpm_tree_irradiance(tree, query, q.point, q.normal, k, max_radius, got);
        const double r_k = cpm_tree_radius(tree, query, q.point, q.normal, k, max_radius);
        oracle(c, &q, (size_t)k, max_radius, 1, tree->unit, wanted, &radius);
        close_to(r_k, radius, 0.0, "r_k", s, i);
        for (size_t b = 0; b < c->bins; b++) close_to(got[b], wanted[b], 1e-14, "irradiance", s, i);
        double largest = 0x1p-24; /* the spacing of floats there: no radius used is below it */
        for (int a = 0; a < 3; a++) largest = fmax(largest, fabs((double)(q.point[a] * tree->unit)));
        const double least = 0x1p-24 * largest / (double)tree->unit;
        close_to(used, r_k < max_radius ? fmax(r_k, least) : max_radius, 0.0, "radius used", s, i);

        memset(wanted, 0, sizeof wanted);
        const int clear = oracle(c, &q, (size_t)k, max_radius, 0, tree->unit, wanted, &radius);
        close_to(r_k, radius, 3e-7, "r_k in double", s, i);
        for (size_t b = 0; b < c->bins && clear && radius > 0.0; b++)
            close_to(got[b], wanted[b], 1e-6, "irradiance in double", s, i);
    }
    cpm_query_free(query);
}

static void against_brute_force(void **state) {
    (void)state;
    for (int s = VOLUME; s <= LINE; s++) {
        const size_t bins = s == CUBE ? 16 : 1 + (size_t)s * 2;
        cloud c = cloud_make((shape)s, 5000, bins, s % 3 == 0 ? 3 : 0, 0);
        cloud copy = cloud_copy(&c);
        cpm_map_tree *tree = tree_of(&copy, 1);
        check_queries(&c, tree, (shape)s, 64, 50, INFINITY);
        check_queries(&c, tree, (shape)s, 32, 2, INFINITY);
        check_queries(&c, tree, (shape)s, 8, 1, INFINITY);
        check_queries(&c, tree, (shape)s, 16, 1500, INFINITY);
        check_queries(&c, tree, (shape)s, 32, 40, s == HUGE_CUBE ? 1e36 : s == TINY_CUBE ? 1e-31 : 0.05);
        cpm_tree_free(tree);
        cloud_free(&c);
    }
}

/* Sizes around a leaf, a node, and nothing. */
static void every_small_size(void **state) {
    (void)state;
    for (size_t count = 1; count < 400; count = count < 70 ? count + 1 : count + 37) {
        cloud c = cloud_make(count % 2 ? SHELL : LATTICE, count, 3, 2, 0);
        cloud copy = cloud_copy(&c);
        cpm_map_tree *tree = tree_of(&copy, 2);
        check_queries(&c, tree, count % 2 ? SHELL : LATTICE, 6, 5, INFINITY);
        check_queries(&c, tree, count % 2 ? SHELL : LATTICE, 6, 10000, INFINITY); /* more than there are */
        check_queries(&c, tree, count % 2 ? SHELL : LATTICE, 6, INT32_MAX, 4.0);
        cpm_tree_free(tree);
        cloud_free(&c);
    }
}

/* Large enough for several threads, and for cells that all threads must divide anew. */
static void large_clouds(void **state) {
    (void)state;
    const shape shapes[] = {CUBE, CLUSTERS, OUTLIER, LATTICE};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        cloud c = cloud_make(shapes[s], 300000, 2, 0, 0);
        cloud copy = cloud_copy(&c);
        cpm_map_tree *tree = tree_of(&copy, 3);
        check_queries(&c, tree, shapes[s], 3, 150, INFINITY);
        check_queries(&c, tree, shapes[s], 1, 10000, INFINITY);
        cpm_tree_free(tree);
        cloud_free(&c);
    }
}

/* --- what must not matter -------------------------------------------------------------------------------------- */

#define MANY 400

/* Radius and irradiance of MANY queries, asked from last to first where `backwards`. */
static double *answers(const cpm_map_tree *tree, shape s, int32_t k, int backwards, const cpm_search *search,
                       const cloud *places) {
    const size_t row = tree->bins + 1;
    double *out = calloc(MANY * row, sizeof *out);
    cpm_map_query *query = cpm_query_create(tree);
    assert_non_null(out);
    assert_non_null(query);
    if (search) query->search = search;
    for (uint32_t j = 0; j < MANY; j++) {
        const uint32_t i = backwards ? MANY - 1 - j : j;
        const ask q = ask_make(s, i, places);
        out[i * row] = cpm_tree_irradiance(tree, query, q.point, q.normal, k, INFINITY, out + i * row + 1);
        if (backwards) query->state.guess *= i % 3 == 0 ? 1000.0f : i % 3 == 1 ? 0.001f : 0.0f; /* bad memory */
    }
    cpm_query_free(query);
    return out;
}

static void order_threads_and_guesses_do_not_matter(void **state) {
    (void)state;
    const shape shapes[] = {CUBE, SHELL, CLUSTERS, OUTLIER, LATTICE, WALL, POINT};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        const unsigned split = s % 2 ? 4 : 0;
        cloud places = cloud_make(shapes[s], 150000, 5, split, 0), first = cloud_copy(&places);
        cpm_map_tree *tree = tree_of(&first, 1);
        double *wanted = answers(tree, shapes[s], 60, 0, NULL, &places);
        for (int32_t threads = 1; threads <= 4; threads++) {
            cloud c = cloud_make(shapes[s], 150000, 5, split, (uint64_t)threads);
            cpm_map_tree *other = tree_of(&c, threads);
            assert_int_equal(cpm_tree_bytes(other), cpm_tree_bytes(tree));
            assert_memory_equal(other->photons, tree->photons, tree->count * sizeof *tree->photons);
            assert_memory_equal(other->spectra, tree->spectra, tree->spectra_count * sizeof *tree->spectra);
            assert_memory_equal(other->points, tree->points, 3 * tree->count * sizeof *tree->points);
            assert_memory_equal(other->nodes, tree->nodes, tree->node_count * sizeof *tree->nodes);
            for (int backwards = 0; backwards < 2; backwards++) {
                double *got = answers(other, shapes[s], 60, backwards, NULL, &places);
                assert_memory_equal(got, wanted, MANY * 6 * sizeof *got);
                free(got);
            }
            cpm_tree_free(other);
        }
        free(wanted);
        cpm_tree_free(tree);
        cloud_free(&places);
    }
}

static void instruction_sets_agree(void **state) {
    (void)state;
    const size_t bins[] = {1, 16, 23};
    for (int s = VOLUME; s <= LINE; s++) {
        cloud places = cloud_make((shape)s, 20000, bins[s % 3], s % 4 == 3 ? 2 : 0, 0), c = cloud_copy(&places);
        cpm_map_tree *tree = tree_of(&c, 2);
        const int32_t ks[] = {2, 33, 150, 9999}; /* 9999: sums that need not be exact */
        for (size_t k = 0; k < sizeof ks / sizeof *ks; k++) {
            double *wanted = answers(tree, (shape)s, ks[k], 0, cpm_search_for(CPM_ISA_BASELINE), &places);
            for (int isa = CPM_ISA_V3; isa <= (int)cpm_isa_chosen(); isa++) {
                double *got = answers(tree, (shape)s, ks[k], 0, cpm_search_for((cpm_isa)isa), &places);
                assert_memory_equal(got, wanted, MANY * (tree->bins + 1) * sizeof *got);
                free(got);
            }
            free(wanted);
        }
        cpm_tree_free(tree);
        cloud_free(&places);
    }
}

/* --- edges ----------------------------------------------------------------------------------------------------- */

static void nothing_in_it(void **state) {
    (void)state;
    cloud c = {.bins = 4};
    cpm_map_tree *tree = tree_of(&c, 2);
    assert_int_equal(cpm_tree_bytes(tree), 0);
    cpm_map_query *query = cpm_query_create(tree);
    assert_non_null(query);
    const float point[3] = {0}, normal[3] = {0.0f, 0.0f, 1.0f};
    double irradiance[4] = {1.0, 2.0, 3.0, 4.0};
    assert_true(cpm_tree_irradiance(tree, query, point, normal, 50, INFINITY, irradiance) == 0.0);
    assert_true(cpm_tree_radius(tree, query, point, normal, 50, INFINITY) == 0.0);
    assert_true(irradiance[0] == 1.0 && irradiance[3] == 4.0);
    cpm_query_free(query);
    cpm_tree_free(tree);
    cpm_tree_free(NULL);
    cpm_query_free(NULL);
}

static void a_million_in_one_point(void **state) {
    (void)state;
    cloud c = cloud_make(POINT, 1000000, 1, 0, 5), places = {.bins = 1};
    cpm_map_tree *tree = tree_of(&c, 2);
    cpm_map_query *query = cpm_query_create(tree);
    assert_non_null(query);
    const float normal[3] = {0.0f, 0.0f, 1.0f}, beside[3] = {0.25f, -3.0f, 1.0f}, behind[3] = {0.0f, 0.0f, -1.0f};
    const float there[3] = {0.25f, -3.5f, 1.0f};
    double sum = 0.0;
    for (size_t i = 0; i < 149; i++) sum += (double)cpm_half_to_float(tree->spectra[i]); /* ties: the first paths */
    for (int repeat = 0; repeat < 1000; repeat++) {
        double e = 0.0;
        assert_true(cpm_tree_irradiance(tree, query, beside, normal, 150, INFINITY, &e) == 0.5);
        close_to(e, SCALE * sum / (PI * 0.25), 1e-14, "irradiance", POINT, 0);
    }
    double e = 0.0; /* at the point itself: finite, and large */
    assert_true(cpm_tree_irradiance(tree, query, there, normal, 150, INFINITY, &e) > 0.0);
    assert_true(isfinite(e) && e > 1e9);
    assert_true(cpm_tree_radius(tree, query, there, normal, 150, INFINITY) == 0.0);
    e = 0.0;
    assert_true(cpm_tree_irradiance(tree, query, there, behind, 150, 2.0, &e) == 2.0 && e == 0.0);
    cpm_query_free(query);
    cpm_tree_free(tree);
    cloud_free(&places);
}

static void radii_of_no_use(void **state) {
    (void)state;
    cloud c = cloud_make(CUBE, 3000, 2, 0, 0);
    cpm_map_tree *tree = tree_of(&c, 1);
    cpm_map_query *query = cpm_query_create(tree);
    assert_non_null(query);
    const float inside[3] = {0.5f, 0.5f, 0.5f}, normal[3] = {0.0f, 0.0f, 1.0f};
    const float *at = tree->photons[7].position;
    const double radii[] = {1e-300, 1e-38, 1e-9};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++) {
        double e[2] = {0};
        assert_true(cpm_tree_irradiance(tree, query, inside, normal, 50, radii[i], e) == radii[i]);
        assert_true(e[0] == 0.0 && e[1] == 0.0);
        const cpm_vec n = cpm_octahedral_decode(tree->photons[7].normal);
        const float up[3] = {(float)n.x, (float)n.y, (float)n.z};
        assert_true(cpm_tree_irradiance(tree, query, at, up, 50, radii[i], e) == radii[i]);
        assert_true(isfinite(e[0]) && e[0] > 0.0); /* the photon that is just there */
    }
    const double refused[] = {0.0, -1.0, (double)NAN};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        double e[2] = {0};
        assert_true(cpm_tree_irradiance(tree, query, at, normal, 50, refused[i], e) == 0.0);
        assert_true(e[0] == 0.0 && e[1] == 0.0);
    }
    double e[2] = {0};
    const float far_away[3] = {3e38f, -3e38f, 3e38f}, up[3] = {0.0f, 0.0f, 1.0f};
    assert_true(cpm_tree_irradiance(tree, query, far_away, up, 50, 10.0, e) == 10.0 && e[0] == 0.0);
    cpm_query_free(query);
    cpm_tree_free(tree);
}

static void bad_photons_are_refused(void **state) {
    (void)state;
    cpm_context *context = new_context();
    for (int bad = 0; bad < 7; bad++) {
        cloud c = cloud_make(CUBE, 100, 4, 0, 0);
        size_t bins = 4;
        if (bad == 0) bins = 0;
        if (bad == 1) bins = CPM_MAX_BINS + 1;
        if (bad == 2) c.photons[60].position[1] = NAN;
        if (bad == 3) c.photons[60].position[2] = INFINITY;
        if (bad == 4) c.photons[60].spectrum = 397;
        if (bad == 5) c.photons[60].bin = 4;
        if (bad == 6) c.photons[60].bin = 2 + 256 * 2; /* bins 2, 3 and 4, of four */
        cpm_map_tree *tree = NULL;
        const cpm_status status =
            cpm_tree_build(context, c.photons, c.spectra, c.count, c.spectra_count, free, bins, SCALE, &tree);
        assert_int_equal(status, bad < 2 ? CPM_ERROR_INVALID_ARGUMENT : CPM_ERROR_INTERNAL);
        assert_null(tree);
        assert_non_null(strstr(cpm_context_last_error(context), bad < 2 ? "bins" : "photon 60 "));
    }
    cpm_context_release(context);
}

/* A photon's bytes are where the header says. */
static void a_photon_takes_32_bytes(void **state) {
    (void)state;
    assert_int_equal(sizeof(cpm_photon), 32);
    assert_int_equal(offsetof(cpm_photon, direction), 12);
    assert_int_equal(offsetof(cpm_photon, bounce), 30);
    assert_int_equal(sizeof(cpm_node), 320);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_brute_force),
        cmocka_unit_test(every_small_size),
        cmocka_unit_test(large_clouds),
        cmocka_unit_test(order_threads_and_guesses_do_not_matter),
        cmocka_unit_test(instruction_sets_agree),
        cmocka_unit_test(nothing_in_it),
        cmocka_unit_test(a_million_in_one_point),
        cmocka_unit_test(radii_of_no_use),
        cmocka_unit_test(bad_photons_are_refused),
        cmocka_unit_test(a_photon_takes_32_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
