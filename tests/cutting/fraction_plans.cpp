// Fractions of cells by kernels have the bytes of the host's, in memory of the device.

#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include "core/vectors.hpp"
#include "device/opencl.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fraction_plan.hpp>
#include <clsdf/fractions.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

const device::Context& context() {
    return device::context_of(test_device());
}

std::size_t cells_of(const Grid& grid) {
    const auto [nx, ny, nz] = Fractions{grid, {}, {}}.counts();
    return nx * ny * nz;
}

/// Buffers for all members of rows, and a row more than may be written.
struct Buffers {
    Buffers(std::size_t room_in, const Grid& grid)
        : room(room_in), cell_count(cells_of(grid)), full(filled(cell_count)) {}

    static cl::Buffer filled(std::size_t bytes) {
        std::vector<std::uint8_t> values(bytes, 77);
        return {context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes, values.data()};
    }

    FractionRows rows() const {
        FractionRows to;
        to.room = room;
        to.cells = {cells(), ElementType::int32};
        to.pieces = {pieces(), ElementType::uint32};
        // Doubles beside each other: volume, area, centroid, vector area, ...
        const auto part = [&](std::size_t first) {
            OutputArray array(doubles(), ElementType::float64);
            array.offset = first * sizeof(double);
            array.strides[0] = doubles_of_row * sizeof(double);
            array.component_stride = sizeof(double);
            return array;
        };
        to.volume = part(0);
        to.centroid = part(1);
        to.area = part(4);
        to.vector_area = part(5);
        to.surface_centroid = part(8);
        to.face_fractions = part(11);
        to.face_centroids = part(17);
        to.full = {full(), ElementType::uint8};
        return to;
    }

    /// As the rows that are known, with what is full; or as before.
    bool hold(const Fractions& known, bool is_complete = true) const {
        const auto of_cells = read<std::array<std::int32_t, 3>>(context(), cells, room + 1);
        const auto of_pieces = read<std::uint32_t>(context(), pieces, room + 1);
        const auto of_doubles = read<std::array<double, doubles_of_row>>(context(), doubles, room + 1);
        const auto of_full = read<std::uint8_t>(context(), full, cell_count);
        const std::size_t count = is_complete ? known.cells.size() : 0;
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < count; ++n) {
            CellFraction row{};
            row.cell = of_cells[n];
            row.pieces = of_pieces[n];
            static_assert(sizeof row == 16 + sizeof of_doubles[n]);
            std::memcpy(&row.volume, &of_doubles[n], sizeof of_doubles[n]);
            wrong += std::memcmp(&row, &known.cells[n], sizeof row) != 0;
        }
        for (std::size_t n = count; n <= room; ++n)
            wrong += of_pieces[n] != 77U * 0x01010101U || of_cells[n][0] != 77 * 0x01010101;
        for (std::size_t n = 0; n < cell_count; ++n)
            wrong += of_full[n] != (is_complete ? unsigned{known.is_full(n)} : 77U);
        const auto told = read<DeviceFractionCount>(context(), count_memory, 1);
        wrong += !(told[0] == DeviceFractionCount{known.cells.size(), is_complete ? 1U : 0U});
        return wrong == 0;
    }

    static constexpr std::size_t doubles_of_row = 29;
    std::size_t room, cell_count;
    cl::Buffer cells = filled(12 * (room + 1)), pieces = filled(4 * (room + 1)),
               doubles = filled(8 * doubles_of_row * (room + 1)), full, count_memory = filled(16);
};

/// A run of a plan has the bytes of the host.
void check_same(const OuterSurface& surface, const Grid& grid, const FractionOptions& options) {
    const Fractions known = fractions(surface, grid, options);
    FractionPlan plan(test_device(), surface, grid, known.cells.size(), options);
    BOOST_TEST(plan.row_count() == known.cells.size());
    const Buffers buffers(known.cells.size(), grid);
    plan.enqueue(nullptr, buffers.rows(), {buffers.count_memory()});
    context().queue().finish();
    BOOST_TEST(buffers.hold(known));
}

std::vector<FractionOptions> conventions() {
    std::vector<FractionOptions> all;
    for (const char* const name : {"plain", "amrex", "vtk"}) all.push_back(FractionOptions::of(name));
    all.push_back({.walls = WallCell::solid, .snap = 1e-9});
    return all;
}

}  // namespace

