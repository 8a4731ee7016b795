#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

// Plans of links: what they enqueue has the bytes of DistanceTransform::links().

using namespace clsdf;
using namespace clsdf::test;

namespace {

const device::Context& context() {
    return device::context_of(test_device());
}

cl::Buffer filled(std::size_t bytes) {
    std::vector<std::uint8_t> values(bytes, 77);
    return {context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes, values.data()};
}

const std::vector<LinkDirection> directions = stencil("D3Q19");

/// Buffers for the rows of a run, with a row more than it may write.
struct Buffers {
    explicit Buffers(std::size_t room_in, std::size_t samples_in) : room(room_in), sample_count(samples_in) {}

    LinkTargets targets() const {
        return {.room = room,
                .samples = {samples(), ElementType::int32},
                .directions = {bytes(), ElementType::uint8},
                .q = {q()},
                .triangles = {triangles(), ElementType::int32},
                .counts = {counts()},
                .flags = flags_array(),
                .inside = {inside()}};
    }
    OutputArray flags_array() const {
        OutputArray array(bytes(), ElementType::uint8);
        array.offset = room + 1;
        return array;
    }

    /// The number of wrong items, with `links` in the buffers, or none of them.
    std::size_t wrong(const Links& links, bool is_complete) const {
        using Sample = std::array<std::int32_t, 3>;
        const auto of_samples = read<Sample>(context(), samples, room + 1);
        const auto of_bytes = read<std::uint8_t>(context(), bytes, 2 * (room + 1));
        const auto of_q = read<double>(context(), q, room + 1);
        const auto of_triangles = read<std::uint32_t>(context(), triangles, room + 1);
        const auto of_counts = read<std::uint32_t>(context(), counts, room + 1);
        const auto of_inside = read<std::uint8_t>(context(), inside, sample_count);
        const auto total = read<DeviceLinkCount>(context(), count, 1);
        std::size_t wrong = !(total[0] == DeviceLinkCount{links.size(), is_complete ? 1U : 0U});
        const std::size_t rows = is_complete ? links.size() : 0;
        for (std::size_t n = 0; n < rows; ++n)
            wrong += of_samples[n] != links.samples[n] || of_bytes[n] != links.directions[n] || of_q[n] != links.q[n] ||
                     of_triangles[n] != links.triangles[n] || of_counts[n] != links.counts[n] ||
                     of_bytes[room + 1 + n] != static_cast<std::uint8_t>(links.flags[n]);
        for (std::size_t n = rows; n <= room; ++n)
            wrong += of_counts[n] != 77U * 0x01010101U || of_bytes[n] != 77 || of_bytes[room + 1 + n] != 77;
        for (std::size_t n = 0; n < sample_count; ++n) wrong += of_inside[n] != links.inside.is_inside(n);
        return wrong;
    }

    std::size_t room, sample_count;
    cl::Buffer samples = filled(12 * (room + 1)), bytes = filled(2 * (room + 1)), q = filled(8 * (room + 1)),
               triangles = filled(4 * (room + 1)), counts = filled(4 * (room + 1)), inside = filled(sample_count),
               count = filled(24);
};

Grid grid_of(const Mesh& mesh, std::int64_t samples) {
    return Grid::around(mesh.box(), {.resolution = samples});
}

}  // namespace

BOOST_AUTO_TEST_SUITE(links)

