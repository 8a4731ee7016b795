// Arrays in files of a scratch folder have the contents of arrays in memory, and the process stays within its limit.
#include "apps/scratch_folder.hpp"
#include "calls/restricted_bodies.hpp"
#include "support/small_disk.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "scratch_memory.hpp"

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::size_t least_block = 8192, mebibyte = std::size_t{1} << 20, no_limit = std::size_t{1} << 40;

std::vector<Body> all_bodies() {
    std::vector<Body> all = bodies();
    for (const DoubtfulMesh& one : doubtful_meshes()) all.push_back({one.mesh});
    for (const Mesh& mesh : open_meshes(5)) all.push_back({mesh});
    Random random(7);
    all.push_back({reversed(make_shape("sphere4"))});
    all.push_back({unwelded(tilted(make_shape("knot")))});
    all.push_back({random_soup(random, 200, 500)});
    all.push_back({moebius_strip(40)});
    return all;
}

std::vector<std::vector<std::byte>> parts_of(const Body& body, double margin) {
    const double side = body.mesh.box().longest_side(), h = side / 30;
    const DistanceTransform whole(test_device(), body.mesh, body.options);
    std::vector<Box> boxes = boxes_about(body.mesh);
    boxes.resize(2);
    std::vector<std::vector<std::byte>> parts;
    for (const Box& box : boxes) parts.push_back(whole.restrict_to({box, 4 * h, h}, margin * side).part_bytes());
    return parts;
}

/// Numbers of a random-looking sequence that is known.
std::uint64_t number_at(std::uint64_t array, std::uint64_t i) {
    return (array + 1) * 0x9E3779B97F4A7C15U ^ i * 0xD6E8FEB86659FD93U;
}

}  // namespace

BOOST_AUTO_TEST_CASE(parts_made_in_scratch_memory_have_the_bytes_of_others) {
    const ScratchFolder folder("scratch-of-test");
    std::size_t meshes = 0, blocks = 0;
    for (const Body& body : all_bodies()) {
        const double margin = meshes % 2 == 0 ? 0 : 0.02;
        const auto expected = parts_of(body, margin);
        const ScratchMemory scratch(folder.path, meshes % 8 == 0 ? mebibyte : no_limit, least_block);
        const auto found = parts_of(body, margin);
        BOOST_TEST((found == expected), body.mesh.name() << ", margin " << margin);
        blocks += scratch.use().blocks;
        ++meshes;
        BOOST_TEST(folder.is_empty());
    }
    BOOST_TEST(meshes > 40U);
    if (has_scratch) BOOST_TEST(blocks > 10 * meshes);
}

BOOST_AUTO_TEST_CASE(arrays_beyond_the_limit_keep_their_contents_and_leave_the_memory) {
    if (!has_scratch) return;
    const ScratchFolder folder("scratch-of-test");
    constexpr std::size_t arrays = 6, numbers = 8 * mebibyte;  // 64 MiB each
    const std::size_t base = ScratchMemory(folder.path, mebibyte).use().most_resident, limit = base + 128 * mebibyte;
    const ScratchMemory scratch(folder.path, limit);
    std::vector<UninitializedVector<std::uint64_t>> all;
    for (std::size_t a = 0; a < arrays; ++a) {
        all.emplace_back(numbers);
        for_each_index(numbers, [&](std::size_t i) { all[a][i] = number_at(a, i); });
    }
    for (std::size_t round = 0; round < 2; ++round)
        for (std::size_t a = 0; a < arrays; ++a) {
            const bool is_same = reduce_ranges(
                numbers, 4096, true,
                [&](std::size_t begin, std::size_t end, bool same) {
                    for (std::size_t i = begin; i != end; ++i) same = same && all[a][i] == number_at(a, i);
                    return same;
                },
                [](bool one, bool other) { return one && other; });
            BOOST_TEST(is_same, "array " << a);
        }
    BOOST_TEST(scratch.use().most_bytes >= arrays * numbers * sizeof(std::uint64_t));
    BOOST_TEST(scratch.use().most_resident < limit + 32 * mebibyte);
}

BOOST_AUTO_TEST_CASE(a_block_grows_moves_and_may_outlive_the_scratch_memory) {
    const ScratchFolder folder("scratch-of-test");
    std::vector<std::uint64_t> kept;
    {
        const ScratchMemory scratch(folder.path, mebibyte, least_block);
        for (std::uint64_t i = 0; i < 100'000; ++i) kept.push_back(number_at(1, i));
        std::vector<std::uint64_t> other = kept;
        kept.swap(other);
    }
    for (std::uint64_t i = 0; i < 100'000; ++i) kept.push_back(number_at(1, 100'000 + i));
    for (std::uint64_t i = 0; i < kept.size(); ++i) BOOST_REQUIRE(kept[i] == number_at(1, i));
}

BOOST_AUTO_TEST_CASE(a_folder_without_room_is_an_error_that_names_it) {
    if (!has_scratch) return;
    const ScratchFolder folder("scratch-of-test");
    const ScratchMemory scratch(folder.path, no_limit, least_block);
    const Body body{make_shape("sphere5")};
    scratch.throw_if_full();
    const SmallDisk disk(64 * least_block);
    check_throws(ErrorCode::out_of_memory, {"memory"}, [&] { parts_of(body, 0); });
    check_throws(ErrorCode::output_failure, {folder.path, "has no room for", "--scratch"},
                 [&] { scratch.throw_if_full(); });
}

BOOST_AUTO_TEST_CASE(folders_that_would_save_no_memory_are_refused) {
    check_throws(ErrorCode::invalid_argument, {"'/nonexistent'", "No such file", "--scratch"},
                 [] { ScratchMemory("/nonexistent", mebibyte); });
    check_throws(ErrorCode::unsupported, {"'/proc'", "takes no files"}, [] { ScratchMemory("/proc", mebibyte); });
    if (std::filesystem::exists("/dev/shm"))
        check_throws(ErrorCode::unsupported, {"'/dev/shm'", "in memory itself"},
                     [] { ScratchMemory("/dev/shm", mebibyte); });
}
