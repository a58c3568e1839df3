/* bindings/rays.cpp: cpm_rays_trace on arrays. */
#include "bindings.h"

namespace {

struct Results {
    py::dict arrays;

    /* A new array under `name`, for the ABI to fill. */
    template <class T> T *add(const char *name, std::vector<py::ssize_t> shape) {
        py::array_t<T> array(shape);
        arrays[name] = array;
        return array.mutable_data();
    }
};

/* One value for all rays, or one for each. */
ptrdiff_t stride_of(const Doubles &values) { return values.size() == 1 ? 0 : 1; }

py::dict trace(const Medium *medium, const Scene *scene, const Doubles &origins, const Doubles &directions,
               const Doubles &wavelengths, const std::optional<Doubles> &lengths,
               const std::optional<Point> &plane_point, const std::optional<Point> &plane_normal, int32_t method,
               uint32_t exclude, double rtol, double atol, double step, double max_step, int64_t max_evaluations,
               int32_t error_mode, bool single_precision, size_t path_samples, int32_t threads, int32_t device,
               py::object progress) {
    const py::ssize_t count = origins.shape(0);

    cpm_rays_request request{};
    request.struct_size = sizeof request;
    request.count = static_cast<size_t>(count);
    request.origins = origins.data();
    request.directions = directions.data();
    request.wavelengths = wavelengths.data();
    request.wavelength_stride = stride_of(wavelengths);
    if (lengths) {
        request.lengths = lengths->data();
        request.length_stride = stride_of(*lengths);
    }
    if (plane_point) request.plane_point = plane_point->data();
    if (plane_normal) request.plane_normal = plane_normal->data();
    request.method = method;
    request.exclude = exclude;
    request.rtol = rtol;
    request.atol = atol;
    request.step = step;
    request.max_step = max_step;
    request.max_evaluations = max_evaluations;
    request.error_mode = error_mode;
    request.single_precision = single_precision ? 1 : 0;
    request.path_samples = path_samples;

    Results results;
    cpm_rays_result result{};
    result.struct_size = sizeof result;
    result.position = results.add<double>("position", {count, 3});
    result.direction = results.add<double>("direction", {count, 3});
    result.momentum = results.add<double>("momentum", {count, 3});
    result.length = results.add<double>("length", {count});
    result.optical_path = results.add<double>("optical_path", {count});
    result.drift = results.add<double>("drift", {count});
    result.error_estimate = results.add<double>("error_estimate", {count});
    result.evaluations = results.add<int64_t>("evaluations", {count});
    result.steps = results.add<int64_t>("steps", {count});
    result.rejected = results.add<int64_t>("rejected", {count});
    result.error_evaluations = results.add<int64_t>("error_evaluations", {count});
    result.status = results.add<int32_t>("status", {count});
    result.method = results.add<int32_t>("method", {count});
    result.shape = results.add<int32_t>("shape", {count});
    if (path_samples) result.paths = results.add<double>("paths", {count, static_cast<py::ssize_t>(path_samples), 3});

    const Context context(threads, device);
    run_long(context, std::move(progress), [&] {
        return cpm_rays_trace(context.get(), medium ? medium->handle.get() : nullptr,
                              scene ? scene->handle.get() : nullptr, &request, &result);
    });
    return results.arrays;
}

} // namespace

void bind_rays(py::module_ &module) {
    using py::arg;
    module.attr("METHODS") = py::dict(arg("auto") = int{CPM_METHOD_AUTO}, arg("exact") = int{CPM_METHOD_EXACT},
                                      arg("euler") = int{CPM_METHOD_EULER}, arg("rk4") = int{CPM_METHOD_RK4},
                                      arg("dopri5") = int{CPM_METHOD_DOPRI5});
    module.attr("ERROR_MODES") = py::dict(arg("local") = int{CPM_ERROR_LOCAL}, arg("global") = int{CPM_ERROR_GLOBAL});
    module.def("trace", &trace, py::kw_only(), arg("medium").none(true), arg("scene").none(true), arg("origins"),
               arg("directions"), arg("wavelengths"), arg("lengths").none(true), arg("plane_point").none(true),
               arg("plane_normal").none(true), arg("method"), arg("exclude"), arg("rtol"), arg("atol"), arg("step"),
               arg("max_step"), arg("max_evaluations"), arg("error_mode"), arg("single_precision"), arg("path_samples"),
               arg("threads"), arg("device"), arg("progress").none(true));
}
