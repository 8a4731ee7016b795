// A restricted transform that is made of bytes gives what the one does that they were made from.
#include "calls/restricted_bodies.hpp"
#include "support/filled_memory.hpp"
#include "support/throws.hpp"

#include "core/word_hash.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_CASE(a_part_of_bytes_has_the_answers_and_the_bytes_of_the_first) {
    for (const auto& [mesh, options] : bodies()) {
        const double side = mesh.box().longest_side(), h = side / 30;
        std::optional<DistanceTransform> whole(std::in_place, test_device(), mesh, options);
        for (const Box& box : boxes_about(mesh)) {
            const Region region{box, 4 * h, h};
            const Vec3 origin{0.1 * side, -0.3 * side, 0.2 * side};
            const Grid bricks = in_whole_bricks(samples_in(box, h, origin));  // of a sparse field
            const std::vector<Region> regions{region, {bricks.box(), region.half_width, h}};
            const DistanceTransform part = whole->restrict_to(regions);
            const std::vector<std::byte> bytes = part.part_bytes();
            const DistanceTransform read = DistanceTransform::from_part(test_device(), bytes);
            BOOST_TEST_CONTEXT(mesh.name()
                               << ", box from " << box.lower[0] << ", " << box.lower[1] << ", " << box.lower[2]) {
                BOOST_TEST((read.sign() == whole->sign()));
                BOOST_TEST(read.box().lower == whole->box().lower, boost::test_tools::per_element());
                BOOST_TEST((read.topology() == whole->topology()));
                check_same_answers(part, read, region, origin);
                BOOST_TEST((read.part_bytes() == bytes));
            }
        }
    }
}

// No byte of memory that was there before gets out.
BOOST_AUTO_TEST_CASE(equal_parts_have_equal_bytes_whatever_was_in_memory_before) {
    for (const auto& [mesh, options] : bodies()) {
        const double side = mesh.box().longest_side(), h = side / 30;
        const Region region{boxes_about(mesh).front(), 4 * h, h};
        for (const double margin : {0.0, 0.5 * h}) {
            const auto bytes_of = [&](unsigned char old, bool has_worked) {
                const FilledMemory filled(old);
                const DistanceTransform whole(test_device(), mesh, options);
                const DistanceTransform part = whole.restrict_to(region, margin);
                if (has_worked) {
                    part.compute(samples_in(region.box, h, {0, 0, 0}), Band::symmetric(2 * h), all_outputs());
                    query(part, std::array{region.box.lower, region.box.upper}, region.half_width);
                }
                return part.part_bytes();
            };
            const std::vector<std::byte> bytes = bytes_of(0x00, false);
            BOOST_TEST((bytes_of(0xA5, false) == bytes), mesh.name() << ", margin " << margin);
            BOOST_TEST((bytes_of(0x5A, true) == bytes), mesh.name() << ", margin " << margin);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_part_of_bytes_refuses_what_the_first_refuses) {
    const DistanceTransform whole(test_device(), cube(1));
    const Box box{{0, 0, 0}, {1, 1, 1}};
    DistanceTransform part =
        DistanceTransform::from_part(test_device(), whole.restrict_to({box, 0.3, 0.1}).part_bytes());
    const Grid inside = samples_in(box, 0.1, {0, 0, 0});
    check_throws(ErrorCode::invalid_argument, {"samples reach from", "restrict the whole"},
                 [&] { part.compute(inside.grown(1), Band::symmetric(0.3)); });
    check_throws(ErrorCode::unsupported, {"restrict the whole one"}, [&] { part.restrict_to({box, 0.1, 0.1}); });
    check_throws(ErrorCode::unsupported, {"set the positions of the whole one"},
                 [&] { part.set_positions(cube(1).vertices()); });
    check_throws(ErrorCode::unsupported, {"whole", "restrict it first"}, [&] { whole.part_bytes(); });
    const Mesh overlapping = together({cube(1), shifted(cube(1), {0.5, 0.6, 0.7})}, "two");
    const DistanceTransform outer(test_device(), overlapping, {.surface = Surface::outer});
    check_throws(ErrorCode::unsupported, {"surface is outer", "the mesh of outer()"}, [&] {
        outer.restrict_to({box, 0.3, 0.1}).part_bytes();
    });
}

BOOST_AUTO_TEST_CASE(bytes_that_are_no_whole_part_are_refused_by_name) {
    const DistanceTransform whole(test_device(), without_triangle(make_shape("sphere3"), 3));
    const std::vector<std::byte> bytes = whole.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.2, 0.1}).part_bytes();
    const auto refused = [](std::span<const std::byte> wrong, const char* said) {
        check_throws(ErrorCode::invalid_argument, {"these bytes are no part", said, "part_bytes()"},
                     [&] { DistanceTransform::from_part(test_device(), wrong); });
    };
    refused({}, "there are 0");
    refused(std::span(bytes).first(20), "fewer than its head");
    for (std::size_t size = 48; size < bytes.size(); size += 997) refused(std::span(bytes).first(size), "which states");
    std::vector<std::byte> longer = bytes;
    longer.push_back({});
    refused(longer, "which states");
    Random random(11);
    for (int i = 0; i < 300; ++i) {
        std::vector<std::byte> damaged = bytes;
        damaged[48 + random.index(bytes.size() - 48)] ^= std::byte{static_cast<unsigned char>(1U << random.index(8))};
        refused(damaged, "were changed");
    }
    for (const auto& [at, said] : {std::pair{0, "the head has another name"},
                                   {8, "another byte order"},
                                   {12, "layout"},
                                   {16, "was the writer, and this is"},
                                   {24, "which states"},
                                   {40, "were changed"}}) {
        std::vector<std::byte> damaged = bytes;
        damaged[static_cast<std::size_t>(at)] ^= std::byte{1};
        refused(damaged, said);
    }
}

