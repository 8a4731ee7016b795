#include "acceptance/case.hpp"

#include <fmt/format.h>

namespace clsdf::acceptance {

std::string name_of(const Setting& setting) {
    return fmt::format("{}, {:g}%", setting.resolution, 100 * setting.share);
}

Problem problem(Mesh mesh, const Setting& setting, SignRule sign) {
    const Band band = Band::symmetric(setting.share * mesh.box().longest_side());
    const Grid grid = Grid::around(mesh, setting.resolution, band);
    return {std::move(mesh), grid, band, sign};
}

Grid grid_about(const Vec3& centre, double h, std::int64_t reach) {
    Grid grid;
    grid.spacing = {h, h, h};
    grid.size = {2 * reach + 1, 2 * reach + 1, 2 * reach + 1};
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = centre[axis] - static_cast<double>(reach) * h;
    return grid;
}

}  // namespace clsdf::acceptance
