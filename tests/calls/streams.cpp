#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/tuning.hpp>

#include <atomic>
#include <chrono>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Mesh& mesh() {
    static const Mesh shape = [] {
        Random random(7);
        return random_sphere(random, "sphere3", 0.2);
    }();
    return shape;
}

/// Long along z: several slabs of a device that allocates little.
Grid long_grid(std::int64_t first_z = 0) {
    Grid grid = grid_around(mesh(), 84, 4);
    grid.size[2] = 150;
    grid.origin[2] -= grid.spacing[2] * static_cast<double>(40 + first_z);
    grid.first[2] = first_z;
    return grid;
}

Band band_on(const Grid& grid) {
    return Band::symmetric(3 * grid.voxel());
}

/// The tests' device as if it allocated at most 40 of the grid's slices of distances at once.
Device small_device(const Grid& grid) {
    return with_largest_allocation(40 * static_cast<std::size_t>(grid.size[0] * grid.size[1]) * sizeof(float));
}

/// A field that is put together from its slabs, which must be in order.
struct Collected {
    Field field;
    std::size_t slabs = 0;
    TransformStatistics statistics;

    void add(const Grid& whole, const Grid& part, const FieldSlab& values) {
        const std::int64_t slices =
            static_cast<std::int64_t>(field.distance().size()) / (whole.size[0] * whole.size[1]);
        BOOST_REQUIRE((part == whole.part({0, 0, slices}, {whole.size[0], whole.size[1], part.size[2]})));
        BOOST_REQUIRE(values.distance().size() == part.sample_count());
        for (const OutputInfo& info : output_table()) {
            const std::span<const std::byte> bytes = values.bytes(info.output);
            if (bytes.empty()) continue;
            const std::size_t before = field.bytes(info.output).size();
            const std::span<std::byte> all = field.resize(info.output, (before + bytes.size()) / info.sample_bytes());
            std::ranges::copy(bytes, all.begin() + static_cast<std::ptrdiff_t>(before));
        }
        ++slabs;
    }
};

Collected collect(DistanceTransform& transform, const Grid& grid, OutputSet outputs, const SlabOptions& options = {}) {
    Collected collected;
    collected.statistics = transform.compute(
        grid, band_on(grid), outputs,
        [&](const Grid& part, const FieldSlab& values) { collected.add(grid, part, values); }, options);
    return collected;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_field_in_slabs)

// The first slab of the second grid is a slice shorter than the third, which takes its place. A sink on the calling
// thread gets the only one.
BOOST_AUTO_TEST_CASE(holds_two_slabs_at_a_time) {
    for (const std::int64_t first : {0, 1}) BOOST_TEST_CONTEXT("from slice " << first) {
            const Grid grid = long_grid(first);
            DistanceTransform transform(small_device(grid), mesh());
            const auto slice = static_cast<std::size_t>(grid.size[0] * grid.size[1] * 4);
            for (const bool overlap : {true, false}) {
                const Collected collected =
                    collect(transform, grid, Output::triangle, {.sink_has_own_thread = overlap});
                BOOST_REQUIRE(collected.slabs > 2U);
                const std::size_t held = overlap ? 2 : 1;
                BOOST_TEST(collected.statistics.host_bytes >= held * 2 * 32 * slice);
                BOOST_TEST(collected.statistics.host_bytes <= held * 2 * 40 * slice);
            }
            TransformStatistics in_place;
            transform.compute(grid, band_on(grid), Output::distance, {}, &in_place);
            BOOST_TEST(in_place.host_bytes == 0U);
        }
}

BOOST_AUTO_TEST_CASE(comes_one_slab_at_a_time_while_the_next_is_computed) {
    const Grid grid = long_grid();
    int slabs = 0;
    for (const bool overlap : {false, true}) {
        std::atomic<int> inside = 0;
        std::atomic<bool> computed_meanwhile = false;
        const auto wait = [](double seconds, const auto& is_done) {
            const Stopwatch watch;
            while (!is_done() && watch.seconds() < seconds) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        };
        CallOptions call;
        call.progress = when_computing([&](double fraction) {
            // The second slab waits for the sink, which has the first, and the sink for the second slab; not for ever,
            // since one of the first slab that comes late would wait as well.
            if (overlap && fraction > 0.5 / slabs) wait(2, [&] { return inside > 0 || computed_meanwhile; });
            if (inside > 0) computed_meanwhile = true;
        });
        DistanceTransform transform(small_device(grid), mesh());
        bool own_thread = false;
        transform.compute(
            grid, band_on(grid), Output::distance,
            [&, caller = std::this_thread::get_id()](const Grid&, const FieldSlab&) {
                BOOST_TEST(++inside == 1);
                own_thread = std::this_thread::get_id() != caller;
                wait(overlap ? 2 : 0.1, [&] { return computed_meanwhile.load(); });
                --inside;
                if (!overlap) ++slabs;
            },
            {.sink_has_own_thread = overlap}, call);
        BOOST_TEST(computed_meanwhile == overlap);
        BOOST_TEST(own_thread == overlap);
        BOOST_TEST(slabs >= 3);
    }
}

