#pragma once

#include "acceptance/case.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace clsdf::acceptance {

/// The part of the list that is run: all of it for a record, or a sample for a test.
enum class Scope { sampled, complete };

/// The number of samples of a field that are compared with the reference, as Case::samples: all in a complete run.
constexpr std::size_t samples_in(Scope scope) {
    return scope == Scope::complete ? 0 : 5'000;
}

/// Every shape the library makes, and every mesh on which bounding polyhedra are known to fail.
std::vector<Case> shape_cases(Scope scope);
std::vector<Case> counterexample_cases(Scope scope);

/// Cases that strain the arithmetic: thin plates, triangles far larger than a voxel, meshes and lattices far from the
/// origin, unequal spacing.
std::vector<Case> strained_cases(Scope scope);

/// Tetrahedra, stairs, flaps, spikes and noisy scans; `seed` is that of the first of each.
std::vector<Case> random_cases(Scope scope, std::uint64_t seed);

struct ArchiveCases {
    std::vector<Case> cases;
    std::vector<std::string> unreadable;  ///< messages of files that hold no mesh; the list names none of them
};

/// Meshes of CGAL's data: the named ones at several resolutions, and every other one that can be read. Open ones are
/// computed unsigned. Always complete.
ArchiveCases archive_cases(const std::filesystem::path& folder);

}  // namespace clsdf::acceptance