BOOST_AUTO_TEST_CASE(kernels_have_the_bytes_of_the_host) {
    const Mesh knot = make_shape("knot");
    const OuterSurface surface = outer(knot);
    const Grid around = Grid::around(knot.box(), {.resolution = 24});
    for (const FractionOptions& options : conventions()) check_same(surface, around, options);
    // A part, with surface below, above and beside it on each axis; and unequal spacings.
    check_same(surface, around.block({7, 6, 5}, {9, 11, 8}), {});
    const Vec3 side = difference(knot.box().upper, knot.box().lower);
    check_same(surface, {knot.box().lower, {side[0] / 3, side[1] / 40, side[2] / 11}, {5, 42, 13}, {-1, 0, 0}}, {});
    // The whole in a cell, and none at all.
    check_same(surface, {knot.box().lower, {9 * side[0], 9 * side[1], 9 * side[2]}, {3, 3, 3}, {-1, -1, -1}}, {});
    check_same(surface, around.block({60, 0, 0}, {5, 5, 5}), {});
    // Far from sample 0; and a body there and one here, in one mesh.
    Grid far = around;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        far.first[axis] = axis == 1 ? -100'000'000 : 100'000'000;
        far.origin[axis] -= far.spacing[axis] * static_cast<double>(far.first[axis]);
    }
    for (const FractionOptions& options : conventions()) check_same(surface, far, options);
    const OuterSurface two = outer(together({knot, shifted(knot, {1e6, -1e6, 1e6})}, "two knots"));
    Grid beside = around;
    for (std::size_t axis = 0; axis < 3; ++axis)
        beside.first[axis] = static_cast<std::int64_t>((axis == 1 ? -1e6 : 1e6) / around.spacing[axis]);
    check_same(two, beside, {});
}

BOOST_AUTO_TEST_CASE(walls_between_cells_have_the_bytes_of_the_host) {
    const Mesh stairs = together({test::box({1, 1, 1}, {5, 3, 2}), test::box({1, 1, 2}, {3, 3, 3})}, "stairs");
    const OuterSurface surface = outer(stairs);
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {8, 7, 7}};
    for (const WallCell walls : {WallCell::above, WallCell::solid, WallCell::fluid}) {
        check_same(surface, grid, {.walls = walls});
        // Ends of a part in the walls.
        for (const Index3& first : {Index3{1, 1, 1}, Index3{5, 3, 2}, Index3{0, 3, 3}, Index3{3, 0, 2}})
            check_same(surface, grid.block(first, {3, 3, 3}), {.walls = walls});
    }
    // Far from the origin, in cells of which one is 700 times as long as another.
    const Mesh far = shifted(tilted(stairs), {1e6, -1e6, 1e6});
    const Vec3 low = far.box().lower;
    check_same(outer(far), {low, {0.35, 2.45, 0.0035}, {20, 4, 1000}, {-1, -1, -1}}, FractionOptions::of("chombo"));
}

BOOST_AUTO_TEST_CASE(tetrahedra_in_many_planes_have_the_bytes_of_the_host) {
    Random random(7);
    std::size_t count = 0;
    for (int n = 0; n < 60; ++n) {
        const Mesh mesh = random_lattice_tetrahedron(random, 1);
        const Vec3 &a = mesh.vertices()[0], &b = mesh.vertices()[1], &c = mesh.vertices()[2], &d = mesh.vertices()[3];
        if (dot(cross(difference(b, a), difference(c, a)), difference(d, a)) == 0) continue;
        const OuterSurface surface = outer(mesh);
        const std::vector<FractionOptions> all = conventions();
        check_same(surface, {{0, 0, 0}, {1, 1, 1}, {6 + n % 5, 10, 8}, {-4 + n % 3, -4, -3}},
                   all[static_cast<std::size_t>(n) % all.size()]);
        ++count;
    }
    BOOST_TEST(count > 40U);
}

