#pragma once

#include "arrays.hpp"
#include "calls.hpp"
#include "devices.hpp"

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <utility>

namespace clsdf::python {

/// An object's call, on this thread. A callback that uses the object of its own call would wait for itself: it gets an
/// error.
class AtWork {
public:
    AtWork(const void* object, const char* what) : before_(current), object_(object) {
        check_process();
        for (const AtWork* work = before_; work != nullptr; work = work->before_)
            if (work->object_ == object)
                refuse(std::string("a function that a call of this ") + what + " has called, as progress=, uses the " +
                       what);
        current = this;
    }
    ~AtWork() { current = before_; }
    AtWork(const AtWork&) = delete;
    AtWork& operator=(const AtWork&) = delete;

private:
    static thread_local const AtWork* current;
    const AtWork* before_;
    const void* object_;
};

/// A transform of the library for Python's threads: calls that read run side by side; a call that changes positions
/// waits for them. The GIL is released during all of them.
class Body {
public:
    Body(const PyDevice& device, DistanceTransform transform)
        : device_(device), transform_(new DistanceTransform(std::move(transform))) {}

    const PyDevice& device() const { return device_; }

    /// Calls the function with the transform.
    template <typename Function>
    auto read(Function function) const {
        const AtWork work(this, "transform");
        const nb::gil_scoped_release no_gil;
        const std::shared_lock lock(*mutex_);
        return function(std::as_const(*transform_));
    }
    template <typename Function>
    auto change(Function function) {
        const AtWork work(this, "transform");
        const nb::gil_scoped_release no_gil;
        const std::unique_lock lock(*mutex_);
        return function(*transform_);
    }

private:
    PyDevice device_;
    Owner<DistanceTransform> transform_;
    std::unique_ptr<std::shared_mutex> mutex_ = std::make_unique<std::shared_mutex>();
};

/// A list of (grid, band, {output: array}).
using RequestList = nb::typed<nb::list, nb::any>;
std::vector<Request> requests_of(const RequestList& requests, Arrays& arrays);

/// Equal blocks of a lattice; `first` must outlive it.
BlockSet blocks_of(const Grid& lattice, const Band& band, const Index3& size, const std::vector<Index3>& first,
                   const ArraysByName& outputs, Arrays& arrays);

}  // namespace clsdf::python
