/* backend/opencl/eye_buffers.c: see eye_buffers.h. */
#include "eye_buffers.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "program.h"

#define MOST_BRANCHES 65536 /* more would only leave the caches */
#define ITEMS_A_UNIT 32

static unsigned kinds_of(const cpm_pass *pass) {
    unsigned kinds = 0;
    for (size_t m = 0; m < pass->scene->medium_count; m++)
        kinds |= (unsigned)cpm_medium_kinds(pass->scene->media[m].medium);
    return kinds;
}

static cpm_status kernel_of(cpm_context *context, const char *name, const char *function, const char *more,
                            cl_kernel *kernel) {
    char options[256];
    cpm_opencl_options(context->opencl, 1, more, options, sizeof options);
    return cpm_program_kernel(context, name, function, options, kernel);
}

cpm_status cpm_eye_kernels_of(const cpm_pass *pass, cpm_eye_kernels *k) {
    cpm_context *context = pass->context;
    char media[64];
    memset(k, 0, sizeof *k);
    snprintf(media, sizeof media, "-DCPM_MEDIA=%u", kinds_of(pass));
    cpm_status status = kernel_of(context, "eye", "cpm_eye_start", "", &k->start);
    if (!status) status = kernel_of(context, "eye", "cpm_eye_see", "", &k->see);
    if (!status) status = kernel_of(context, "eye", "cpm_eye_film", "", &k->film);
    if (!status) status = kernel_of(context, "eye_gather", "cpm_eye_gather", "", &k->gather);
    if (!status && (pass->features & CPM_FEATURE_SPECULAR))
        status = kernel_of(context, "eye_branch", "cpm_eye_branch", media, &k->branch);
    return status;
}

/* Bytes of a branch, those of its pixel and its gather with it; *largest: in one buffer. */
static uint64_t branch_bytes(size_t bins, uint64_t *largest) {
    *largest = sizeof(cpm_arrival) > 8 * bins ? sizeof(cpm_arrival) : 8 * bins;
    return 2 * (sizeof(cpm_flight) + 4 * bins) + sizeof(cpm_arrival) + 1 + 3 * 4 + 8 + 8 * bins + 8 + 8 * bins;
}

cpm_status cpm_eye_device_open(const cpm_pass *pass, const cpm_gather *gather, const cpm_eye *eye, uint64_t allowed,
                               cpm_eye_device *d) {
    cpm_context *context = pass->context;
    const cpm_opencl *o = context->opencl;
    const cpm_scene *scene = pass->scene;
    const size_t bins = pass->bins, least = eye->is.splits ? bins : 1;
    const cpm_vec origin = gather->photons->origin;
    const double from[3] = {origin.x, origin.y, origin.z};
    uint64_t largest, each = branch_bytes(bins, &largest), fit = allowed / each;
    memset(d, 0, sizeof *d);
    if (fit > o->largest / largest) fit = o->largest / largest;
    if (fit > MOST_BRANCHES) fit = MOST_BRANCHES;
    if (fit < least)
        return cpm_fail(
            context, CPM_ERROR_OUT_OF_MEMORY,
            "an eye ray takes %.3f MB of OpenCL device '%s', of which %.3f MB are left; allow more memory, ask "
            "for fewer wavelengths, or use the native backend",
            1e-6 * (double)(least * each), o->name, 1e-6 * (double)allowed);
    const size_t n = (size_t)fit, lights = scene->light_count + 1, materials = scene->material_count + 1;
    d->capacity = (cl_int)n, d->bins = (cl_int)bins;
    d->items = (size_t)o->units * ITEMS_A_UNIT;
    const struct {
        cl_mem *to;
        const void *from;
        size_t size;
    } all[] = {{&d->tables[0], &eye->is, sizeof eye->is},
               {&d->tables[1], eye->shape_light, (scene->shape_count + 1) * sizeof *eye->shape_light},
               {&d->tables[2], eye->reflectance, materials * bins * sizeof *eye->reflectance},
               {&d->tables[3], eye->reflectance_max, materials * sizeof *eye->reflectance_max},
               {&d->tables[4], eye->emission, lights * bins * sizeof *eye->emission},
               {&d->tables[5], eye->squared_index, bins * sizeof *eye->squared_index},
               {&d->map_origin, from, sizeof from},
               {&d->flights[0], NULL, n * sizeof(cpm_flight)},
               {&d->flights[1], NULL, n * sizeof(cpm_flight)},
               {&d->weights[0], NULL, n * bins * sizeof(float)},
               {&d->weights[1], NULL, n * bins * sizeof(float)},
               {&d->arrivals, NULL, n * sizeof(cpm_arrival)},
               {&d->seen, NULL, n},
               {&d->evaluations, NULL, n * sizeof(double)},
               {&d->counts, NULL, n * sizeof(cl_int)},
               {&d->children, NULL, n * sizeof(cl_int)},
               {&d->pixels, NULL, n * sizeof(cl_int)},
               {&d->first_branch, NULL, (n + 1) * sizeof(cl_int)},
               {&d->sums, NULL, n * bins * sizeof(double)},
               {&d->list, NULL, n * sizeof(cl_int)},
               {&d->gathered, NULL, n * sizeof(cl_int)},
               {&d->irradiance, NULL, n * bins * sizeof(double)},
               {&d->whole, NULL, n * sizeof(double)}};
    cl_int code = CL_SUCCESS;
    for (size_t i = 0; i < sizeof all / sizeof *all && code == CL_SUCCESS; i++)
        *all[i].to =
            cpm_opencl_buffer(o, all[i].from ? CL_MEM_READ_ONLY : CL_MEM_READ_WRITE, all[i].size, all[i].from, &code);
    if (code == CL_SUCCESS) return CPM_OK;
    cpm_eye_device_close(o, d);
    return cpm_opencl_failed(context, o, "making the eye pass's buffers", code);
}

