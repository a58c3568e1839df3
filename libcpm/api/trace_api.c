/* api/trace_api.c: cpm_rays_trace: checks, the choice of method, and rays alone in a medium. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "backend/native/lanes.h"
#include "backend/opencl/trace.h"
#include "context.h"
#include "medium/medium.h"
#include "medium/method.h"
#include "scene/rays.h"

#define MIN_RTOL 1e-14
#define MAX_CHUNK 1024
#define FIRST_CHUNK CPM_LANES
#define SHORT_CHUNK 0.005 /* s */
#define LONG_CHUNK 0.05

typedef struct trace_work {
    cpm_context *context;
    const cpm_medium *medium;
    const cpm_rays_request *request;
    cpm_ray_start *starts;
    cpm_ray_end *ends;
    cpm_step_control control;
    cpm_ray_goal goal;
} trace_work;

/* ------------------------------------------------------------------------------------------------------ checks */

static cpm_status bad_number(cpm_context *context, const char *name, double value, const char *allowed) {
    return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is %g; must be %s", name, value, allowed);
}

static cpm_status check_steering(cpm_context *context, const cpm_rays_request *q) {
    if (q->method < CPM_METHOD_AUTO || q->method > CPM_METHOD_LAST)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "method is %d; must be 0 to %d (cpm_method)",
                        (int)q->method, CPM_METHOD_LAST);
    if (q->rtol != 0.0 && !(q->rtol >= MIN_RTOL && q->rtol <= 1.0))
        return bad_number(context, "rtol", q->rtol, "in [1e-14, 1], or 0 for the method's default");
    if (!(q->atol >= 0.0) || !isfinite(q->atol)) return bad_number(context, "atol", q->atol, "finite and >= 0");
    if (!(q->step >= 0.0) || !isfinite(q->step))
        return bad_number(context, "step", q->step, "finite and > 0, or 0 for adaptive steps");
    if (!(q->max_step >= 0.0)) return bad_number(context, "max_step", q->max_step, "> 0, or 0 for no bound");
    if (q->max_evaluations < 0)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "max_evaluations is %lld; must be >= 0 (0: 1 000 000)",
                        (long long)q->max_evaluations);
    if (q->error_mode != CPM_ERROR_LOCAL && q->error_mode != CPM_ERROR_GLOBAL)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "error_mode is %d; must be 0 (local) or 1 (global)",
                        (int)q->error_mode);
    return CPM_OK;
}

static cpm_status check_arrays(cpm_context *context, const cpm_rays_request *q) {
    if (q->count && (!q->origins || !q->directions || !q->wavelengths))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL",
                        !q->origins      ? "origins"
                        : !q->directions ? "directions"
                                         : "wavelengths");
    if (q->count > PTRDIFF_MAX / sizeof(cpm_ray_end) ||
        (q->path_samples && q->count > PTRDIFF_MAX / 24 / q->path_samples))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is %zu with path_samples %zu; too many", q->count,
                        q->path_samples);
    if (q->wavelength_stride < 0 || q->wavelength_stride > 1 || q->length_stride < 0 || q->length_stride > 1)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "wavelength_stride and length_stride are %td and %td; must be 0 or 1", q->wavelength_stride,
                        q->length_stride);
    for (size_t i = 0; i < (q->wavelength_stride ? q->count : q->count > 0); i++)
        if (!isfinite(q->wavelengths[i]) || !(q->wavelengths[i] > 0.0))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "wavelengths[%zu] is %g nm; must be finite and > 0", i,
                            q->wavelengths[i]);
    for (size_t i = 0; i < q->count; i++) {
        const double *r = q->origins + 3 * i, *d = q->directions + 3 * i;
        for (int k = 0; k < 3; k++) {
            if (!isfinite(r[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "origins[%zu, %d] is %g; must be finite", i, k,
                                r[k]);
            if (!isfinite(d[k]))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "directions[%zu, %d] is %g; must be finite", i, k,
                                d[k]);
        }
        if (d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0)
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "directions[%zu] is zero; must have a direction", i);
    }
    return CPM_OK;
}

