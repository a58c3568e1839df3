/* bindings/context.cpp: contexts, statuses as exceptions, progress as a callback. */
#include "bindings.h"

namespace {

PyObject *error_type = nullptr; /* cpm.Error; lives as long as the module */

PyObject *exception_of(cpm_status status) {
    switch (status) {
    case CPM_ERROR_INVALID_ARGUMENT: return PyExc_ValueError;
    case CPM_ERROR_OUT_OF_MEMORY: return PyExc_MemoryError;
    case CPM_ERROR_IO: return PyExc_OSError;
    case CPM_ERROR_CANCELLED: return PyExc_KeyboardInterrupt;
    default: return error_type;
    }
}

} // namespace

void raise_status(cpm_status status, const char *message) {
    /* Messages may quote names and paths in any encoding. */
    const char *text = message && *message ? message : cpm_status_string(status);
    py::object decoded = py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(text, static_cast<Py_ssize_t>(std::char_traits<char>::length(text)), "replace"));
    if (decoded) PyErr_SetObject(exception_of(status), decoded.ptr());
    throw py::error_already_set();
}

Context::Context(int32_t threads, int32_t device) {
    cpm_context_options options{};
    options.struct_size = sizeof options;
    options.threads = threads;
    const cpm_status status = cpm_context_create(&options, &context_);
    if (status == CPM_ERROR_INVALID_ARGUMENT)
        raise_status(status, ("threads is " + std::to_string(threads) + "; 0 (all) to 1024 are allowed").c_str());
    if (status != CPM_OK) raise_status(status, nullptr);
    if (device < 0) return;
    cpm_device_options on{};
    on.struct_size = sizeof on;
    on.device = device;
    const cpm_status opened = cpm_context_set_device(context_, &on);
    if (opened == CPM_OK) return;
    const std::string message = cpm_context_last_error(context_);
    cpm_context_release(context_); /* a constructor that throws has no destructor */
    raise_status(opened, message.c_str());
}

namespace {

py::list devices() {
    const Context context;
    size_t count = 0;
    context.check(cpm_device_count(context.get(), &count));
    py::list all;
    for (size_t i = 0; i < count; i++) {
        cpm_device_info info{};
        info.struct_size = sizeof info;
        context.check(cpm_device_describe(context.get(), i, &info));
        all.append(py::make_tuple(info.name, info.platform, info.version, info.units, info.double_precision != 0,
                                  info.memory));
    }
    return all;
}

} // namespace

void Context::check(cpm_status status) const {
    if (status != CPM_OK) raise_status(status, cpm_context_last_error(context_));
}

Progress::Progress(const Context &context, py::object callback) : context_(context), callback_(std::move(callback)) {
    context.check(cpm_context_set_progress(context.get(), &Progress::report, this));
}

Progress::~Progress() { cpm_context_set_progress(context_.get(), nullptr, nullptr); }

int32_t Progress::report(void *user, const char *stage, double fraction) {
    auto *self = static_cast<Progress *>(user);
    py::gil_scoped_acquire gil;
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set(); /* Ctrl-C, where this is the main thread */
        if (!self->callback_.is_none()) self->callback_(stage, fraction);
        return 0;
    } catch (...) {
        self->raised_ = std::current_exception();
        return 1;
    }
}

void bind_context(py::module_ &module) {
    error_type = PyErr_NewExceptionWithDoc(
        "cpm.Error", "What is asked for is not supported, or a backend failed. Wrong arguments are ValueError.",
        PyExc_RuntimeError, nullptr);
    if (!error_type) throw py::error_already_set();
    module.attr("Error") = py::reinterpret_borrow<py::object>(error_type);

    module.def("version", &cpm_version);
    module.def("build_info", &cpm_build_info);
    module.def("threads", [] { return cpm_context_threads(Context().get()); });
    module.def("devices", &devices);

    py::dict ray_status;
#define CPM_ENTRY(name, value, text) ray_status[text] = value;
    CPM_RAY_STATUS_LIST(CPM_ENTRY)
#undef CPM_ENTRY
    module.attr("RAY_STATUS") = ray_status;
}
