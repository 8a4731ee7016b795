// Points of a body that moves in memory of a GPU: the results are those of the host, whatever kernels leave to it, and
// of meshes with ordinary edges nothing comes to the host.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"

#include "device/context.hpp"
#include "disguise/disguise.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

const device::Context& context() {
    return device::context_of(test_device());
}

template <typename Value>
cl::Buffer copied(const std::vector<Value>& values) {
    return {context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(Value),
            const_cast<Value*>(values.data())};  // which is only read
}

/// On vertices, beside them and around the mesh; on the first triangle, and in rows of the last vertices.
std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count, Random& random) {
    std::vector<Vec3> points(count);
    const Vec3 extent = mesh.box().extent();
    const auto [a, b, c] = mesh.triangles().front();
    for (std::size_t i = 0; i < count; ++i) {
        Vec3& p = points[i];
        const std::size_t vertices = mesh.vertices().size();
        p = mesh.vertices()[i % 5 == 4 ? vertices - 1 - random.index(40) : random.index(vertices)];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double around = mesh.box().lower[axis] + extent[axis] * random.uniform(-0.2, 1.2);
            if (i % 5 == 1) p[axis] += 0.02 * extent[axis] * random.uniform(-1, 1);
            if (i % 5 == 2 || (i % 5 == 4 && axis == 0)) p[axis] = around;
            if (i % 5 == 3)
                p[axis] = (mesh.vertices()[a][axis] + mesh.vertices()[b][axis] + mesh.vertices()[c][axis]) / 3 +
                          1e-3 * extent[axis] * random.uniform(-1, 1);
        }
    }
    return points;
}

struct Found {
    std::vector<float> distance, gradient;
    std::vector<std::uint32_t> triangle;

    explicit Found(std::size_t count) : distance(count, 7), gradient(3 * count, 7), triangle(count, 7) {}
};

/// By the host, which answers few points.
Found by_host(const DistanceTransform& transform, const std::vector<Vec3>& points) {
    Found found(points.size());
    constexpr std::size_t few = 96;
    for (std::size_t begin = 0; begin < points.size(); begin += few) {
        const std::size_t count = std::min(few, points.size() - begin);
        transform.query(std::span(points).subspan(begin, count), infinity,
                        {{Output::distance, std::span(found.distance).subspan(begin, count)},
                         {Output::gradient, std::span(found.gradient).subspan(3 * begin, 3 * count)},
                         {Output::triangle, std::span(found.triangle).subspan(begin, count)}});
    }
    return found;
}

/// A run of a plan; the gradient if the plan has one.
Found by_plan(PointPlan& plan, const std::vector<Vec3>& points) {
    Found found(points.size());
    const cl::Buffer from = copied(points), distance = copied(found.distance), gradient = copied(found.gradient),
                     triangle = copied(found.triangle);
    OutputTargets targets{{Output::distance, OutputArray(distance())}, {Output::triangle, OutputArray(triangle())}};
    if (plan.outputs().contains(Output::gradient)) targets[Output::gradient] = OutputArray(gradient());
    cl_event done = nullptr;
    plan.enqueue(nullptr, InputArray(from(), ElementType::float64, points.size()), targets, {}, &done);
    cl::Event(done).wait();
    found.distance = read<float>(context(), distance, found.distance.size());
    found.gradient = read<float>(context(), gradient, found.gradient.size());
    found.triangle = read<std::uint32_t>(context(), triangle, found.triangle.size());
    return found;
}

/// The bytes, also of what is not a number.
template <typename Value>
bool are_same(const std::vector<Value>& values, const std::vector<Value>& others) {
    return std::memcmp(values.data(), others.data(), values.size() * sizeof(Value)) == 0;
}

/// Bent, and so stretched that the tree's boxes become more than twice as large by step 2.
std::vector<Vec3> at_step(const Mesh& mesh, int step) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& p : vertices) {
        const double x = p[0], z = p[2];
        p[1] += 0.05 * step * (x * x + z);
        if (step == 2) p[2] += 2 * std::sin(7 * (x + p[1]));
    }
    return vertices;
}

struct Body {
    Mesh mesh;
    SignRule sign = SignRule::automatic;
    std::optional<double> floor{};
};

/// A terrain of 1,152 triangles.
Mesh terrain() {
    constexpr std::uint32_t side = 24;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t j = 0; j <= side; ++j)
        for (std::uint32_t i = 0; i <= side; ++i)
            vertices.push_back({i / 12.0 - 1, j / 12.0 - 1, 0.25 * std::sin(0.5 * i) * std::cos(0.4 * j)});
    for (std::uint32_t j = 0; j < side; ++j)
        for (std::uint32_t i = 0; i < side; ++i) {
            const std::uint32_t a = j * (side + 1) + i, b = a + 1, c = a + side + 1, d = c + 1;
            triangles.push_back({a, b, d});
            triangles.push_back({a, d, c});
        }
    return {std::move(vertices), std::move(triangles), "terrain"};
}

