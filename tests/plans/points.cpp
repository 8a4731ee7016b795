#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
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
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

// Plans of points: what they enqueue has the bytes of a query.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

const device::Context& context() {
    return device::context_of(test_device());
}

template <typename Value>
cl::Buffer buffer_of(const std::vector<Value>& values, cl_mem_flags flags = CL_MEM_READ_WRITE) {
    return {context().context(), CL_MEM_COPY_HOST_PTR | flags, values.size() * sizeof(Value),
            const_cast<Value*>(values.data())};  // which is only read
}

/// Of every output.
constexpr OutputSet every_one = {Output::distance, Output::triangle,    Output::site,  Output::closest,
                                 Output::gradient, Output::barycentric, Output::offset};

/// A point and its results, as a program keeps them.
struct Particle {
    Vec3 position{};
    std::array<double, 3> gradient{7, 7, 7};
    Vec3 closest{7, 7, 7};
    std::array<float, 3> offset{7, 7, 7};
    std::array<float, 2> barycentric{7, 7};
    std::uint32_t triangle = 7;
    float distance = 7;
    std::uint8_t site = 7, status = 7;
    std::array<std::uint8_t, 2> other{7, 7};
};
static_assert(sizeof(Particle) == 104);

OutputTargets targets_in(const Particle* first, cl_mem memory) {
    OutputTargets targets;
    const auto add = [&](Output output, ElementType type, std::size_t offset) {
        OutputArray& array = targets[output];
        if (memory != nullptr)
            array = OutputArray(memory, type);
        else
            array.host = const_cast<Particle*>(first);
        array.type = type;
        array.offset = offset;
        array.strides[0] = sizeof(Particle);
    };
    add(Output::distance, ElementType::float32, offsetof(Particle, distance));
    add(Output::triangle, ElementType::uint32, offsetof(Particle, triangle));
    add(Output::site, ElementType::uint8, offsetof(Particle, site));
    add(Output::closest, ElementType::float64, offsetof(Particle, closest));
    add(Output::gradient, ElementType::float64, offsetof(Particle, gradient));
    add(Output::barycentric, ElementType::float32, offsetof(Particle, barycentric));
    add(Output::offset, ElementType::float32, offsetof(Particle, offset));
    return targets;
}

/// Points on vertices, edges and faces, around the mesh, far away and near zero.
std::vector<Vec3> hard_points(const Mesh& mesh, std::size_t count) {
    constexpr std::uint64_t seed = 17;
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> part(-0.1, 1.1), share(0, 1);
    std::vector<Vec3> points(count);
    const Vec3 extent = mesh.box().extent();
    const auto corner = [&](const Triangle& t, std::size_t k) { return mesh.vertices()[t[k]]; };
    for (std::size_t i = 0; i < count; ++i) {
        const Triangle& t = mesh.triangles()[generator() % mesh.triangles().size()];
        const double u = share(generator), v = share(generator) * (1 - u);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double a = corner(t, 0)[axis], b = corner(t, 1)[axis], c = corner(t, 2)[axis];
            double& x = points[i][axis];
            switch (i % 8) {
                case 0:
                    x = a;
                    break;
                case 1:
                    x = (a + b) / 2;
                    break;
                case 2:
                    x = a * (1 - u - v) + b * u + c * v;
                    break;
                case 3:  // beside a face
                    x = (a + b + c) / 3 * (1 + 1e-13);
                    break;
                case 4:
                    x = 1e6 * (share(generator) - 0.5) * (extent[axis] + 1);
                    break;
                case 5:  // in the rows of vertices
                    x = axis == 0 ? mesh.box().lower[0] + part(generator) * extent[0] : a;
                    break;
                default:
                    x = mesh.box().lower[axis] + part(generator) * extent[axis];
            }
        }
    }
    return points;
}

/// The particles as a query of the host gives them.
std::vector<Particle> expected_particles(const DistanceTransform& transform, const std::vector<Vec3>& points,
                                         double half_width) {
    std::vector<Particle> particles(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) particles[i].position = points[i];
    transform.query(points, half_width, targets_in(particles.data(), nullptr));
    return particles;
}

