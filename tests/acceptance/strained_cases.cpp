#include "acceptance/cases.hpp"

#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include "support/hostile_meshes.hpp"

#include <algorithm>
#include <numbers>

namespace clsdf::acceptance {

namespace {

void add_plates(Scope scope, std::vector<Case>& cases) {
    const std::vector<Setting> settings = scope == Scope::complete
                                              ? std::vector<Setting>{{96, 0.10}, {192, 0.03}, {256, 0.01}}
                                              : std::vector<Setting>{{96, 0.03}};
    for (const double thickness : {1e-4, 1e-6}) {
        for (const double angle : {0.0, 0.6})
            for (const Setting& setting : settings)
                cases.push_back(
                    {"thin plate", fmt::format("plate {:g}, turned by {:g}, {}", thickness, angle, name_of(setting)),
                     [=] { return problem(test::tilted(test::plate(thickness), angle), setting); }, samples_in(scope)});
        cases.push_back({"thin plate", fmt::format("plate {:g}, samples within it", thickness),
                         [=] {
                             return Problem{test::plate(thickness),
                                            grid_about({0.03, 0.02, 0.1 * thickness}, thickness / 5, 24),
                                            Band::symmetric(thickness)};
                         },
                         samples_in(scope)});
    }
}

/// A triangle, or a flat tetrahedron of it, 500 units wide, its vertices at generic places.
Mesh wide_mesh(bool closed) {
    const std::vector<Vec3> vertices{
        {0.3, -0.2, 0.4}, {400.3, 179.8, 240.4}, {25.3, 179.8, 240.4}, {160.1, 90.7, 190.2}};
    if (!closed) return {vertices, {{0, 1, 2}}, "triangle"};
    return {vertices, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}, "tetrahedron"};
}

/// Around a vertex, the middle of an edge and the middle of a face, each a thousandth of a voxel from a sample.
void add_wide_triangles(Scope scope, std::vector<Case>& cases) {
    struct Place {
        const char* name;
        Vec3 weights;
    };
    for (const bool closed : {false, true})
        for (const Place& place :
             {Place{"vertex", {1, 0, 0}}, Place{"edge", {0.5, 0.5, 0}}, Place{"face", {0.3, 0.3, 0.4}}})
            cases.push_back({"wide triangle",
                             fmt::format("{} 500 voxels wide, {}", closed ? "tetrahedron" : "triangle", place.name),
                             [=] {
                                 Mesh mesh = wide_mesh(closed);
                                 Vec3 centre{};
                                 for (std::size_t axis = 0; axis < 3; ++axis) {
                                     for (std::size_t v = 0; v < 3; ++v)
                                         centre[axis] += place.weights[v] * mesh.vertices()[v][axis];
                                     centre[axis] += 1e-3 / std::numbers::sqrt3;
                                 }
                                 const SignRule sign = closed ? SignRule::nonzero : SignRule::none;
                                 return Problem{std::move(mesh), grid_about(centre, 1, 48), Band::symmetric(10), sign};
                             },
                             samples_in(scope)});
}

void add_far_meshes(Scope scope, std::vector<Case>& cases) {
    constexpr std::int64_t voxels = 1'000'000;
    const Setting setting{96, 0.10};
    const std::size_t samples = samples_in(scope);
    for (const char* shape : {"knot", "noisy"}) {
        cases.push_back({"far mesh", fmt::format("{}, 1e6 voxels from the origin, {}", shape, name_of(setting)),
                         [=] {
                             const Mesh mesh = make_shape(shape);
                             const double away = problem(mesh, setting).grid.voxel() * static_cast<double>(voxels);
                             return problem(test::shifted(mesh, {away, -0.7 * away, 0.3 * away}), setting);
                         },
                         samples});
        cases.push_back({"far mesh", fmt::format("{}, sample (0, 0, 0) 1e6 voxels away, {}", shape, name_of(setting)),
                         [=] {
                             Problem moved = problem(make_shape(shape), setting);
                             moved.grid.first = {voxels, -voxels, voxels / 2};
                             for (std::size_t axis = 0; axis < 3; ++axis)
                                 moved.grid.origin[axis] -=
                                     moved.grid.spacing[axis] * static_cast<double>(moved.grid.first[axis]);
                             return moved;
                         },
                         samples});
    }
}

void add_unequal_spacing(Scope scope, std::vector<Case>& cases) {
    const std::vector<double> shares =
        scope == Scope::complete ? std::vector<double>{0.01, 0.03, 0.10} : std::vector<double>{0.03};
    for (const char* shape : {"torus", "noisy"})
        for (const Vec3& ratio : {Vec3{1, 1, 100}, Vec3{100, 1, 1}})
            for (const double share : shares)
                cases.push_back(
                    {"unequal spacing",
                     fmt::format("{}, spacing {:g}:{:g}:{:g}, {:g}%", shape, ratio[0], ratio[1], ratio[2], 100 * share),
                     [=] {
                         Mesh mesh = test::tilted(make_shape(shape));
                         const double h = mesh.box().longest_side() / 256;
                         GridOptions options;
                         options.spacing = {h * ratio[0], h * ratio[1], h * ratio[2]};
                         options.margin = Length::of_extent(share);
                         const Grid grid = Grid::around(mesh.box(), options);
                         const Band band = Band::symmetric(share * mesh.box().longest_side());
                         return Problem{std::move(mesh), grid, band};
                     },
                     samples_in(scope)});
}

}  // namespace

std::vector<Case> strained_cases(Scope scope) {
    std::vector<Case> cases;
    add_plates(scope, cases);
    add_wide_triangles(scope, cases);
    add_far_meshes(scope, cases);
    add_unequal_spacing(scope, cases);
    return cases;
}

}  // namespace clsdf::acceptance