/* Exactly one of a length and a plane. */
static cpm_status check_end(cpm_context *context, const cpm_rays_request *q, cpm_ray_goal *goal) {
    int plane = q->plane_point || q->plane_normal;
    if ((q->plane_point == NULL) != (q->plane_normal == NULL))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL; a plane needs a point and a normal",
                        q->plane_point ? "plane_normal" : "plane_point");
    if ((q->lengths != NULL) == plane)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "%s lengths and a plane are given; exactly one ends a ray in a medium",
                        plane ? "both" : "neither");
    if (!plane) {
        for (size_t i = 0; i < (q->length_stride ? q->count : q->count > 0); i++)
            if (!isfinite(q->lengths[i]) || !(q->lengths[i] >= 0.0))
                return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "lengths[%zu] is %g; must be finite and >= 0", i,
                                q->lengths[i]);
        return CPM_OK;
    }
    double largest = 0.0, size = 0.0;
    for (int k = 0; k < 3; k++) {
        if (!isfinite(q->plane_point[k]) || !isfinite(q->plane_normal[k]))
            return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                            "until: plane_point[%d] and plane_normal are %g and %g; must be finite", k,
                            q->plane_point[k], q->plane_normal[k]);
        largest = fmax(largest, fabs(q->plane_normal[k]));
    }
    if (largest == 0.0)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "until: plane_normal is zero; must have a direction");
    for (int k = 0; k < 3; k++) size += (q->plane_normal[k] / largest) * (q->plane_normal[k] / largest);
    for (int k = 0; k < 3; k++) {
        goal->point[k] = q->plane_point[k];
        goal->normal[k] = q->plane_normal[k] / largest / sqrt(size);
    }
    return CPM_OK;
}

/* ------------------------------------------------------------------------------------------------------ method */

static cpm_status choose_method(cpm_context *context, const cpm_medium *medium, const cpm_rays_request *q,
                                int32_t *method) {
    const int exact = cpm_medium_has_exact(medium), exact_only = cpm_medium_needs_exact(medium);
    *method = cpm_method_in(medium, q->method, q->exclude, q->step);
    if (cpm_medium_is_uniform(medium)) return CPM_OK; /* straight, whatever was asked: no integrator runs */
    if (*method == CPM_METHOD_AUTO)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "exclude is 0x%x; no method is left for this medium",
                        (unsigned)q->exclude);
    if (*method == CPM_METHOD_EXACT && !exact)
        return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                        "method is exact; this medium has no closed form (homogeneous, linear-squared, linear, layered "
                        "linear-squared and step, parabolic, luneburg, fisheye and eaton have)");
    if (*method != CPM_METHOD_EXACT && exact_only)
        return cpm_fail(context, CPM_ERROR_UNSUPPORTED,
                        "discrete layers (step) have no gradient to integrate; only method exact (or auto, exact not "
                        "excluded) traces them");
    if (cpm_method_needs_step(*method) && !(q->step > 0.0))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "step is 0; method %s takes fixed steps: give step > 0 in metres", cpm_method_text(*method));
    return CPM_OK;
}

/* ------------------------------------------------------------------------------------------------------- work */

static cpm_status fill_starts(trace_work *w) {
    const cpm_rays_request *q = w->request;
    double last_wavelength = NAN, scale = 1.0;
    for (size_t i = 0; i < q->count; i++) {
        cpm_ray_start *s = &w->starts[i];
        memcpy(s->r, q->origins + 3 * i, sizeof s->r);
        memcpy(s->d, q->directions + 3 * i, sizeof s->d);
        double size = sqrt(s->d[0] * s->d[0] + s->d[1] * s->d[1] + s->d[2] * s->d[2]);
        if (!(size > 1e-100 && size < 1e100)) { /* |d|^2 must neither vanish nor overflow, in float neither */
            size = fmax(fabs(s->d[0]), fmax(fabs(s->d[1]), fabs(s->d[2])));
            for (int k = 0; k < 3; k++) s->d[k] /= size;
            size = sqrt(s->d[0] * s->d[0] + s->d[1] * s->d[1] + s->d[2] * s->d[2]);
        }
        for (int k = 0; k < 3; k++) s->d[k] /= size;
        double wavelength = q->wavelengths[q->wavelength_stride ? i : 0];
        if (wavelength != last_wavelength) {
            cpm_status status = cpm_medium_scale(w->context, w->medium, wavelength, &scale);
            if (status != CPM_OK) {
                char why[512];
                strncpy(why, cpm_context_last_error(w->context), sizeof why - 1);
                why[sizeof why - 1] = '\0';
                return cpm_fail(w->context, status, "wavelengths[%zu]: %s", q->wavelength_stride ? i : 0, why);
            }
            last_wavelength = wavelength;
        }
        s->scale = scale;
        s->max_step = 0.0;
        s->length = q->lengths ? q->lengths[q->length_stride ? i : 0] : -1.0;
    }
    return CPM_OK;
}

/* All rays, in chunks; with `positions` the second time, for the samples of the paths. No ray depends on its chunk, so
 * chunks grow while they take little time and shrink where rays are long: cancelling waits for the chunks at work. */
