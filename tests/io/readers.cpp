#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <sys/wait.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>

using namespace clsdf;
using namespace clsdf::test;

namespace {

// A narrow band around a plane, with unequal spacing unless `spacing` says so: values that every program has.
Field plain_field(const Vec3& spacing, const clsdf::Band& band = {0.2, 0.25}) {
    Field field({{{-1.1, 0.3, 1.0 / 3}, spacing, {21, 13, 9}}, band, SignRule::parity, "a \"mesh\" & <more>"},
                Output::distance | Output::triangle);
    const auto inside = static_cast<float>(-band.inside), outside = static_cast<float>(band.outside);
    for (std::int64_t k = 0; k < 9; ++k)
        for (std::int64_t j = 0; j < 13; ++j)
            for (std::int64_t i = 0; i < 21; ++i) {
                const auto distance =
                    static_cast<float>(0.1 * static_cast<double>(k + j / 2) - 0.9 + 0.01 * static_cast<double>(i % 3));
                const bool is_in_band = distance > inside && distance < outside;
                const std::size_t sample = field.grid.offset(i, j, k);
                field.distance()[sample] = std::clamp(distance, inside, outside);
                field.triangle()[sample] =
                    is_in_band ? static_cast<std::uint32_t>(7 * i + j + (k << 28)) : clsdf::no_triangle;
            }
    return field;
}

// A ball with bricks inside and outside, on a part of a lattice.
Field ball_field() {
    const clsdf::Band band{0.25, 0.5};
    Field field({clsdf::Grid{{-3, -3, -3}, {0.125, 0.125, 0.125}, {60, 60, 60}}.part({1, 2, 3}, {47, 45, 43}), band,
                 SignRule::nonzero, ""},
                Output::distance | Output::triangle);
    for (std::int64_t k = 0; k < 43; ++k)
        for (std::int64_t j = 0; j < 45; ++j)
            for (std::int64_t i = 0; i < 47; ++i) {
                const Vec3 p = field.grid.position(i, j, k);
                const auto distance = static_cast<float>(std::hypot(p[0], p[1], p[2]) - 2);
                field.distance()[field.grid.offset(i, j, k)] = std::clamp(distance, -0.25F, 0.5F);
                field.triangle()[field.grid.offset(i, j, k)] = clsdf::no_triangle;
            }
    return field;
}

const Vec3 unequal{0.1, 0.07, 1.0 / 7};
const Vec3 equal{0.1, 0.1, 0.1};

// A word of a shell's command line.
std::string quoted(std::string word) {
    for (std::size_t at = 0; (at = word.find('\'', at)) != std::string::npos; at += 4) word.replace(at, 1, R"('\'')");
    return '\'' + word + '\'';
}

// Writes the field and what is expected of it, and has the other program look at it. False if that program is not
// installed (scripts/setup --tests installs it): the check is skipped.
bool check_with_reader(const TemporaryFolder& folder, const std::string& kind, const std::string& ending,
                       const Field& field) {
    Field written = field;
    if (ending == "sdf") written.erase(Output::triangle);
    const std::string path = folder.file("field." + ending);
    if (kind.starts_with("sparse_")) {
        written.erase(Output::triangle);
        write_field(written, folder.file("field.nvdb"));
        write_field(read_sparse_field(folder.file("field.nvdb")).value(), path);
    } else {
        write_field(written, path);
    }
    const std::string expected = folder.file("expected");
    const nlohmann::json about{{"origin", field.grid.position(0, 0, 0)},
                               {"spacing", field.grid.spacing},
                               {"size", field.grid.size},
                               {"band", {{"inside", field.band.inside}, {"outside", field.band.outside}}},
                               {"sign", name_of(field.sign)},
                               {"mesh", field.mesh_name}};
    folder.file("expected.json", about.dump());
    folder.file("expected.f32", bytes_of(field.distance(), std::endian::native));
    folder.file("expected.u32", bytes_of(field.triangle(), std::endian::native));
    const std::string answer = folder.file("answer.txt");
    const std::string line = fmt::format("{} {} {} {} {} >{} 2>&1", quoted(CLSDF_TEST_PYTHON), quoted(CLSDF_READERS),
                                         kind, quoted(path), quoted(expected), quoted(answer));
    const int ended = std::system(line.c_str());
    const int status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
    const bool is_missing = status == 3 || status == 127;  // readers.py's, and the shell's without a Python
    if (is_missing) fmt::print(stderr, "skipped: {}: {}", kind, content_of(answer));
    BOOST_CHECK_MESSAGE(status == 0 || is_missing, kind << ": status " << status << ": " << content_of(answer));
    return !is_missing;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_field_opened_by_the_program_it_is_for)

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_vtk) {
    check_with_reader(TemporaryFolder(), "vti", "vti", plain_field(unequal));
}

