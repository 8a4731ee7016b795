#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>
#include <clsdf/sparse.hpp>

#include <hdf5.h>
#include <boost/test/unit_test.hpp>

#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array<hsize_t, 3> shape{9, 13, 20};
constexpr std::size_t sample_count = 9 * 13 * 20;
const Vec3 origin{-1.5, 0.1, 1e5};
const Vec3 spacing{0.25, 0.5, 3};

float value_of(std::size_t sample) {
    return 0.1F * static_cast<float>(sample) - 100;
}

/// How another program writes a field with HDF5's C interface.
struct Settings {
    hid_t type = H5T_IEEE_F32LE;
    std::vector<hsize_t> chunk{};  ///< empty: contiguous
    hid_t triangle_type = -1;      ///< none
    hid_t attribute_type = H5T_IEEE_F64LE;
    bool is_complete = true;
    bool is_compressed = false;
    int members = 0;  ///< groups beside the field's arrays
    bool is_newer = false;
    bool is_link = false;  ///< "distance" is a link to another array of the file
};

void add_attribute(hid_t object, const char* name, hid_t type, const Vec3& values) {
    const hsize_t three = 3;
    const hid_t space = H5Screate_simple(1, &three, nullptr);
    const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    BOOST_REQUIRE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data()) >= 0);
    H5Aclose(attribute);
    H5Sclose(space);
}

