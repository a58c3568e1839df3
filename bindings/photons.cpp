/* bindings/photons.cpp: the photon pass, its two maps, its books. */
#include "bindings.h"

py::dict stats_dict(const cpm_stats &stats) {
    py::dict values;
#define CPM_FIELD(name) values[#name] = stats.name
    CPM_FIELD(seconds_prepare);
    CPM_FIELD(seconds_project);
    CPM_FIELD(seconds_trace);
    CPM_FIELD(seconds_map);
    CPM_FIELD(seconds_gather);
    CPM_FIELD(seconds_total);
    CPM_FIELD(photons_emitted);
    CPM_FIELD(photons_stored_direct);
    CPM_FIELD(photons_stored_later);
    CPM_FIELD(photons_stored_caustic);
    CPM_FIELD(photon_segments);
    CPM_FIELD(photon_evaluations);
    CPM_FIELD(photons_lost);
    CPM_FIELD(eye_rays);
    CPM_FIELD(eye_segments);
    CPM_FIELD(eye_evaluations);
    CPM_FIELD(gathers);
    CPM_FIELD(bytes_diffuse);
    CPM_FIELD(bytes_caustic);
    CPM_FIELD(projection_cells);
    CPM_FIELD(projection_active);
    CPM_FIELD(projection_caustic_cells);
    CPM_FIELD(projection_caustic_active);
    CPM_FIELD(features);
#undef CPM_FIELD
    return values;
}

namespace {

cpm_map map_of(const std::string &name) {
    if (name == "diffuse") return CPM_MAP_DIFFUSE;
    if (name == "caustic") return CPM_MAP_CAUSTIC;
    throw py::value_error("map is '" + name + "'; diffuse and caustic are allowed");
}

std::shared_ptr<Photons> trace_photons(const std::shared_ptr<Scene> &scene, uint64_t count, uint64_t seed,
                                       const Doubles &wavelengths, bool projection, double bundle_tolerance,
                                       int32_t batch, int32_t threads, int32_t device,
                                       py::object progress) {
    cpm_photons_options options{};
    options.struct_size = sizeof options;
    options.photons = count;
    options.seed = seed;
    options.wavelengths = wavelengths.data();
    options.wavelength_count = static_cast<size_t>(wavelengths.size());
    options.no_projection = projection ? 0 : 1;
    options.batch = batch;
    options.bundle_tolerance = bundle_tolerance;

    auto photons = std::make_shared<Photons>();
    photons->scene = scene;
    const Context context(threads, device);
    run_long(context, std::move(progress),
             [&] { return cpm_photons_trace(context.get(), scene->handle.get(), &options, photons->handle.out()); });
    return photons;
}

/* One column of a map, as a new array: a map is millions of photons, and most callers want one or two columns. */
py::array read_column(const Photons &photons, const std::string &map_name, const std::string &column) {
    const cpm_map map = map_of(map_name);
    const auto count = static_cast<py::ssize_t>(cpm_photons_count(photons.handle.get(), map));
    const auto bins = static_cast<py::ssize_t>(cpm_photons_bins(photons.handle.get()));
    cpm_photons_arrays arrays{};
    arrays.struct_size = sizeof arrays;
    py::array values;
    auto floats = [&](py::ssize_t width, float *&target) {
        py::array_t<float> array({count, width});
        target = array.mutable_data();
        values = array;
    };
    if (column == "position")
        floats(3, arrays.position);
    else if (column == "direction")
        floats(3, arrays.direction);
    else if (column == "power")
        floats(bins, arrays.power);
    else if (column == "wavelength") {
        py::array_t<double> array({count, bins});
        arrays.wavelength = array.mutable_data();
        values = array;
    } else if (column == "bounce") {
        py::array_t<int32_t> array(count);
        arrays.bounce = array.mutable_data();
        values = array;
    } else
        throw py::value_error("a photon has no '" + column + "'");
    const cpm_status status = cpm_photons_read(photons.handle.get(), map, &arrays);
    if (status != CPM_OK) raise_status(status, nullptr);
    return values;
}

py::array_t<double> irradiance(const Photons &photons, const std::string &map_name, const Doubles &points,
                               const Doubles &normals, int32_t nearest, double max_radius, int32_t threads,
                               int32_t device, py::object progress) {
    const auto count = points.shape(0);
    const auto bins = static_cast<py::ssize_t>(cpm_photons_bins(photons.handle.get()));
    const cpm_map map = map_of(map_name);
    py::array_t<double> values({count, bins});
    double *target = values.mutable_data();
    const Context context(threads, device);
    run_long(context, std::move(progress), [&] {
        return cpm_photons_irradiance(context.get(), photons.handle.get(), map, points.data(), normals.data(),
                                      static_cast<size_t>(count), nearest, max_radius, target);
    });
    return values;
}

py::dict energy(const Photons &photons) {
    const auto bins = static_cast<py::ssize_t>(cpm_photons_bins(photons.handle.get()));
    py::dict values;
    auto row = [&](const char *name) {
        py::array_t<double> array(bins);
        values[name] = array;
        return array.mutable_data();
    };
    double *emitted = row("emitted"), *gain = row("roulette_gain"), *absorbed = row("absorbed"),
           *escaped = row("escaped"), *loss = row("roulette_loss"), *variance = row("roulette_variance");
    cpm_status status = cpm_photons_energy(photons.handle.get(), emitted, gain, absorbed, escaped, loss);
    if (status == CPM_OK) status = cpm_photons_roulette_variance(photons.handle.get(), variance);
    if (status != CPM_OK) raise_status(status, nullptr);
    return values;
}

py::dict stats(const Photons &photons) {
    cpm_stats values{};
    values.struct_size = sizeof values;
    const cpm_status status = cpm_photons_stats(photons.handle.get(), &values);
    if (status != CPM_OK) raise_status(status, nullptr);
    return stats_dict(values);
}

} // namespace

void bind_photons(py::module_ &module) {
    using py::arg;
    module.attr("MAX_BINS") = CPM_MAX_BINS;
    py::class_<Photons, std::shared_ptr<Photons>>(module, "Photons")
        .def(
            "count",
            [](const Photons &photons, const std::string &map) {
                return cpm_photons_count(photons.handle.get(), map_of(map));
            },
            arg("map"))
        .def("read", &read_column, arg("map"), arg("column"))
        .def("irradiance", &irradiance, py::kw_only(), arg("map"), arg("points"), arg("normals"), arg("nearest"),
             arg("max_radius"), arg("threads"), arg("device"), arg("progress").none(true))
        .def("energy", &energy)
        .def("stats", &stats);
    module.def("trace_photons", &trace_photons, py::kw_only(), arg("scene"), arg("photons"), arg("seed"),
               arg("wavelengths"), arg("projection"), arg("bundle_tolerance"), arg("batch"), arg("threads"),
               arg("device"), arg("progress").none(true));
}
