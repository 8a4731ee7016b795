// Meshes and positions in memory of a GPU stay there until the host needs them, and give what those of the host give.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"
#include "disguise/disguise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

namespace {

/// The arrays of a mesh in memory of the device, of any types and with bytes between: the components of positions in a
/// row each, triangles of 64 bits backwards.
struct MeshOnDevice {
    explicit MeshOnDevice(const Mesh& mesh) {
        const std::size_t count = mesh.vertices().size(), faces = mesh.triangles().size();
        std::vector<float> rows(3 * count + 1);
        for (std::size_t v = 0; v < count; ++v)
            for (std::size_t axis = 0; axis < 3; ++axis)
                rows[1 + axis * count + v] = static_cast<float>(mesh.vertices()[v][axis]);
        std::vector<std::int64_t> words(5 * faces, -7);
        for (std::size_t t = 0; t < faces; ++t)
            std::ranges::copy(mesh.triangles()[t], words.begin() + static_cast<std::ptrdiff_t>(5 * (faces - 1 - t)));
        const cl::Context& context = device::context_of(test_device()).context();
        const auto copied = [&](const auto& values) {
            return cl::Buffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(values[0]),
                              const_cast<void*>(static_cast<const void*>(values.data())));
        };
        of_vertices = copied(rows);
        of_triangles = copied(words);
        vertices = {of_vertices(), ElementType::float32, count};
        vertices.offset = sizeof(float);
        vertices.component_stride = static_cast<std::ptrdiff_t>(count * sizeof(float));
        triangles = {of_triangles(), ElementType::int64, faces};
        triangles.offset = 5 * (faces - 1) * sizeof(std::int64_t);
        triangles.strides[0] = -5 * static_cast<std::ptrdiff_t>(sizeof(std::int64_t));
    }
    MeshView view() const { return {vertices, triangles}; }

    cl::Buffer of_vertices, of_triangles;
    InputArray vertices, triangles;
};

/// With positions that floats have.
Mesh in_floats(const Mesh& mesh) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices)
        for (double& x : vertex) x = static_cast<double>(static_cast<float>(x));
    return {std::move(vertices), mesh.triangles()};
}

bool are_same(const Field& a, const Field& b) {
    return std::ranges::equal(a.distance(), b.distance());
}

}  // namespace

BOOST_AUTO_TEST_CASE(positions_in_memory_of_the_device_do_not_come_to_the_host) {
    const Mesh moved = scaled(mesh(), 1.01);
    DistanceTransform transform(test_device(), mesh()), expected(test_device(), moved);
    transform.compute(grid(), band());
    std::vector<Vec3> numbers = moved.vertices();  // in every other place, after the first one
    std::vector<Vec3> places(2 * numbers.size() + 1, {-7, -7, -7});
    for (std::size_t i = 0; i < numbers.size(); ++i) places[2 * i + 1] = numbers[i];
    const device::Context& context = device::context_of(test_device());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, places.size() * sizeof(Vec3),
                            places.data());
    InputArray positions(memory(), ElementType::float64, numbers.size());
    positions.offset = sizeof(Vec3);
    positions.strides[0] = 2 * sizeof(Vec3);
    disguise::restart();
    transform.set_positions(positions);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.bytes_up == 0U);
    BOOST_TEST(counts.bytes_down <= 256U);
    BOOST_TEST(counts.blocking_waits <= 1U);
    BOOST_TEST(transform.box().upper[0] == moved.box().upper[0]);
    // The host reads them back when it needs them: for few points, say.
    BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
    const std::vector<Vec3> few{{0, 0, 0}, {1, 2, 3}, mesh().vertices()[5]};
    BOOST_TEST(are_same(query(transform, few), query(expected, few)));
    // The host finds positions that are not finite.
    context.queue().enqueueFillBuffer(memory, std::nan(""), 0, places.size() * sizeof(Vec3));
    check_throws(ErrorCode::invalid_mesh, {"is not finite"}, [&] { transform.set_positions(positions); });
    BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
}

