/* scene/rays.c: cpm_rays_trace in a scene. Boundaries are crossed by Snell's law, reflected only where they must be. */
#include "rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/cross.h"
#include "medium/method.h"

#define CHUNK 64
#define MAX_BOUNDARIES 10000

typedef struct leg { /* a piece of a journey, used up to theta */
    cpm_piece piece;
    double theta;
    int32_t degree, padding;
} leg;

typedef struct journey { /* one ray from its start to its end */
    leg *legs;
    size_t count, capacity;
    double length, optical_path, drift, error, evaluations, steps, rejected;
    int32_t status, method, shape;
    cpm_vec position, direction;
    double n;
    int failed;
} journey;

static void keep_piece(void *user, size_t ray, const cpm_piece *piece, int degree, double theta) {
    journey *j = (journey *)user + ray;
    if (j->count == j->capacity) {
        size_t capacity = j->capacity ? 2 * j->capacity : 8;
        leg *grown = realloc(j->legs, capacity * sizeof *grown);
        if (!grown) {
            j->failed = 1;
            return;
        }
        j->legs = grown;
        j->capacity = capacity;
    }
    j->legs[j->count++] = (leg){*piece, theta, degree, 0};
}

/* Optical path of part of a leg: h int |p|^2 dtheta; |p|^2 has degree 8 at most, so five Gauss-Legendre points are
 * exact. */
static double optical_path_of(const leg *l, double theta) {
    static const double x[5] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
    static const double w[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                0.2369268850561891};
    cpm_curve curve = cpm_curve_from_piece(&l->piece, l->degree);
    double sum = 0.0;
    for (int i = 0; i < 5; i++) {
        cpm_vec v = cpm_curve_tangent(&curve, 0.5 * theta * (1.0 + x[i])); /* h p */
        sum += w[i] * cpm_vdot(v, v);
    }
    return l->piece.h > 0.0 ? 0.5 * theta * sum / l->piece.h : 0.0;
}

static void end_at(journey *j, size_t last, double theta, int32_t status) {
    leg *l = &j->legs[last];
    cpm_curve curve = cpm_curve_from_piece(&l->piece, l->degree);
    l->theta = theta;
    j->count = last + 1;
    j->status = status;
    j->position = cpm_curve_at(&curve, theta);
    cpm_vec v = cpm_curve_tangent(&curve, theta);
    double speed = cpm_norm(v);
    if (speed > 0.0) j->direction = cpm_scaled(1.0 / speed, v);
    if (l->piece.h > 0.0) j->n = speed / l->piece.h;
    if (status == CPM_RAY_ARRIVED) j->shape = -1;
}

/* Walks the legs from `from` on: adds up lengths, and ends the journey at its length or plane if that comes first. */
static int measure(journey *j, size_t from, double wanted, const double *point, const double *normal, int at_start) {
    for (size_t i = from; i < j->count; i++) {
        leg *l = &j->legs[i];
        double arc = cpm_piece_arc(&l->piece, l->degree, l->theta), theta = -1.0;
        if (j->length + arc >= wanted) theta = cpm_piece_theta_of_arc(&l->piece, l->degree, wanted - j->length);
        if (point) {
            cpm_curve curve = cpm_curve_from_piece(&l->piece, l->degree);
            double roots[5];
            cpm_vec n = cpm_v(normal[0], normal[1], normal[2]), q = cpm_v(point[0], point[1], point[2]);
            int leaving =
                at_start && i == 0 &&
                fabs(cpm_vdot(cpm_sub(curve.c[0], q), n)) <= 1e-14 * cpm_norm(n) * (1.0 + cpm_norm(curve.c[0]));
            if (cpm_curve_plane(&curve, q, n, leaving, 0.0, l->theta, roots)) theta = roots[0];
        }
        if (theta >= 0.0) {
            j->length += cpm_piece_arc(&l->piece, l->degree, theta);
            j->optical_path += optical_path_of(l, theta);
            end_at(j, i, theta, CPM_RAY_ARRIVED);
            return 1;
        }
        j->length += arc;
        j->optical_path += optical_path_of(l, l->theta);
    }
    return 0;
}

typedef struct errand { /* what all rays of a request share */
    const cpm_pass *pass;
    const cpm_rays_request *request;
    const double *max_step; /* rays, metres; NULL: the pass's */
} errand;

static void add_up(journey *j, const cpm_arrival *a, int first) {
    j->evaluations += a->evaluations;
    j->steps += a->steps;
    j->rejected += a->rejected;
    j->error += a->error;
    j->drift = cpm_max(j->drift, a->drift);
    if (first) j->method = a->method;
    j->status = a->status;
    j->position = a->hit.position;
    j->direction = a->direction;
    j->n = a->n;
    j->shape = -1;
}

/* Does the ray go on through this boundary? Sets the next flight. */
static int goes_on(const cpm_pass *pass, cpm_flight *flight, const cpm_arrival *a, journey *j) {
    int32_t index = cpm_primitive_shape(pass->scene, a->hit.primitive);
    const shape *s = &pass->scene->shapes[index];
    cpm_passage passage;
    j->shape = index;
    if (s->material != CPM_NO_MATERIAL && pass->scene->materials[s->material].kind != CPM_MATERIAL_DIELECTRIC) return 0;
    if (!cpm_pass_boundary(pass, flight, a, &passage)) return 0;
    *flight = passage.total ? passage.reflected : passage.transmitted;
    return 1;
}

