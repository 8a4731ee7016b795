#include "core/real_numbers.hpp"
#include "core/refuse.hpp"
#include "tools/shape_builders.hpp"
#include "tools/text.hpp"

#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace clsdf::shapes {

namespace {

/// Turns the vertices about z, then y, then x, by angles that are no simple fractions of a turn.
void tilt(MeshArrays& mesh) {
    constexpr Vec3 angles{0.173, 0.311, 0.237};
    for (Vec3& vertex : mesh.vertices)
        for (const std::size_t axis : {2U, 1U, 0U}) {
            const double c = std::cos(angles[axis]);
            const double s = std::sin(angles[axis]);
            double& p = vertex[(axis + 1) % 3];
            double& q = vertex[(axis + 2) % 3];
            const double turned = c * p - s * q;
            q = s * p + c * q;
            p = turned;
        }
}

}  // namespace

MeshArrays cube() {
    MeshArrays mesh;
    for (const double z : {0.0, 1.0})
        for (const double y : {0.0, 1.0})
            for (const double x : {0.0, 1.0}) mesh.vertices.push_back({x, y, z});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

MeshArrays tetrahedron() {
    return {{{0, 0, 0}, {-4, -4, -3}, {1, 1, 3}, {-2, -1, -2}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

MeshArrays needle() {
    constexpr double width = 1e-6;
    const double side = 0.5 * std::sqrt(3.0) * width;
    MeshArrays mesh{{{0, 0, 0.9}, {width, 0, 0}, {-0.5 * width, side, 0}, {-0.5 * width, -side, 0}, {0, 0, -0.1}},
                    {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {4, 2, 1}, {4, 3, 2}, {4, 1, 3}}};
    tilt(mesh);
    return mesh;
}

MeshArrays plate(double thickness) {
    constexpr std::uint32_t cells_x = 12;
    constexpr std::uint32_t cells_y = 9;
    MeshArrays mesh;
    for (const double z : {0.0, thickness})
        for (std::uint32_t j = 0; j <= cells_y; ++j)
            for (std::uint32_t i = 0; i <= cells_x; ++i)
                mesh.vertices.push_back({static_cast<double>(i) / cells_x, static_cast<double>(j) / cells_x, z});
    const auto vertex = [](std::uint32_t i, std::uint32_t j, std::uint32_t layer) {
        return (layer * (cells_y + 1) + j) * (cells_x + 1) + i;
    };
    const auto add_quadrilateral = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
    };
    for (std::uint32_t j = 0; j < cells_y; ++j)
        for (std::uint32_t i = 0; i < cells_x; ++i) {
            add_quadrilateral(vertex(i, j, 0), vertex(i, j + 1, 0), vertex(i + 1, j + 1, 0), vertex(i + 1, j, 0));
            add_quadrilateral(vertex(i, j, 1), vertex(i + 1, j, 1), vertex(i + 1, j + 1, 1), vertex(i, j + 1, 1));
        }
    // The rim, between neighbouring points of either layer with the inside on the left.
    const auto add_wall = [&](std::uint32_t i0, std::uint32_t j0, std::uint32_t i1, std::uint32_t j1) {
        add_quadrilateral(vertex(i0, j0, 0), vertex(i1, j1, 0), vertex(i1, j1, 1), vertex(i0, j0, 1));
    };
    for (std::uint32_t i = 0; i < cells_x; ++i) {
        add_wall(i, 0, i + 1, 0);
        add_wall(i + 1, cells_y, i, cells_y);
    }
    for (std::uint32_t j = 0; j < cells_y; ++j) {
        add_wall(cells_x, j, cells_x, j + 1);
        add_wall(0, j + 1, 0, j);
    }
    tilt(mesh);
    return mesh;
}

MeshArrays stairs() {
    constexpr std::uint32_t steps = 24;
    constexpr double rise = 0.12;
    constexpr double depth = 8;
    // Each column of the profile is the ground below its tread, left and right, and the tread's two ends; neighbouring
    // columns share the ground's points, and a column's left side passes through the tread before it.
    const auto ground = [](std::uint32_t column, std::uint32_t side) { return 2 * column + side; };
    const auto tread = [](std::uint32_t column, std::uint32_t end, std::uint32_t side) {
        return 2 * (steps + 1) + 4 * column + 2 * end + side;
    };
    MeshArrays mesh;
    for (std::uint32_t column = 0; column <= steps; ++column)
        for (const double y : {0.0, depth}) mesh.vertices.push_back({static_cast<double>(column), y, -1});
    for (std::uint32_t column = 0; column < steps; ++column)
        for (const std::uint32_t end : {0U, 1U})
            for (const double y : {0.0, depth})
                mesh.vertices.push_back({static_cast<double>(column + end), y, rise * column});
    const auto add = [&](std::initializer_list<std::uint32_t> corners) { mesh.add_polygon(corners); };
    const auto add_wall = [&](const auto& from, const auto& to) { add({from(0U), from(1U), to(1U), to(0U)}); };
    for (std::uint32_t column = 0; column < steps; ++column) {
        const auto ground_left = [&](std::uint32_t side) { return ground(column, side); };
        const auto ground_right = [&](std::uint32_t side) { return ground(column + 1, side); };
        const auto tread_left = [&](std::uint32_t side) { return tread(column, 0, side); };
        const auto tread_right = [&](std::uint32_t side) { return tread(column, 1, side); };
        const auto before = [&](std::uint32_t side) { return tread(column - 1, 1, side); };
        add_wall(ground_left, ground_right);
        add_wall(tread_right, tread_left);
        if (column == 0) {
            add_wall(tread_left, ground_left);
            add({tread_right(0), tread_left(0), ground_left(0), ground_right(0)});
            add({tread_right(1), ground_right(1), ground_left(1), tread_left(1)});
        } else {
            add_wall(tread_left, before);
            add({tread_right(0), tread_left(0), before(0), ground_left(0), ground_right(0)});
            add({tread_right(1), ground_right(1), ground_left(1), before(1), tread_left(1)});
        }
        if (column + 1 == steps) add_wall(ground_right, tread_right);
    }
    return mesh;
}

MeshArrays step() {
    MeshArrays mesh;
    for (const double y : {0.0, 20.0})
        for (const auto& [x, z] :
             {std::pair{0.0, -10.0}, {20.0, -10.0}, {20.0, 0.01}, {10.0, 0.01}, {10.0, 0.0}, {0.0, 0.0}})
            mesh.vertices.push_back({x, y, z});
    mesh.triangles = {{0, 7, 1},  {0, 6, 7},  {1, 8, 2},   {1, 7, 8},  {2, 9, 3},  {2, 8, 9}, {3, 10, 4},
                      {3, 9, 10}, {4, 11, 5}, {4, 10, 11}, {5, 6, 0},  {5, 11, 6}, {4, 5, 0}, {10, 6, 11},
                      {4, 0, 1},  {10, 7, 6}, {4, 1, 2},   {10, 8, 7}, {4, 2, 3},  {10, 9, 8}};
    return mesh;
}

MeshArrays flap() {
    MeshArrays mesh;
    for (const double y : {0.0, 20.0})
        for (const auto& [x, z] :
             {std::pair{0.0, -5.0}, {20.0, -5.0}, {20.0, 0.0}, {10.01, 0.0}, {9.9, 0.02}, {10.0, 0.0}, {0.0, 0.0}})
            mesh.vertices.push_back({x, y, z});
    mesh.triangles = {{0, 8, 1},  {0, 7, 8},   {1, 9, 2},   {1, 8, 9},   {2, 10, 3},   {2, 9, 10},
                      {3, 11, 4}, {3, 10, 11}, {4, 12, 5},  {4, 11, 12}, {5, 13, 6},   {5, 12, 13},
                      {6, 7, 0},  {6, 13, 7},  {0, 1, 5},   {1, 3, 5},   {1, 2, 3},    {3, 4, 5},
                      {0, 5, 6},  {7, 12, 8},  {8, 12, 10}, {8, 10, 9},  {10, 12, 11}, {7, 13, 12}};
    return mesh;
}

}  // namespace clsdf::shapes

namespace clsdf {

namespace {

/// The candidate that is the fewest insertions, deletions and replacements of one character away from the text, the
/// first of several; empty if there is no candidate.
std::string nearest_name(std::string_view text, std::span<const std::string> candidates) {
    std::string nearest;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(text, candidate);
        if (distance < least) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

struct Shape {
    ShapeName name;
    std::function<MeshArrays()> build;
};

std::vector<Shape> catalogue() {
    std::vector<Shape> result;
    for (int level = 0; level <= 9; ++level) {
        const std::size_t faces = std::size_t{8} << (2 * level);
        std::string description = fmt::format("unit sphere, an octahedron subdivided {} times: {} vertices, {} faces",
                                              level, faces / 2 + 2, faces);
        result.push_back({{fmt::format("sphere{}", level), std::move(description)},
                          [level] { return shapes::subdivided_octahedron(level); }});
    }
    const std::vector<Shape> others{
        {{"torus", "torus of 100 x 30 vertices, 1788 of them saddles"}, shapes::torus},
        {{"knot", "tube of 240 x 6 vertices around the (2, 3) torus knot"}, shapes::knot},
        {{"seashell", "spiral tube of 83 x 11 vertices, closed at both ends"}, shapes::seashell},
        {{"stairs", "solid flight of 24 low steps"}, shapes::stairs},
        {{"plate", "tilted thin box of longest side 1 and thickness 0.01; another thickness follows the name"},
         [] { return shapes::plate(1e-2); }},
        {{"plate1e-4", "the same of thickness 1e-4"}, [] { return shapes::plate(1e-4); }},
        {{"plate1e-6", "the same of thickness 1e-6"}, [] { return shapes::plate(1e-6); }},
        {{"needle", "tilted spike of length 1 and width 1e-6"}, shapes::needle},
        {{"tetrahedron", "one tetrahedron with obtuse corners"}, shapes::tetrahedron},
        {{"cube", "axis-parallel unit cube"}, shapes::cube},
        {{"noisy", "unit sphere of 20480 faces with noise along its radius"}, shapes::noisy_sphere},
        {{"nested", "three spheres within one another, the middle one a hollow"}, shapes::nested_spheres},
        {{"step", "block with a step of one thousandth of its height"}, shapes::step},
        {{"flap", "block with a thin flap that all but lies on it"}, shapes::flap},
    };
    result.insert(result.end(), others.begin(), others.end());
    return result;
}

/// "plate0.002" -> 0.002.
std::optional<double> plate_thickness(std::string_view name) {
    constexpr std::string_view prefix = "plate";
    if (!name.starts_with(prefix)) return {};
    name.remove_prefix(prefix.size());
    double thickness = 0;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = read_real(name.data(), end, thickness);
    if (error != std::errc() || stop != end || !std::isfinite(thickness)) return {};
    if (!(thickness > 0 && thickness <= 1))
        refuse("a plate's thickness is above 0 and at most 1, its longest side, but not {}", name);
    return thickness;
}

}  // namespace

std::vector<ShapeName> shape_names() {
    std::vector<ShapeName> names;
    for (Shape& shape : catalogue()) names.push_back(std::move(shape.name));
    return names;
}

Mesh make_shape(const std::string& name) {
    std::vector<std::string> known;
    for (const Shape& shape : catalogue()) {
        if (shape.name.name == name) {
            MeshArrays arrays = shape.build();
            return Mesh(std::move(arrays.vertices), std::move(arrays.triangles), name);
        }
        known.push_back(shape.name.name);
    }
    if (const std::optional<double> thickness = plate_thickness(name)) {
        MeshArrays arrays = shapes::plate(*thickness);
        return Mesh(std::move(arrays.vertices), std::move(arrays.triangles), name);
    }
    refuse("there is no shape '{}'; the nearest name is '{}'", name, nearest_name(name, known));
}

}  // namespace clsdf
