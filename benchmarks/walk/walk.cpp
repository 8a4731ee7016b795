// Records which functions of the library a call enters on the host, and which kernels it launches, in the order of
// their first use: walk first|kept. Prints a line for each, "function ADDRESS" or "kernel NAME"; scripts/walk finds the
// names and files.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <tbb/global_control.h>
#include <clsdf/clsdf.hpp>
#if __has_include(<clsdf/tuning.hpp>)
#include <clsdf/tuning.hpp>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t most_functions = 1 << 16;
std::atomic<bool> is_recording = false;
/// A hash table, and its functions in the order of their first entry.
std::array<std::atomic<void*>, most_functions> entered;
std::array<std::atomic<void*>, most_functions> in_order;
std::atomic<std::size_t> entered_count = 0;

struct Launch {
    std::string kernel;
    std::size_t functions;  ///< that were entered before its first launch
};
std::mutex launches_mutex;
std::vector<Launch> launches;

}  // namespace

extern "C" {

[[gnu::no_instrument_function]] void __cyg_profile_func_enter(void* function, void*) {
    if (!is_recording.load(std::memory_order_relaxed)) return;
    const std::size_t hash = reinterpret_cast<std::uintptr_t>(function) / 4 * 2654435761U;
    for (std::size_t step = 0; step < most_functions; ++step) {
        std::atomic<void*>& slot = entered[(hash + step) % most_functions];
        void* found = slot.load();
        if (found == nullptr && slot.compare_exchange_strong(found, function)) {
            in_order[entered_count.fetch_add(1)] = function;
            return;
        }
        if (found == function) return;
    }
}

[[gnu::no_instrument_function]] void __cyg_profile_func_exit(void*, void*) {}

/// The library's calls come here first.
cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const std::size_t* offset,
                              const std::size_t* items, const std::size_t* group, cl_uint wait_count,
                              const cl_event* wait_list, cl_event* event) {
    static auto* const next =
        reinterpret_cast<decltype(&::clEnqueueNDRangeKernel)>(::dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel"));
    if (is_recording) {
        std::array<char, 128> name{};
        ::clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, name.size() - 1, name.data(), nullptr);
        const std::scoped_lock lock(launches_mutex);
        if (std::none_of(launches.begin(), launches.end(), [&](const Launch& l) { return l.kernel == name.data(); }))
            launches.push_back({name.data(), entered_count});
    }
    return next(queue, kernel, dimensions, offset, items, group, wait_count, wait_list, event);
}

}  // extern "C"

namespace {

/// The caller's arrays: a torus whose surface has bumps, with saddle vertices.
struct Arrays {
    std::vector<float> positions;
    std::vector<std::uint32_t> triangles;
};

Arrays bumpy_torus() {
    constexpr std::uint32_t around = 96, across = 48;
    Arrays arrays;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double radius = 0.4 + 0.05 * std::sin(5 * u) * std::cos(3 * v);
            const double to_axis = 1 + radius * std::cos(v);
            for (const double x : {to_axis * std::cos(u), to_axis * std::sin(u), radius * std::sin(v)})
                arrays.positions.push_back(static_cast<float>(x));
            const auto vertex = [&](std::uint32_t di, std::uint32_t dj) {
                return (i + di) % around * across + (j + dj) % across;
            };
            for (const std::uint32_t corner :
                 {vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 0), vertex(1, 1), vertex(0, 1)})
                arrays.triangles.push_back(corner);
        }
    return arrays;
}

/// The README's call. Its name differs between commits.
template <class Transform>
clsdf::Field field_of(const Transform& transform, const clsdf::Grid& grid, const clsdf::Band& band) {
    if constexpr (requires { transform.compute(grid, band); })
        return transform.compute(grid, band);
    else
        return transform(grid, band);
}

template <typename Field>
std::span<const float> distances_of(const Field& field) {
    if constexpr (requires { field.distance(); })
        return field.distance();
    else
        return field.distance;
}

/// Waits until the driver's threads have called the library back for all commands of the queue.
void settle(cl_command_queue queue) {
    ::clFinish(queue);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
}

/// Records run().
template <class Run>
void walk(cl_command_queue queue, const Run& run) {
    settle(queue);
    is_recording = true;
    run();
    settle(queue);
    is_recording = false;
}

void print() {
    std::size_t function = 0;
    const auto functions_until = [&](std::size_t end) {
        for (; function < end; ++function)
            std::printf("function %016zx\n", reinterpret_cast<std::uintptr_t>(in_order[function].load()));
    };
    for (const Launch& launch : launches) {
        functions_until(launch.functions);
        std::printf("kernel %s\n", launch.kernel.c_str());
    }
    functions_until(entered_count);
}

int walk_through(bool is_first) {
    // One thread: the order of the first entries is the same on every run.
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const Arrays arrays = bumpy_torus();
    const auto view = [&] { return clsdf::MeshView(arrays.positions, arrays.triangles); };
    const clsdf::Mesh mesh(view());
    const clsdf::Band band = clsdf::Band::symmetric(0.1 * mesh.box().longest_side());
    const clsdf::Grid grid = clsdf::Grid::around(mesh, 256, band);
    const clsdf::Device device = clsdf::Device::select("Portable Computing Language");

    // A field on the heap is not moved.
    const auto new_field = [&](const clsdf::DistanceTransform& transform) {
        return std::unique_ptr<const clsdf::Field>(new clsdf::Field(field_of(transform, grid, band)));
    };

    // The device's programs are built by a transform of its own.
    const auto expected = new_field(clsdf::DistanceTransform(device, view()));
    std::optional<clsdf::DistanceTransform> transform;
    std::unique_ptr<const clsdf::Field> walked;
    cl_command_queue const queue = device.queue();
    if (is_first) {
        walk(queue, [&] {
            transform.emplace(device, view());
            walked = new_field(*transform);
        });
    } else {
        transform.emplace(device, view());
        new_field(*transform);
        walk(queue, [&] { walked = new_field(*transform); });
    }
    if (!std::ranges::equal(distances_of(*walked), distances_of(*expected))) {
        std::fprintf(stderr, "walk: the field differs from that of another transform\n");
        return 1;
    }
    print();
    return 0;
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    try {
#if __has_include(<clsdf/tuning.hpp>)
        clsdf::tuning::read_environment();
#endif
        return walk_through(std::strcmp(arguments[1], "first") == 0);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "walk: %s\n", error.what());
        return 1;
    }
}