BOOST_AUTO_TEST_CASE(points_take_the_faces_that_are_on_the_device) {
    const PointPlan tested = DistanceTransform(test_device(), mesh()).plan_points(10, 1e9);  // programs are tested
    DistanceTransform transform(test_device(), mesh());
    disguise::restart();
    const PointPlan plan = transform.plan_points(10, 1e9);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    const std::size_t of_tree_and_signs = 410;  // bytes a face; its vertices' numbers would be 12 more
    BOOST_TEST(counts.bytes_up <= of_tree_and_signs * mesh().triangles().size());
}

BOOST_AUTO_TEST_CASE(a_mesh_in_memory_of_the_device_does_not_come_to_the_host) {
    const Mesh first = in_floats(mesh()), second = in_floats(scaled(mesh(), 1.01));
    const MeshOnDevice of_first(first), of_second(second);
    const DeviceMemory field(test_device().context(), grid().sample_count());
    DistanceTransform(test_device(), first).compute(grid(), band(), field.handle());  // programs are built and tested
    const std::size_t of_lists = 112 * mesh().triangles().size() / 2 + 65536;

    disguise::restart();
    DistanceTransform transform(test_device(), of_first.view());
    transform.compute(grid(), band(), field.handle());
    disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.bytes_up <= 65536U);
    BOOST_TEST(counts.bytes_down <= of_lists);
    BOOST_TEST(counts.blocking_waits <= 5U);

    DistanceTransform expected(test_device(), first);
    BOOST_TEST((transform.box().lower == expected.box().lower && transform.box().upper == expected.box().upper));
    BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
    disguise::restart();
    transform.set_positions(of_second.vertices);
    transform.compute(grid(), band(), field.handle());
    counts = disguise::counts();
    BOOST_TEST(counts.bytes_up <= 65536U);
    BOOST_TEST(counts.bytes_down <= of_lists);
    expected.set_positions(second.vertices());
    BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));

    // The host reads it when it needs it: for outputs that name sites, for few points, for the first positions.
    const OutputSet sites = Output::triangle | Output::site;
    BOOST_TEST(std::ranges::equal(transform.compute(grid(), band(), sites).bytes(Output::triangle),
                                  expected.compute(grid(), band(), sites).bytes(Output::triangle)));
    const std::vector<Vec3> few{{0, 0, 0}, {1, 2, 3}, second.vertices()[5]};
    BOOST_TEST(are_same(query(transform, few), query(expected, few)));
    const std::array<Vec3, 3> turn{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
    transform.set_motion(turn, {0.5, 0, 0});
    expected.set_motion(turn, {0.5, 0, 0});
    BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
    BOOST_TEST(are_same(query(transform, few), query(expected, few)));
}

// Whatever is given up first.
BOOST_AUTO_TEST_CASE(a_mesh_in_memory_of_the_device_outlives_a_lack_of_memory) {
    const OutputSet outputs = Output::gradient | Output::triangle | Output::site;
    for (const bool is_soup : {false, true}) {
        const Mesh first = in_floats(is_soup ? unwelded(mesh()) : mesh()), second = in_floats(scaled(first, 1.01));
        const MeshOnDevice of_first(first), of_second(second);
        for (std::size_t bytes = 0; bytes <= 160; bytes += is_soup ? 40 : 8) {
            const TransformOptions options{.kept_bytes = bytes * first.triangles().size()};
            DistanceTransform transform(test_device(), of_first.view(), options), expected(test_device(), first);
            for (const bool moves : {false, true}) {
                if (moves) {
                    transform.set_positions(of_second.vertices);
                    expected.set_positions(second.vertices());
                }
                transform.compute(grid(), band());
                const Field field = transform.compute(grid(), band(), outputs),
                            of_host = expected.compute(grid(), band(), outputs);
                for (const Output output : {Output::distance, Output::gradient, Output::triangle, Output::site})
                    BOOST_TEST(std::ranges::equal(field.bytes(output), of_host.bytes(output)),
                               bytes << " bytes a triangle, output " << static_cast<int>(output)
                                     << (is_soup ? ", a soup" : ""));
            }
        }
    }
}