namespace {

constexpr std::size_t head_bytes = 40, place_of_hash = 32;

/// The head's hash of what follows, as a program has it that writes such bytes itself.
void set_hash(std::vector<std::byte>& bytes) {
    WordHash hash;
    std::size_t at = head_bytes;
    for (; at + 8 <= bytes.size(); at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + at, 8);
        hash.add(word);
    }
    for (; at < bytes.size(); ++at) hash.add(std::to_integer<std::uint64_t>(bytes[at]));
    const std::uint64_t value = hash.value();
    std::memcpy(bytes.data() + place_of_hash, &value, 8);
}

}  // namespace

// Sanitizers see whether a wrong index, count or number is used beyond what there is.
BOOST_AUTO_TEST_CASE(bytes_with_wrong_values_and_the_right_hash_do_no_harm) {
    const Mesh mesh = without_triangle(tilted(make_shape("sphere2")), 3);
    const DistanceTransform whole(test_device(), mesh);
    const double h = mesh.box().longest_side() / 16;
    const Region region{boxes_about(mesh).front(), 3 * h, h};
    const Grid grid = samples_in(region.box, h, {0, 0, 0});
    Random random(19);
    for (const double margin : {0.0, 0.2 * h}) {
        const std::vector<std::byte> bytes = whole.restrict_to(region, margin).part_bytes();
        std::vector<std::byte> same = bytes;
        set_hash(same);
        BOOST_REQUIRE((same == bytes));
        std::size_t refused = 0, used = 0;
        for (int i = 0; i < 1500; ++i) {
            std::vector<std::byte> damaged = bytes;
            const std::size_t at = head_bytes + 4 * random.index((bytes.size() - head_bytes) / 4);
            std::uint32_t word = 0;
            std::memcpy(&word, damaged.data() + at, 4);
            const std::array<std::uint32_t, 5> wrong{0xFFFFFFFFU, 0, word + 1, word ^ 1U << random.index(32),
                                                     static_cast<std::uint32_t>(random.index(1000))};
            word = wrong[random.index(wrong.size())];
            std::memcpy(damaged.data() + at, &word, 4);
            set_hash(damaged);
            try {
                DistanceTransform part = DistanceTransform::from_part(test_device(), damaged);
                if (i % 4 == 0) part.compute(grid, Band::symmetric(2 * h), all_outputs());
                if (margin > 0) {
                    std::vector<Vec3> positions;
                    for (const std::uint32_t vertex : part.part_vertices())
                        positions.push_back(mesh.vertices()[vertex % mesh.vertices().size()]);
                    part.set_positions(positions);
                }
                ++used;
            } catch (const Error&) {
                ++refused;
            }
        }
        BOOST_TEST(refused > 100U);
        BOOST_TEST(used > 100U);
    }
}

namespace {

/// Puts other values in the place of these, which are there once.
template <typename Value, std::size_t N>
std::vector<std::byte> with_others(std::vector<std::byte> bytes, const std::array<Value, N>& values,
                                   const std::array<Value, N>& others) {
    const auto sought = std::as_bytes(std::span(values));
    const auto found = std::ranges::search(bytes, sought);
    BOOST_REQUIRE_EQUAL(found.size(), sought.size());
    BOOST_REQUIRE(std::search(found.begin() + 1, bytes.end(), sought.begin(), sought.end()) == bytes.end());
    std::ranges::copy(std::as_bytes(std::span(others)), found.begin());
    set_hash(bytes);
    return bytes;
}

}  // namespace

BOOST_AUTO_TEST_CASE(loops_without_an_edge_and_regions_that_are_none_are_refused) {
    const Mesh two_holes = without_triangle(without_triangle(make_shape("sphere3"), 300), 3);
    const DistanceTransform whole(test_device(), two_holes, {.sign = SignRule::solid_angle});
    const std::vector<std::byte> bytes = whole.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.21, 0.11}).part_bytes();
    using Begins = std::array<std::uint64_t, 4>;  // their number, and they
    using Lengths = std::array<double, 2>;
    for (const std::vector<std::byte>& wrong : {with_others(bytes, Begins{3, 0, 3, 6}, Begins{3, 0, 0, 6}),
                                                with_others(bytes, Begins{3, 0, 3, 6}, Begins{3, 0, 6, 6}),
                                                with_others(bytes, Lengths{0.21, 0.11}, Lengths{std::nan(""), 0.11}),
                                                with_others(bytes, Lengths{0.21, 0.11}, Lengths{0.21, -1})})
        check_throws(ErrorCode::invalid_argument, {"these bytes are no part"},
                     [&] { DistanceTransform::from_part(test_device(), wrong); });
}
