#pragma once

#include "arrays.hpp"
#include "calls.hpp"
#include "devices.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

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

/// What messages call an object of the library.
template <typename Object>
inline constexpr const char* name_of_object = nullptr;
template <>
inline constexpr const char* name_of_object<DistanceTransform> = "transform";
template <>
inline constexpr const char* name_of_object<Scene> = "scene";

/// A transform or a scene of the library for Python's threads: calls that read run side by side; a call that changes
/// positions waits for them. The GIL is released during all of them.
template <typename Object>
class OnDevice {
public:
    OnDevice(const PyDevice& device, Object object) : device_(device), object_(new Object(std::move(object))) {}

    const PyDevice& device() const { return device_; }

    /// Calls the function with the object.
    template <typename Function>
    auto read(Function function) const {
        const AtWork work(this, name_of_object<Object>);
        const nb::gil_scoped_release no_gil;
        const std::shared_lock lock(*mutex_);
        return function(std::as_const(*object_));
    }
    template <typename Function>
    auto change(Function function) {
        const AtWork work(this, name_of_object<Object>);
        const nb::gil_scoped_release no_gil;
        const std::unique_lock lock(*mutex_);
        return function(*object_);
    }

private:
    PyDevice device_;
    Owner<Object> object_;
    std::unique_ptr<std::shared_mutex> mutex_ = std::make_unique<std::shared_mutex>();
};
using Body = OnDevice<DistanceTransform>;
using Bodies = OnDevice<Scene>;

/// The rules that sign= names.
SignRule sign_named(const std::string& name);

/// Boxes as NumPy has them, and their places: an array that owns them.
using Boxes = nb::ndarray<const double, nb::shape<-1, 2, 3>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>>;
template <typename Object>
Places classify(const OnDevice<Object>& object, const Boxes& boxes, double half_width) {
    auto places = std::make_unique<std::vector<BoxPlace>>(boxes.shape(0));
    const std::span all(reinterpret_cast<const Box*>(boxes.data()), boxes.shape(0));
    // Part by part: the library does not ask whether Ctrl-C was pressed.
    constexpr std::size_t part = 1 << 15;
    const Call call;
    object.read([&](const Object& own) {
        try {
            std::size_t begin = 0;
            do {
                const std::size_t size = std::min(part, all.size() - begin);
                own.classify(all.subspan(begin, size), half_width, std::span(*places).subspan(begin, size));
                call.options().should_stop();
                begin += size;
            } while (begin < all.size());
        } catch (const Error& error) {
            // The message numbers the boxes of a part. A call for all of them fails before any work, with the number
            // among all.
            if (error.code() == ErrorCode::invalid_argument) own.classify(all, half_width, *places);
            throw;
        }
    });
    auto* const data = reinterpret_cast<std::uint8_t*>(places->data());
    const std::size_t count = places->size();
    return Places(data, {count}, owner_of(std::move(places)));
}

/// A list of (grid, band, {output: array}).
using RequestList = nb::typed<nb::list, nb::any>;
std::vector<Request> requests_of(const RequestList& requests, Arrays& arrays);

/// Equal blocks of a lattice; `first` must outlive it.
BlockSet blocks_of(const Grid& lattice, const Band& band, const Index3& size, const std::vector<Index3>& first,
                   const ArraysByName& outputs, Arrays& arrays);

}  // namespace clsdf::python
