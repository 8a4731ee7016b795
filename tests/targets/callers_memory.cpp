#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

// The mesh, new positions, points and results lie in the caller's memory, on the host or on the device, in any layout;
// the bytes are the same.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Doubles before the positions, and what a vertex has beside its position.
constexpr std::size_t head = 4096;
struct Vertex {
    float weight = 7;
    std::array<float, 3> x{};
};
struct Face {
    std::array<std::uint64_t, 3> vertices{};
    double area = 7;
};

const cl::Context& context() {
    return device::context_of(test_device()).context();
}

cl::CommandQueue new_queue() {
    return {context(), device::context_of(test_device()).device()};
}

template <typename Value>
cl::Buffer buffer_of(const std::vector<Value>& values, cl_mem_flags flags = 0) {
    return {context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR | flags, values.size() * sizeof(Value),
            const_cast<Value*>(values.data())};  // which is only read
}

template <typename Value>
std::vector<Value> contents_of(const cl::Buffer& buffer) {
    std::vector<Value> values(buffer.getInfo<CL_MEM_SIZE>() / sizeof(Value));
    new_queue().enqueueReadBuffer(buffer, CL_TRUE, 0, values.size() * sizeof(Value), values.data());
    return values;
}

/// Coordinates that floats hold.
Mesh in_floats(const Mesh& mesh) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices)
        for (double& x : vertex) x = static_cast<double>(static_cast<float>(x));
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

std::vector<Vertex> vertices_of(const Mesh& mesh) {
    std::vector<Vertex> result;
    for (const Vec3& x : mesh.vertices())
        result.push_back({7, {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])}});
    return result;
}

InputArray positions_in(const cl::Buffer& vertices, std::size_t count) {
    InputArray positions(vertices(), ElementType::float32, count);
    positions.offset = offsetof(Vertex, x);
    positions.strides[0] = sizeof(Vertex);
    return positions;
}

std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count) {
    std::mt19937_64 generator(17);
    std::uniform_real_distribution<double> part(-0.1, 1.1);
    std::vector<Vec3> points(count);
    const Vec3 extent = mesh.box().extent();
    for (Vec3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = mesh.box().lower[axis] + part(generator) * extent[axis];
    return points;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_mesh_and_its_new_positions_may_be_memory_of_the_device) {
    const Mesh mesh = in_floats(make_shape("knot"));
    const std::size_t count = mesh.vertices().size();
    std::vector<Face> faces;
    for (const Triangle& t : mesh.triangles()) faces.push_back({{t[0], t[1], t[2]}, 7});
    const cl::Buffer vertex_buffer = buffer_of(vertices_of(mesh)), face_buffer = buffer_of(faces);
    InputArray triangles(face_buffer(), ElementType::uint64, faces.size());
    triangles.strides[0] = sizeof(Face);
    const MeshView view(positions_in(vertex_buffer, count), triangles);
    check_throws(ErrorCode::unsupported, {"memory of the device"}, [&] { Mesh{view}; });
    DistanceTransform transform(test_device(), view);
    DistanceTransform expected(test_device(), mesh);
    const Grid grid = grid_around(mesh, 40, 5);
    const Band band = Band::symmetric(3 * grid.voxel());
    const OutputSet outputs = Output::triangle | Output::gradient;
    BOOST_TEST(same_bytes(transform.compute(grid, band, outputs), expected.compute(grid, band, outputs)));

    // The positions are written when the event has ended, and not before.
    const Mesh moved = in_floats(tilted(mesh));
    const std::vector<Vertex> values = vertices_of(moved);
    cl::UserEvent begin(context());
    const std::vector<cl::Event> after_begin{begin};
    cl::Event written;
    const cl::CommandQueue queue = new_queue();
    queue.enqueueWriteBuffer(vertex_buffer, CL_FALSE, 0, values.size() * sizeof(Vertex), values.data(), &after_begin,
                             &written);
    queue.flush();
    std::thread starter([&] { begin.setStatus(CL_COMPLETE); });
    const cl_event handle = written();
    transform.set_positions(positions_in(vertex_buffer, count), {.wait_list = {&handle, 1}});
    starter.join();
    expected.set_positions(moved.vertices());
    BOOST_TEST(same_bytes(transform.compute(grid, band, outputs), expected.compute(grid, band, outputs)));

    // Doubles from an offset on; and floats of the host, all x before all y.
    std::vector<double> doubles(head, 7.0);
    for (const Vec3& x : mesh.vertices()) doubles.insert(doubles.end(), x.begin(), x.end());
    const cl::Buffer buffer = buffer_of(doubles);
    InputArray positions(buffer(), ElementType::float64, count);
    positions.offset = head * sizeof(double);
    transform.set_positions(positions);
    expected.set_positions(mesh.vertices());
    BOOST_TEST(same_bytes(transform.compute(grid, band, outputs), expected.compute(grid, band, outputs)));
    std::vector<float> planes;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const Vec3& x : moved.vertices()) planes.push_back(static_cast<float>(x[axis]));
    const auto width = static_cast<std::ptrdiff_t>(sizeof(float));
    transform.set_positions({planes.data(), count, width, width * static_cast<std::ptrdiff_t>(count)});
    expected.set_positions(moved.vertices());
    BOOST_TEST(same_bytes(transform.compute(grid, band, outputs), expected.compute(grid, band, outputs)));
}

