#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "bricks/field_scan.hpp"
#include "frusta/prepared_mesh.hpp"
#include "launch/programs.hpp"
#include "plan/job.hpp"
#include "plan/kept_mesh.hpp"

#include <memory>
#include <string>
#include <vector>

namespace clsdf {

/// Another way from a mesh to its distances than leaned polyhedra scanned by bricks, from a library beside the core.
/// The sign, slabs, plans and the self-test are the core's. A method has no state: threads and transforms may share it.
class FieldMethod {
public:
    virtual ~FieldMethod() = default;

    /// Throws Error(unsupported) for an output that it does not give.
    virtual void check_outputs(OutputSet outputs) const = 0;

    /// The mesh on the device for a job, which is not kept for others.
    virtual std::shared_ptr<const engine::PreparedMesh> prepare(engine::KeptMesh& kept_mesh,
                                                                const engine::Job& job) const = 0;

    /// `inputs.mesh` is the result of prepare().
    virtual std::unique_ptr<engine::FieldScan> make_scan(const engine::ScanInputs& inputs) const = 0;

    /// The method that the self-test computes its known field with: it runs the kernels that such a computation runs,
    /// and its fields are exact.
    virtual std::shared_ptr<const FieldMethod> tested_as(const device::Context& context, const Layout& layout,
                                                         const engine::BrickVariant& variant) const = 0;

    // Asked of the method that tested_as() returns:

    /// Names the kernels, for messages and for the records of what was tested.
    virtual std::string name() const = 0;
    /// The programs that are built beside those that every computation needs.
    virtual std::vector<cl::Program> build(device::Context& context, const engine::Programs& programs,
                                           const engine::BrickVariant& variant,
                                           const device::BuildWatch& watch) const = 0;
    /// How many programs build() builds.
    virtual std::size_t step_count() const = 0;
};

}  // namespace clsdf