/// The last corners of 40 triangles are vertices of their own, which are joined for the sign.
Mesh cracked() {
    std::vector<Vec3> vertices = mesh().vertices();
    std::vector<Triangle> triangles = mesh().triangles();
    for (std::size_t i = 0; i < 40; ++i) {
        Triangle& triangle = triangles[i * triangles.size() / 40];
        Vec3 beside = vertices[triangle[2]];
        beside[1] += 0x1p-48 * mesh().box().longest_side();
        triangle[2] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(beside);
    }
    return {std::move(vertices), std::move(triangles), "cracked"};
}

/// The first triangle is there three times.
Mesh with_copies() {
    std::vector<Triangle> triangles = mesh().triangles();
    triangles.insert(triangles.end(), 2, triangles.front());
    return {mesh().vertices(), std::move(triangles), "with copies"};
}

Mesh open_knot() {
    std::vector<Triangle> triangles = mesh().triangles();
    triangles.resize(triangles.size() - 100);
    return {mesh().vertices(), std::move(triangles), "open knot"};
}

std::vector<Body> bodies() {
    const Mesh segment({{0, 0, 0}, {1, 1, 1}}, {{0, 1, 1}}, "segment");
    return {{mesh()},
            {reversed(mesh()), SignRule::parity},
            {together({mesh(), shifted(cube(1), {0.3, 0, 0})}, "two that overlap"), SignRule::nonzero},
            {unwelded(mesh())},
            {together({mesh(), segment}, "with a segment"), SignRule::none},
            {with_copies(), SignRule::none},
            {cracked()},
            {open_knot(), SignRule::none},
            {open_knot(), SignRule::solid_angle},
            {round_mesh(24, 1, {0, 0, 0}, true, "half a sphere"), SignRule::solid_angle},
            {terrain(), SignRule::below, -20.0},
            {round_mesh(24, 1, {0, 0, 0}, true, "hill"), SignRule::below, -20.0}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(points_of_a_body_that_moves_on_the_device_are_those_of_the_host) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Body& body : bodies())
        for (const std::optional<std::size_t> kept_bytes :
             {std::optional<std::size_t>(), std::optional<std::size_t>(0)}) {
            TransformOptions options{.sign = body.sign, .floor = body.floor};
            options.kept_bytes = kept_bytes;
            DistanceTransform transform(test_device(), body.mesh, options),
                expected(test_device(), body.mesh, {.sign = body.sign, .floor = body.floor});
            constexpr std::size_t count = 400;
            PointPlan distances = transform.plan_points(count, infinity, Output::triangle),
                      gradients = transform.plan_points(count, infinity, Output::triangle | Output::gradient);
            for (int step = 0; step < 4; ++step) {
                const Mesh moved(at_step(body.mesh, step), body.mesh.triangles());
                const cl::Buffer positions = copied(moved.vertices());
                transform.set_positions(InputArray(positions(), ElementType::float64, moved.vertices().size()));
                expected.set_positions(moved.vertices());
                distances.update(transform);
                const std::vector<Vec3> points = points_around(moved, count, random);
                const Found of_host = by_host(expected, points), of_distances = by_plan(distances, points);
                BOOST_TEST_CONTEXT(body.mesh.name() << ", step " << step << ", seed " << seed
                                                    << (kept_bytes ? ", nothing is kept" : "")) {
                    BOOST_TEST(are_same(of_distances.distance, of_host.distance));
                    BOOST_TEST(are_same(of_distances.triangle, of_host.triangle));
                    gradients.update(transform);
                    const Found of_gradients = by_plan(gradients, points);
                    BOOST_TEST(are_same(of_gradients.distance, of_host.distance));
                    BOOST_TEST(are_same(of_gradients.triangle, of_host.triangle));
                    BOOST_TEST(are_same(of_gradients.gradient, of_host.gradient));
                }
            }
        }
}

// Also of an open mesh without a sign: nothing but numbers that the host waits for.
BOOST_AUTO_TEST_CASE(a_step_of_points_leaves_mesh_and_positions_on_the_device) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Body& body : {Body{mesh()}, Body{unwelded(mesh())}, Body{open_knot(), SignRule::none}}) {
        DistanceTransform transform(test_device(), body.mesh, {.sign = body.sign});
        constexpr std::size_t count = 400;
        PointPlan plan = transform.plan_points(count, infinity);
        disguise::Counts counts;
        for (int step = 0; step < 2; ++step) {
            std::vector<Vec3> moved = body.mesh.vertices();
            for (Vec3& p : moved) p[0] += 0.1 * step;
            const cl::Buffer positions = copied(moved);
            disguise::restart();
            transform.set_positions(InputArray(positions(), ElementType::float64, moved.size()));
            plan.update(transform);
            counts = disguise::counts();
        }
        BOOST_TEST_CONTEXT(body.mesh.name() << ": " << disguise::to_json(counts)) {
            BOOST_TEST(counts.bytes_up == 0U);
            BOOST_TEST(counts.bytes_down <= 256U);
            BOOST_TEST(counts.blocking_waits <= 3U);
        }
    }
}