BOOST_AUTO_TEST_CASE(positions_on_the_device_that_cannot_be_used_are_refused_and_the_mesh_stays) {
    const Mesh mesh = in_floats(make_shape("cube"));
    const std::size_t count = mesh.vertices().size();
    DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 20, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Field before = transform.compute(grid, band);
    std::vector<Vertex> vertices = vertices_of(mesh);
    const cl::Buffer buffer = buffer_of(vertices);
    InputArray positions = positions_in(buffer, count);
    const auto refused = [&](ErrorCode code, const std::vector<std::string>& words) {
        check_throws(code, words, [&] { transform.set_positions(positions); });
        BOOST_TEST(same_bytes(transform.compute(grid, band), before));
    };
    positions.offset += sizeof(Vertex);
    refused(ErrorCode::invalid_argument, {"positions", "memory holds " + std::to_string(count * sizeof(Vertex))});
    positions.offset = 2;
    refused(ErrorCode::invalid_argument, {"positions", "multiples", "4 bytes"});
    positions = positions_in(buffer, count);
    positions.strides[0] = 15;
    refused(ErrorCode::invalid_argument, {"positions", "15", "4 bytes"});
    positions = positions_in(buffer, count - 1);
    refused(ErrorCode::invalid_argument, {std::to_string(count - 1) + " positions"});
    positions = InputArray(buffer(), ElementType::uint32, count);
    refused(ErrorCode::invalid_argument, {"positions", "uint32", "floats or doubles"});
    const cl::Context other(device::context_of(test_device()).device());
    const cl::Buffer of_other(other, CL_MEM_READ_WRITE, count * sizeof(Vertex));
    positions = positions_in(of_other, count);
    refused(ErrorCode::invalid_argument, {"positions", "another OpenCL context"});
    const cl::Buffer hidden(context(), CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS, count * sizeof(Vertex));
    positions = positions_in(hidden, count);
    refused(ErrorCode::unsupported, {"positions", "CL_MEM_HOST_NO_ACCESS", "reads"});
    vertices[5].x[1] = std::numeric_limits<float>::quiet_NaN();
    const cl::Buffer spoilt = buffer_of(vertices);
    positions = positions_in(spoilt, count);
    refused(ErrorCode::invalid_mesh, {"vertex 5", "nan"});
}

