// A transform that reads a prepared mesh in memory that others share gives what the one does that was shared.
#include "calls/restricted_bodies.hpp"
#include "support/filled_memory.hpp"
#include "support/throws.hpp"

#include <clsdf/segments.hpp>

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Pages as processes share them, with a prepared mesh.
class Pages {
public:
    explicit Pages(const DistanceTransform& transform) : size_(transform.prepared_bytes()) {
        void* const memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        BOOST_REQUIRE(memory != MAP_FAILED);
        memory_ = static_cast<std::byte*>(memory);
        transform.share({memory_, size_});
    }
    Pages(const Pages&) = delete;
    Pages& operator=(const Pages&) = delete;
    ~Pages() { munmap(memory_, size_); }

    /// From now on a write ends the program.
    void make_read_only() { BOOST_REQUIRE(mprotect(memory_, size_, PROT_READ) == 0); }
    std::span<const std::byte> bytes() const { return {memory_, size_}; }

private:
    std::size_t size_;
    std::byte* memory_ = nullptr;
};

bool is_same(const Links& a, const Links& b) {
    return a.samples == b.samples && a.directions == b.directions && a.q == b.q && a.triangles == b.triangles &&
           a.counts == b.counts && a.flags == b.flags && a.inside.bits == b.inside.bits;
}

std::vector<Vec3> points_about(const Box& box, std::size_t count) {
    Random random(3);
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = box.upper[axis] - box.lower[axis];
            point[axis] = random.uniform(box.lower[axis] - 0.2 * side, box.upper[axis] + 0.2 * side);
        }
    return points;
}

std::vector<double> ray_hits(const DistanceTransform& transform, const std::vector<Vec3>& origins) {
    const std::vector<Vec3> directions(origins.size(), Vec3{1, 0.25, -0.125});
    std::vector<double> t(origins.size());
    RayTargets targets;
    targets.t = OutputArray(t);
    transform.rays(origins, directions, {.hits = transform.sign() == SignRule::none ? Hits::faces : Hits::walls},
                   targets);
    return t;
}