BOOST_AUTO_TEST_CASE(a_plan_follows_a_body_that_moves) {
    const Mesh knot = make_shape("knot");
    const OuterSurface surface = outer(knot);
    const Grid grid = Grid::around(knot.box(), {.resolution = 20});
    const std::size_t room = 2 * fractions(surface, grid).cells.size();
    FractionPlan plan(test_device(), surface, grid, room);
    BOOST_TEST(plan.vertex_count() == surface.mesh.vertices().size());
    const cl::CommandQueue own(context().context(), context().device());
    for (const double step : {0.0, 0.013, 0.3}) {
        std::vector<Vec3> moved(surface.mesh.vertices().begin(), surface.mesh.vertices().end());
        for (Vec3& vertex : moved) vertex = {vertex[0] + step, vertex[1] - 2 * step, vertex[2] + 0.5 * step};
        OuterSurface known = surface;
        known.mesh = Mesh(moved, {surface.mesh.triangles().begin(), surface.mesh.triangles().end()});
        const cl::Buffer vertices(context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                                  moved.size() * sizeof(Vec3), moved.data());
        const Buffers buffers(room, grid);
        cl_event done = nullptr;
        plan.enqueue(own(), InputArray(vertices(), ElementType::float64, moved.size()), buffers.rows(),
                     {buffers.count_memory()}, {}, &done);
        cl::Event(done).wait();
        BOOST_TEST(buffers.hold(fractions(known, grid)));
    }
    // Floats with a stride, then again the vertices of the plan.
    std::vector<float> floats(4 * surface.mesh.vertices().size());
    std::vector<Vec3> rounded(surface.mesh.vertices().size());
    for (std::size_t n = 0; n < rounded.size(); ++n)
        for (std::size_t axis = 0; axis < 3; ++axis)
            rounded[n][axis] = floats[4 * n + axis] = static_cast<float>(surface.mesh.vertices()[n][axis]);
    OuterSurface known = surface;
    known.mesh = Mesh(rounded, {surface.mesh.triangles().begin(), surface.mesh.triangles().end()});
    const cl::Buffer of_floats(context().context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, 4 * floats.size(),
                               floats.data());
    InputArray strided(of_floats(), ElementType::float32, rounded.size());
    strided.strides[0] = 4 * sizeof(float);
    const Buffers first(room, grid), second(room, grid);
    plan.enqueue(nullptr, strided, first.rows(), {first.count_memory()});
    plan.enqueue(nullptr, second.rows(), {second.count_memory()});
    context().queue().finish();
    BOOST_TEST(first.hold(fractions(known, grid)));
    BOOST_TEST(second.hold(fractions(surface, grid)));

    // Another surface, grid and room.
    const OuterSurface ball = outer(make_shape("sphere3"));
    const Grid other = Grid::around(ball.mesh.box(), {.resolution = 15});
    plan.update(ball, other, 5000);
    BOOST_TEST((plan.grid() == other && plan.room() == 5000U));
    const Buffers third(5000, other);
    plan.enqueue(nullptr, third.rows(), {third.count_memory()});
    context().queue().finish();
    BOOST_TEST(third.hold(fractions(ball, other)));
    BOOST_TEST(plan.statistics().device_bytes > 5000 * sizeof(CellFraction));
}