// Equal vertices count as one there, too, at first and when they move: neither arrays nor numbers come to the host.
BOOST_AUTO_TEST_CASE(a_soup_is_joined_and_moved_on_the_device) {
    const Mesh first = in_floats(unwelded(mesh())), second = in_floats(scaled(first, 1.01));
    const MeshOnDevice of_first(first), of_second(second);
    const DeviceMemory field(test_device().context(), grid().sample_count());
    const DistanceTransform welded(test_device(), weld(first));
    const Field of_welded = welded.compute(grid(), band());
    welded.compute(grid(), band(), field.handle());  // programs are built and tested
    const std::size_t of_lists = 112 * first.triangles().size() / 2 + 65536,
                      of_arrays = first.vertices().size() * sizeof(Vec3) + first.triangles().size() * sizeof(Triangle);
    const auto counts_of = [&](const auto& run) {
        disguise::restart();
        run();
        return disguise::counts();
    };

    std::optional<DistanceTransform> transform, of_host;
    disguise::Counts counts = counts_of([&] {
        transform.emplace(test_device(), of_first.view());
        transform->compute(grid(), band(), field.handle());
    });
    BOOST_TEST(counts.bytes_up <= 65536U);
    BOOST_TEST(counts.bytes_down <= of_lists);
    counts = counts_of([&] {
        of_host.emplace(test_device(), first);
        of_host->compute(grid(), band(), field.handle());
    });
    BOOST_TEST(counts.bytes_up <= of_arrays + 65536);
    BOOST_TEST(counts.bytes_down <= of_lists);
    BOOST_TEST(transform->topology().coincident_vertices == of_host->topology().coincident_vertices);
    BOOST_TEST(are_same(transform->compute(grid(), band()), of_welded));
    BOOST_TEST(are_same(of_host->compute(grid(), band()), of_welded));

    counts = counts_of([&] {
        transform->set_positions(of_second.vertices);
        transform->compute(grid(), band(), field.handle());
    });
    BOOST_TEST(counts.bytes_up <= 65536U);
    BOOST_TEST(counts.bytes_down <= of_lists);
    counts = counts_of([&] {
        of_host->set_positions(second.vertices());
        of_host->compute(grid(), band(), field.handle());
    });
    BOOST_TEST(counts.bytes_up <= of_arrays + 65536);
    BOOST_TEST(counts.bytes_down <= of_lists);
    DistanceTransform expected(test_device(), weld(second));
    const Field of_expected = expected.compute(grid(), band());
    BOOST_TEST(are_same(transform->compute(grid(), band()), of_expected));
    BOOST_TEST(are_same(of_host->compute(grid(), band()), of_expected));

    // The host reads and merges them when it needs them, at the first positions and at these.
    const std::vector<Vec3> few{{0, 0, 0}, {1, 2, 3}, second.vertices()[5]};
    for (DistanceTransform* const one : {&*transform, &*of_host}) {
        BOOST_TEST(are_same(query(*one, few), query(expected, few)));
        one->set_motion({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0});
        BOOST_TEST(are_same(one->compute(grid(), band()), of_welded));
        one->set_positions(second.vertices());
        BOOST_TEST(are_same(one->compute(grid(), band()), of_expected));
    }
}

// As on the host, which names them.
BOOST_AUTO_TEST_CASE(vertices_of_a_soup_on_the_device_that_move_apart_are_refused) {
    const Mesh soup = in_floats(unwelded(mesh()));
    const MeshOnDevice arrays(soup);
    DistanceTransform transform(test_device(), arrays.view());
    const Field before = transform.compute(grid(), band());
    std::vector<Vec3> apart = soup.vertices();
    apart.back()[1] += 0.01;
    const Mesh torn = in_floats(Mesh(apart, soup.triangles()));
    const auto refused = [&](const auto& move) {
        check_throws(ErrorCode::invalid_argument, {"had equal coordinates and count as one", "move apart"}, move);
        BOOST_TEST(are_same(transform.compute(grid(), band()), before));
    };
    refused([&] { transform.set_positions(torn.vertices()); });
    refused([&] { transform.set_positions(MeshOnDevice(torn).vertices); });
    // A vertex that no triangle uses may move as it likes, also if it is the first of those that are equal.
    std::vector<Vec3> with_unused{soup.vertices().front()};
    with_unused.insert(with_unused.end(), soup.vertices().begin(), soup.vertices().end());
    std::vector<Triangle> triangles = soup.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) ++index;
    const MeshOnDevice of_unused(Mesh(with_unused, triangles));
    DistanceTransform other(test_device(), of_unused.view());
    with_unused.front() = {7, 7, 7};
    other.set_positions(MeshOnDevice(Mesh(with_unused, triangles)).vertices);
    BOOST_TEST(are_same(other.compute(grid(), band()), before));
}