template <class Value>
void add_array(hid_t file, const char* name, const Settings& settings, hid_t type, hid_t given,
               const std::vector<Value>& values) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (!settings.chunk.empty()) H5Pset_chunk(creation, 3, settings.chunk.data());
    if (settings.is_compressed) H5Pset_shuffle(creation);
    const hid_t space = H5Screate_simple(3, shape.data(), nullptr);
    const hid_t array = H5Dcreate2(file, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    add_attribute(array, "origin", settings.attribute_type, origin);
    add_attribute(array, "spacing", settings.attribute_type, spacing);
    if (settings.is_complete) {
        BOOST_REQUIRE(H5Dwrite(array, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    } else {
        const std::array<hsize_t, 3> first{}, one{1, 1, 1};
        H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, one.data(), nullptr);
        const hid_t memory = H5Screate_simple(3, one.data(), nullptr);
        if (!settings.chunk.empty()) H5Dwrite(array, given, memory, space, H5P_DEFAULT, values.data());
        H5Sclose(memory);
    }
    H5Dclose(array);
    H5Sclose(space);
    H5Pclose(creation);
}

void write_by_hdf5(const std::string& path, const Settings& settings = {}) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    // The default of HDF5 1.
    H5Pset_libver_bounds(access, settings.is_newer ? H5F_LIBVER_LATEST : H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
    BOOST_REQUIRE(file >= 0);
    for (int i = 0; i < settings.members; ++i)
        H5Gclose(H5Gcreate2(file, ("level_" + std::to_string(i)).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    std::vector<float> distance(sample_count);
    for (std::size_t i = 0; i < sample_count; ++i) distance[i] = value_of(i);
    add_array(file, settings.is_link ? "linked" : "distance", settings, settings.type, H5T_NATIVE_FLOAT, distance);
    if (settings.is_link) H5Lcreate_soft("/linked", file, "distance", H5P_DEFAULT, H5P_DEFAULT);
    std::vector<std::uint32_t> triangle(sample_count);
    std::iota(triangle.begin(), triangle.end(), 0xFFFFF000U);
    if (settings.triangle_type >= 0)
        add_array(file, "triangle", settings, settings.triangle_type, H5T_NATIVE_UINT32, triangle);
    H5Fclose(file);
    H5Pclose(access);
    std::ifstream in(path, std::ios::binary);
    in.seekg(8);
    BOOST_REQUIRE((in.get() == 0) != settings.is_newer);  // the superblock's version; 0 has no checksums
}

void check_read(const std::string& path, bool has_triangles) {
    const Field field = read_field(path);
    BOOST_TEST(field.grid.origin == origin, boost::test_tools::per_element());
    BOOST_TEST(field.grid.spacing == spacing, boost::test_tools::per_element());
    BOOST_TEST(field.grid.size == (Index3{20, 13, 9}), boost::test_tools::per_element());
    BOOST_CHECK(field.sign == SignRule::automatic);
    std::size_t wrong = 0;
    BOOST_REQUIRE(field.distance().size() == sample_count);
    BOOST_REQUIRE(field.triangle().size() == (has_triangles ? sample_count : 0));
    for (std::size_t i = 0; i < sample_count; ++i) {
        if (field.distance()[i] != value_of(i)) ++wrong;
        if (has_triangles && field.triangle()[i] != 0xFFFFF000U + static_cast<std::uint32_t>(i)) ++wrong;
    }
    BOOST_TEST(wrong == 0U);
}

/// A sparse field's description and array of bricks, as another program writes them.
void write_bricks(const std::string& path, std::string description, std::size_t bricks) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    BOOST_REQUIRE(file >= 0);
    const hid_t text = H5Tcopy(H5T_C_S1), scalar = H5Screate(H5S_SCALAR);
    H5Tset_size(text, description.size() + 1);
    const hid_t attribute = H5Acreate2(file, "clsdf", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
    BOOST_REQUIRE(H5Awrite(attribute, text, description.c_str()) >= 0);
    const std::array<hsize_t, 2> size{bricks, 3};
    const hid_t space = H5Screate_simple(2, size.data(), nullptr);
    const hid_t array = H5Dcreate2(file, "bricks", H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const std::vector<std::int64_t> values(3 * bricks);
    BOOST_REQUIRE(H5Dwrite(array, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    H5Dclose(array);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Sclose(scalar);
    H5Tclose(text);
    H5Fclose(file);
}

/// Read, or refused as unreadable, and nothing else.
bool can_be_read(const std::string& path) {
    try {
        read_field(path);
        return true;
    } catch (const Error& error) {
        BOOST_CHECK(error.code() == ErrorCode::unreadable_input);
        return false;
    }
}

const std::vector<Settings> some_settings{
    {.triangle_type = H5T_STD_U32LE},
    // More than one level of nodes: 8 members in each of 32, and 64 chunks.
    {.chunk = {2, 3, 4}, .triangle_type = H5T_STD_U32LE, .members = 300},
};

}  // namespace

BOOST_AUTO_TEST_SUITE(a_field_written_with_the_default_settings_of_hdf5)

BOOST_AUTO_TEST_CASE(is_read_contiguous_or_in_chunks_of_any_size_and_in_either_byte_order) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.h5");
    for (const std::vector<hsize_t>& chunk : {std::vector<hsize_t>{}, {9, 13, 20}, {2, 3, 4}, {1, 13, 20}, {1, 1, 1}})
        for (const hid_t type : {H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE, H5T_IEEE_F64BE})
            for (const int members : {0, 300}) {
                write_by_hdf5(path, {.type = type,
                                     .chunk = chunk,
                                     .triangle_type = members == 0 ? H5T_STD_U32BE : H5T_STD_U32LE,
                                     .members = members});
                check_read(path, true);
            }
    for (const hid_t attributes : {H5T_IEEE_F32LE, H5T_IEEE_F64BE}) {
        write_by_hdf5(path, {.attribute_type = attributes});
        BOOST_TEST(read_field(path).grid.spacing == spacing, boost::test_tools::per_element());
    }
    write_by_hdf5(path, {.attribute_type = H5T_STD_I16BE});
    check_throws(ErrorCode::unreadable_input, {"spacing"}, [&] { read_field(path); });  // 0.25 became 0
}

BOOST_AUTO_TEST_CASE(is_refused_with_the_remedy_if_it_is_compressed_incomplete_or_of_another_type) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.h5");
    const auto refused = [&](const Settings& settings, const std::vector<std::string>& fragments) {
        write_by_hdf5(path, settings);
        check_throws(ErrorCode::unreadable_input, fragments, [&] { read_field(path); });
    };
    refused({.chunk = {2, 3, 4}, .is_compressed = true}, {path, "/distance", "without filters"});
    refused({.chunk = {2, 3, 4}, .is_complete = false}, {"/distance", "chunks are missing"});
    refused({.is_complete = false}, {"/distance", "no values"});
    refused({.type = H5T_STD_I32LE}, {"/distance", "neither floats"});
    refused({.type = H5T_STD_U32LE}, {"/distance", "of another type"});
    refused({.triangle_type = H5T_IEEE_F32LE}, {"/triangle", "of another type"});
    refused({.is_link = true}, {"/distance", "is a link; store the array itself"});
    refused({.chunk = {2, 3, 4}, .is_newer = true}, {"/distance", "in chunks", "h5repack -l CONTI"});
    refused({.chunk = {2, 3, 4}, .is_compressed = true, .is_newer = true},
            {"/distance", "compressed", "h5repack -f NONE"});
}

BOOST_AUTO_TEST_CASE(is_refused_wherever_it_is_cut_off) {
    const TemporaryFolder folder;
    for (const Settings& settings : some_settings) {
        const std::string path = folder.file("field.h5");
        write_by_hdf5(path, settings);
        const auto size = std::filesystem::file_size(path);
        for (std::uintmax_t length = size; length-- > 0; length -= std::min(length, size / 997)) {
            std::filesystem::resize_file(path, length);
            BOOST_TEST(!can_be_read(path), "cut to " << length << " bytes");
        }
    }
}

BOOST_AUTO_TEST_CASE(is_read_or_refused_but_nothing_else_whatever_bytes_change) {
    constexpr unsigned seed = 5;
    std::mt19937 random(seed);
    const TemporaryFolder folder;
    for (const Settings& settings : some_settings) {
        const std::string whole_path = folder.file("whole.h5");
        write_by_hdf5(whole_path, settings);
        const std::string whole = content_of(whole_path);
        // Most of a file are values; what surrounds the parts' signatures is what the reader walks along.
        std::vector<std::size_t> structure{8, 24, 60};
        for (const char* signature : {"TREE", "SNOD", "HEAP", "origin", "spacing"})
            for (std::size_t at = whole.find(signature); at != std::string::npos; at = whole.find(signature, at + 1))
                structure.push_back(at);
        std::size_t read = 0;
        for (int round = 0; round < 4000; ++round) {
            BOOST_TEST_CONTEXT("seed " << seed << ", round " << round) {
                std::string mutated = whole;
                for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
                    const std::size_t near = structure[random() % structure.size()];
                    const std::size_t at =
                        random() % 4 == 0
                            ? random() % whole.size()
                            : std::min(whole.size() - 1, near - std::min(near, std::size_t{300}) + random() % 400);
                    // A byte, a number of 8 bytes that is large, or one that leads somewhere else in the file.
                    const std::size_t width = std::min<std::size_t>(whole.size() - at, random() % 2 == 0 ? 1 : 8);
                    const std::size_t elsewhere = structure[random() % structure.size()];
                    for (std::size_t i = 0; i < width; ++i)
                        mutated[at + i] = static_cast<char>(width == 1       ? random()
                                                            : round % 2 == 0 ? 0xFFU
                                                                             : elsewhere >> (8 * i));
                }
                if (can_be_read(folder.file("mutated.h5", mutated))) ++read;
            }
        }
        BOOST_TEST_MESSAGE(read << " of 4000 are read all the same");
        BOOST_TEST(read > 0U);
        BOOST_TEST(read < 4000U);
    }
}

BOOST_AUTO_TEST_CASE(is_refused_if_it_has_more_bricks_than_numbers) {
    const TemporaryFolder folder;
    SparseField field;
    field.grid = {.origin = {}, .spacing = {1, 1, 1}, .size = {8, 8, 8}};
    field.band = Band::symmetric(1);
    write_field(field, folder.file("field.npy"));
    const std::string path = folder.file("field.h5");
    constexpr std::size_t bricks = 777;
    write_bricks(path, content_of(folder.file("field.npy.json")), bricks);
    check_throws(ErrorCode::unreadable_input, {"field.h5", "inside_runs"}, [&] { read_sparse_field(path); });

    std::string bytes = content_of(path);
    std::string shape(16, '\0');
    shape[0] = static_cast<char>(bricks % 256);
    shape[1] = static_cast<char>(bricks / 256);
    shape[8] = 3;
    const std::size_t at = bytes.find(shape);
    BOOST_REQUIRE(at != std::string::npos);
    bytes[at + 7] = static_cast<char>(0x80);
    std::ofstream(path, std::ios::binary) << bytes;
    check_throws(ErrorCode::unreadable_input, {"field.h5", "'/bricks'", "shape"}, [&] { read_sparse_field(path); });
}

BOOST_AUTO_TEST_SUITE_END()