BOOST_AUTO_TEST_CASE(runs_have_the_bytes_of_the_call) {
    const Mesh mesh = make_shape("sphere3");
    DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 24);
    const LinkOptions options{.with_between = true};
    const Links links = transform.links(grid, directions, options);
    const std::size_t room = links.size() + 100;
    LinkPlan plan = transform.plan_links(grid, directions, room, options);
    BOOST_TEST((plan.grid() == grid));
    BOOST_TEST(plan.directions().size() == 19U);
    BOOST_TEST(plan.options().with_between);
    BOOST_TEST(plan.room() == room);
    BOOST_TEST((plan.sign() == transform.sign()));
    BOOST_TEST(plan.statistics().device_bytes >= 30 * links.size() + grid.sample_count());

    const Buffers first(room, grid.sample_count()), second(links.size(), grid.sample_count());
    cl_event done = nullptr;
    plan.enqueue(nullptr, first.targets(), {first.count()}, {}, &done);
    const cl::Event after_first(done);
    // On a queue of the caller's, behind that run.
    const cl::CommandQueue own(context().context(), context().device());
    plan.enqueue(own(), second.targets(), {second.count()}, {&after_first(), 1}, &done);
    cl::Event(done).wait();
    BOOST_TEST(first.wrong(links, true) == 0);
    BOOST_TEST(second.wrong(links, true) == 0);

    // In floats, and the rest is not asked for.
    const cl::Buffer floats = filled(4 * room);
    plan.enqueue(nullptr, {.room = room, .q = {floats(), ElementType::float32}}, {});
    context().queue().finish();
    const auto of_floats = read<float>(context(), floats, links.size());
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < links.size(); ++n) wrong += of_floats[n] != as_float_part(links.q[n]);
    BOOST_TEST(wrong == 0);

    // Strides, backwards, and dense fields of which the first one lies last.
    const std::size_t samples = grid.sample_count();
    const cl::Buffer strided = filled(16 * room), dense = filled(4 * 19 * samples), bytes = filled(2 * samples);
    OutputArray backwards(strided(), ElementType::float64), fields(dense(), ElementType::float32),
        inside(bytes(), ElementType::uint8);
    backwards.offset = 16 * (room - 1) + 8;
    backwards.strides[0] = -16;
    fields.offset = 4 * 18 * samples;
    fields.strides = {4, 4 * grid.size[0], 4 * grid.size[0] * grid.size[1]};
    fields.component_stride = -4 * static_cast<std::ptrdiff_t>(samples);
    inside.offset = 1;
    inside.strides[0] = 2;
    plan.enqueue(nullptr, {.room = room, .q = backwards, .inside = inside, .dense = fields}, {});
    context().queue().finish();
    const auto of_strided = read<double>(context(), strided, 2 * room);
    const auto of_bytes = read<std::uint8_t>(context(), bytes, 2 * samples);
    for (std::size_t n = 0; n < room; ++n)
        wrong += (n < links.size() && of_strided[2 * (room - 1 - n) + 1] != links.q[n]) ||
                 of_strided[2 * (room - 1 - n)] != of_strided[0];
    for (std::size_t n = 0; n < samples; ++n)
        wrong += of_bytes[2 * n + 1] != links.inside.is_inside(n) || of_bytes[2 * n] != 77;
    std::vector<float> expected(19 * samples);
    std::size_t count = 0;
    transform.links(grid, directions, {.dense = expected}, count, options);
    const auto of_fields = read<float>(context(), dense, 19 * samples);
    for (std::size_t field = 0; field < 19; ++field)
        wrong += !std::equal(of_fields.begin() + static_cast<std::ptrdiff_t>(field * samples),
                             of_fields.begin() + static_cast<std::ptrdiff_t>((field + 1) * samples),
                             expected.begin() + static_cast<std::ptrdiff_t>((18 - field) * samples));
    BOOST_TEST(wrong == 0);

    // Too little room.
    const Buffers small(links.size() - 1, grid.sample_count());
    plan.enqueue(nullptr, small.targets(), {small.count()});
    context().queue().finish();
    BOOST_TEST(small.wrong(links, false) == 0);

    // At other positions, on another grid; the plan outlives its transform.
    const Mesh other = tilted(mesh);
    transform.set_positions(other.vertices());
    plan.update(transform);
    const Buffers third(room, grid.sample_count());
    plan.enqueue(nullptr, third.targets(), {third.count()});
    context().queue().finish();
    BOOST_TEST(third.wrong(transform.links(grid, directions, options), true) == 0);
    const Grid part = grid.part({3, 4, 5}, {14, 12, 10});
    const Links of_part = transform.links(part, directions, options);
    plan.update(transform, part, 7);
    BOOST_TEST(plan.room() == 7U);
    plan.update(transform, part, of_part.size());
    { const DistanceTransform gone = std::move(transform); }
    const Buffers fourth(of_part.size(), part.sample_count());
    plan.enqueue(nullptr, fourth.targets(), {fourth.count()});
    context().queue().finish();
    BOOST_TEST(fourth.wrong(of_part, true) == 0);
}