OutputArray status_in(cl_mem memory) {
    OutputArray status(memory, ElementType::uint8);
    status.offset = offsetof(Particle, status);
    status.strides[0] = sizeof(Particle);
    return status;
}

InputArray positions_in(cl_mem memory, std::size_t count) {
    InputArray positions(memory, ElementType::float64, count);
    positions.strides[0] = sizeof(Particle);
    return positions;
}

/// One run, from and to particles.
std::vector<Particle> run(PointPlan& plan, const std::vector<Vec3>& points) {
    std::vector<Particle> particles(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) particles[i].position = points[i];
    const cl::Buffer memory = buffer_of(particles);
    cl_event done = nullptr;
    plan.enqueue(nullptr, positions_in(memory(), points.size()), targets_in(nullptr, memory()), {}, &done,
                 status_in(memory()));
    cl::Event(done).wait();
    return read<Particle>(context(), memory, points.size());
}

/// Compares the bytes, but of the status.
void check_same(std::vector<Particle> found, const std::vector<Particle>& expected) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        found[i].status = 7;
        if (std::memcmp(&found[i], &expected[i], sizeof(Particle)) == 0) continue;
        if (different++ > 0) continue;
        const Vec3& p = found[i].position;
        BOOST_TEST_MESSAGE("point " << i << " at " << p[0] << ", " << p[1] << ", " << p[2] << ": " << found[i].distance
                                    << " of triangle " << found[i].triangle << " in place of " << expected[i].distance
                                    << " of " << expected[i].triangle);
    }
    BOOST_TEST(different == 0U);
}

Mesh flat_square() {
    return {std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}},
            "square"};
}

Mesh hill() {
    return {std::vector<Vec3>{{0, 0, 0}, {1, 0, 0.125}, {1.5, 1, 0}, {0, 1, 0.25}, {0.5, 0.5, 0.75}},
            std::vector<Triangle>{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, "hill"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_run_has_the_bytes_of_a_query) {
    struct Case {
        Mesh mesh;
        SignRule sign;
        std::optional<double> floor{};
    };
    const std::vector<Case> cases{{tilted(make_shape("knot")), SignRule::automatic},
                                  {cube(1), SignRule::automatic},
                                  {reversed(cube(1)), SignRule::parity},
                                  {without_triangle(make_shape("knot"), 7), SignRule::solid_angle},
                                  {make_shape("noisy"), SignRule::none},
                                  {flat_square(), SignRule::none},
                                  {hill(), SignRule::below, -0.5}};
    for (const Case& tested : cases)
        for (const KernelBody body : {KernelBody::automatic, KernelBody::by_group}) {
            const DistanceTransform transform(test_device(), tested.mesh,
                                              {.sign = tested.sign, .body = body, .floor = tested.floor});
            for (const double half_width : {0.2, infinity}) {
                if (body == KernelBody::by_group && half_width == infinity) continue;
                PointPlan plan = transform.plan_points(16384, half_width, every_one);
                for (const std::size_t count : {std::size_t{1}, std::size_t{96}, std::size_t{97}, std::size_t{16384}}) {
                    const std::vector<Vec3> points = hard_points(tested.mesh, count);
                    BOOST_TEST_CONTEXT(tested.mesh.name() << ", " << count << " points, half width " << half_width
                                                          << ", body " << static_cast<int>(body)) {
                        const std::vector<Particle> found = run(plan, points);
                        check_same(found, expected_particles(transform, points, half_width));
                        BOOST_TEST(std::ranges::all_of(found, [](const Particle& p) { return p.status == 0; }));
                    }
                }
            }
        }
}

BOOST_AUTO_TEST_CASE(points_without_a_distance_have_a_status) {
    const Mesh mesh = tilted(make_shape("knot"));
    const DistanceTransform transform(test_device(), mesh);
    std::vector<Vec3> points = hard_points(mesh, 500);
    points[3] = {not_a_number, 0, 0};
    points[4] = {0, -infinity, 0};
    points[499] = {0, 1e30, 0};
    for (const double half_width : {0.2, infinity}) {
        PointPlan plan = transform.plan_points(points.size(), half_width, every_one);
        const std::vector<Particle> found = run(plan, points);
        check_same(found, expected_particles(transform, points, half_width));
        for (std::size_t i = 0; i < points.size(); ++i) {
            const PointStatus expected = i == 3 || i == 4 ? PointStatus::not_finite
                                         : i == 499       ? PointStatus::too_far
                                                          : PointStatus::found;
            BOOST_REQUIRE(static_cast<PointStatus>(found[i].status) == expected);
        }
    }
}

// Products of such coordinates underflow.
BOOST_AUTO_TEST_CASE(points_with_tiny_coordinates_have_the_bytes_of_a_query_or_an_open_sign) {
    const Mesh mesh = cube(1);
    const DistanceTransform transform(test_device(), mesh);
    const auto look_up = [&](const std::vector<Vec3>& points) {
        PointPlan plan = transform.plan_points(points.size(), infinity, every_one);
        return std::pair(run(plan, points), expected_particles(transform, points, infinity));
    };
    std::vector<Vec3> points;
    for (const double tiny : {5e-324, 1e-310, -1e-310, -1e-300, 1e-200, -1e-60, 0.0})
        for (const double x : {0.0, 0.5, -1.0, 1.5})
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Vec3 p{tiny, tiny, tiny};
                p[axis] = x;
                points.push_back(p);
                p[(axis + 1) % 3] *= 3;
                points.push_back(p);
                p[(axis + 1) % 3] = 0.25;
                points.push_back(p);
            }
    const auto& [found, expected] = look_up(points);
    check_same(found, expected);
    BOOST_TEST(std::ranges::all_of(found, [](const Particle& p) { return p.status == 0; }));

    // Not of one size: in the corners of faces, whose sides tell nothing, the sign is open.
    const auto& [open, known] = look_up({{1 - 1e-9, 1e-30, 1e-320}, {0.5, 1e-30, 1e-320}});
    BOOST_TEST(std::ranges::any_of(
        open, [](const Particle& p) { return static_cast<PointStatus>(p.status) == PointStatus::sign_open; }));
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (static_cast<PointStatus>(open[i].status) != PointStatus::sign_open) {
            check_same({open[i]}, {known[i]});
            continue;
        }
        BOOST_TEST(std::isnan(open[i].distance));
        BOOST_TEST(open[i].triangle == no_triangle);
    }
}