static cpm_status run(const trace_work *w, cpm_ray_end *ends, double *positions, double from, double to) {
    cpm_context *context = w->context;
    if (context->opencl)
        return cpm_opencl_trace(context, w->medium, &w->control, &w->goal, w->request->single_precision, w->starts,
                                ends, positions, positions ? (int64_t)w->request->path_samples : 0,
                                (int64_t)w->request->count, from, to);
    const cpm_lane_code *code = cpm_lane_code_for(w->medium->data.kind, w->request->single_precision);
    const int64_t count = (int64_t)w->request->count;
    const int64_t fair = count / (8 * context->threads) / CPM_LANES * CPM_LANES; /* leaves each thread several */
    const int64_t most = fair < CPM_LANES ? CPM_LANES : fair < MAX_CHUNK ? fair : MAX_CHUNK;
    const cpm_trace_arrays arrays = {.starts = w->starts,
                                     .ends = ends,
                                     .positions = positions,
                                     .samples = positions ? (int64_t)w->request->path_samples : 0};
    int64_t next = 0;
    int finished = 0;
#pragma omp parallel num_threads(context->threads) if (count > CPM_LANES)
    {
        const int telling = omp_get_thread_num() == 0;
        int64_t chunk = most < FIRST_CHUNK ? most : FIRST_CHUNK, first;
        double reported = cpm_seconds();
        while (!cpm_poll(context)) {
#pragma omp atomic capture
            {
                first = next;
                next += chunk;
            }
            if (first >= count) break;
            const double start = cpm_seconds();
            code->trace(&w->control, &w->medium->data, w->medium->table, &w->goal, &arrays, first,
                        first + chunk < count ? first + chunk : count);
            const double now = cpm_seconds();
            if (now - start < SHORT_CHUNK && 2 * chunk <= most) chunk *= 2;
            if (now - start > LONG_CHUNK && chunk > CPM_LANES)
                chunk = (chunk / 2 + CPM_LANES - 1) / CPM_LANES * CPM_LANES;
            if (telling && now - reported > 0.1) {
                reported = now;
                cpm_progress(context, "trace", from + (to - from) * (double)first / (double)count);
            }
        }
#pragma omp atomic update
        finished++;
        if (telling) cpm_wait(context, &finished, omp_get_num_threads());
    }
    return cpm_cancelled(context) ? cpm_fail(context, CPM_ERROR_CANCELLED, "cancelled while tracing rays") : CPM_OK;
}

/* A ray that could not start: n^2 <= 0 there. */
static cpm_status check_started(const trace_work *w) {
    for (size_t i = 0; i < w->request->count; i++)
        if (w->ends[i].status == CPM_RAY_CUTOFF && w->ends[i].steps == 0.0 && w->ends[i].rejected == 0.0) {
            const double *r = w->starts[i].r;
            if (!(cpm_medium_n_toward(w->medium, w->starts[i].scale, r, w->starts[i].d) > 0.0))
                return cpm_fail(w->context, CPM_ERROR_INVALID_ARGUMENT,
                                "origins[%zu] is (%g, %g, %g), where n is not positive and finite (n^2 <= 0); a ray "
                                "must start where n > 0",
                                i, r[0], r[1], r[2]);
        }
    return CPM_OK;
}

/* ------------------------------------------------------------------------------------------------------ results */