void cpm_eye_device_close(const cpm_opencl *o, cpm_eye_device *d) {
    const cl_mem all[] = {d->flights[0],  d->flights[1], d->weights[0], d->weights[1], d->arrivals,     d->seen,
                          d->evaluations, d->counts,     d->children,   d->pixels,     d->first_branch, d->sums,
                          d->list,        d->gathered,   d->irradiance, d->whole,      d->map_origin};
    for (int i = 0; i < CPM_EYE_TABLES; i++)
        if (d->tables[i]) o->cl->ReleaseMemObject(d->tables[i]);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i]) o->cl->ReleaseMemObject(all[i]);
    memset(d, 0, sizeof *d);
}

int cpm_eye_host_open(const cpm_eye_device *d, int host_gathers, cpm_eye_host *h) {
    const size_t n = (size_t)d->capacity, bins = (size_t)d->bins;
    memset(h, 0, sizeof *h);
    h->seen = malloc(n);
    h->children = malloc(n * sizeof *h->children);
    h->list = malloc(n * sizeof *h->list), h->gathered = malloc(n * sizeof *h->gathered);
    h->first_branch = malloc((n + 1) * sizeof *h->first_branch);
    h->counts = malloc(n * sizeof *h->counts), h->pixels = malloc(n * sizeof *h->pixels);
    h->owner[0] = malloc(n * sizeof **h->owner), h->owner[1] = malloc(n * sizeof **h->owner);
    h->evaluations = malloc(n * sizeof *h->evaluations);
    h->sums = malloc(n * bins * sizeof *h->sums);
    h->irradiance = host_gathers ? malloc(n * bins * sizeof *h->irradiance) : NULL;
    h->arrivals = host_gathers ? malloc(n * sizeof *h->arrivals) : NULL;
    return h->seen && h->children && h->list && h->gathered && h->first_branch && h->counts && h->pixels &&
           h->owner[0] && h->owner[1] && h->evaluations && h->sums && (!host_gathers || (h->irradiance && h->arrivals));
}

void cpm_eye_host_close(cpm_eye_host *h) {
    free(h->seen), free(h->children), free(h->list), free(h->gathered), free(h->first_branch), free(h->counts);
    free(h->pixels), free(h->owner[0]), free(h->owner[1]), free(h->evaluations), free(h->sums), free(h->irradiance);
    free(h->arrivals);
}
#endif