BOOST_AUTO_TEST_CASE(runs_follow_one_another_on_any_queue_and_the_plan_follows_the_mesh) {
    const Mesh mesh = make_shape("knot");
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh);
    const std::vector<Vec3> points = hard_points(mesh, 3000);
    const std::size_t count = points.size();
    PointPlan plan = transform->plan_points(count, infinity, Output::triangle);
    BOOST_TEST(plan.count() == count);
    BOOST_TEST((plan.outputs() == (Output::distance | Output::triangle)));
    BOOST_TEST(plan.statistics().device_bytes > 80 * count);
    std::vector<Vec3> moved = mesh.vertices();
    for (Vec3& x : moved) x[1] *= 1.5;
    const cl::Buffer from = buffer_of(points);
    const InputArray positions(from(), ElementType::float64, count);
    const auto check = [&](const DistanceTransform& at) {
        std::vector<float> distance(count);
        std::vector<std::uint32_t> triangle(count);
        at.query(points, infinity, {{Output::distance, distance}, {Output::triangle, triangle}});
        const cl::CommandQueue queue(context().context(), context().device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
        std::array<cl::Buffer, 2> distances, triangles;
        cl::Event first, last;
        for (std::size_t n = 0; n < 2; ++n) {
            distances[n] = buffer_of(std::vector<float>(count, 7));
            triangles[n] = buffer_of(std::vector<std::uint32_t>(count, 7));
            const OutputTargets targets{{Output::distance, OutputArray(distances[n]())},
                                        {Output::triangle, OutputArray(triangles[n]())}};
            cl_event done = nullptr;
            const std::vector<cl_event> wait_list = n == 0 ? std::vector<cl_event>() : std::vector<cl_event>{first()};
            plan.enqueue(queue(), positions, targets, wait_list, &done);
            (n == 0 ? first : last) = cl::Event(done);
        }
        last.wait();
        for (std::size_t n = 0; n < 2; ++n) {
            BOOST_TEST((read<float>(context(), distances[n], count) == distance));
            BOOST_TEST((read<std::uint32_t>(context(), triangles[n], count) == triangle));
        }
    };
    check(*transform);
    const DistanceTransform as_before(test_device(), mesh);
    transform->set_positions(moved);
    check(as_before);  // a plan keeps its positions
    CallOptions stopped;
    stopped.should_stop = [] { return true; };
    check_throws(ErrorCode::cancelled, {}, [&] { plan.update(*transform, stopped); });
    check_throws(ErrorCode::unsupported, {"restricted"}, [&] {
        plan.update(transform->restrict_to({{{-2, -2, -2}, {2, 2, 2}}, 1, 0}));
    });
    check(as_before);  // also if an update fails
    plan.update(*transform);
    check(*transform);
    DistanceTransform again = std::move(*transform);
    transform.reset();
    check(again);
    PointPlan other = std::move(plan);
    check_throws(ErrorCode::invalid_argument, {"PointPlan", "moved from"}, [&] { plan.count(); });
    plan = std::move(other);
    check(again);
    plan.update(DistanceTransform(test_device(), mesh, {.body = KernelBody::by_group}));
    check(as_before);
    // No points need no memory.
    cl_event done = nullptr;
    plan.enqueue(nullptr, InputArray(nullptr, ElementType::float64, 0), {}, {}, &done);
    cl::Event(done).wait();
}

