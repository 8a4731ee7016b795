#include "io/fields/field_files.hpp"
#include "io/fields/hdf5.hpp"
#include "io/fields/vtkhdf.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf {
namespace {

Grid grid_of(const InputFile& file, const hdf5::Source& source) {
    const std::vector<double> direction = source.numbers(vtkhdf::root, "Direction", 9, "nine numbers");
    if (direction != std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1})
        file.fail("attribute 'Direction': the grid is not parallel to the axes");
    const std::vector<double> extent = source.numbers(vtkhdf::root, "WholeExtent", 6, "six numbers");
    Grid grid;
    grid.origin = source.triple(vtkhdf::root, "Origin");
    grid.spacing = source.triple(vtkhdf::root, "Spacing");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = extent[2 * axis], last = extent[2 * axis + 1];
        constexpr double most = 9007199254740992;  // 2^53
        if (!(first >= -most && last <= most && first <= last) || first != std::floor(first) ||
            last != std::floor(last))
            file.fail(fmt::format("attribute 'WholeExtent': {} to {} is no range of samples", first, last));
        grid.first[axis] = static_cast<std::int64_t>(first);
        grid.size[axis] = static_cast<std::int64_t>(last) - grid.first[axis] + 1;
    }
    grid.validate();
    return grid;
}

std::string in_points(const std::string& array) {
    return std::string(vtkhdf::point_data) + "/" + array;
}

/// The distance's name: "distance", or that of the array that PointData calls its scalars.
std::string name_of_distance(const InputFile& file, const hdf5::Source& source) {
    const std::string own = in_points(info_of(Output::distance).name);
    if (source.has(own)) return own;
    if (source.has(vtkhdf::point_data))
        if (const auto scalars = source.text(vtkhdf::point_data, "Scalars"); scalars && source.has(in_points(*scalars)))
            return in_points(*scalars);
    file.fail("no array of its points is called \"distance\", and none is the Scalars");
}

hdf5::WantedArray wanted_array(const std::string& path, const OutputInfo& info) {
    hdf5::WantedArray wanted(info);
    wanted.name = path;
    return wanted;
}

Field read(InputFile& file, const hdf5::Source& source, OutputSet wanted) {
    if (!source.has(vtkhdf::root)) file.fail("there is no group '/VTKHDF'; a field of clsdf in HDF5 ends in .h5");
    const std::string type = source.text(vtkhdf::root, "Type").value_or("");
    if (type != "ImageData")
        file.fail(fmt::format("attribute 'Type' is \"{}\": a field is ImageData", type.substr(0, 80)));
    Field field;
    field.grid = grid_of(file, source);
    field.band = Band::full();
    field.sign = SignRule::automatic;
    if (const std::optional<std::string> text = source.text("", "clsdf"))
        field = parse_description(file.path() + ": attribute 'clsdf'", *text, field.grid).field;
    const OutputInfo& distance = info_of(Output::distance);
    hdf5::read_samples(file, source, wanted_array(name_of_distance(file, source), distance), distance, field);
    for (const OutputInfo& info : extra_outputs())
        if (const std::string name = in_points(info.name); wanted.contains(info.output) && source.has(name))
            hdf5::read_samples(file, source, wanted_array(name, info), info, field);
    return field;
}

}  // namespace

Field read_vtkhdf(const std::string& path, OutputSet wanted) {
    Field field;
    hdf5::with_source(path, [&](InputFile& file, const hdf5::Source& source) { field = read(file, source, wanted); });
    return field;
}

}  // namespace clsdf