// Of these the host makes the topology, or says what is wrong.
BOOST_AUTO_TEST_CASE(any_mesh_in_memory_of_the_device_is_one_of_the_host) {
    const Mesh closed = in_floats(mesh());
    std::vector<Triangle> some = closed.triangles();
    some.resize(some.size() - 7);
    for (const Mesh& one : {unwelded(closed), Mesh(closed.vertices(), some), in_floats(make_shape("cube")),
                            unwelded(in_floats(make_shape("cube")))}) {
        const TransformOptions options{.sign = one.triangles().size() == some.size() ? SignRule::none
                                                                                     : SignRule::automatic};
        const MeshOnDevice arrays(one);
        DistanceTransform transform(test_device(), arrays.view(), options), expected(test_device(), one, options);
        BOOST_TEST(transform.topology().coincident_vertices == expected.topology().coincident_vertices);
        BOOST_TEST(transform.topology().open_edges == expected.topology().open_edges);
        BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
        const Mesh moved = in_floats(scaled(one, 0.99));
        transform.set_positions(MeshOnDevice(moved).vertices);
        expected.set_positions(moved.vertices());
        BOOST_TEST(are_same(transform.compute(grid(), band()), expected.compute(grid(), band())));
    }

    // An index of 2^32 and more, one out of range, a negative one; a position in use that is no number.
    const device::Context& context = device::context_of(test_device());
    const auto replaced = [&](const cl::Buffer& memory, std::size_t place, auto value) {
        context.queue().enqueueWriteBuffer(memory, CL_TRUE, place * sizeof value, sizeof value, &value);
    };
    for (const std::int64_t index : {std::int64_t{1} << 32, std::int64_t{1'000'000}, std::int64_t{-1}}) {
        const MeshOnDevice arrays(closed);
        replaced(arrays.of_triangles, 5 * (closed.triangles().size() - 1 - 9) + 1, index);
        check_throws(ErrorCode::invalid_mesh, {"triangle 9 has the vertex index"},
                     [&] { DistanceTransform(test_device(), arrays.view()); });
    }
    const MeshOnDevice arrays(closed);
    replaced(arrays.of_vertices, 1 + 5, std::numeric_limits<float>::infinity());
    check_throws(ErrorCode::invalid_mesh, {"vertex 5", "is not finite"},
                 [&] { DistanceTransform(test_device(), arrays.view()); });
}

BOOST_AUTO_TEST_CASE(bodies_that_part_are_described_anew) {
    const Mesh ball = make_shape("sphere3");
    const auto apart = [&](double distance) { return together({ball, shifted(ball, {distance, 0, 0})}, "two balls"); };
    BOOST_REQUIRE(apart(1).triangles().size() >= 1024U);
    DistanceTransform transform(test_device(), apart(1), {.surface = Surface::outer});
    BOOST_TEST(transform.topology().hidden_faces > 0U);
    for (const double distance : {3.0, 1.0, 4.0, 4.5}) {
        transform.set_positions(apart(distance).vertices());
        const DistanceTransform expected(test_device(), apart(distance), {.surface = Surface::outer});
        BOOST_TEST((transform.topology() == expected.topology()), distance);
    }
}

// Denormal floats too, which a device may take for zeros.
BOOST_AUTO_TEST_CASE(floats_of_all_sizes_are_the_doubles_of_the_host) {
    const Mesh small = in_floats(scaled(mesh(), 1e-40 / mesh().box().longest_side()));
    const MeshOnDevice arrays(small);
    const DistanceTransform transform(test_device(), arrays.view());
    BOOST_TEST(transform.box().lower[0] == small.box().lower[0]);
    BOOST_TEST(transform.box().upper[2] == small.box().upper[2]);
}
