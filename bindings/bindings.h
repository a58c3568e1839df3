/* bindings/bindings.h: what the handle files share: contexts, errors, progress, arrays. Internal.
 *
 * One .cpp per handle of the C ABI. Nothing is computed here: arguments become descriptors, statuses become exceptions. */
#ifndef CPM_BINDINGS_H
#define CPM_BINDINGS_H
#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cpm/cpm.h>

namespace py = pybind11;

/* C-contiguous doubles; anything else is converted once. */
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Point = std::array<double, 3>;

/* A context for one handle or one long call, so that neither messages nor progress of two Python threads meet. */
class Context {
public:
    /* `device`: an OpenCL device's index, -1: the processor's threads. */
    explicit Context(int32_t threads = 0, int32_t device = -1);
    ~Context() { cpm_context_release(context_); }
    Context(const Context &) = delete;
    Context &operator=(const Context &) = delete;

    cpm_context *get() const { return context_; }

    /* Throws what the status means in Python, with the context's message. */
    void check(cpm_status status) const;

private:
    cpm_context *context_ = nullptr;
};

/* ValueError, MemoryError, OSError, KeyboardInterrupt or cpm.Error. */
[[noreturn]] void raise_status(cpm_status status, const char *message);

/* Holds the Python callback of a long call and what it raised. */
class Progress {
public:
    Progress(const Context &context, py::object callback);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;

    void rethrow() const {
        if (raised_) std::rethrow_exception(raised_);
    }

private:
    static int32_t report(void *user, const char *stage, double fraction);

    const Context &context_;
    py::object callback_;
    std::exception_ptr raised_;
};

/* Runs `call` without the GIL. Ctrl-C and whatever the callback raises cancel it and are raised here. */
template <class Call>
void run_long(const Context &context, py::object callback, Call &&call) {
    Progress progress(context, std::move(callback));
    cpm_status status;
    {
        py::gil_scoped_release nogil;
        status = call();
    }
    progress.rethrow();
    context.check(status);
}

/* An owned, reference-counted handle of the ABI. */
template <class T>
class Handle {
public:
    explicit Handle(void (*release)(T *)) : release_(release) {}
    ~Handle() { release_(pointer_); }
    Handle(Handle &&other) noexcept : pointer_(std::exchange(other.pointer_, nullptr)), release_(other.release_) {}
    Handle(const Handle &) = delete;
    Handle &operator=(const Handle &) = delete;
    Handle &operator=(Handle &&) = delete;

    T *get() const { return pointer_; }
    T **out() { return &pointer_; }

private:
    T *pointer_ = nullptr;
    void (*release_)(T *);
};

struct Medium {
    Handle<cpm_medium> handle{cpm_medium_release};
};

/* Owned samples behind a cpm_spectrum; no wavelengths: flat. */
struct Spectrum {
    std::vector<double> wavelengths, values;
    cpm_spectrum view() const;
};

struct Material {
    int32_t kind = CPM_MATERIAL_BLACK;
    Spectrum reflectance;
    std::shared_ptr<Medium> interior;
};

struct Scene {
    std::unique_ptr<Context> context; /* the scene's messages arrive here: it must live as long */
    Handle<cpm_scene> handle{cpm_scene_release};
};

struct Photons {
    std::shared_ptr<Scene> scene;
    Handle<cpm_photons> handle{cpm_photons_release};
};

py::dict stats_dict(const cpm_stats &stats);

void bind_context(py::module_ &module);
void bind_medium(py::module_ &module);
void bind_scene(py::module_ &module);
void bind_rays(py::module_ &module);
void bind_photons(py::module_ &module);
void bind_image(py::module_ &module);

#endif
