#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

using namespace clsdf;
using namespace clsdf::test;

#if CLSDF_WITH_OPENVDB

namespace {

// A ball whose inside and outside reach beyond the band, on a grid that is no multiple of OpenVDB's leaves.
Field ball(const clsdf::Band& band) {
    Field field({{{-2.1, -1.9, -2}, {0.1, 0.1, 0.1}, {43, 39, 41}}, band, SignRule::nonzero, ""},
                Output::distance | Output::triangle);
    for (std::int64_t k = 0; k < field.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < field.grid.size[1]; ++j)
            for (std::int64_t i = 0; i < field.grid.size[0]; ++i) {
                const clsdf::Vec3 p = field.grid.position(i, j, k);
                const double distance = std::hypot(p[0], p[1], p[2]) - 1.7;
                const std::size_t sample = field.grid.offset(i, j, k);
                field.distance()[sample] = distance > band.outside   ? static_cast<float>(band.outside)
                                           : distance < -band.inside ? -static_cast<float>(band.inside)
                                                                     : static_cast<float>(distance);
                field.triangle()[sample] =
                    std::abs(distance) < 0.2 ? static_cast<std::uint32_t>(i) : clsdf::no_triangle;
            }
    return field;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_vdb_field)

BOOST_AUTO_TEST_CASE(has_the_same_bits_for_every_band) {
    const TemporaryFolder folder;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const clsdf::Band band : {clsdf::Band{0.2, 0.2}, clsdf::Band{0.3, 0.2}, clsdf::Band{0, 0.2},
                                   clsdf::Band{0.2, 0}, clsdf::Band::signs_only(), clsdf::Band{infinity, 0.2},
                                   clsdf::Band{0.2, infinity}, clsdf::Band{infinity, infinity}}) {
        BOOST_TEST_CONTEXT("band " << band.inside << " inside, " << band.outside << " outside") {
            const Field field = ball(band);
            write_field(field, folder.file("ball.vdb"));
            const Field read = read_field(folder.file("ball.vdb"));
            BOOST_CHECK(same_bits(read.distance(), field.distance()));
            BOOST_CHECK(std::ranges::equal(read.triangle(), field.triangle()));
            BOOST_CHECK(read.grid == field.grid);
        }
    }
}

BOOST_AUTO_TEST_CASE(is_smaller_than_its_samples_where_the_band_is_narrow) {
    const TemporaryFolder folder;
    Field field = ball({0.15, 0.15});
    field.erase(Output::triangle);
    write_field(field, folder.file("ball.vdb"));
    BOOST_TEST(content_of(folder.file("ball.vdb")).size() < 3 * field.distance().size());
}

BOOST_AUTO_TEST_CASE(of_voxels_too_small_for_openvdb_says_so) {
    const TemporaryFolder folder;
    Field field = ball({0.2, 0.2});
    field.grid.spacing = {1e-6, 1e-6, 1e-6};
    check_throws(ErrorCode::unsupported, {"ball.vdb", "scale the mesh"},
                 [&] { write_field(field, folder.file("ball.vdb")); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(that_is_damaged_has_a_wrong_checksum_wherever_the_damage_is) {
    const TemporaryFolder folder;
    write_field(ball({0.2, 0.2}), folder.file("ball.vdb"));
    const std::string whole = content_of(folder.file("ball.vdb"));
    const auto refused = [&](const std::string& damaged) {
        check_throws(ErrorCode::unreadable_input, {"damaged.vdb", "checksum"},
                     [&] { read_field(folder.file("damaged.vdb", damaged)); });
    };
    for (std::size_t position = 8; position < whole.size(); position += 101) {
        std::string damaged = whole;
        damaged[position] = static_cast<char>(damaged[position] ^ 1);
        refused(damaged);
    }
    refused(whole + '\0');
    refused(whole.substr(0, whole.size() - 1));
}

BOOST_AUTO_TEST_CASE(that_openvdb_saved_again_has_its_own_uuid_and_no_checksum) {
    const TemporaryFolder folder;
    const Field field = ball({0.2, 0.2});
    write_field(field, folder.file("ball.vdb"));
    std::string content = content_of(folder.file("ball.vdb"));
    const std::string random = "3f0c7a9e-51d2-4b86-9e1f-0a2b4c6d8e9f";
    content.replace(content.find("c15df000-0000-8000-"), random.size(), random);
    const Field read = read_field(folder.file("saved.vdb", content));
    BOOST_CHECK(same_bits(read.distance(), field.distance()));
    BOOST_CHECK(read.grid == field.grid);
    BOOST_CHECK(read.sign == field.sign);
}

BOOST_AUTO_TEST_CASE(with_damage_in_its_uuid_is_damaged) {
    const TemporaryFolder folder;
    write_field(ball({0.2, 0.2}), folder.file("ball.vdb"));
    std::string content = content_of(folder.file("ball.vdb"));
    content[content.find("c15df000-0000-8000-")] = 'a';
    check_throws(ErrorCode::unreadable_input, {"damaged.vdb", "checksum"},
                 [&] { read_field(folder.file("damaged.vdb", content)); });
}

BOOST_AUTO_TEST_SUITE_END()

#else

BOOST_AUTO_TEST_CASE(a_build_without_openvdb_says_what_to_install_before_anything_is_computed) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.vdb");
    check_throws(ErrorCode::unsupported, {path, "libopenvdb-dev"}, [&] { check_field_path(path); });
    check_throws(ErrorCode::unsupported, {path, "libopenvdb-dev"}, [&] { write_field(example_field(), path); });
    check_throws(ErrorCode::unsupported, {path, "libopenvdb-dev"}, [&] { read_field(path); });
    BOOST_TEST(folder.file_count() == 0U);
}

#endif
