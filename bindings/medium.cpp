/* bindings/medium.cpp: refractive index fields and dispersion models. */
#include "bindings.h"

#include <cstring>

namespace {

cpm_dispersion make_dispersion(const std::string &kind, const std::vector<double> &coefficients, double low,
                               double high) {
    cpm_dispersion dispersion{};
    dispersion.struct_size = sizeof dispersion;
    if (kind == "constant") dispersion.kind = CPM_DISPERSION_CONSTANT;
    else if (kind == "cauchy") dispersion.kind = CPM_DISPERSION_CAUCHY;
    else if (kind == "sellmeier") dispersion.kind = CPM_DISPERSION_SELLMEIER;
    else if (kind == "tabulated") dispersion.kind = CPM_DISPERSION_TABULATED;
    else if (kind == "gas") dispersion.kind = CPM_DISPERSION_GAS;
    else throw py::value_error("dispersion kind is '" + kind + "'");
    if (coefficients.size() > CPM_DISPERSION_MAX_COEFFICIENTS)
        throw py::value_error("a dispersion has " + std::to_string(coefficients.size()) + " numbers; at most " +
                              std::to_string(CPM_DISPERSION_MAX_COEFFICIENTS) + " are allowed");
    dispersion.count = static_cast<int32_t>(coefficients.size());
    std::copy(coefficients.begin(), coefficients.end(), dispersion.coefficients);
    dispersion.low = low;
    dispersion.high = high;
    return dispersion;
}

/* Makes a medium by one of the creators, whose last argument is the handle. */
template <class Create>
std::shared_ptr<Medium> make_medium(Create &&create) {
    Context context;
    auto medium = std::make_shared<Medium>();
    context.check(create(context.get(), medium->handle.out()));
    return medium;
}

std::shared_ptr<Medium> make_layered(const Doubles &heights, const Doubles &n, const Point &up, const Point &origin,
                                     double radius, int32_t interpolation, const cpm_dispersion *dispersion,
                                     const std::vector<size_t> &kinks) {
    cpm_layered_desc desc{};
    desc.struct_size = sizeof desc;
    desc.heights = heights.data();
    desc.n = n.data();
    desc.count = static_cast<size_t>(n.size());
    std::copy(up.begin(), up.end(), desc.up);
    std::copy(origin.begin(), origin.end(), desc.origin);
    desc.interpolation = interpolation;
    desc.radius = radius;
    desc.kinks = kinks.data();
    desc.kink_count = kinks.size();
    return make_medium([&](cpm_context *context, cpm_medium **medium) {
        return cpm_medium_create_layered(context, &desc, dispersion, medium);
    });
}

/* The samples are read where they are, whatever their strides. */
std::shared_ptr<Medium> make_grid(const py::array_t<double, py::array::forcecast> &values, const Point &origin,
                                  const Point &spacing, int32_t interpolation, const cpm_dispersion *dispersion) {
    cpm_grid_desc desc{};
    desc.struct_size = sizeof desc;
    desc.values = values.data();
    for (int axis = 0; axis < 3; axis++) {
        desc.size[axis] = static_cast<size_t>(values.shape(axis));
        desc.stride[axis] = values.strides(axis);
    }
    std::copy(origin.begin(), origin.end(), desc.origin);
    std::copy(spacing.begin(), spacing.end(), desc.spacing);
    desc.interpolation = interpolation;
    return make_medium([&](cpm_context *context, cpm_medium **medium) {
        return cpm_medium_create_grid(context, &desc, dispersion, medium);
    });
}

/* codes (count, 5): operation, target, a, b, c; constants (count, 2): k, l. */
std::shared_ptr<Medium> make_expression(const py::array_t<int32_t, py::array::c_style | py::array::forcecast> &codes,
                                        const Doubles &constants, const std::array<int32_t, 4> &results, double feature,
                                        const cpm_dispersion *dispersion) {
    if (codes.ndim() != 2 || codes.shape(1) != 5 || constants.ndim() != 2 || constants.shape(1) != 2 ||
        constants.shape(0) != codes.shape(0))
        throw py::value_error("a program is (count, 5) codes and (count, 2) constants");
    std::vector<cpm_instruction> instructions(static_cast<size_t>(codes.shape(0)));
    for (py::ssize_t i = 0; i < codes.shape(0); i++) {
        cpm_instruction &instruction = instructions[static_cast<size_t>(i)];
        instruction = {codes.at(i, 0), codes.at(i, 1), codes.at(i, 2),     codes.at(i, 3),
                       codes.at(i, 4), 0,              constants.at(i, 0), constants.at(i, 1)};
    }
    cpm_expression_desc desc{};
    desc.struct_size = sizeof desc;
    desc.instructions = instructions.data();
    desc.count = instructions.size();
    std::copy(results.begin(), results.end(), desc.results);
    desc.feature = feature;
    return make_medium([&](cpm_context *context, cpm_medium **medium) {
        return cpm_medium_create_expression(context, &desc, dispersion, medium);
    });
}

std::shared_ptr<Medium> make_sum(const std::vector<std::shared_ptr<Medium>> &terms) {
    std::vector<cpm_medium *> handles;
    for (const auto &term : terms) handles.push_back(term->handle.get());
    return make_medium([&](cpm_context *context, cpm_medium **medium) {
        return cpm_medium_create_sum(context, handles.data(), handles.size(), medium);
    });
}

/* Rows of one length, checked by the package. */
std::shared_ptr<Medium> make_sources(const Doubles &centers, const Doubles &directions, const Doubles &strengths,
                                     const Doubles &exponents, const cpm_dispersion *dispersion) {
    cpm_sources_desc desc{};
    desc.struct_size = sizeof desc;
    desc.count = static_cast<size_t>(strengths.size());
    desc.centers = centers.data();
    desc.directions = directions.data();
    desc.strengths = strengths.data();
    desc.exponents = exponents.data();
    return make_medium([&](cpm_context *context, cpm_medium **medium) {
        return cpm_medium_create_sources(context, &desc, dispersion, medium);
    });
}

py::tuple evaluate(const Medium &medium, const Doubles &points, double wavelength) {
    Context context;
    const auto count = points.shape(0);
    py::array_t<double> n(count);
    py::array_t<double> gradient({count, py::ssize_t{3}});
    context.check(cpm_medium_evaluate(context.get(), medium.handle.get(), points.data(), static_cast<size_t>(count),
                                      wavelength, n.mutable_data(), gradient.mutable_data()));
    return py::make_tuple(n, gradient);
}

/* n of a dispersion alone: the index of a medium that is nothing else. */
py::array_t<double> dispersion_n(const cpm_dispersion &dispersion, const Doubles &wavelengths) {
    const auto medium = make_medium([&](cpm_context *context, cpm_medium **out) {
        return cpm_medium_create_dispersive(context, &dispersion, out);
    });
    Context context;
    const double point[3] = {0.0, 0.0, 0.0};
    py::array_t<double> n(wavelengths.size());
    for (py::ssize_t i = 0; i < wavelengths.size(); i++)
        context.check(cpm_medium_evaluate(context.get(), medium->handle.get(), point, 1, wavelengths.data()[i],
                                          n.mutable_data(i), nullptr));
    return n;
}

} // namespace

