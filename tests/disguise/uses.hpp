#pragma once

#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include "device/context.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

/// The calls of the library, for tests in which the device fails: each returns the bytes of what it found.
namespace clsdf::test {

using Bytes = std::vector<std::byte>;
using Call = std::function<Bytes()>;

/// A way to use a transform: make() makes it, and the call uses it.
struct Use {
    std::string name;
    std::function<Call()> make;
};

/// Fields, points and their plans.
const std::vector<Use>& uses();
/// Links, crossings, rays, scenes, cut cells, outer surfaces, parts and shared meshes, and their plans.
const std::vector<Use>& uses_of_rows();

/// An event of a call that does not wait.
struct EventHasFailed {};

/// A call of OpenCL that the test makes, not the library.
struct OwnCallFailed {};
template <class Function>
auto own(const Function& call) {
    try {
        return call();
    } catch (const cl::Error&) {
        throw OwnCallFailed();
    }
}

inline void wait_for(const cl::Event& done) {
    if (clWaitForEvents(1, &done()) != CL_SUCCESS) throw EventHasFailed();
}

template <class... Arrays>
Bytes bytes_of_all(const Arrays&... arrays) {
    Bytes bytes;
    const auto add = [&](const auto& array) {
        const auto more = std::as_bytes(std::span(array));
        bytes.insert(bytes.end(), more.begin(), more.end());
    };
    (add(arrays), ...);
    return bytes;
}

inline Bytes bytes_of_field(const FieldSlab& values) {
    return bytes_of_all(values.distance(), values.triangle(), values.closest(), values.gradient());
}

inline const OutputSet outputs_of_uses{Output::distance, Output::triangle, Output::closest, Output::gradient};

inline const Grid& small_grid() {
    static const Grid around = grid_around(mesh(), 20, 3);
    return around;
}
inline Band small_band() {
    return Band::symmetric(3 * small_grid().voxel());
}

inline std::vector<Vec3> points_about(std::size_t count) {
    constexpr std::uint64_t seed = 3;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> part(-0.2, 1.2);
    const Box box = mesh().box();
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = box.lower[axis] + part(random) * (box.upper[axis] - box.lower[axis]);
    return points;
}

inline const device::Context& context() {
    return device::context_of(test_device());
}

template <class Value>
cl::Buffer on_device(const std::vector<Value>& values) {
    return own([&] {
        return cl::Buffer(context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(Value),
                          const_cast<Value*>(values.data()));  // which is only read
    });
}

inline std::shared_ptr<DistanceTransform> transform_of(const Mesh& of) {
    return std::make_shared<DistanceTransform>(test_device(), of);
}

/// By the test, in a queue of its own, of what a run that has ended has written.
template <class Value>
std::vector<Value> read_apart(const cl::Buffer& buffer, std::size_t count) {
    return own([&] {
        const cl::CommandQueue queue(context().context(), context().device());
        std::vector<Value> values(count);
        if (count > 0) queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(Value), values.data());
        return values;
    });
}

/// The call of transforms that need nothing else.
inline Use use(std::string name, const std::function<Bytes(DistanceTransform&)>& call) {
    return {std::move(name), [call] { return [call, used = transform_of(mesh())] { return call(*used); }; }};
}

/// Which of `count` calls or kernels fail, from 1 on: a sample by CLSDF_FAULT_SEED, or those of
/// CLSDF_FAULT_PART=N/PARTS in the environment.
std::vector<std::uint64_t> chosen_faults(std::uint64_t count);

}  // namespace clsdf::test
