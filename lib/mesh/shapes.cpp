#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include "core/text.hpp"
#include "mesh/shape_builders.hpp"

#include <fmt/format.h>

#include <functional>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

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
    // libc++ has no from_chars for numbers with a point.
    std::istringstream text{std::string(name)};
    text.imbue(std::locale::classic());
    double thickness = 0;
    if (!(text >> std::noskipws >> thickness) || text.peek() != std::istringstream::traits_type::eof()) return {};
    if (!(thickness > 0 && thickness <= 1))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("a plate's thickness is above 0 and at most 1, its longest side, but not {}", name));
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
    throw Error(ErrorCode::invalid_argument,
                fmt::format("there is no shape '{}'; the nearest name is '{}'", name, nearest_name(name, known)));
}

}  // namespace clsdf