void bind_medium(py::module_ &module) {
    using py::arg;
    py::class_<cpm_dispersion>(module, "Dispersion")
        .def(py::init(&make_dispersion), arg("kind"), arg("coefficients"), arg("low"), arg("high"))
        .def("n", &dispersion_n, arg("wavelengths"));

    py::class_<Medium, std::shared_ptr<Medium>>(module, "Medium")
        .def("evaluate", &evaluate, arg("points"), arg("wavelength"))
        .def(
            "set_extinction",
            [](Medium &medium, const Doubles &wavelengths, const Doubles &values) {
                if (wavelengths.size() != values.size()) throw py::value_error("as many values as wavelengths");
                Context context;
                context.check(cpm_medium_set_extinction(context.get(), medium.handle.get(), wavelengths.data(),
                                                        values.data(), static_cast<size_t>(values.size())));
            },
            arg("wavelengths"), arg("values"));

    module.attr("INTERPOLATION") =
        py::dict(arg("linear") = int{CPM_INTERPOLATION_LINEAR}, arg("cubic") = int{CPM_INTERPOLATION_CUBIC},
                 arg("step") = int{CPM_INTERPOLATION_STEP});
    module.attr("INTERPOLATION")["linear-squared"] = int{CPM_INTERPOLATION_LINEAR_SQUARED};

    module.def(
        "homogeneous",
        [](double n, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_homogeneous(context, n, dispersion, medium);
            });
        },
        arg("n"), arg("dispersion").none(true));
    module.def(
        "dispersive",
        [](const cpm_dispersion &dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_dispersive(context, &dispersion, medium);
            });
        },
        arg("dispersion"));
    module.def(
        "linear_squared",
        [](double n_squared, const Point &gradient, const Point &origin, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_linear_squared(context, n_squared, gradient.data(), origin.data(), dispersion,
                                                        medium);
            });
        },
        arg("n_squared"), arg("gradient"), arg("origin"), arg("dispersion").none(true));
    module.def(
        "linear",
        [](double n, const Point &gradient, const Point &origin, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_linear(context, n, gradient.data(), origin.data(), dispersion, medium);
            });
        },
        arg("n"), arg("gradient"), arg("origin"), arg("dispersion").none(true));
    module.def(
        "parabolic",
        [](double n, double alpha, const Point &axis, const Point &origin, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_parabolic(context, n, alpha, axis.data(), origin.data(), dispersion, medium);
            });
        },
        arg("n"), arg("alpha"), arg("axis"), arg("origin"), arg("dispersion").none(true));
    module.def(
        "luneburg",
        [](double radius, const Point &center, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_luneburg(context, radius, center.data(), dispersion, medium);
            });
        },
        arg("radius"), arg("center"), arg("dispersion").none(true));
    module.def(
        "fisheye",
        [](double n, double radius, const Point &center, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_fisheye(context, n, radius, center.data(), dispersion, medium);
            });
        },
        arg("n"), arg("radius"), arg("center"), arg("dispersion").none(true));
    module.def(
        "eaton",
        [](double radius, const Point &center, const cpm_dispersion *dispersion) {
            return make_medium([&](cpm_context *context, cpm_medium **medium) {
                return cpm_medium_create_eaton(context, radius, center.data(), dispersion, medium);
            });
        },
        arg("radius"), arg("center"), arg("dispersion").none(true));
    module.def("sources", &make_sources, arg("centers"), arg("directions"), arg("strengths"), arg("exponents"),
               arg("dispersion").none(true));
    module.def("layered", &make_layered, arg("heights"), arg("n"), arg("up"), arg("origin"), arg("radius"),
               arg("interpolation"), arg("dispersion").none(true), arg("kinks") = std::vector<size_t>{});
    module.def("expression", &make_expression, arg("codes"), arg("constants"), arg("results"), arg("feature"),
               arg("dispersion").none(true));
    module.def("sum", &make_sum, arg("terms"));
    module.def("grid", &make_grid, arg("values"), arg("origin"), arg("spacing"), arg("interpolation"),
               arg("dispersion").none(true));
}
