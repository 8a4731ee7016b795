#pragma once

#include "frusta/prepared_mesh.hpp"
#include "lists/surface_points.hpp"
#include "plan/job.hpp"
#include "plan/kept_mesh.hpp"
#include "sign/sign_sweep.hpp"
#include "sign/sweep_mesh.hpp"

#include <cstddef>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// The inputs of the computation of a grid.
struct Inputs {
    std::shared_ptr<const PreparedMesh> records;
    RecordSelection selection;                    ///< those that matter; null for all, and with another method
    std::shared_ptr<const SurfacePoints> points;  ///< null if the band is so narrow that no bound would be below it
    std::shared_ptr<const SweepMesh> sweep_mesh;  ///< null if the field has no sign, or exact ones
    SweepSelection sweep_selection;               ///< its triangles that matter
    MakeSignBits make_sign_bits;                  ///< of exact signs; gone when the plan is made
    std::shared_ptr<const DeviceSites> sites;     ///< null for the distance alone
    bool needs_normals = false;                   ///< set for outputs that take normals: see KeptMesh::needs_normals()
    bool is_inside_out = false;                   ///< the faces look inwards, and the field has a sign
    bool shares_short_lists = false;              ///< of a known field: groups share them as they do long ones
};

/// The inputs of a job, without sites and exact signs. The whole mesh's are kept for its lattice. A grid that is small
/// beside the mesh gets its own, of what is near it, which are not kept; if many such grids of a lattice are asked for,
/// those of the whole mesh are made and kept, and each grid gets a selection of them. The field has the same bytes
/// either way.
///
/// lone: a small grid gets inputs of its own in any case, which contain only triangles near it. Throws
/// Error(invalid_argument, unsupported or out_of_memory).
Inputs grid_inputs(KeptMesh& kept_mesh, const Job& job, SignRule sign, bool lone = false);

/// The faces that rows of a job's bricks can cross before their samples; nothing if these are most.
std::optional<NearRecords> faces_near_rows(KeptMesh& kept_mesh, const Job& job);

/// Reduces a job's inputs to those near a part of it, unless most of them are. Throws Error(out_of_memory).
void select_inputs(KeptMesh& kept_mesh, const Job& part, Inputs& inputs);

/// Device memory of the records and of the sign's triangles, if they are not among what the mesh keeps.
std::size_t bytes_beside(const KeptMesh& kept_mesh, const Inputs& inputs);

}  // namespace clsdf::engine
