// A kernel that fails is seen by every call: as an error that names it or, by calls that do not wait, as an event that
// has failed. Afterwards the same transform gives the right bytes, or refuses and names the kernel. A sample of the
// kernels, or with CLSDF_FAULT_EVERY=1 in the environment each of them.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/supposes.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using Bytes = std::vector<std::byte>;
using Call = std::function<Bytes()>;

/// An event of a call that does not wait.
struct EventHasFailed {};

void wait_for(const cl::Event& done) {
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

Bytes bytes_of_field(const FieldSlab& values) {
    return bytes_of_all(values.distance(), values.triangle(), values.closest(), values.gradient());
}

Bytes bytes_of_sparse(const SparseField& field) {
    Bytes bytes = bytes_of_all(field.bricks, field.inside);
    const Bytes values = bytes_of_field(field.values());
    bytes.insert(bytes.end(), values.begin(), values.end());
    return bytes;
}

const OutputSet outputs{Output::distance, Output::triangle, Output::closest, Output::gradient};

const Grid& small_grid() {
    static const Grid around = grid_around(mesh(), 20, 3);
    return around;
}
Band small_band() {
    return Band::symmetric(3 * small_grid().voxel());
}

std::vector<Request> requests_of(const std::function<OutputTargets(std::size_t)>& targets) {
    std::vector<Request> requests;
    for (std::size_t n = 0; n < 3; ++n)
        requests.push_back(
            {small_grid().part({1, 1, static_cast<std::int64_t>(5 * n)}, {9, 8, 4}), small_band(), targets(n)});
    return requests;
}
constexpr std::size_t samples_of_request = 9 * 8 * 4;

std::vector<Vec3> points(std::size_t count) {
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
constexpr std::size_t few_points = 20, some_points = 700;
constexpr double infinity = std::numeric_limits<double>::infinity();

const device::Context& context() {
    return device::context_of(test_device());
}

template <class Value>
cl::Buffer on_device(const std::vector<Value>& values) {
    return {context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(Value),
            const_cast<Value*>(values.data())};  // which is only read
}

std::shared_ptr<DistanceTransform> transform_of(const Mesh& of) {
    return std::make_shared<DistanceTransform>(test_device(), of);
}
std::shared_ptr<DistanceTransform> transform() {
    return transform_of(mesh());
}

/// By the test, in a queue of its own, of what a run that has ended has written.
template <class Value>
std::vector<Value> read_apart(const cl::Buffer& buffer, std::size_t count) {
    const cl::CommandQueue queue(context().context(), context().device());
    std::vector<Value> values(count);
    if (count > 0) queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(Value), values.data());
    return values;
}

Bytes query_of(const DistanceTransform& transform, std::size_t count) {
    std::vector<float> distance(count, 7);
    std::vector<std::uint32_t> triangle(count, 7);
    std::vector<Vec3> gradient(count);
    const std::vector<Vec3> asked = points(count);
    transform.query(asked, infinity,
                    {{Output::distance, distance}, {Output::triangle, triangle}, {Output::gradient, gradient}});
    return bytes_of_all(distance, triangle, gradient);
}

Bytes query_on_device(const DistanceTransform& transform, std::size_t count) {
    const cl::Buffer asked = on_device(points(count)), distance = on_device(std::vector<float>(count, 7));
    transform.query(InputArray(asked(), ElementType::float64, count), infinity, {{Output::distance, distance()}});
    return bytes_of_all(read_apart<float>(distance, count));
}

std::size_t many_points() {
    return mesh().triangles().size() + 5000;  // which processors scan
}

/// A way to use a transform: make() makes it, and the call uses it.
struct Use {
    std::string name;
    std::function<Call()> make;
};

/// The call of transforms that need nothing else.
Use use(std::string name, const std::function<Bytes(DistanceTransform&)>& call) {
    return {std::move(name), [call] { return [call, used = transform()] { return call(*used); }; }};
}

const std::vector<Use>& uses() {
    static const std::vector<Use> all{
        use("compute",
            [](auto& used) { return bytes_of_field(used.compute(small_grid(), small_band(), outputs).slab()); }),
        use("compute with progress",
            [](auto& used) {
                const CallOptions watched{.progress = [](const Progress&) {}};
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs, watched).slab());
            }),
        use("compute with counted work",
            [](auto& used) {
                const CallOptions counted{.count_work = true};
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs, counted).slab());
            }),
        use("compute requests",
            [](auto& used) {
                std::vector<float> distance(3 * samples_of_request, 7);
                used.compute(requests_of([&](std::size_t n) {
                    return OutputTargets{{Output::distance, distance.data() + n * samples_of_request}};
                }));
                return bytes_of_all(distance);
            }),
        use("compute slabs",
            [](auto& used) {
                Bytes bytes;
                used.compute(small_grid(), small_band(), outputs, [&](const Grid&, const FieldSlab& values) {
                    const Bytes more = bytes_of_field(values);
                    bytes.insert(bytes.end(), more.begin(), more.end());
                });
                return bytes;
            }),
        use("compute on the device",
            [](auto& used) {
                const std::size_t samples = small_grid().sample_count();
                const DeviceMemory memory(test_device().context(), samples);
                used.compute(small_grid(), small_band(), {{Output::distance, memory.handle()}});
                return bytes_of_all(read_apart<float>(cl::Buffer(memory.handle(), true), samples));
            }),
        use("compute an open mesh",
            [](auto&) {
                static const Mesh open = without_triangle(mesh(), 100);
                return bytes_of_field(transform_of(open)->compute(small_grid(), small_band(), outputs).slab());
            }),
        use("compute a sparse field",
            [](auto& used) { return bytes_of_sparse(used.compute_sparse(small_grid(), small_band(), outputs)); }),
        use("compute sparse arrays",
            [](auto& used) {
                std::vector<Index3> bricks(1000);
                std::vector<BrickRun> inside(1000);
                std::vector<float> distance(brick_samples * bricks.size(), 7);
                SparseCounts counts{};
                used.compute_sparse(small_grid(), small_band(), {bricks, inside, {{Output::distance, distance}}},
                                    counts);
                return bytes_of_all(bricks, inside, distance, std::vector<SparseCounts>{counts});
            }),
        use("count a sparse field",
            [](auto& used) {
                return bytes_of_all(std::vector<SparseCounts>{used.count_sparse(small_grid(), small_band())});
            }),
        use("query few points", [](auto& used) { return query_of(used, few_points); }),
        use("query points", [](auto& used) { return query_of(used, some_points); }),
        use("query many points", [](auto& used) { return query_of(used, many_points()); }),
        use("query on the device", [](auto& used) { return query_on_device(used, some_points); }),
        use("winding",
            [](auto& used) {
                std::vector<double> results(some_points, 7);
                const std::vector<Vec3> asked = points(some_points);
                used.winding(asked, results);
                return bytes_of_all(results);
            }),
        use("classify",
            [](auto& used) {
                std::vector<Box> boxes;
                for (const Vec3& point : points(some_points))
                    boxes.push_back({point, {point[0] + 0.1, point[1] + 0.2, point[2] + 0.1}});
                std::vector<BoxPlace> places(boxes.size());
                used.classify(boxes, 0.1, places);
                return bytes_of_all(places);
            }),
        use("restrict",
            [](auto& used) {
                const Grid part = small_grid().part({0, 0, 0}, {12, 12, 12});
                const DistanceTransform restricted =
                    used.restrict_to(Region{part.box(), 3 * part.voxel(), part.voxel()});
                return bytes_of_field(restricted.compute(part, small_band(), outputs).slab());
            }),
        use("set positions",
            [](auto& used) {
                used.compute(small_grid(), small_band());
                used.set_positions(scaled(mesh(), 1.01).vertices());
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs).slab());
            }),
        use("set positions on the device",
            [](auto& used) {
                const std::vector<Vec3> moved = scaled(mesh(), 1.01).vertices();
                const cl::Buffer positions = on_device(moved);
                used.compute(small_grid(), small_band());
                used.set_positions(InputArray(positions(), ElementType::float64, moved.size()));
                Bytes bytes = bytes_of_field(used.compute(small_grid(), small_band(), outputs).slab());
                const Bytes more = query_of(used, few_points);
                bytes.insert(bytes.end(), more.begin(), more.end());
                return bytes;
            }),
        {"mesh on the device",
         [] {
             const cl::Buffer vertices = on_device(mesh().vertices()), triangles = on_device(mesh().triangles());
             const MeshView view(InputArray(vertices(), ElementType::float64, mesh().vertices().size()),
                                 InputArray(triangles(), ElementType::uint32, mesh().triangles().size()));
             return [used = std::make_shared<DistanceTransform>(test_device(), view)] {
                 return bytes_of_field(used->compute(small_grid(), small_band(), outputs).slab());
             };
         }},
        {"plan",
         [] {
             const auto memory = std::make_shared<DeviceMemory>(test_device().context(), 3 * samples_of_request);
             const auto used = transform();
             const auto plan = std::make_shared<Plan>(used->plan(requests_of([&](std::size_t n) {
                 OutputArray array(memory->handle());
                 array.offset = n * samples_of_request * sizeof(float);
                 return OutputTargets{{Output::distance, array}};
             })));
             return [=] {
                 for (int run = 0; run < 2; ++run) wait_for(enqueue(*plan, nullptr));
                 return bytes_of_all(read_apart<float>(cl::Buffer(memory->handle(), true), 3 * samples_of_request));
             };
         }},
        {"update a plan",
         [] {
             const auto memory = std::make_shared<DeviceMemory>(test_device().context(), small_grid().sample_count());
             const auto used = transform();
             const auto plan = std::make_shared<Plan>(
                 used->plan(Request{small_grid(), small_band(), {{Output::distance, memory->handle()}}}));
             return [=] {
                 used->set_positions(scaled(mesh(), 1.01).vertices());
                 plan->update(*used);
                 wait_for(enqueue(*plan, nullptr));
                 return bytes_of_all(
                     read_apart<float>(cl::Buffer(memory->handle(), true), small_grid().sample_count()));
             };
         }},
        {"sparse plan",
         [] {
             constexpr std::size_t room = 200;
             const auto used = transform();
             const auto plan =
                 std::make_shared<SparsePlan>(used->plan_sparse({small_grid(), small_band(), {}}, {room, room}));
             const cl::Buffer counts = on_device(std::vector<DeviceSparseCounts>(1)),
                              bricks = on_device(std::vector<Index3>(room)),
                              inside = on_device(std::vector<BrickRun>(room)),
                              distance = on_device(std::vector<float>(room * brick_samples, 7));
             return [=] {
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, {{counts()}, {bricks()}, {inside()}, {{Output::distance, distance()}}}, {},
                               &done);
                 wait_for(cl::Event(done));
                 const auto found = read_apart<DeviceSparseCounts>(counts, 1);
                 return bytes_of_all(found, read_apart<Index3>(bricks, found[0].bricks),
                                     read_apart<BrickRun>(inside, found[0].runs),
                                     read_apart<float>(distance, found[0].bricks * brick_samples));
             };
         }},
        {"plan of points",
         [] {
             const auto used = transform();
             const auto plan = std::make_shared<PointPlan>(used->plan_points(some_points, infinity));
             const cl::Buffer asked = on_device(points(some_points)),
                              distance = on_device(std::vector<float>(some_points, 7));
             return [=] {
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, InputArray(asked(), ElementType::float64, some_points),
                               {{Output::distance, distance()}}, {}, &done);
                 wait_for(cl::Event(done));
                 return bytes_of_all(read_apart<float>(distance, some_points));
             };
         }},
        {"update a plan of points",
         [] {
             const auto used = transform();
             const auto plan = std::make_shared<PointPlan>(used->plan_points(some_points, infinity));
             const cl::Buffer asked = on_device(points(some_points)),
                              distance = on_device(std::vector<float>(some_points, 7));
             return [=] {
                 used->set_positions(scaled(mesh(), 1.01).vertices());
                 plan->update(*used);
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, InputArray(asked(), ElementType::float64, some_points),
                               {{Output::distance, distance()}}, {}, &done);
                 wait_for(cl::Event(done));
                 return bytes_of_all(read_apart<float>(distance, some_points));
             };
         }},
    };
    return all;
}

