#include "acceptance/cases.hpp"

#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include "support/test_meshes.hpp"

namespace clsdf::acceptance {

namespace {

std::vector<Setting> settings_of(Scope scope) {
    if (scope == Scope::sampled) return {{96, 0.01}, {96, 0.03}, {96, 0.10}};
    return {{96, 0.10}, {192, 0.03}, {256, 0.01}, {256, 0.10}};
}

/// Shapes of more than 100,000 triangles, which take minutes in a wide band.
bool is_large(const std::string& shape) {
    return shape == "sphere7" || shape == "sphere8" || shape == "sphere9";
}

}  // namespace

std::vector<Case> shape_cases(Scope scope) {
    std::vector<Case> cases;
    for (const ShapeName& shape : shape_names()) {
        if (scope == Scope::sampled && is_large(shape.name)) continue;
        for (const Setting& setting : settings_of(scope)) {
            if (is_large(shape.name) && setting.resolution == 256 && setting.share > 0.01) continue;
            cases.push_back({"shape", fmt::format("{}, {}", shape.name, name_of(setting)),
                             [name = shape.name, setting] { return problem(make_shape(name), setting); },
                             samples_in(scope)});
        }
    }
    return cases;
}

std::vector<Case> counterexample_cases(Scope scope) {
    std::vector<Case> cases;
    for (const test::Counterexample& example : test::all_counterexamples()) {
        for (const Setting& setting : settings_of(scope))
            cases.push_back({"counterexample", fmt::format("{}, {}", example.name(), name_of(setting)),
                             [mesh = example.mesh, setting] { return problem(mesh, setting); }, samples_in(scope)});
        // With the half width at which it fails, on a lattice that has the failing sample.
        constexpr std::int64_t reach = 24;
        cases.push_back({"counterexample", example.name() + ", its known sample",
                         [example] {
                             return Problem{
                                 example.mesh,
                                 grid_about(example.samples.front().position, example.half_width / 20, reach),
                                 Band::symmetric(example.half_width)};
                         },
                         samples_in(scope)});
    }
    return cases;
}

}  // namespace clsdf::acceptance
