#include "disguise/uses.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>

namespace clsdf::test {

namespace {

Bytes bytes_of_sparse(const SparseField& field) {
    Bytes bytes = bytes_of_all(field.bricks, field.inside);
    const Bytes values = bytes_of_field(field.values());
    bytes.insert(bytes.end(), values.begin(), values.end());
    return bytes;
}

std::vector<Request> requests_of(const std::function<OutputTargets(std::size_t)>& targets) {
    std::vector<Request> requests;
    for (std::size_t n = 0; n < 3; ++n)
        requests.push_back(
            {small_grid().part({1, 1, static_cast<std::int64_t>(5 * n)}, {9, 8, 4}), small_band(), targets(n)});
    return requests;
}
constexpr std::size_t samples_of_request = 9 * 8 * 4;

constexpr std::size_t few_points = 20, some_points = 700;
constexpr double infinity = std::numeric_limits<double>::infinity();

Bytes query_of(const DistanceTransform& transform, std::size_t count) {
    std::vector<float> distance(count, 7);
    std::vector<std::uint32_t> triangle(count, 7);
    std::vector<Vec3> gradient(count);
    const std::vector<Vec3> asked = points_about(count);
    transform.query(asked, infinity,
                    {{Output::distance, distance}, {Output::triangle, triangle}, {Output::gradient, gradient}});
    return bytes_of_all(distance, triangle, gradient);
}

Bytes query_on_device(const DistanceTransform& transform, std::size_t count) {
    const cl::Buffer asked = on_device(points_about(count)), distance = on_device(std::vector<float>(count, 7));
    transform.query(InputArray(asked(), ElementType::float64, count), infinity, {{Output::distance, distance()}});
    return bytes_of_all(read_apart<float>(distance, count));
}

std::size_t many_points() {
    return mesh().triangles().size() + 5000;  // which processors scan
}

}  // namespace

const std::vector<Use>& uses() {
    static const std::vector<Use> all{
        use("compute",
            [](auto& used) {
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses).slab());
            }),
        use("compute with progress",
            [](auto& used) {
                const CallOptions watched{.progress = [](const Progress&) {}};
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses, watched).slab());
            }),
        use("compute with counted work",
            [](auto& used) {
                const CallOptions counted{.count_work = true};
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses, counted).slab());
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
                used.compute(small_grid(), small_band(), outputs_of_uses, [&](const Grid&, const FieldSlab& values) {
                    const Bytes more = bytes_of_field(values);
                    bytes.insert(bytes.end(), more.begin(), more.end());
                });
                return bytes;
            }),
        use("compute on the device",
            [](auto& used) {
                const std::size_t samples = small_grid().sample_count();
                const DeviceMemory memory = own([&] { return DeviceMemory(test_device().context(), samples); });
                used.compute(small_grid(), small_band(), {{Output::distance, memory.handle()}});
                return bytes_of_all(read_apart<float>(cl::Buffer(memory.handle(), true), samples));
            }),
        use("compute an open mesh",
            [](auto&) {
                static const Mesh open = without_triangle(mesh(), 100);
                return bytes_of_field(transform_of(open)->compute(small_grid(), small_band(), outputs_of_uses).slab());
            }),
        use("compute a sparse field",
            [](auto& used) {
                return bytes_of_sparse(used.compute_sparse(small_grid(), small_band(), outputs_of_uses));
            }),
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
                const std::vector<Vec3> asked = points_about(some_points);
                used.winding(asked, results);
                return bytes_of_all(results);
            }),
        use("classify",
            [](auto& used) {
                std::vector<Box> boxes;
                for (const Vec3& point : points_about(some_points))
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
                return bytes_of_field(restricted.compute(part, small_band(), outputs_of_uses).slab());
            }),
        use("set positions",
            [](auto& used) {
                used.compute(small_grid(), small_band());
                used.set_positions(scaled(mesh(), 1.01).vertices());
                return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses).slab());
            }),
        use("set positions on the device",
            [](auto& used) {
                const std::vector<Vec3> moved = scaled(mesh(), 1.01).vertices();
                const cl::Buffer positions = on_device(moved);
                used.compute(small_grid(), small_band());
                used.set_positions(InputArray(positions(), ElementType::float64, moved.size()));
                Bytes bytes = bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses).slab());
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
                 return bytes_of_field(used->compute(small_grid(), small_band(), outputs_of_uses).slab());
             };
         }},
        {"plan",
         [] {
             const auto memory =
                 own([] { return std::make_shared<DeviceMemory>(test_device().context(), 3 * samples_of_request); });
             const auto used = transform_of(mesh());
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
             const auto memory = own(
                 [] { return std::make_shared<DeviceMemory>(test_device().context(), small_grid().sample_count()); });
             const auto used = transform_of(mesh());
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
             const auto used = transform_of(mesh());
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
             const auto used = transform_of(mesh());
             const auto plan = std::make_shared<PointPlan>(used->plan_points(some_points, infinity));
             const cl::Buffer asked = on_device(points_about(some_points)),
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
             const auto used = transform_of(mesh());
             const auto plan = std::make_shared<PointPlan>(used->plan_points(some_points, infinity));
             const cl::Buffer asked = on_device(points_about(some_points)),
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

std::vector<std::uint64_t> chosen_faults(std::uint64_t count) {
    std::vector<std::uint64_t> numbers;
    unsigned part = 0, parts = 0;
    if (const char* const given = std::getenv("CLSDF_FAULT_PART")) {
        BOOST_REQUIRE((std::sscanf(given, "%u/%u", &part, &parts) == 2 && part < parts));
        for (std::uint64_t number = 1 + part; number <= count; number += parts) numbers.push_back(number);
        return numbers;
    }
    static std::mt19937_64 random = [] {
        const char* const given = std::getenv("CLSDF_FAULT_SEED");
        const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
        BOOST_TEST_MESSAGE("seed " << seed);
        return std::mt19937_64(seed);
    }();
    constexpr std::uint64_t wanted = 5;
    const std::uint64_t step = std::max<std::uint64_t>(count / wanted, 1);
    for (std::uint64_t begin = 1; begin <= count; begin += step)
        numbers.push_back(std::min(begin + random() % step, count));
    return numbers;
}

}  // namespace clsdf::test