// Particles in one buffer, with what is found beside where they are.
BOOST_AUTO_TEST_CASE(points_and_results_may_be_memory_of_the_device) {
    struct Particle {
        Vec3 position{};
        std::array<float, 3> normal{7, 7, 7};
        float distance = 7;
        std::uint32_t triangle = 7, kept = 7;
        double weight = 7;
    };
    const Mesh mesh = tilted(make_shape("knot"));
    const DistanceTransform transform(test_device(), mesh);
    for (const std::size_t count : {std::size_t{1}, std::size_t{1000}, std::size_t{20000}}) {
        const std::vector<Vec3> points = points_around(mesh, count);
        const Field expected = query(transform, points, 0.3);
        std::vector<Particle> particles(count);
        for (std::size_t i = 0; i < count; ++i) particles[i].position = points[i];
        const cl::Buffer buffer = buffer_of(particles);
        const auto target = [&](std::size_t offset, ElementType element) {
            OutputArray result(buffer(), element);
            result.offset = offset;
            result.strides[0] = sizeof(Particle);
            return result;
        };
        InputArray positions(buffer(), ElementType::float64, count);
        positions.strides[0] = sizeof(Particle);
        // The site goes to the host.
        std::vector<std::uint8_t> site(count);
        transform.query(positions, 0.3,
                        {{Output::distance, target(offsetof(Particle, distance), ElementType::float32)},
                         {Output::triangle, target(offsetof(Particle, triangle), ElementType::uint32)},
                         {Output::site, site},
                         {Output::gradient, target(offsetof(Particle, normal), ElementType::float32)}});
        const std::vector<Particle> found = contents_of<Particle>(buffer);
        BOOST_TEST(std::ranges::equal(site, expected.site()));
        for (std::size_t i = 0; i < count; ++i) {
            BOOST_REQUIRE(found[i].position == points[i]);
            BOOST_REQUIRE(found[i].distance == expected.distance()[i]);
            BOOST_REQUIRE(found[i].triangle == expected.triangle()[i]);
            BOOST_REQUIRE(std::memcmp(found[i].normal.data(), &expected.gradient()[3 * i], sizeof found[i].normal) ==
                          0);
            BOOST_REQUIRE(found[i].kept == 7U);
            BOOST_REQUIRE(found[i].weight == 7.0);
        }

        // Packed, in parts of one buffer, the points on the host.
        constexpr std::size_t room = std::size_t{1} << 20;
        const cl::Buffer whole(context(), CL_MEM_READ_WRITE, 2 * room);
        const cl_buffer_region second{room, room};
        cl::Buffer part = cl::Buffer(whole).createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &second);
        transform.query(points, 0.3,
                        {{Output::distance, OutputArray(whole())}, {Output::closest, OutputArray(part())}});
        const std::vector<std::byte> bytes = contents_of<std::byte>(whole);
        BOOST_TEST(std::memcmp(bytes.data(), expected.distance().data(), count * sizeof(float)) == 0);
        BOOST_TEST(std::memcmp(bytes.data() + room, expected.closest().data(), count * sizeof(Vec3)) == 0);

        // Points in floats are the doubles of the same value.
        std::vector<std::array<float, 3>> floats;
        std::vector<Vec3> rounded;
        for (const Vec3& p : points) {
            floats.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
            rounded.push_back({static_cast<double>(floats.back()[0]), static_cast<double>(floats.back()[1]),
                               static_cast<double>(floats.back()[2])});
        }
        std::vector<float> distance(count);
        const cl::Buffer float_buffer = buffer_of(floats);
        transform.query(InputArray(float_buffer(), ElementType::float32, count), 0.3, distance);
        BOOST_TEST(std::ranges::equal(distance, query(transform, rounded, 0.3).distance()));
    }
    const cl::Buffer empty(context(), CL_MEM_READ_WRITE, 16);
    transform.query(InputArray(empty(), ElementType::float64, 0), 1, {{Output::distance, OutputArray(empty())}});
}

