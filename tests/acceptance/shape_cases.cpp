#include "acceptance/cases.hpp"

#include <clsdf/shapes.hpp>

#include <fmt/format.h>

#include "support/test_meshes.hpp"

namespace clsdf::acceptance {

namespace {

struct CheckedSetting {
    Setting setting;
    std::size_t samples;
};

std::vector<CheckedSetting> settings_of(Scope scope) {
    if (scope == Scope::sampled)
        return {{{96, 0.01}, few_samples}, {{96, 0.03}, few_samples}, {{96, 0.10}, few_samples}};
    return {{{256, 0.01}, many_samples}, {{192, 0.03}, many_samples}, {{96, 0.10}, 0}};
}

/// Beyond 100,000 triangles: these take their time.
bool is_large(const std::string& shape) {
    return shape == "sphere7" || shape == "sphere8" || shape == "sphere9";
}

}  // namespace

std::vector<Case> shape_cases(Scope scope) {
    std::vector<Case> cases;
    for (const ShapeName& shape : shape_names()) {
        if (scope == Scope::sampled && is_large(shape.name)) continue;
        for (const auto& [setting, samples] : settings_of(scope))
            cases.push_back({"shape", fmt::format("{}, {}", shape.name, name_of(setting)),
                             [name = shape.name, setting = setting] { return problem(make_shape(name), setting); },
                             is_large(shape.name) ? many_samples : samples});
    }
    return cases;
}

std::vector<Case> counterexample_cases(Scope scope) {
    std::vector<Case> cases;
    for (const test::Counterexample& example : test::all_counterexamples()) {
        for (const auto& [setting, samples] : settings_of(scope))
            cases.push_back({"counterexample", fmt::format("{}, {}", example.name(), name_of(setting)),
                             [mesh = example.mesh, setting = setting] { return problem(mesh, setting); }, samples});
        // With the half width at which it fails, on a lattice that has the failing sample.
        constexpr std::int64_t reach = 24;
        cases.push_back({"counterexample", example.name() + ", its known sample",
                         [example] {
                             return Problem{
                                 example.mesh,
                                 grid_about(example.samples.front().position, example.half_width / 20, reach),
                                 Band::symmetric(example.half_width)};
                         },
                         scope == Scope::sampled ? few_samples : 0});
    }
    return cases;
}

}  // namespace clsdf::acceptance