std::uint64_t number_in(const char* name, std::uint64_t otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// One of each part of a use's kernels.
std::vector<std::uint64_t> sample(std::uint64_t launches) {
    constexpr std::uint64_t wanted = 5;
    const std::uint64_t step = number_in("CLSDF_FAULT_EVERY", std::max<std::uint64_t>(launches / wanted, 1));
    static std::mt19937_64 random(number_in("CLSDF_FAULT_SEED", std::random_device{}()));
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t begin = 1; begin <= launches; begin += step)
        numbers.push_back(std::min(begin + random() % step, launches));
    return numbers;
}

void check_error(const Error& error, const std::string& kernel) {
    BOOST_TEST_CONTEXT("message: " << error.what()) {
        BOOST_CHECK(error.code() == ErrorCode::device_failure);
        BOOST_TEST(std::string(error.what()).find(kernel) != std::string::npos);
        BOOST_TEST(std::string(error.what()).find("internal error") == std::string::npos);
    }
}

/// The kernel of this launch fails.
void check_failing(const Use& use, std::uint64_t launch, const Bytes& right) {
    // CL_OUT_OF_RESOURCES, and that of NVIDIA for an illegal address.
    const int code = launch % 2 == 0 ? -5 : -9999;
    disguise::restart({.call = "clEnqueueNDRangeKernel", .number = launch, .code = code, .in_kernel = true});
    Call call;
    std::optional<Error> error;
    bool has_failed = false;
    try {
        call = use.make();
        call();
    } catch (const Error& thrown) {
        error = thrown;
    } catch (const EventHasFailed&) {
        has_failed = true;
    }
    const std::string kernel = disguise::counts().failed;
    disguise::restart();
    BOOST_TEST_CONTEXT(use.name << ", launch " << launch << ", kernel " << kernel) {
        BOOST_TEST(!kernel.empty());
        BOOST_TEST((error.has_value() || has_failed), "nobody has seen it");
        if (error) check_error(*error, kernel);
        if (!call) return;
        try {
            BOOST_TEST((call() == right), "wrong bytes afterwards");
        } catch (const Error& thrown) {
            check_error(thrown, kernel);
        } catch (const EventHasFailed&) {
            BOOST_ERROR("an event of the next call has failed");
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(on_a_known_driver, *boost::unit_test::precondition(on_pocl))

BOOST_AUTO_TEST_CASE(a_kernel_that_fails_is_seen_by_every_call) {
    BOOST_REQUIRE(Device::all().size() > 0U);
    BOOST_REQUIRE(disguise::counts().all_calls > 0U);  // else the library is not between this program and the loader
    const char* const chosen = std::getenv("CLSDF_FAULT_USE");
    for (const Use& use : uses()) {
        if (chosen != nullptr && use.name != chosen) continue;
        use.make()();  // programs are compiled and tested
        disguise::restart();
        const Call call = use.make();
        const Bytes right = call();
        const std::uint64_t launches = disguise::counts().launches;
        BOOST_TEST((call() == right));
        const std::vector<std::uint64_t> numbers = sample(launches);
        BOOST_TEST_MESSAGE(use.name << ": " << launches << " kernels, " << numbers.size() << " of them fail");
        for (const std::uint64_t launch : numbers) check_failing(use, launch, right);
    }
    // The device is as before.
    BOOST_TEST((uses().front().make()() == uses().front().make()()));
}

/// A call that is stopped waits for the device, and tells nothing of a kernel that has failed.
BOOST_AUTO_TEST_CASE(a_kernel_that_fails_in_a_call_that_is_stopped_is_seen_by_the_next_one) {
    const auto compute = [](const DistanceTransform& used, const CallOptions& call = {}) {
        return bytes_of_field(used.compute(small_grid(), small_band(), outputs, call).slab());
    };
    const Bytes right = compute(*transform());
    for (std::uint64_t launch = 1; launch <= 20; ++launch) {
        const auto used = transform();
        int asked = 0;
        const CallOptions stopped{.should_stop = [&] { return ++asked > 3; }};
        disguise::restart({.call = "clEnqueueNDRangeKernel", .number = launch, .in_kernel = true});
        BOOST_CHECK_THROW(compute(*used, stopped), Error);
        const std::string kernel = disguise::counts().failed;
        disguise::restart();
        BOOST_TEST_CONTEXT("launch " << launch << ", kernel " << kernel) {
            try {
                BOOST_TEST((compute(*used) == right), "wrong bytes afterwards");
            } catch (const Error& thrown) {
                check_error(thrown, kernel);
            }
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()