// The device orders the points and writes the results; the host sees only a part of them.
BOOST_AUTO_TEST_CASE(all_points_and_results_in_buffers_have_the_bytes_of_the_host) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    struct Place {
        float weight = 7;
        std::array<float, 3> x{};
    };
    for (const Mesh& mesh : {tilted(make_shape("knot")), without_triangle(make_shape("knot"), 7), reversed(cube(1))}) {
        const DistanceTransform transform(
            test_device(), mesh,
            {.sign = mesh.triangles().size() % 2 == 1 ? SignRule::solid_angle : SignRule::automatic});
        for (const std::size_t count : {std::size_t{97}, std::size_t{3000}, std::size_t{20000}})
            for (const double half_width : {0.2, infinity})
                for (const bool are_marked : {false, true}) {
                    std::vector<Vec3> points = points_around(mesh, count);
                    points[5] = mesh.vertices()[1];
                    for (std::size_t i = 0; are_marked && i < count; i += 7)
                        points[i] = i % 2 == 0 ? Vec3{nan, 0, 0} : Vec3{0, 1e30, 0};
                    std::vector<Place> places(count);
                    for (std::size_t i = 0; i < count; ++i)
                        for (std::size_t axis = 0; axis < 3; ++axis) {
                            places[i].x[axis] = static_cast<float>(points[i][axis]);
                            points[i][axis] = static_cast<double>(places[i].x[axis]);
                        }
                    std::vector<std::string> expected_log, log;
                    std::vector<double> distance(count, 7);
                    std::vector<std::uint32_t> triangle(count, 7);
                    std::vector<std::uint8_t> site(count, 7);
                    std::vector<Vec3> closest(count);
                    std::vector<float> gradient(3 * count);
                    const auto into = [](std::vector<std::string>& lines) {
                        return [&lines](const std::string& line) { lines.push_back(line); };
                    };
                    transform.query(points, half_width,
                                    {{Output::distance, distance},
                                     {Output::triangle, triangle},
                                     {Output::site, site},
                                     {Output::closest, closest},
                                     {Output::gradient, gradient}},
                                    {.log = into(expected_log)});
                    const cl::Buffer doubles = buffer_of(points), floats = buffer_of(places);
                    InputArray packed(doubles(), ElementType::float64, count);
                    InputArray spread(floats(), ElementType::float32, count);
                    spread.offset = offsetof(Place, x);
                    spread.strides[0] = sizeof(Place);
                    for (const InputArray& from : {packed, spread}) {
                        const cl::Buffer d = buffer_of(std::vector<double>(count, 3)), t = buffer_of(triangle),
                                         s = buffer_of(std::vector<std::uint8_t>(count, 3)),
                                         c = buffer_of(std::vector<Vec3>(count)),
                                         g = buffer_of(std::vector<float>(3 * count));
                        log.clear();
                        const TransformStatistics statistics =
                            transform.query(from, half_width,
                                            {{Output::distance, OutputArray(d(), ElementType::float64)},
                                             {Output::triangle, OutputArray(t())},
                                             {Output::site, OutputArray(s())},
                                             {Output::closest, OutputArray(c())},
                                             {Output::gradient, OutputArray(g())}},
                                            {.log = into(log)});
                        const auto same = [](const auto& values, const cl::Buffer& buffer) {
                            using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
                            return std::memcmp(values.data(), contents_of<Value>(buffer).data(),
                                               values.size() * sizeof(Value)) == 0;
                        };
                        BOOST_TEST_CONTEXT(mesh.name() << ", " << count << " points, half width " << half_width
                                                       << ", marked: " << are_marked) {
                            BOOST_TEST(same(distance, d));
                            BOOST_TEST(same(triangle, t));
                            BOOST_TEST(same(site, s));
                            BOOST_TEST(same(closest, c));
                            BOOST_TEST(same(gradient, g));
                            BOOST_TEST((log == expected_log));
                            BOOST_TEST(statistics.unusable_points == (are_marked ? (count + 6) / 7 : 0U));
                        }
                    }
                }
    }
}

BOOST_AUTO_TEST_CASE(points_and_results_on_the_device_that_cannot_be_used_are_refused) {
    const Mesh mesh = make_shape("cube");
    const DistanceTransform transform(test_device(), mesh);
    std::vector<Vec3> points(5, {0.5, 0, 0});
    points[3][1] = std::numeric_limits<double>::quiet_NaN();
    const cl::Buffer buffer = buffer_of(points), distance(context(), CL_MEM_READ_WRITE, 5 * sizeof(float));
    const auto refused = [&](ErrorCode code, const InputArray& from, const OutputArray& to,
                             const std::vector<std::string>& words) {
        check_throws(code, words, [&] { transform.query(from, 1, to, {.refuse_unusable_points = true}); });
    };
    const InputArray all(buffer(), ElementType::float64, 5);
    refused(ErrorCode::invalid_argument, all, OutputArray(distance()), {"point 3", "nan"});
    refused(ErrorCode::invalid_argument, InputArray(buffer(), ElementType::float64, 6), OutputArray(distance()),
            {"6 points", "holds 120"});
    OutputArray late(distance());
    late.offset = 4;
    refused(ErrorCode::invalid_argument, all, late, {"output distance", "from byte 4 to 24", "holds 20"});
    const cl::Context other(device::context_of(test_device()).device());
    const cl::Buffer of_other(other, CL_MEM_READ_WRITE, 5 * sizeof(float));
    refused(ErrorCode::invalid_argument, all, OutputArray(of_other()), {"output distance", "another OpenCL context"});
    const cl::Buffer hidden(context(), CL_MEM_READ_WRITE | CL_MEM_HOST_READ_ONLY, 5 * sizeof(float));
    refused(ErrorCode::unsupported, all, OutputArray(hidden()), {"output distance", "CL_MEM_HOST_READ_ONLY", "writes"});
    refused(ErrorCode::invalid_argument, all, OutputArray(), {"distance has no target"});
}