BOOST_AUTO_TEST_CASE(a_plan_without_links_or_without_room_runs) {
    const DistanceTransform transform(test_device(), make_shape("sphere3"));
    const Grid grid{{100, 100, 100}, {1, 1, 1}, {3, 4, 5}, {}};
    LinkPlan plan = transform.plan_links(grid, directions, 0);
    const Buffers buffers(0, grid.sample_count());
    plan.enqueue(nullptr, {.inside = {buffers.inside()}}, {buffers.count()});
    context().queue().finish();
    BOOST_TEST(buffers.wrong(transform.links(grid, directions), true) == 0);
}

BOOST_AUTO_TEST_CASE(what_a_run_cannot_write_is_refused_by_name) {
    const Mesh mesh = make_shape("sphere3");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 16);
    const std::size_t room = transform.count_links(grid, directions);
    LinkPlan plan = transform.plan_links(grid, directions, room);
    const cl::Buffer memory = filled(16 * room);
    const auto refused = [&](ErrorCode code, std::vector<std::string> words, const LinkTargets& targets,
                             const DeviceRange& count = {}) {
        check_throws(code, words, [&] { plan.enqueue(nullptr, targets, count); });
    };
    std::vector<double> host(room);
    OutputArray strided(memory(), ElementType::float64), shifted(memory(), ElementType::float64);
    strided.strides[1] = 16;
    shifted.offset = 8 * room + 8;
    const cl::Buffer read_only(context().context(), CL_MEM_READ_ONLY, 8 * room);
    refused(ErrorCode::unsupported, {"array of q", "memory of the host"}, {.room = room, .q = host});
    refused(ErrorCode::unsupported, {"array of flags", "double", "uint8"},
            {.room = room, .flags = {memory(), ElementType::float64}});
    refused(ErrorCode::invalid_argument, {"dense array", "larger"}, {.dense = {memory()}});
    refused(ErrorCode::invalid_argument, {"array of q", "strides", "one row"}, {.room = room, .q = strided});
    refused(ErrorCode::invalid_argument, {"array of q", "larger"}, {.room = room, .q = shifted});
    refused(ErrorCode::invalid_argument, {"array of q", "CL_MEM_READ_ONLY"}, {.room = room, .q = {read_only()}});
    refused(ErrorCode::invalid_argument, {fmt::format("room for {}", room + 1), fmt::format("room for {}", room)},
            {.room = room + 1, .q = {memory()}});
    refused(ErrorCode::invalid_argument, {"array of q", "array of counts", "same bytes"},
            {.room = room, .q = {memory()}, .counts = {memory()}});
    refused(ErrorCode::invalid_argument, {"memory of the count", "multiple of 8"}, {.room = room}, {memory(), 4});
    const DistanceTransform sheet(test_device(), Mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, "sheet"),
                                  {.sign = SignRule::none});
    check_throws(ErrorCode::unsupported, {"sheet", "no sign"}, [&] { plan.update(sheet); });
    // The plan is as it was.
    const Buffers buffers(room, grid.sample_count());
    plan.enqueue(nullptr, buffers.targets(), {buffers.count()});
    context().queue().finish();
    BOOST_TEST(buffers.wrong(transform.links(grid, directions), true) == 0);
    LinkPlan other = std::move(plan);
    check_throws(ErrorCode::invalid_argument, {"LinkPlan"}, [&] { plan.enqueue(nullptr, {}, {}); });
}

BOOST_AUTO_TEST_SUITE_END()
