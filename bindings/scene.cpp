/* bindings/scene.cpp: spectra, materials, shapes, bounded media, lights, the camera. */
#include "bindings.h"

cpm_spectrum Spectrum::view() const {
    cpm_spectrum spectrum{};
    spectrum.wavelengths = wavelengths.empty() ? nullptr : wavelengths.data();
    spectrum.values = values.empty() ? nullptr : values.data();
    spectrum.count = values.size();
    return spectrum;
}

namespace {

cpm_material describe(const Material &material) {
    cpm_material desc{};
    desc.struct_size = sizeof desc;
    desc.kind = material.kind;
    desc.reflectance = material.reflectance.view();
    desc.interior = material.interior ? material.interior->handle.get() : nullptr;
    return desc;
}

void copy(const Point &from, double (&to)[3]) { std::copy(from.begin(), from.end(), to); }

cpm_box make_box(const Point &low, const Point &high) {
    cpm_box box{};
    copy(low, box.low);
    copy(high, box.high);
    return box;
}

std::shared_ptr<Scene> make_scene(const std::shared_ptr<Medium> &medium,
                                  const std::optional<std::pair<Point, Point>> &extent, int32_t method,
                                  uint32_t exclude, double rtol, double atol, double step, double max_step) {
    cpm_box box{};
    cpm_scene_options options{};
    options.struct_size = sizeof options;
    options.medium = medium ? medium->handle.get() : nullptr;
    if (extent) {
        box = make_box(extent->first, extent->second);
        options.extent = &box;
    }
    options.method = method;
    options.exclude = exclude;
    options.rtol = rtol;
    options.atol = atol;
    options.step = step;
    options.max_step = max_step;
    auto scene = std::make_shared<Scene>();
    scene->context = std::make_unique<Context>();
    scene->context->check(cpm_scene_create(scene->context->get(), &options, scene->handle.out()));
    return scene;
}

/* Vertices and faces are read where they are, with their own row strides. */
int32_t add_mesh(Scene &scene, const Doubles &vertices,
                 const py::array_t<uint32_t, py::array::c_style | py::array::forcecast> &faces,
                 const Material &material, const std::optional<Doubles> &normals,
                 const std::optional<std::string> &name) {
    const cpm_material described = describe(material);
    cpm_mesh_desc desc{};
    desc.struct_size = sizeof desc;
    desc.vertices = vertices.data();
    desc.vertex_count = static_cast<size_t>(vertices.shape(0));
    desc.faces = faces.data();
    desc.face_count = static_cast<size_t>(faces.shape(0));
    desc.normals = normals ? normals->data() : nullptr;
    desc.material = &described;
    desc.name = name ? name->c_str() : nullptr;
    int32_t shape = -1;
    cpm_status status;
    {
        py::gil_scoped_release nogil;
        status = cpm_scene_add_mesh(scene.handle.get(), &desc, &shape);
    }
    scene.context->check(status);
    return shape;
}

int32_t add_sphere(Scene &scene, const Point &center, double radius, const Material &material,
                   const std::optional<std::string> &name) {
    const cpm_material described = describe(material);
    int32_t shape = -1;
    scene.context->check(cpm_scene_add_sphere(scene.handle.get(), center.data(), radius, &described,
                                              name ? name->c_str() : nullptr, &shape));
    return shape;
}

int32_t add_medium(Scene &scene, const Medium &medium, const cpm_bounds &bounds) {
    int32_t index = 0;
    scene.context->check(cpm_scene_add_medium(scene.handle.get(), medium.handle.get(), &bounds, &index));
    return index;
}

cpm_bounds make_bounds(int32_t kind) {
    cpm_bounds bounds{};
    bounds.struct_size = sizeof bounds;
    bounds.kind = kind;
    return bounds;
}

int32_t add_light(Scene &scene, int32_t kind, const Spectrum &emission, const Point &position, const Point &target,
                  double cutoff, int32_t shape) {
    cpm_light_desc desc{};
    desc.struct_size = sizeof desc;
    desc.kind = kind;
    desc.shape = shape;
    copy(position, desc.position);
    copy(target, desc.target);
    desc.cutoff = cutoff;
    desc.emission = emission.view();
    int32_t light = -1;
    scene.context->check(cpm_scene_add_light(scene.handle.get(), &desc, &light));
    return light;
}

/* Keeps what a descriptor of a far light points at. */
struct Far {
    cpm_light_desc desc{};
    cpm_box aim{};
};
void describe_far(Far &far, int32_t kind, const std::optional<std::pair<Point, Point>> &aim) {
    far.desc.struct_size = sizeof far.desc;
    far.desc.kind = kind;
    far.desc.shape = -1;
    if (!aim) return;
    far.aim = make_box(aim->first, aim->second);
    far.desc.aim = &far.aim;
}

int32_t add_far(Scene &scene, const Far &far) {
    int32_t light = -1;
    scene.context->check(cpm_scene_add_light(scene.handle.get(), &far.desc, &light));
    return light;
}

int32_t add_sun(Scene &scene, const Point &direction, double radius, const Spectrum &radiance,
                const std::optional<Doubles> &limb, const std::optional<std::pair<Point, Point>> &aim) {
    Far far;
    describe_far(far, CPM_LIGHT_SUN, aim);
    copy(direction, far.desc.target);
    far.desc.cutoff = radius;
    far.desc.emission = radiance.view();
    if (limb) {
        far.desc.limb = limb->data();
        far.desc.limb_count = static_cast<size_t>(limb->size() / 7);
    }
    return add_far(scene, far);
}

int32_t add_environment(Scene &scene, const Spectrum &radiance, const std::optional<std::pair<Point, Point>> &aim) {
    Far far;
    describe_far(far, CPM_LIGHT_ENVIRONMENT, aim);
    far.desc.emission = radiance.view();
    return add_far(scene, far);
}

int32_t add_sky_image(Scene &scene, const Doubles &wavelengths,
                      const py::array_t<float, py::array::c_style | py::array::forcecast> &pixels, const Point &up,
                      const Point &north, const std::optional<std::pair<Point, Point>> &aim) {
    if (pixels.ndim() != 3 || pixels.shape(2) != wavelengths.size())
        throw py::value_error("pixels must be (height, width, bins), with as many wavelengths");
    Far far;
    describe_far(far, CPM_LIGHT_ENVIRONMENT, aim);
    copy(north, far.desc.target);
    copy(up, far.desc.up);
    far.desc.pixels = pixels.data();
    far.desc.height = static_cast<int32_t>(pixels.shape(0));
    far.desc.width = static_cast<int32_t>(pixels.shape(1));
    far.desc.emission.wavelengths = wavelengths.data();
    far.desc.emission.count = static_cast<size_t>(wavelengths.size());
    return add_far(scene, far);
}

void set_camera(Scene &scene, const Point &origin, const Point &target, const Point &up, double fov) {
    cpm_camera camera{};
    camera.struct_size = sizeof camera;
    copy(origin, camera.origin);
    copy(target, camera.target);
    copy(up, camera.up);
    camera.fov = fov;
    scene.context->check(cpm_scene_set_camera(scene.handle.get(), &camera));
}

py::tuple extent(Scene &scene) {
    cpm_box box;
    scene.context->check(cpm_scene_extent(scene.handle.get(), &box));
    return py::make_tuple(py::make_tuple(box.low[0], box.low[1], box.low[2]),
                          py::make_tuple(box.high[0], box.high[1], box.high[2]));
}

uint32_t features(Scene &scene, const Doubles &wavelengths) {
    uint32_t bits = 0;
    scene.context->check(
        cpm_scene_features(scene.handle.get(), wavelengths.data(), static_cast<size_t>(wavelengths.size()), &bits));
    return bits;
}

py::dict feature_bits() {
    py::dict bits;
    bits["curved"] = CPM_FEATURE_CURVED;
    bits["exact"] = CPM_FEATURE_EXACT;
    bits["integrator"] = CPM_FEATURE_INTEGRATOR;
    bits["dispersion"] = CPM_FEATURE_DISPERSION;
    bits["specular"] = CPM_FEATURE_SPECULAR;
    bits["boundaries"] = CPM_FEATURE_BOUNDARIES;
    bits["spheres"] = CPM_FEATURE_SPHERES;
    bits["meshes"] = CPM_FEATURE_MESHES;
    bits["shading_normals"] = CPM_FEATURE_SHADING_NORMALS;
    bits["area_lights"] = CPM_FEATURE_AREA_LIGHTS;
    bits["projection"] = CPM_FEATURE_PROJECTION;
    bits["delta_lights"] = CPM_FEATURE_DELTA_LIGHTS;
    bits["sky"] = CPM_FEATURE_SKY;
    bits["extinction"] = CPM_FEATURE_EXTINCTION;
    return bits;
}

void bind_materials(py::module_ &module) {
    using py::arg;
    py::class_<Spectrum>(module, "Spectrum")
        .def(py::init([](std::vector<double> wavelengths, std::vector<double> values) {
                 return Spectrum{std::move(wavelengths), std::move(values)};
             }),
             arg("wavelengths"), arg("values"));
    py::class_<Material>(module, "Material");
    module.def("black", [] { return Material{}; });
    module.def(
        "diffuse",
        [](Spectrum reflectance) {
            return Material{CPM_MATERIAL_DIFFUSE, std::move(reflectance), nullptr};
        },
        arg("reflectance"));
    module.def(
        "mirror",
        [](Spectrum reflectance) {
            return Material{CPM_MATERIAL_MIRROR, std::move(reflectance), nullptr};
        },
        arg("reflectance"));
    module.def(
        "dielectric",
        [](std::shared_ptr<Medium> interior) {
            return Material{CPM_MATERIAL_DIELECTRIC, {}, std::move(interior)};
        },
        arg("interior"));
}

} // namespace

