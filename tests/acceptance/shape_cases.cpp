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

/// In a sample, each mesh has points at one of its settings.
bool has_points(Scope scope, std::size_t mesh, std::size_t setting) {
    return scope == Scope::complete || mesh % settings_of(scope).size() == setting;
}

}  // namespace

std::vector<Case> shape_cases(Scope scope) {
    const std::vector<Setting> settings = settings_of(scope);
    std::vector<Case> cases;
    std::size_t mesh = 0;
    for (const ShapeName& shape : shape_names()) {
        if (scope == Scope::sampled && is_large(shape.name)) continue;
        for (std::size_t n = 0; n < settings.size(); ++n) {
            const Setting& setting = settings[n];
            if (is_large(shape.name) && setting.resolution == 256 && setting.share > 0.01) continue;
            cases.push_back({"shape", fmt::format("{}, {}", shape.name, name_of(setting)),
                             [name = shape.name, setting] { return problem(make_shape(name), setting); },
                             samples_in(scope), has_points(scope, mesh, n)});
        }
        ++mesh;
    }
    return cases;
}

std::vector<Case> counterexample_cases(Scope scope) {
    const std::vector<Setting> settings = settings_of(scope);
    std::vector<Case> cases;
    std::size_t mesh = 0;
    for (const test::Counterexample& example : test::all_counterexamples()) {
        for (std::size_t n = 0; n < settings.size(); ++n)
            cases.push_back({"counterexample", fmt::format("{}, {}", example.name(), name_of(settings[n])),
                             [mesh = example.mesh, setting = settings[n]] { return problem(mesh, setting); },
                             samples_in(scope), has_points(scope, mesh, n)});
        ++mesh;
        // With the half width at which it fails, on a lattice that has the failing sample.
        constexpr std::int64_t reach = 24;
        cases.push_back({"counterexample", example.name() + ", its known sample",
                         [example] {
                             return Problem{
                                 example.mesh,
                                 grid_about(example.samples.front().position, example.half_width / 20, reach),
                                 Band::symmetric(example.half_width)};
                         },
                         samples_in(scope), scope == Scope::complete});
    }
    return cases;
}

}  // namespace clsdf::acceptance