// More than are computed at once.
BOOST_AUTO_TEST_CASE(points_of_several_batches_have_the_bytes_of_a_query) {
    const Mesh mesh = cube(1);
    const DistanceTransform transform(test_device(), mesh);
    const std::size_t count = (std::size_t{1} << 20) + 1000;
    const std::vector<Vec3> few = hard_points(mesh, 1000);
    std::vector<std::array<float, 3>> points(count);
    std::vector<float> expected(count), of_few(few.size());
    std::vector<Vec3> rounded(few.size());
    for (std::size_t i = 0; i < few.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            rounded[i][axis] = static_cast<double>(static_cast<float>(few[i][axis]));
    transform.query(rounded, 0.5, of_few);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) points[i][axis] = static_cast<float>(few[i % few.size()][axis]);
        expected[i] = of_few[i % few.size()];
    }
    PointPlan plan = transform.plan_points(count, 0.5);
    const cl::Buffer from = buffer_of(points);
    for (const std::ptrdiff_t stride : {std::ptrdiff_t{0}, std::ptrdiff_t{8}}) {
        const std::size_t step = stride == 0 ? 1 : 2;
        const cl::Buffer to = buffer_of(std::vector<float>(step * count, 7));
        const cl::Buffer status = buffer_of(std::vector<std::uint8_t>(count, 7));
        OutputArray distance(to());
        distance.strides[0] = stride;
        cl_event done = nullptr;
        plan.enqueue(nullptr, InputArray(from(), ElementType::float32, count), distance, {}, &done,
                     OutputArray(status()));
        cl::Event(done).wait();
        const std::vector<float> found = read<float>(context(), to, step * count);
        bool is_same = true;
        for (std::size_t i = 0; i < count; ++i)
            is_same = is_same && std::memcmp(&found[step * i], &expected[i], sizeof(float)) == 0;
        BOOST_TEST(is_same);
        BOOST_TEST((read<std::uint8_t>(context(), status, count) == std::vector<std::uint8_t>(count, 0)));
    }
}

