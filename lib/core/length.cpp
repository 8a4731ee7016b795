#include <clsdf/error.hpp>
#include <clsdf/length.hpp>

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

namespace clsdf {

Length Length::infinite() {
    return in_mesh_units(std::numeric_limits<double>::infinity());
}

bool Length::is_infinite() const {
    return std::isinf(value);
}

Length Length::parse(const std::string& text) {
    if (text == "full") return infinite();

    std::string_view digits = text;
    Unit unit = Unit::mesh;
    if (digits.ends_with('%'))
        unit = Unit::extent;
    else if (digits.ends_with('v'))
        unit = Unit::voxels;
    if (unit != Unit::mesh) digits.remove_suffix(1);

    double value = 0;
    const char* end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value) || value < 0)
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("\"{}\" is not a length: write 10% (of the longest side of the mesh's box), 3v (voxels), "
                        "0.05 (the mesh's units) or full",
                        text));
    return {unit == Unit::extent ? value / 100 : value, unit};
}

double Length::resolve(double voxel, double extent) const {
    if (is_infinite()) return value;
    switch (unit) {
        case Unit::voxels:
            return value * voxel;
        case Unit::extent:
            return value * extent;
        case Unit::mesh:
            break;
    }
    return value;
}

}  // namespace clsdf
