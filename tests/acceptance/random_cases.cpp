#include "acceptance/cases.hpp"

#include <fmt/format.h>

#include "support/hostile_meshes.hpp"

#include <algorithm>

namespace clsdf::acceptance {

namespace {

/// Every second one has vertices on a lattice, so that edges tie and faces may have no area.
Mesh random_tetrahedron(test::Random& random) {
    if (random.index(2) == 0) return test::random_lattice_tetrahedron(random, 0.5);
    std::vector<Vec3> vertices(4);
    for (Vec3& vertex : vertices) vertex = random.point(-1, 1);
    return {std::move(vertices), {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, "tetrahedron"};
}

struct Family {
    const char* kind;
    Mesh (*make)(test::Random& random);
};

constexpr Family families[] = {
    {"random tetrahedron", random_tetrahedron},
    {"random stairs",
     [](test::Random& random) {
         const Mesh stairs = test::random_stairs(random, 4 + random.index(12));
         return test::tilted(stairs, random.uniform(0, 3));
     }},
    {"random flap",
     [](test::Random& random) {
         const Mesh flap = test::random_flap(random);
         return test::tilted(flap, random.uniform(0, 3));
     }},
    {"random spikes", [](test::Random& random) { return test::random_sphere(random, "sphere2", 0.9); }},
    {"noisy scan", [](test::Random& random) { return test::random_sphere(random, "sphere5", 0.05); }},
};

}  // namespace

std::vector<Case> random_cases(Scope scope, std::uint64_t seed) {
    const std::vector<Setting> settings{{96, 0.10}, {128, 0.03}, {160, 0.01}};
    const std::uint64_t count = scope == Scope::complete ? 30 : 3;
    std::vector<Case> cases;
    for (const Family& family : families)
        for (std::uint64_t i = 0; i < count; ++i) {
            Setting setting = settings[i % settings.size()];
            if (scope == Scope::sampled) setting.resolution = 96;
            cases.push_back({family.kind, fmt::format("{}, seed {}, {}", family.kind, seed + i, name_of(setting)),
                             [=] {
                                 test::Random random(seed + i);
                                 return problem(family.make(random), setting);
                             },
                             samples_in(scope)});
        }
    return cases;
}

}  // namespace clsdf::acceptance
