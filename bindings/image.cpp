/* bindings/image.cpp: rendering, the spectral film, spectral OpenEXR. */
#include "bindings.h"

namespace {

struct Image {
    Handle<cpm_image> handle{cpm_image_release};
    std::optional<cpm_device_stats> built; /* what programs cost, where a device rendered */

    std::array<py::ssize_t, 3> shape() const {
        int32_t width = 0, height = 0;
        size_t bins = 0;
        const cpm_status status = cpm_image_size(handle.get(), &width, &height, &bins);
        if (status != CPM_OK) raise_status(status, nullptr);
        return {height, width, static_cast<py::ssize_t>(bins)};
    }
};

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/* Photons traced before, or a count of them to trace. */
std::shared_ptr<Image> render(const std::shared_ptr<Scene> &scene, const std::shared_ptr<Photons> &photon_map,
                              int32_t width, int32_t height, uint64_t photons, uint64_t seed,
                              const Doubles &wavelengths, int32_t nearest, int32_t samples, double max_radius,
                              bool projection, bool edge_correction, double bundle_tolerance, int32_t batch,
                              int32_t threads, int32_t device, py::object progress) {
    cpm_render_options options{};
    options.struct_size = sizeof options;
    options.width = width;
    options.height = height;
    options.photons = photons;
    options.seed = seed;
    options.wavelengths = wavelengths.data();
    options.wavelength_count = static_cast<size_t>(wavelengths.size());
    options.nearest = nearest;
    options.samples = samples;
    options.no_projection = projection ? 0 : 1;
    options.batch = batch;
    options.no_edge_correction = edge_correction ? 0 : 1;
    options.max_radius = max_radius;
    options.bundle_tolerance = bundle_tolerance;

    auto image = std::make_shared<Image>();
    const Context context(threads, device);
    run_long(context, std::move(progress), [&] {
        if (photon_map)
            return cpm_image_gather(context.get(), scene->handle.get(), photon_map->handle.get(), &options,
                                    image->handle.out());
        return cpm_image_render(context.get(), scene->handle.get(), &options, image->handle.out());
    });
    if (device >= 0) {
        cpm_device_stats built{};
        built.struct_size = sizeof built;
        context.check(cpm_context_device_stats(context.get(), &built));
        image->built = built;
    }
    return image;
}

std::shared_ptr<Image> image_of(const Floats &values, const Doubles &wavelengths) {
    const Context context;
    auto image = std::make_shared<Image>();
    context.check(cpm_image_create(context.get(), static_cast<int32_t>(values.shape(1)),
                                   static_cast<int32_t>(values.shape(0)), wavelengths.data(),
                                   static_cast<size_t>(wavelengths.size()), values.data(), image->handle.out()));
    return image;
}

/* The film itself, not a copy: the array keeps the image alive, and is read-only. */
py::array data(const std::shared_ptr<Image> &image) {
    py::array_t<float> view(image->shape(), cpm_image_data(image->handle.get()), py::cast(image));
    view.attr("flags").attr("writeable") = false;
    return std::move(view);
}

py::array_t<double> wavelengths_of(const Image &image) {
    return py::array_t<double>(image.shape()[2], cpm_image_wavelengths(image.handle.get()));
}

py::dict stats(const Image &image) {
    cpm_stats values{};
    values.struct_size = sizeof values;
    const cpm_status status = cpm_image_stats(image.handle.get(), &values);
    if (status != CPM_OK) raise_status(status, nullptr);
    py::dict all = stats_dict(values);
    if (image.built) {
        all["device_programs_compiled"] = image.built->compiled;
        all["device_programs_cached"] = image.built->cached;
        all["device_seconds_build"] = image.built->seconds;
        all["device_source_bytes"] = image.built->source_bytes;
    }
    return all;
}

void write_exr(const Image &image, const std::string &path, const std::optional<Floats> &rgb) {
    const Context context;
    run_long(context, py::none(), [&] {
        return cpm_image_write_exr(context.get(), image.handle.get(), path.c_str(), rgb ? rgb->data() : nullptr);
    });
}

} // namespace

void bind_image(py::module_ &module) {
    using py::arg;
    py::class_<Image, std::shared_ptr<Image>>(module, "Image")
        .def(py::init(&image_of), arg("values"), arg("wavelengths"))
        .def_property_readonly("data", &data)
        .def_property_readonly("wavelengths", &wavelengths_of)
        .def("stats", &stats)
        .def("write_exr", &write_exr, arg("path"), arg("rgb").none(true));
    module.def("render", &render, py::kw_only(), arg("scene"), arg("photon_map").none(true), arg("width"),
               arg("height"), arg("photons"), arg("seed"), arg("wavelengths"), arg("nearest"), arg("samples"),
               arg("max_radius"), arg("projection"), arg("edge_correction"), arg("bundle_tolerance"), arg("batch"),
               arg("threads"), arg("device"), arg("progress").none(true));
}