/* How far a straight ray has to go: to its length, or a little beyond the plane. */
static double far_enough(const cpm_rays_request *q, const cpm_flight *flight, double length) {
    if (!q->plane_point) return length;
    const double *a = q->plane_point, *b = q->plane_normal;
    cpm_vec n = cpm_v(b[0], b[1], b[2]);
    double t = cpm_vdot(cpm_sub(cpm_v(a[0], a[1], a[2]), flight->position), n) / cpm_vdot(flight->direction, n);
    return t >= 0.0 ? t * (1.0 + 1e-9) : INFINITY;
}

static void travel(const errand *e, size_t ray, journey *j) {
    const cpm_rays_request *q = e->request;
    const double *r = &q->origins[3 * ray], *d = &q->directions[3 * ray];
    double wanted = q->lengths ? q->lengths[(ptrdiff_t)ray * q->length_stride] : INFINITY;
    cpm_flight flight = {.position = cpm_v(r[0], r[1], r[2]), .left = -1};
    flight.direction = cpm_unit(cpm_v(d[0], d[1], d[2]));
    flight.bin = q->wavelength_stride ? (int32_t)ray : 0;
    flight.region = cpm_region_at(e->pass, flight.position, flight.direction);
    for (int i = 0; i < MAX_BOUNDARIES; i++) {
        cpm_arrival arrival;
        cpm_follow_options options = {.max_evaluations = q->max_evaluations,
                                      .sink = keep_piece,
                                      .user = j,
                                      .far = far_enough(q, &flight, wanted - j->length),
                                      .longest = q->lengths ? wanted - j->length : 0.0,
                                      .max_step = e->max_step ? e->max_step[ray] : 0.0};
        size_t from = j->count;
        cpm_follow(e->pass, &flight, 1, &options, &arrival);
        add_up(j, &arrival, i == 0);
        if (j->failed || measure(j, from, wanted, q->plane_point, q->plane_normal, i == 0)) return;
        if (arrival.status != CPM_RAY_HIT || !goes_on(e->pass, &flight, &arrival, j)) return;
    }
    j->status = CPM_RAY_EVALUATIONS_EXHAUSTED;
}

/* K points at equal arc length. */
static void sample_path(const journey *j, size_t samples, double *to) {
    double before = 0.0; /* arc length up to leg l */
    size_t l = 0;
    for (size_t k = 0; k < samples; k++) {
        double wanted = samples > 1 ? j->length * (double)k / (double)(samples - 1) : 0.0;
        cpm_vec r = j->position;
        while (l < j->count) {
            double arc = cpm_piece_arc(&j->legs[l].piece, j->legs[l].degree, j->legs[l].theta);
            if (wanted <= before + arc || l + 1 == j->count) {
                cpm_curve curve = cpm_curve_from_piece(&j->legs[l].piece, j->legs[l].degree);
                double theta = cpm_piece_theta_of_arc(&j->legs[l].piece, j->legs[l].degree, wanted - before);
                r = cpm_curve_at(&curve, cpm_min(theta, j->legs[l].theta));
                break;
            }
            before += arc;
            l++;
        }
        to[3 * k] = r.x, to[3 * k + 1] = r.y, to[3 * k + 2] = r.z;
    }
}

static void put3(double *to, size_t ray, cpm_vec v) {
    if (to) to[3 * ray] = v.x, to[3 * ray + 1] = v.y, to[3 * ray + 2] = v.z;
}

static void report(const cpm_rays_request *q, size_t ray, const journey *j, cpm_rays_result *to) {
    put3(to->position, ray, j->position);
    put3(to->direction, ray, j->direction);
    put3(to->momentum, ray, cpm_scaled(j->n, j->direction));
    if (to->length) to->length[ray] = j->length;
    if (to->optical_path) to->optical_path[ray] = j->optical_path;
    if (to->drift) to->drift[ray] = j->drift;
    if (to->error_estimate) to->error_estimate[ray] = cpm_max(j->error, 4e-16 * (cpm_norm(j->position) + j->length));
    if (to->evaluations) to->evaluations[ray] = (int64_t)j->evaluations;
    if (to->steps) to->steps[ray] = (int64_t)j->steps;
    if (to->rejected) to->rejected[ray] = (int64_t)j->rejected;
    if (to->error_evaluations) to->error_evaluations[ray] = 0;
    if (to->status) to->status[ray] = j->status;
    if (to->method) to->method[ray] = j->method;
    if (to->shape) to->shape[ray] = j->status == CPM_RAY_HIT ? j->shape : -1;
    if (to->paths && q->path_samples) sample_path(j, q->path_samples, &to->paths[3 * q->path_samples * ray]);
}

