// Boxes of refined levels as VTK's OverlappingAMR. What VTK itself makes of such a file:
// bindings/python/tests/test_files.py.
#include "io/fields/hdf5.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// `size` cells from the cell `first` of a lattice of cells of this side, which begins at (-1, 2, 0.5).
Field box(double side, Index3 first, Index3 size, float value) {
    Grid grid{.origin = {}, .spacing = {side, side, side}, .size = size};
    const Vec3 corner{-1, 2, 0.5};
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] = corner[axis] + side * (static_cast<double>(first[axis]) + 0.5);
    FieldDescription description;
    description.grid = grid;
    Field field(description, {Output::distance, Output::closest});
    for (float& distance : field.distance()) distance = value++;
    std::ranges::fill(field.closest(), value);
    return field;
}

std::vector<CellBox> views(const std::vector<Field>& fields) {
    std::vector<CellBox> boxes;
    for (const Field& field : fields) boxes.push_back({field.grid, field.slab()});
    return boxes;
}

/// The values of an array of an HDF5 file, whatever its shape.
template <typename Value>
std::vector<Value> values_of(const std::string& path, const std::string& array, hid_t type) {
    const hdf5::Session session;
    hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    hdf5::Handle data(H5Dopen2(file.get(), array.c_str(), H5P_DEFAULT), H5Dclose);
    BOOST_REQUIRE(data.is_valid());
    hdf5::Handle space(H5Dget_space(data.get()), H5Sclose);
    std::vector<Value> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
    BOOST_REQUIRE(H5Dread(data.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    return values;
}

std::vector<std::int32_t> cells_of(const std::string& path, int level) {
    return values_of<std::int32_t>(path, "VTKHDF/Level" + std::to_string(level) + "/AMRBox", H5T_NATIVE_INT32);
}

}  // namespace

BOOST_AUTO_TEST_CASE(boxes_of_a_spacing_are_a_level_at_their_places) {
    // In no order; the fine ones lie in the coarse ones, and one begins before them.
    const std::vector<Field> fields{box(0.25, {4, 4, 0}, {2, 2, 4}, 100), box(0.5, {0, 0, 0}, {4, 3, 2}, 0),
                                    box(0.25, {-2, 0, 0}, {4, 2, 2}, 200), box(0.5, {4, 0, 0}, {2, 3, 2}, 50)};
    const TemporaryFolder folder;
    const std::string path = folder.file("levels.vtkhdf");
    write_overlapping_amr(views(fields), path);
    const std::vector<std::int32_t> coarse{0, 3, 0, 2, 0, 1, 4, 5, 0, 2, 0, 1},
        fine{4, 5, 4, 5, 0, 3, -2, 1, 0, 1, 0, 1};
    BOOST_TEST(cells_of(path, 0) == coarse, boost::test_tools::per_element());
    BOOST_TEST(cells_of(path, 1) == fine, boost::test_tools::per_element());
    for (const auto& [level, boxes] : {std::pair{0, std::pair{1, 3}}, {1, {0, 2}}}) {
        const std::string data = "VTKHDF/Level" + std::to_string(level) + "/CellData/";
        std::vector<float> distances;
        std::vector<double> closest;
        for (const int i : {boxes.first, boxes.second}) {
            const Field& field = fields[static_cast<std::size_t>(i)];
            distances.insert(distances.end(), field.distance().begin(), field.distance().end());
            closest.insert(closest.end(), field.closest().begin(), field.closest().end());
        }
        BOOST_TEST(values_of<float>(path, data + "distance", H5T_NATIVE_FLOAT) == distances,
                   boost::test_tools::per_element());
        BOOST_TEST(values_of<double>(path, data + "closest", H5T_NATIVE_DOUBLE) == closest,
                   boost::test_tools::per_element());
    }
}

BOOST_AUTO_TEST_CASE(a_box_that_does_not_fit_is_named_and_nothing_is_left) {
    const Field coarse = box(0.5, {0, 0, 0}, {4, 4, 4}, 0);
    Field other_outputs = box(0.25, {0, 0, 0}, {2, 2, 2}, 0);
    other_outputs.erase(Output::closest);
    const TemporaryFolder folder;
    const auto refused = [&](std::vector<Field> fields, const char* said) {
        fields.insert(fields.begin(), coarse);
        check_throws(ErrorCode::invalid_argument, {said},
                     [&] { write_overlapping_amr(views(fields), folder.file("levels.vtkhdf")); });
    };
    refused({box(0.2, {0, 0, 0}, {2, 2, 2}, 0)}, "box 1 of a refined mesh: 0.2 is no whole part");
    Field beside = box(0.25, {0, 0, 0}, {2, 2, 2}, 0);
    beside.grid.origin[1] += 0.1;
    refused({beside}, "box 1 of a refined mesh: its cells lie 0.4 cells beside");
    refused({box(0.5, {3, 3, 3}, {2, 2, 2}, 0)}, "box 1 of a refined mesh: it overlaps box 0 of the same spacing");
    refused({other_outputs}, "box 1 of a refined mesh: it has other outputs than box 0");
    CellBox short_box{coarse.grid, coarse.slab()};
    ++short_box.grid.size[0];
    const std::vector<CellBox> boxes{short_box};
    check_throws(ErrorCode::invalid_argument, {"'distance' has 256 bytes, not those of 80 cells"},
                 [&] { write_overlapping_amr(boxes, folder.file("levels.vtkhdf")); });
    check_throws(ErrorCode::invalid_argument, {"one box at least"},
                 [&] { write_overlapping_amr({}, folder.file("levels.vtkhdf")); });
    check_throws(ErrorCode::unsupported, {"written as .vtkhdf"},
                 [&] { write_overlapping_amr(views({coarse}), folder.file("levels.vti")); });
    BOOST_TEST(std::filesystem::is_empty(std::filesystem::path(folder.file("x")).parent_path()));
}