BOOST_AUTO_TEST_CASE(comes_on_the_calling_thread_unless_it_is_asked_for_otherwise) {
    const Grid grid = long_grid();
    DistanceTransform transform(small_device(grid), mesh());
    const std::thread::id caller = std::this_thread::get_id();
    std::size_t on_caller = 0, on_another = 0;
    const SlabSink count = [&](const Grid&, const FieldSlab&) {
        ++(std::this_thread::get_id() == caller ? on_caller : on_another);
    };
    transform.compute(grid, band_on(grid), Output::distance, count);
    BOOST_TEST(on_caller >= 3U);
    BOOST_TEST(on_another == 0U);
    on_caller = 0;
    transform.compute(grid, band_on(grid), Output::distance, count, {.sink_has_own_thread = true});
    BOOST_TEST(on_caller == 0U);
    BOOST_TEST(on_another >= 3U);
}

BOOST_AUTO_TEST_CASE(ends_with_what_the_sink_throws) {
    struct Refusal {};
    const Grid grid = long_grid();
    for (const bool overlap : {true, false})
        for (const int refused : {1, 2, 3}) {
            DistanceTransform transform(small_device(grid), mesh());
            int calls = 0;
            const auto refuse = [&](const Grid&, const FieldSlab&) {
                if (++calls == refused) throw Refusal();
            };
            BOOST_CHECK_THROW(
                transform.compute(grid, band_on(grid), Output::distance, refuse, {.sink_has_own_thread = overlap}),
                Refusal);
            BOOST_TEST(calls == refused);
            // The transform is as good as new.
            BOOST_TEST(
                same_bytes(collect(transform, grid, Output::triangle).field,
                           DistanceTransform(test_device(), mesh()).compute(grid, band_on(grid), Output::triangle)));
        }
    // Memory that the sink lacks is no reason to compute smaller slabs.
    DistanceTransform transform(small_device(grid), mesh());
    int calls = 0;
    check_throws(ErrorCode::out_of_memory, {"the sink's"}, [&] {
        transform.compute(grid, band_on(grid), Output::distance, [&](const Grid&, const FieldSlab&) {
            ++calls;
            throw Error(ErrorCode::out_of_memory, "the sink's");
        });
    });
    BOOST_TEST(calls == 1);
}

BOOST_AUTO_TEST_CASE(ends_when_it_is_cancelled_and_calls_the_sink_no_more) {
    const Grid grid = long_grid();
    DistanceTransform transform(small_device(grid), mesh());
    std::atomic<int> calls = 0;
    check_throws(ErrorCode::cancelled, {"cancelled"}, [&] {
        transform.compute(grid, band_on(grid), Output::distance, [&](const Grid&, const FieldSlab&) { ++calls; }, {},
                          {.should_stop = [&] { return calls >= 2; }});
    });
    BOOST_TEST(calls >= 2);
    BOOST_TEST(calls <= 3);
    const int before = calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    BOOST_TEST(calls == before);
}

BOOST_AUTO_TEST_CASE(needs_a_sink) {
    const Grid grid = long_grid();
    DistanceTransform transform(test_device(), mesh());
    check_throws(ErrorCode::invalid_argument, {"sink"},
                 [&] { transform.compute(grid, band_on(grid), Output::distance, SlabSink()); });
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(the_slabs_of_a_grid)

namespace {

/// The slices of each slab.
std::vector<std::int64_t> slabs_of_cube(std::int64_t side, std::int64_t first_z = 0) {
    Grid grid;
    grid.size = {side, side, side};
    grid.first[2] = first_z;
    std::vector<std::int64_t> slices;
    for (const Grid& slab : DistanceTransform::slabs_of(grid)) slices.push_back(slab.size[2]);
    return slices;
}

}  // namespace

BOOST_AUTO_TEST_CASE(are_of_64_mebibytes_or_a_coarse_brick_or_a_brick) {
    BOOST_TEST(slabs_of_cube(256).size() == 1U);
    BOOST_TEST((slabs_of_cube(512) == std::vector<std::int64_t>(8, 64)));
    BOOST_TEST((slabs_of_cube(1024) == std::vector<std::int64_t>(32, 32)));
    BOOST_TEST((slabs_of_cube(2048) == std::vector<std::int64_t>(128, 16)));
    BOOST_TEST((slabs_of_cube(4096) == std::vector<std::int64_t>(512, 8)));
}

BOOST_AUTO_TEST_CASE(end_at_boundaries_of_the_lattice) {
    for (const std::int64_t first : {-13, 0, 5}) {
        std::int64_t at = first;
        for (const std::int64_t slices : slabs_of_cube(512, first)) {
            BOOST_TEST(((at == first) || at % 32 == 0));
            at += slices;
        }
        BOOST_TEST(at == first + 512);
    }
}

BOOST_AUTO_TEST_SUITE_END()