static cpm_status trace_all(cpm_context *context, const cpm_pass *pass, const cpm_rays_request *q,
                            const double *max_step, cpm_rays_result *result) {
    const errand e = {.pass = pass, .request = q, .max_step = max_step};
    const ptrdiff_t count = (ptrdiff_t)q->count;
    int failed = 0;
#pragma omp parallel for num_threads(context->threads) schedule(dynamic, CHUNK)
    for (ptrdiff_t i = 0; i < count; i++) {
        journey j = {.status = CPM_RAY_ARRIVED, .shape = -1};
        if (cpm_poll(context)) continue;
        travel(&e, (size_t)i, &j);
        if (j.failed) {
#pragma omp atomic write
            failed = 1;
        }
        report(q, (size_t)i, &j, result);
        free(j.legs);
    }
    if (failed) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for the paths of %zu rays", q->count);
    return cpm_poll(context) ? cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing rays") : CPM_OK;
}

/* The difference to a second run with a tenth of the tolerance, and at most half the steps: where one step of the
 * loosest tolerance does, a tenth of it alone would repeat it (fixed steps: half the step). */
static cpm_status global_error(cpm_context *context, cpm_scene *scene, cpm_scene_options options,
                               const cpm_rays_request *request, size_t bins, cpm_rays_result *result) {
    const size_t count = request->count;
    double *position = malloc(3 * count * sizeof *position), *max_step = malloc(count * sizeof *max_step);
    int64_t *evaluations = malloc(count * sizeof *evaluations);
    cpm_rays_request q = *request;
    cpm_rays_result second = {.struct_size = sizeof second, .position = position, .evaluations = evaluations};
    cpm_pass pass;
    q.path_samples = 0;
    options.rtol = cpm_max(0.1 * cpm_method_rtol(options.method, options.rtol), 1e-14);
    options.atol *= 0.1;
    options.step *= 0.5;
    for (size_t i = 0; i < count && max_step; i++) {
        max_step[i] = result->steps[i] > 0 ? 0.5 * result->length[i] / (double)result->steps[i] : 0.0;
        if (options.max_step > 0.0) max_step[i] = cpm_min(max_step[i], options.max_step);
    }
    cpm_status status = position && evaluations && max_step
                            ? cpm_pass_begin_with(context, scene, &options, q.wavelengths, bins, &pass)
                            : cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for a second run");
    if (!status) {
        status = trace_all(context, &pass, &q, options.step > 0.0 ? NULL : max_step, &second);
        cpm_pass_end(&pass);
    }
    for (size_t i = 0; i < count && !status; i++) {
        const double *a = &result->position[3 * i], *b = &position[3 * i];
        double difference =
            sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
        if (result->error_estimate)
            result->error_estimate[i] = cpm_max(difference, 4e-16 * sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]));
        if (result->error_evaluations) result->error_evaluations[i] = evaluations[i];
    }
    free(position), free(evaluations), free(max_step);
    return status;
}

cpm_status cpm_scene_rays_trace(cpm_context *context, cpm_scene *scene, const cpm_rays_request *request,
                                cpm_rays_result *result) {
    if (!request->count) return CPM_OK;
    size_t bins = request->wavelength_stride ? request->count : 1;
    cpm_scene_options options = scene->options;
    if (request->method != CPM_METHOD_AUTO) options.method = request->method;
    options.exclude |= request->exclude;
    if (request->rtol > 0.0) options.rtol = request->rtol;
    if (request->atol > 0.0) options.atol = request->atol;
    if (request->step > 0.0) options.step = request->step;
    if (request->max_step > 0.0) options.max_step = request->max_step;
    if (options.method == CPM_METHOD_EXACT)
        for (size_t m = 0; m < scene->medium_count; m++)
            if (!cpm_medium_has_exact(scene->media[m].medium))
                return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                                "method exact: medium %zu of the scene has no closed form "
                                "of the path",
                                m);
    cpm_rays_result r = *result;
    double *own = NULL; /* position, length and steps that global_error needs */
    if (request->error_mode == CPM_ERROR_GLOBAL) {
        own = malloc(request->count * (4 * sizeof *own + sizeof *r.steps));
        if (!own) return cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "no memory for %zu rays", request->count);
        if (!r.position) r.position = own;
        if (!r.length) r.length = own + 3 * request->count;
        if (!r.steps) r.steps = (int64_t *)(own + 4 * request->count);
    }
    cpm_pass pass;
    if (context->opencl) {
        free(own);
        return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                        "an OpenCL device traces rays alone in a medium, photons and pictures; rays of a scene need the "
                        "native backend");
    }
    cpm_progress_begin(context);
    cpm_progress(context, "trace", 0.0);
    cpm_status status = cpm_pass_begin_with(context, scene, &options, request->wavelengths, bins, &pass);
    int integrates = 0; /* else a second run would only repeat the first */
    if (!status) {
        status = trace_all(context, &pass, request, NULL, &r);
        for (size_t m = 0; m < scene->medium_count; m++) integrates |= pass.method[m] != CPM_METHOD_EXACT;
        cpm_pass_end(&pass);
    }
    if (!status && request->error_mode == CPM_ERROR_GLOBAL && integrates)
        status = global_error(context, scene, options, request, bins, &r);
    free(own);
    return status;
}