void bind_scene(py::module_ &module) {
    using py::arg;
    bind_materials(module);
    module.attr("FEATURES") = feature_bits();
    py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene")
        .def(py::init(&make_scene), py::kw_only(), arg("medium").none(true), arg("extent").none(true), arg("method"),
             arg("exclude"), arg("rtol"), arg("atol"), arg("step"), arg("max_step"))
        .def("add_mesh", &add_mesh, arg("vertices"), arg("faces"), arg("material"), arg("normals").none(true),
             arg("name").none(true))
        .def("add_sphere", &add_sphere, arg("center"), arg("radius"), arg("material"), arg("name").none(true))
        .def(
            "add_medium_in_box",
            [](Scene &scene, const Medium &medium, const Point &low, const Point &high) {
                cpm_bounds bounds = make_bounds(CPM_BOUNDS_BOX);
                bounds.box = make_box(low, high);
                return add_medium(scene, medium, bounds);
            },
            arg("medium"), arg("low"), arg("high"))
        .def(
            "add_medium_in_sphere",
            [](Scene &scene, const Medium &medium, const Point &center, double radius) {
                cpm_bounds bounds = make_bounds(CPM_BOUNDS_SPHERE);
                copy(center, bounds.center);
                bounds.radius = radius;
                return add_medium(scene, medium, bounds);
            },
            arg("medium"), arg("center"), arg("radius"))
        .def(
            "add_medium_in_shape",
            [](Scene &scene, const Medium &medium, int32_t shape) {
                cpm_bounds bounds = make_bounds(CPM_BOUNDS_SHAPE);
                bounds.shape = shape;
                return add_medium(scene, medium, bounds);
            },
            arg("medium"), arg("shape"))
        .def(
            "add_point",
            [](Scene &scene, const Point &position, const Spectrum &intensity) {
                return add_light(scene, CPM_LIGHT_POINT, intensity, position, Point{}, 0.0, -1);
            },
            arg("position"), arg("intensity"))
        .def(
            "add_spot",
            [](Scene &scene, const Point &position, const Point &target, double cutoff, const Spectrum &intensity) {
                return add_light(scene, CPM_LIGHT_SPOT, intensity, position, target, cutoff, -1);
            },
            arg("position"), arg("target"), arg("cutoff"), arg("intensity"))
        .def(
            "add_area",
            [](Scene &scene, int32_t shape, const Spectrum &radiance) {
                return add_light(scene, CPM_LIGHT_AREA, radiance, Point{}, Point{}, 0.0, shape);
            },
            arg("shape"), arg("radiance"))
        .def("add_sun", &add_sun, arg("direction"), arg("radius"), arg("radiance"), arg("limb").none(true),
             arg("aim").none(true))
        .def("add_environment", &add_environment, arg("radiance"), arg("aim").none(true))
        .def("add_sky_image", &add_sky_image, arg("wavelengths"), arg("pixels"), arg("up"), arg("north"),
             arg("aim").none(true))
        .def("set_camera", &set_camera, arg("origin"), arg("target"), arg("up"), arg("fov"))
        .def("extent", &extent)
        .def("features", &features, arg("wavelengths"));
}