// With the groups of its triangles.
BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_vtk_as_vtkhdf) {
    Field field = plain_field(unequal);
    FaceGroups groups{{"even", "odd ones"}, std::vector<std::uint32_t>(256)};
    for (std::uint32_t i = 0; i < groups.numbers.size(); ++i) groups.numbers[i] = i % 2;
    for (std::uint32_t& triangle : field.triangle())
        if (triangle != clsdf::no_triangle) triangle %= 256;
    field.groups = std::make_shared<const FaceGroups>(groups);
    check_with_reader(TemporaryFolder(), "vtkhdf", "vtkhdf", field);
}

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_h5py_and_the_xdmf_file_says_the_same) {
    check_with_reader(TemporaryFolder(), "h5", "h5", plain_field(unequal));
}

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_teem) {
    check_with_reader(TemporaryFolder(), "nrrd", "nrrd", plain_field(unequal));
}

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_numpy) {
    check_with_reader(TemporaryFolder(), "npy", "npy", plain_field(unequal));
}

BOOST_AUTO_TEST_CASE(that_is_sparse_is_looked_up_in_numpy_and_h5py) {
    check_with_reader(TemporaryFolder(), "sparse_npy", "npy", ball_field());
    check_with_reader(TemporaryFolder(), "sparse_h5", "h5", ball_field());
}

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_in_the_text_of_sdfgen) {
    check_with_reader(TemporaryFolder(), "sdf", "sdf", plain_field(equal));
}

BOOST_AUTO_TEST_CASE(is_read_back_from_vtk) {
    const TemporaryFolder folder;
    const Field field = plain_field(unequal);
    if (!check_with_reader(folder, "vti_rewritten", "vti", field)) return;
    for (const std::string header : {"32", "64"}) {
        for (const std::string way :
             {"appended", "base64", "encoded", "compressed", "compressed_raw", "compressed_base64"}) {
            BOOST_TEST_CONTEXT(way << " with headers of " << header << " bits") {
                const Field read = read_field(folder.file("field_" + way + "_" + header + ".vti"));
                BOOST_CHECK(same_bits(read.distance(), field.distance()));
                BOOST_CHECK(std::ranges::equal(read.triangle(), field.triangle()));
                BOOST_CHECK(read.grid == field.grid);
                BOOST_CHECK(read.sign == field.sign);
                BOOST_TEST(read.mesh_name == field.mesh_name);
            }
        }
        const auto refused = [&](const std::string& way, const std::string& word) {
            check_throws(ErrorCode::unreadable_input, {"field_" + way, word},
                         [&] { read_field(folder.file("field_" + way + "_" + header + ".vti")); });
        };
        refused("ascii", "ascii");
        refused("lz4", "vtkLZ4DataCompressor");
    }
}

BOOST_AUTO_TEST_CASE(is_read_back_from_vtkhdf_as_other_programs_write_it) {
    const TemporaryFolder folder;
    const Field field = plain_field(unequal);
    if (!check_with_reader(folder, "vtkhdf_rewritten", "vtkhdf", field)) return;
    for (const std::string name : {"plain_earliest", "plain_latest", "chunks_earliest"}) {
        BOOST_TEST_CONTEXT(name) {
            const Field read = read_field(folder.file("field_" + name + ".vtkhdf"));
            BOOST_CHECK(same_bits(read.distance(), field.distance()));
            BOOST_CHECK(std::ranges::equal(read.triangle(), field.triangle()));
            BOOST_CHECK(read.grid == field.grid);
            BOOST_CHECK(read.band == field.band);
            BOOST_CHECK(read.sign == field.sign);
            BOOST_TEST(read.mesh_name == field.mesh_name);
        }
    }
    const auto refused = [&](const std::string& name, const std::string& word) {
        const std::string path = folder.file("field_" + name + ".vtkhdf");
        check_throws(ErrorCode::unreadable_input, {path, "VTKHDF/PointData/phi", word}, [&] { read_field(path); });
    };
    refused("chunks_latest", "chunks");
    refused("compressed_earliest", "compressed");
    refused("compressed_latest", "compressed");
}

#if CLSDF_WITH_OPENVDB

BOOST_AUTO_TEST_CASE(has_its_values_and_its_place_and_its_band_in_openvdb) {
    check_with_reader(TemporaryFolder(), "vdb", "vdb", plain_field(equal));
    // Not a level set to OpenVDB's tools, which take voxels for cubes.
    check_with_reader(TemporaryFolder(), "vdb_unequal", "vdb", plain_field(unequal));
}

BOOST_AUTO_TEST_CASE(is_read_back_from_openvdb_as_its_active_voxels_with_the_background_as_band) {
    const TemporaryFolder folder;
    const Field field = plain_field(equal, clsdf::Band::symmetric(0.25));
    if (!check_with_reader(folder, "vdb_rewritten", "vdb", field)) return;
    const Field read = read_field(folder.file("field_rewritten.vdb"));
    BOOST_TEST(read.grid.size == (clsdf::Index3{21, 13, 8}), boost::test_tools::per_element());
    BOOST_CHECK(read.sign == clsdf::SignRule::automatic);
    BOOST_TEST(read.band.inside == 0.25);
    BOOST_TEST(read.band.outside == 0.25);
    for (std::int64_t k = 0; k < read.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < read.grid.size[1]; ++j)
            for (std::int64_t i = 0; i < read.grid.size[0]; ++i) {
                const std::int64_t z = read.grid.first[2] + k;
                BOOST_REQUIRE(read.distance()[read.grid.offset(i, j, k)] ==
                              field.distance()[field.grid.offset(i, j, z)]);
                BOOST_REQUIRE(read.grid.position(i, j, k) == field.grid.position(i, j, z));
            }
}

#endif

BOOST_AUTO_TEST_SUITE_END()