/// All kinds of calls.
void check_same_results(const DistanceTransform& expected, const DistanceTransform& found) {
    const Box box = expected.box();
    const double side = box.longest_side(), h = side / 23;
    BOOST_TEST((found.sign() == expected.sign()));
    BOOST_TEST((found.topology() == expected.topology()));
    BOOST_TEST((found.floor() == expected.floor()));
    BOOST_TEST(found.mesh_name() == expected.mesh_name());
    const Grid grid = samples_in({{box.lower[0] - 3 * h, box.lower[1] - 3 * h, box.lower[2] - 3 * h}, box.upper}, h,
                                 {0.1 * side, -0.3 * side, 0.2 * side});
    for (const Band& band : {Band::symmetric(3 * h), Band::full()})
        check_same(expected.compute(grid, band, all_outputs()), found.compute(grid, band, all_outputs()));
    const Grid small = grid.part({2, 3, 1}, {5, 4, 3});  // of which only the triangles near it are prepared
    check_same(expected.compute(small, Band::symmetric(2 * h)), found.compute(small, Band::symmetric(2 * h)));
    const SparseField one = expected.compute_sparse(grid, Band::symmetric(2 * h)),
                      other = found.compute_sparse(grid, Band::symmetric(2 * h));
    BOOST_TEST((one.bricks == other.bricks));
    BOOST_TEST((bits_of(one.distance()) == bits_of(other.distance())));
    // The calling thread answers few points; of many a processor makes groups.
    for (const std::size_t count : {std::size_t{40}, std::size_t{3000}, std::size_t{17'000}}) {
        const std::vector<Vec3> points = points_about(box, count);
        check_same(query(expected, points), query(found, points));
    }
    const std::vector<Vec3> points = points_about(box, 500);
    BOOST_TEST((ray_hits(expected, points) == ray_hits(found, points)));
    const LinkOptions options{.hits = expected.sign() == SignRule::none ? Hits::faces : Hits::walls};
    BOOST_TEST(is_same(expected.links(grid, stencil("D3Q19"), options), found.links(grid, stencil("D3Q19"), options)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_shared_transform_has_the_bytes_of_the_first_in_read_only_memory) {
    for (const auto& [mesh, options] : bodies()) {
        std::optional<DistanceTransform> first(std::in_place, test_device(), mesh, options);
        Pages pages(*first);
        pages.make_read_only();
        const DistanceTransform shared = DistanceTransform::from_shared(test_device(), pages.bytes());
        BOOST_TEST_CONTEXT(mesh.name()) {
            check_same_results(*first, shared);
            // And so on, without the first.
            std::optional<Pages> again(std::in_place, shared);
            const DistanceTransform other = DistanceTransform::from_shared(test_device(), again->bytes());
            BOOST_TEST(std::ranges::equal(again->bytes(), pages.bytes()));
            check_same(query(*first, points_about(mesh.box(), 300)), query(other, points_about(mesh.box(), 300)));
        }
    }
}

namespace {

/// The bytes that a new transform shares. `old`: what is in all memory before, its own and that for the result.
/// has_worked: whether it has answered all kinds of calls, whose results its buffers had, too.
std::vector<std::byte> shared_bytes(const Body& body, unsigned char old, bool has_worked) {
    const FilledMemory filled(old);
    const DistanceTransform transform(test_device(), body.mesh, body.options);
    if (has_worked) {
        const double side = body.mesh.box().longest_side();
        const Grid grid = samples_in(body.mesh.box(), side / 19, {0, 0, 0});
        transform.compute(grid, Band::symmetric(side / 5));
        transform.compute(grid, Band::full(), all_outputs());
        query(transform, points_about(body.mesh.box(), 3000));
        ray_hits(transform, points_about(body.mesh.box(), 100));
    }
    const std::size_t size = transform.prepared_bytes();
    std::vector<std::byte> bytes(size + 64, std::byte{old});
    const std::size_t begin = (64 - reinterpret_cast<std::uintptr_t>(bytes.data()) % 64) % 64;
    transform.share(std::span(bytes).subspan(begin, size));
    return {bytes.begin() + static_cast<std::ptrdiff_t>(begin),
            bytes.begin() + static_cast<std::ptrdiff_t>(begin + size)};
}

}  // namespace

// No byte of memory that was there before gets out, and the hash in the head is that of the mesh.
BOOST_AUTO_TEST_CASE(equal_transforms_share_equal_bytes_whatever_was_in_memory_before) {
    std::vector<Body> all = bodies();
    all.push_back({make_shape("sphere3")});
    all.push_back({fins()});  // and one without area
    for (const Body& body : all) {
        const std::vector<std::byte> bytes = shared_bytes(body, 0x00, false);
        BOOST_TEST_CONTEXT(body.mesh.name()) {
            BOOST_TEST((shared_bytes(body, 0xA5, false) == bytes));
            BOOST_TEST((shared_bytes(body, 0x5A, true) == bytes));
        }
    }
}

BOOST_AUTO_TEST_CASE(a_shared_transform_moves_and_is_restricted_by_itself) {
    for (const Mesh& mesh : {tilted(make_shape("knot")), without_triangle(make_shape("sphere4"), 7)}) {
        DistanceTransform first(test_device(), mesh);
        Pages pages(first);
        pages.make_read_only();
        DistanceTransform one = DistanceTransform::from_shared(test_device(), pages.bytes()),
                          other = DistanceTransform::from_shared(test_device(), pages.bytes());
        const double side = mesh.box().longest_side();
        const Region region{boxes_about(mesh).front(), 0.1 * side, 0.03 * side};
        const Grid bricks = in_whole_bricks(samples_in(region.box, region.spacing, {0, 0, 0}));  // of a sparse field
        const std::vector<Region> regions{region, {bricks.box(), region.half_width, region.spacing}};
        check_same_answers(first.restrict_to(regions), one.restrict_to(regions), region, {0, 0, 0});
        std::vector<Vec3> moved = mesh.vertices();
        for (Vec3& p : moved) p = {1.1 * p[0], p[1] + 0.1 * p[0] * p[0], p[2] - 0.2 * p[1]};
        first.set_positions(moved);
        one.set_positions(moved);
        check_same_results(first, one);
        const std::array<Vec3, 3> rotation{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
        first.set_motion(rotation, {0.1, 0.2, 0.3});
        one.set_motion(rotation, {0.1, 0.2, 0.3});
        check_same_results(first, one);
        check_throws(ErrorCode::unsupported, {"have moved", "at these positions"}, [&] { one.prepared_bytes(); });
        check_same(query(DistanceTransform(test_device(), mesh), points_about(mesh.box(), 300)),
                   query(other, points_about(mesh.box(), 300)));
    }
}

// The trees, the polyhedra and the rest are not there once more.
BOOST_AUTO_TEST_CASE(a_shared_transform_keeps_little_beside) {
    if (!is_processor()) return;  // another device has copies
    const Mesh mesh = make_shape("sphere6");
    const DistanceTransform first(test_device(), mesh);
    const Pages pages(first);
    const DistanceTransform shared = DistanceTransform::from_shared(test_device(), pages.bytes());
    const std::vector<Vec3> points = points_about(mesh.box(), 40000);
    check_same(query(first, points), query(shared, points));
    const KeptMemory own = shared.memory();
    BOOST_TEST(own.host_bytes + own.device_bytes < pages.bytes().size() / 50);
    BOOST_TEST(pages.bytes().size() < 700 * mesh.triangles().size());
}

BOOST_AUTO_TEST_CASE(memory_without_a_whole_transform_is_refused_by_name) {
    const DistanceTransform first(test_device(), without_triangle(make_shape("sphere3"), 3));
    std::vector<std::byte> room(first.prepared_bytes() + 2 * 64);
    std::byte* const begin = room.data() + (64 - reinterpret_cast<std::uintptr_t>(room.data()) % 64);
    const std::span<std::byte> memory(begin, first.prepared_bytes());
    const auto refused = [](std::span<const std::byte> wrong, const char* said) {
        check_throws(ErrorCode::invalid_argument, {"this memory has no transform", said, "when share() has returned"},
                     [&] { DistanceTransform::from_shared(test_device(), wrong); });
    };
    refused(memory, "nothing has been written yet");
    check_throws(ErrorCode::invalid_argument, {"begins at a multiple of 64"}, [&] {
        first.share({begin + 8, memory.size()});
    });
    check_throws(ErrorCode::invalid_argument, {"as prepared_bytes() says"},
                 [&] { first.share(memory.first(memory.size() - 1)); });
    first.share({begin, memory.size() + 64});  // more room than it needs
    DistanceTransform::from_shared(test_device(), std::span<const std::byte>(begin, memory.size() + 64));
    check_throws(ErrorCode::invalid_argument, {"begins at a multiple of 64"},
                 [&] { DistanceTransform::from_shared(test_device(), std::span<const std::byte>(memory).subspan(8)); });
    refused(memory.first(20), "fewer than the head");
    refused({}, "fewer than the head");
    for (std::size_t size = 64; size < memory.size(); size += 99'991) refused(memory.first(size), "which states");
    Random random(11);
    for (int i = 0; i < 100; ++i) {
        std::byte& damaged = memory[64 + random.index(memory.size() - 64)];
        const std::byte was = damaged;
        damaged ^= std::byte{static_cast<unsigned char>(1U << random.index(8))};
        refused(memory, "was changed");
        damaged = was;
    }
    for (const auto& [at, said] : {std::pair{0, "the head has another name"},
                                   {8, "another byte order"},
                                   {12, "layout"},
                                   {16, "was the writer, and this is"},
                                   {30, "which states"},
                                   {32, "was changed"}}) {
        std::byte& damaged = memory[static_cast<std::size_t>(at)];
        damaged ^= std::byte{1};
        refused(memory, said);
        damaged ^= std::byte{1};
    }
    // Every bit of the head counts, also of what fills it up.
    for (std::size_t bit = 0; bit < 8 * std::size_t{64}; ++bit) {
        std::byte& damaged = memory[bit / 8];
        damaged ^= std::byte{1} << bit % 8;
        refused(memory, "");
        damaged ^= std::byte{1} << bit % 8;
    }
    DistanceTransform::from_shared(test_device(), memory);
}

BOOST_AUTO_TEST_CASE(other_transforms_are_not_shared) {
    const DistanceTransform whole(test_device(), cube(1));
    check_throws(ErrorCode::unsupported, {"is restricted", "part_bytes()"}, [&] {
        whole.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.3, 0.1}).prepared_bytes();
    });
    const Mesh overlapping = together({cube(1), shifted(cube(1), {0.5, 0.6, 0.7})}, "two");
    const DistanceTransform outer(test_device(), overlapping, {.surface = Surface::outer});
    check_throws(ErrorCode::unsupported, {"surface is outer", "the mesh of outer()"}, [&] { outer.prepared_bytes(); });
}