BOOST_AUTO_TEST_CASE(what_a_plan_of_points_cannot_do_is_refused) {
    const Mesh mesh = make_shape("cube");
    const DistanceTransform transform(test_device(), mesh);
    const auto refused_plan = [&](const DistanceTransform& of, ErrorCode code, const std::vector<std::string>& words,
                                  std::size_t count, double half_width) {
        check_throws(code, words, [&] { (void)of.plan_points(count, half_width); });
    };
    refused_plan(transform, ErrorCode::invalid_argument, {"takes 0 points"}, 0, 1);
    refused_plan(transform, ErrorCode::invalid_argument, {"half width -1", "0 or more"}, 10, -1);
    refused_plan(transform, ErrorCode::invalid_argument, {"half width nan"}, 10, not_a_number);
    std::vector<Vec3> vertices = mesh.vertices();
    vertices[0][0] += 1e-300;
    if (vertices[0][0] != 1e-300) vertices[0][0] = 1e-300;
    refused_plan(DistanceTransform(test_device(), Mesh(vertices, mesh.triangles(), "thin cube")),
                 ErrorCode::invalid_argument, {"thin cube", "2^-300", "query()"}, 10, 1);
    refused_plan(transform.restrict_to({{{-2, -2, -2}, {2, 2, 2}}, 1, 0}), ErrorCode::unsupported,
                 {"restricted", "whole transform"}, 10, 1);

    PointPlan plan = transform.plan_points(5, infinity);
    const std::vector<Vec3> points(6, {0.5, 0, 0});
    const cl::Buffer from = buffer_of(points), to(context().context(), CL_MEM_READ_WRITE, 6 * sizeof(float));
    const InputArray all(from(), ElementType::float64, 5);
    const auto refused = [&](ErrorCode code, const std::vector<std::string>& words, const InputArray& given,
                             const OutputTargets& targets, const OutputArray& status = {}) {
        check_throws(code, words, [&] { plan.enqueue(nullptr, given, targets, {}, nullptr, status); });
    };
    refused(ErrorCode::invalid_argument, {"at most 5 points", "6 are given"},
            InputArray(from(), ElementType::float64, 6), to());
    refused(ErrorCode::unsupported, {"points are memory of the host", "query()"}, std::span(points).first(5), to());
    std::vector<float> host(5);
    refused(ErrorCode::unsupported, {"output distance", "memory of the host"}, all, host);
    refused(ErrorCode::invalid_argument, {"gradient", "plan was made without"}, all,
            {{Output::distance, OutputArray(to())}, {Output::gradient, OutputArray(to())}});
    refused(ErrorCode::invalid_argument, {"distance has no target"}, all, OutputTargets());
    OutputArray late(to());
    late.offset = 8;
    refused(ErrorCode::invalid_argument, {"output distance", "holds 24 bytes"}, all, late);
    refused(ErrorCode::invalid_argument, {"output distance", "the points", "lie on the same bytes"}, all, from());
    refused(ErrorCode::invalid_argument, {"output distance", "the status of points", "lie on the same bytes"}, all,
            to(), OutputArray(to()));
    refused(ErrorCode::unsupported, {"status", "float"}, all, to(), OutputArray(to(), ElementType::float32));
    const cl::Buffer read_only(context().context(), CL_MEM_READ_ONLY, 24),
        write_only(context().context(), CL_MEM_WRITE_ONLY, 200);
    refused(ErrorCode::invalid_argument, {"status", "CL_MEM_READ_ONLY"}, all, to(), OutputArray(read_only()));
    refused(ErrorCode::invalid_argument, {"output distance", "CL_MEM_READ_ONLY"}, all, read_only());
    refused(ErrorCode::invalid_argument, {"points", "CL_MEM_WRITE_ONLY"},
            InputArray(write_only(), ElementType::float64, 5), to());
    const cl::Context other(context().device());
    const cl::Buffer of_other(other, CL_MEM_READ_WRITE, 200);
    refused(ErrorCode::invalid_argument, {"points", "another OpenCL context"},
            InputArray(of_other(), ElementType::float64, 5), to());
    refused(ErrorCode::invalid_argument, {"output distance", "another OpenCL context"}, all, of_other());
    cl_event done = nullptr;
    plan.enqueue(nullptr, all, to(), {}, &done);
    cl::Event(done).wait();
    std::vector<float> expected(5);
    transform.query(std::span(points).first(5), infinity, expected);
    BOOST_TEST((read<float>(context(), to, 5) == expected));
}