BOOST_AUTO_TEST_CASE(too_little_room_is_told) {
    const OuterSurface surface = outer(make_shape("sphere3"));
    const Grid grid = Grid::around(surface.mesh.box(), {.resolution = 16});
    const Fractions known = fractions(surface, grid);
    const std::size_t needed = known.cells.size();
    FractionPlan plan(test_device(), surface, grid, needed);
    const Buffers few(needed - 1, grid);
    plan.enqueue(nullptr, few.rows(), {few.count_memory()});
    context().queue().finish();
    BOOST_TEST(few.hold(known, false));
    // What is full needs no room.
    FractionRows full;
    full.full = few.rows().full;
    plan.enqueue(nullptr, full, {});
    const auto of_full = read<std::uint8_t>(context(), few.full, few.cell_count);
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < of_full.size(); ++n) wrong += of_full[n] != known.is_full(n);
    BOOST_TEST(wrong == 0U);

    // The memory of a plan that was made for a body beside the grid is too small when it moves in.
    FractionPlan beside(test_device(), outer(shifted(surface.mesh, {100, 0, 0})), grid, needed);
    BOOST_TEST(beside.row_count() == 0U);
    std::vector<Vec3> positions(surface.mesh.vertices().begin(), surface.mesh.vertices().end());
    const auto vertices_of = [&](double factor) {
        for (std::size_t n = 0; n < positions.size(); ++n)
            for (std::size_t axis = 0; axis < 3; ++axis) positions[n][axis] = factor * surface.mesh.vertices()[n][axis];
        return cl::Buffer(context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                          positions.size() * sizeof(Vec3), positions.data());
    };
    const auto is_empty_run = [&](FractionPlan& of, const cl::Buffer& vertices) {
        const Buffers none(needed, grid);
        of.enqueue(nullptr, InputArray(vertices(), ElementType::float64, positions.size()), none.rows(),
                   {none.count_memory()});
        context().queue().finish();
        Fractions nothing = known;
        nothing.cells.clear();
        return none.hold(nothing, false);
    };
    BOOST_TEST(is_empty_run(beside, vertices_of(1)));
    // A vertex may be too far away. Then the plan is as before.
    BOOST_TEST(is_empty_run(plan, vertices_of(1e30)));
    const Buffers again(needed, grid);
    plan.enqueue(nullptr, again.rows(), {again.count_memory()});
    context().queue().finish();
    BOOST_TEST(again.hold(known));

    FractionRows more = again.rows();
    more.room = needed + 1;
    check_throws(ErrorCode::invalid_argument, {std::to_string(needed + 1), std::to_string(needed)},
                 [&] { plan.enqueue(nullptr, more, {}); });
    FractionRows overlapping = again.rows();
    overlapping.area = overlapping.volume;
    check_throws(ErrorCode::invalid_argument, {"array of volumes", "array of areas"},
                 [&] { plan.enqueue(nullptr, overlapping, {}); });
    std::vector<double> on_host(needed);
    FractionRows of_host;
    of_host.room = needed;
    of_host.volume = on_host;
    check_throws(ErrorCode::unsupported, {"array of volumes", "host"}, [&] { plan.enqueue(nullptr, of_host, {}); });
    const cl::Buffer few_vertices = vertices_of(1);
    check_throws(ErrorCode::invalid_argument, {"7 vertices", std::to_string(positions.size())},
                 [&] { plan.enqueue(nullptr, InputArray(few_vertices(), ElementType::float64, 7), again.rows(), {}); });
    check_throws(ErrorCode::invalid_argument, {"1 sample", "along x"}, [&] {
        FractionPlan(test_device(), surface, grid.part({0, 0, 0}, {1, 4, 4}), 10);
    });
    CallOptions call;
    call.should_stop = [] { return true; };
    check_throws(ErrorCode::cancelled, {"cut cells", "cancelled"}, [&] { plan.update(surface, call); });
    BOOST_TEST(plan.row_count() == needed);
}

BOOST_AUTO_TEST_CASE(calls_write_to_memory_of_the_device) {
    const OuterSurface surface = outer(make_shape("knot"));
    const Grid grid = Grid::around(surface.mesh.box(), {.resolution = 17});
    for (const FractionOptions& options : {FractionOptions(), FractionOptions::of("chombo")}) {
        const Fractions known = fractions(surface, grid, options);
        const std::size_t needed = known.cells.size();
        const Buffers buffers(needed + 2, grid);
        const cl::Buffer floats = Buffers::filled(4 * needed);
        std::size_t count = 0;
        fractions(test_device(), surface, grid, buffers.rows(), count, options);
        BOOST_TEST(count == needed);
        const DeviceFractionCount told{needed, 1};
        context().queue().enqueueWriteBuffer(buffers.count_memory, CL_TRUE, 0, sizeof told, &told);
        BOOST_TEST(buffers.hold(known));
        FractionRows of_floats;
        of_floats.room = needed;
        of_floats.volume = {floats(), ElementType::float32};
        fractions(test_device(), surface, grid, of_floats, count, options);
        const auto volumes = read<float>(context(), floats, needed);
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < needed; ++n) wrong += volumes[n] != static_cast<float>(known.cells[n].volume);
        BOOST_TEST(wrong == 0U);
        of_floats.room = needed - 1;
        check_throws(ErrorCode::invalid_argument, {std::to_string(needed), "room for " + std::to_string(needed - 1)},
                     [&] { fractions(test_device(), surface, grid, of_floats, count, options); });
        BOOST_TEST(count == needed);
    }
}

}  // namespace clsdf