static double distance(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* What rounding leaves of a position, metres. */
static double rounding_floor(const cpm_ray_start *s, const cpm_ray_end *e, int single) {
    double size = e->length;
    for (int k = 0; k < 3; k++) size += fmax(fabs(s->r[k]), fabs(e->r[k]));
    return (single ? 1.2e-7 : 2.3e-16) * size;
}

static void put3(double *out, size_t i, const double v[3]) {
    if (out) memcpy(out + 3 * i, v, 3 * sizeof *out);
}

static void write_results(const trace_work *w, const cpm_ray_end *second, int32_t method, const cpm_rays_result *out) {
    const int exact = method == CPM_METHOD_EXACT;
    const int watch = exact && !cpm_medium_is_uniform(w->medium) && !cpm_medium_needs_exact(w->medium);
    for (size_t i = 0; i < w->request->count; i++) {
        const cpm_ray_end *e = &w->ends[i];
        double size = sqrt(e->p[0] * e->p[0] + e->p[1] * e->p[1] + e->p[2] * e->p[2]), d[3], drift = e->drift;
        for (int k = 0; k < 3; k++) d[k] = size > 0.0 ? e->p[k] / size : w->starts[i].d[k];
        if (watch) { /* an exact path shows its rounding here; not counted, the path needed no evaluation */
            double n = cpm_medium_n(w->medium, w->starts[i].scale, e->r);
            drift = n > 0.0 ? fabs(size - n) / n : 0.0;
        }
        double error = second ? distance(e->r, second[i].r) : e->error;
        error = fmax(error, rounding_floor(&w->starts[i], e, w->request->single_precision && !exact));
        put3(out->position, i, e->r);
        put3(out->direction, i, d);
        put3(out->momentum, i, e->p);
        if (out->length) out->length[i] = e->length;
        if (out->optical_path) out->optical_path[i] = e->optical_path;
        if (out->drift) out->drift[i] = drift;
        if (out->error_estimate) out->error_estimate[i] = error;
        if (out->evaluations) out->evaluations[i] = (int64_t)e->evaluations;
        if (out->steps) out->steps[i] = (int64_t)e->steps;
        if (out->rejected) out->rejected[i] = (int64_t)e->rejected;
        if (out->error_evaluations) out->error_evaluations[i] = second ? (int64_t)second[i].evaluations : 0;
        if (out->status) out->status[i] = e->status;
        if (out->method) out->method[i] = method;
        if (out->shape) out->shape[i] = -1;
    }
}

static cpm_status trace_in_medium(trace_work *w, int32_t method, const cpm_rays_result *out) {
    const cpm_rays_request *q = w->request;
    cpm_ray_end *second = NULL;
    const int paths = q->path_samples > 0 && out->paths;
    const int again = q->error_mode == CPM_ERROR_GLOBAL && method != CPM_METHOD_EXACT;
    cpm_status status = fill_starts(w);
    if (status == CPM_OK) status = run(w, w->ends, NULL, 0.0, again || paths ? 0.4 : 1.0);
    if (status == CPM_OK) status = check_started(w);
    if (status == CPM_OK && again) {
        trace_work finer = *w;
        finer.control.rtol *= 0.1;
        finer.control.step *= 0.5;
        cpm_step_control_set(&finer.control);
        second = malloc(q->count * sizeof *second);
        /* Also half the steps: where one step of the loosest tolerance does, rtol/10 alone would repeat it. */
        for (size_t i = 0; i < q->count && q->step == 0.0; i++)
            w->starts[i].max_step = w->ends[i].steps > 0.0 ? 0.5 * w->ends[i].length / w->ends[i].steps : 0.0;
        status = second ? run(&finer, second, NULL, 0.4, paths ? 0.7 : 1.0)
                        : cpm_fail(w->context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for %zu rays", q->count);
    }
    if (status == CPM_OK && paths) {
        for (size_t i = 0; i < q->count; i++) w->starts[i].max_step = 0.0;
        status = run(w, w->ends, out->paths, 0.7, 1.0);
    }
    if (status == CPM_OK) write_results(w, second, method, out);
    free(second);
    return status;
}

cpm_status cpm_rays_trace(cpm_context *context, const cpm_medium *medium, struct cpm_scene *scene,
                          const cpm_rays_request *request, cpm_rays_result *result) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!request || !result)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL", request ? "result" : "request");
    if ((medium != NULL) == (scene != NULL))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "%s medium and scene are given; rays are traced in exactly one", medium ? "both" : "neither");
    cpm_rays_request q;
    cpm_rays_result out;
    CPM_TAKE(q, request);
    CPM_TAKE(out, result);
    cpm_status status = check_steering(context, &q);
    if (status == CPM_OK) status = check_arrays(context, &q);
    if (status != CPM_OK) return status;
    if (scene) return cpm_scene_rays_trace(context, scene, &q, &out);

    trace_work w = {.context = context, .medium = medium, .request = &q};
    int32_t method = CPM_METHOD_AUTO;
    status = check_end(context, &q, &w.goal);
    if (status == CPM_OK) status = choose_method(context, medium, &q, &method);
    if (status != CPM_OK || q.count == 0) return status;
    w.control = (cpm_step_control){.method = method,
                                   .atol = q.atol,
                                   .step = q.step,
                                   .rtol = cpm_method_rtol(method, q.rtol),
                                   .dense = q.path_samples > 0 && out.paths,
                                   .max_step = q.max_step > 0.0 ? fmin(q.max_step, CPM_INFINITE) : CPM_INFINITE,
                                   .max_evaluations = q.max_evaluations > 0 ? (double)q.max_evaluations : 1e6};
    cpm_step_control_set(&w.control);
    w.goal.max_evaluations = w.control.max_evaluations;
    w.starts = malloc(q.count * sizeof *w.starts);
    w.ends = malloc(q.count * sizeof *w.ends);
    if (w.starts && w.ends) {
        cpm_progress_begin(context);
        cpm_progress(context, "trace", 0.0);
        status = trace_in_medium(&w, method, &out);
    } else
        status = cpm_fail(context, CPM_ERROR_OUT_OF_MEMORY, "out of memory for %zu rays", q.count);
    free(w.starts);
    free(w.ends);
    return status;
}
