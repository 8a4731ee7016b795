#pragma once

#include "launch/programs.hpp"
#include "plan/job.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::checks {

/// Kernels that are tested together, before a call gives a result of theirs, and the known values that they must
/// compute. Device and programs must outlive it.
struct TestSubject {
    std::string name;       ///< for messages and records, e.g. "by_vector bricks -DNEAREST"
    std::size_t steps = 1;  ///< how often ensure_tested() calls its watch if every program is compiled
    std::function<std::vector<cl::Program>(const device::BuildWatch&)> build{};
    /// Computes the known values by the launches of real computations. Compilers that specialise kernels at their first
    /// launch do it then. Describes, in a sentence, what is wrong; nothing if all is right. Called after build().
    std::function<std::optional<std::string>(const device::BuildWatch&)> difference{};
};

/// The kernels of a field that are tested together: those that every field runs, or those that only some run beside
/// them, or by another branch. Compilers take a second for the latter.
enum class FieldKernels { of_all, of_kept_frusta, of_wide_bands, of_sparse_fields };

/// Those that a job of a dense field runs whatever its transform keeps.
std::vector<FieldKernels> kernels_of(const engine::Workshop& workshop, const engine::Job& job);

TestSubject field_subject(const engine::Workshop& workshop, const engine::Job& job, FieldKernels kernels);

/// The kernels of points that are tested together: those that every query runs, those of many points, those of a GPU in
/// a tree that is deeper than engine::stack_entries, or those by which a processor runs plans of points.
enum class PointKernels { of_all, of_many, of_deep_trees, of_plans };

TestSubject point_subject(const Device& device, const engine::Programs& programs, PointKernels kernels);

/// The kernels that make a mesh's topology on a GPU.
TestSubject topology_subject(const engine::Workshop& workshop);

/// Builds the programs and, the first time on this device and driver version, tests them. Returns whether they were
/// tested here. Throws Error(wrong_results) that says what differs; with tuning_variable("CLSDF_SELF_TEST") "0" nothing
/// is computed.
bool ensure_tested(const Device& device, const TestSubject& subject, const device::BuildWatch& watch = {});

}  // namespace clsdf::checks