BOOST_AUTO_TEST_CASE(a_mesh_without_triangles_on_the_device_is_refused_like_one_on_the_host) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const cl::Buffer buffer = buffer_of(vertices);
    const MeshView on_device(InputArray(buffer(), ElementType::float64, 3),
                             InputArray(buffer(), ElementType::uint32, 0));
    check_throws(ErrorCode::invalid_mesh, {"no triangle"}, [&] { DistanceTransform(test_device(), on_device); });
    check_throws(ErrorCode::invalid_mesh, {"no triangle"}, [&] { Mesh(MeshView(vertices, std::span<Triangle>())); });
}

BOOST_AUTO_TEST_CASE(no_points_need_no_memory) {
    const DistanceTransform transform(test_device(), make_shape("cube"));
    // All x before all y, of arrays of ten.
    std::vector<float> values(1);
    const auto none = std::span(values).first(0);
    OutputArray distance(none), gradient(none);
    gradient.strides = {sizeof(float), 0, 0};
    gradient.component_stride = 10 * sizeof(float);
    BOOST_CHECK_NO_THROW(transform.query(InputArray(static_cast<const double*>(nullptr), 0), 1,
                                         {{Output::distance, distance}, {Output::gradient, gradient}}));
}

// A view of a temporary container would dangle.
static_assert(!std::is_constructible_v<InputArray, std::vector<Vec3>>);
static_assert(!std::is_constructible_v<InputArray, const std::vector<Vec3>>);
static_assert(!std::is_constructible_v<InputArray, std::array<float, 6>>);
static_assert(!std::is_constructible_v<MeshView, std::vector<Vec3>&, std::vector<Triangle>>);
static_assert(!std::is_constructible_v<OutputArray, std::vector<float>>);
static_assert(std::is_constructible_v<InputArray, std::vector<Vec3>&>);
static_assert(std::is_constructible_v<InputArray, const std::vector<Vec3>&>);
static_assert(std::is_constructible_v<InputArray, std::span<const Vec3>>);
static_assert(std::is_constructible_v<InputArray, std::initializer_list<Vec3>>);
static_assert(std::is_constructible_v<MeshView, std::span<const float>, std::vector<Triangle>&>);
static_assert(std::is_constructible_v<OutputArray, std::vector<float>&>);
static_assert(std::is_constructible_v<OutputArray, std::span<double>>);

// A double is the value that a float is rounded from.
BOOST_AUTO_TEST_CASE(gradients_weights_and_offsets_in_double_round_to_those_in_float) {
    const Mesh mesh = tilted(make_shape("noisy"));
    const Grid grid = grid_around(mesh, 24, 4);
    const std::size_t count = grid.sample_count();
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        for (const bool is_on_device : {false, true}) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const Band band = Band::symmetric(3 * grid.voxel());
            const Field field = transform.compute(grid, band, Output::gradient | Output::barycentric | Output::offset);
            std::vector<float> distance(count);
            std::vector<double> gradient(3 * count), barycentric(2 * count), offset(3 * count);
            if (is_on_device) {
                const cl::Buffer distances = buffer_of(distance), gradients = buffer_of(gradient),
                                 weights = buffer_of(barycentric), offsets = buffer_of(offset);
                transform.compute(grid, band,
                                  {{Output::distance, OutputArray(distances())},
                                   {Output::gradient, OutputArray(gradients(), ElementType::float64)},
                                   {Output::barycentric, OutputArray(weights(), ElementType::float64)},
                                   {Output::offset, OutputArray(offsets(), ElementType::float64)}});
                gradient = contents_of<double>(gradients);
                barycentric = contents_of<double>(weights);
                offset = contents_of<double>(offsets);
            } else {
                transform.compute(grid, band,
                                  {{Output::distance, distance},
                                   {Output::gradient, gradient},
                                   {Output::barycentric, barycentric},
                                   {Output::offset, offset}});
            }
            std::size_t vectors = 0, finer = 0;
            const auto compare = [&](const std::vector<double>& doubles, const auto& floats) {
                BOOST_TEST_REQUIRE(doubles.size() == floats.size());
                for (std::size_t i = 0; i < doubles.size(); ++i) {
                    BOOST_REQUIRE(std::isnan(doubles[i]) == std::isnan(floats[i]));
                    if (std::isnan(doubles[i])) continue;
                    BOOST_REQUIRE(static_cast<float>(doubles[i]) == floats[i]);
                    ++vectors;
                    finer += doubles[i] != static_cast<double>(floats[i]) ? 1U : 0U;
                }
            };
            compare(gradient, field.gradient());
            compare(barycentric, field.barycentric());
            compare(offset, field.offset());
            BOOST_TEST(finer > vectors / 4);
            BOOST_TEST(vectors > 1000U);
        }
}
