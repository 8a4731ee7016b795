#pragma once

#include "plan/kept_mesh.hpp"
#include "points/face_sides.hpp"
#include "points/point_query.hpp"
#include "points/point_scan.hpp"
#include "points/sign_faces.hpp"
#include "tree/binary_tree.hpp"
#include "tree/closed_down.hpp"
#include "tree/crossed_faces.hpp"
#include "tree/point_mesh.hpp"
#include "tree/wide_tree.hpp"

#include <memory>
#include <mutex>
#include <optional>

namespace clsdf::points {

/// The values that a transform keeps for points, beside those of its KeptMesh, which must outlive this. Each is made
/// when it is needed first, and forgotten when the vertices move or memory is short.
///
///     faces          of the positions                    once points are asked for and kernels make them
///     mesh           of the positions, with the faces    the same, if the host makes them; once the host reads them
///     host's mesh    of the positions                    once a field with exact signs is asked for
///     wide tree      + positions                         once the host looks for faces, and with the leaves
///     leaves         + positions                         once points are asked for that are not scanned, for the body
///                                                        by_vector; once few points are asked for
///     triangles      of the triangles                    once kernels divide or cross the faces
///     division       of first positions                  once many points are asked for, for the body by_group; until
///                                                        its boxes have become twice as large
///     GPUs' tree     + positions                         the same
///     face sides     + sign rule                         once about as many points are asked for
///     sign faces     + sign rule                         once points in memory of the device are asked for
///     crossed extent + positions                         once rays are asked for
///     closed mesh    + positions                         of the rule below, once its walls are asked for
///     closed faces   + positions                         the same of rays
///     scanned mesh   + frusta                            once many points are asked for
///
/// For one thread at a time.
class KeptPoints {
public:
    explicit KeptPoints(engine::KeptMesh& kept_mesh) : kept_mesh_(kept_mesh) {}
    KeptPoints(const KeptPoints&) = delete;
    KeptPoints& operator=(const KeptPoints&) = delete;

    /// Values of the present positions, in borrowed memory, in the place of those that are made. sides: may be empty.
    void set_borrowed(engine::PointMesh mesh, engine::WideLeaves leaves, FaceSides sides);
    /// Whether the leaves are borrowed: then other tables for many points would only take memory.
    bool has_borrowed_leaves() const {
        return wide_leaves_ && wide_leaves_->host_bytes() == 0 && wide_leaves_->device_bytes() == 0;
    }

    /// The faces that points are looked up among, as kernels read them: those of mesh() if the host makes them. Throws
    /// Error(invalid_argument, unsupported, out_of_memory or device_failure).
    std::shared_ptr<const engine::PointFaces> faces();

    /// The same with what the host reads. Throws Error(invalid_argument, unsupported or out_of_memory).
    std::shared_ptr<const engine::PointMesh> mesh();

    /// Its parts on the host: mesh() if that is kept. Throws as mesh().
    std::shared_ptr<const engine::PointMesh> host_mesh();
    /// The faces that decide the sign: host_mesh(), and with the rule `below` its walls and its floor, too. Throws as
    /// mesh().
    std::shared_ptr<const engine::PointMesh> sign_mesh();
    /// The tree and the faces of such a mesh that has walls and a floor. Throws as mesh().
    std::shared_ptr<const engine::ClosedFaces> closed_faces();

    /// The tree in which the host looks for faces. Throws as mesh().
    std::shared_ptr<const engine::WideTree> wide_tree();

    /// What rays need of the faces beside their corners. Throws as mesh().
    std::shared_ptr<const engine::CrossedExtent> crossed_extent();

    /// The tree of wide_tree() with what the body by_vector and the host search for the nearest face. Throws as mesh().
    std::shared_ptr<const engine::WideLeaves> wide_leaves();

    /// The triangles on the device, by the numbers of faces and vertices of mesh(). Throws as mesh().
    std::shared_ptr<const device::BufferPool::Lease> triangles();

    /// The tree that the body by_group searches. Throws as mesh().
    std::shared_ptr<const engine::FittedTree> fitted_tree();

    /// The records that the scan of many points reads beside the mesh. Throws as mesh().
    std::shared_ptr<const ScannedMesh> scanned_mesh();

    /// The signs on the sides of faces. If they are not known, they are found if `is_found`; otherwise null. Always
    /// null for a part of a mesh, and if open edges count. The sign rule is the same in all calls.
    std::shared_ptr<const FaceSides> face_sides(SignRule sign, bool is_found);

    /// The sites of the outputs, with pseudonormals if they or the sides need them; sides: may be null. Throws as
    /// mesh().
    std::shared_ptr<const engine::DeviceSites> sites(OutputSet outputs, bool are_normals_needed,
                                                     const FaceSides* sides);

    /// The surface that decides signs, for kernels. The sign rule is the same in all calls. Throws as mesh().
    std::shared_ptr<const DeviceSignFaces> sign_faces(SignRule sign);

    /// The inputs of few points that remember() was called with, if they suffice for the outputs and are still kept.
    /// For any number of threads, also beside the one that calls the others.
    std::optional<PointInputs> inputs_of_few(OutputSet outputs) const;
    /// Remembers inputs that suffice for the outputs, without keeping them alive.
    void remember(const PointInputs& inputs, OutputSet outputs);

private:
    /// Sets what the kept mesh knows beside faces.
    void complete(engine::PointMesh& made);

    template <class T>
    using Kept = engine::Kept<T>;
    using MadeOf = engine::MadeOf;
    using UsedBy = engine::UsedBy;

    engine::KeptMesh& kept_mesh_;
    Kept<engine::PointFaces> faces_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::PointMesh> mesh_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::PointMesh> host_mesh_{kept_mesh_.kept(), MadeOf::positions};
    Kept<engine::WideTree> wide_tree_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::WideLeaves> wide_leaves_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::CrossedExtent> crossed_extent_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::ClosedMesh> closed_mesh_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<engine::ClosedFaces> closed_faces_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<device::BufferPool::Lease> triangles_{kept_mesh_.kept(), MadeOf::triangles, UsedBy::points};
    Kept<engine::DividedFaces> divided_faces_{kept_mesh_.kept(), MadeOf::triangles, UsedBy::points};
    Kept<engine::FittedTree> fitted_tree_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<ScannedMesh> scanned_mesh_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<DeviceSignFaces> sign_faces_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};
    Kept<FaceSides> face_sides_{kept_mesh_.kept(), MadeOf::positions, UsedBy::points};

    /// See remember().
    struct Remembered {
        std::size_t moves = 0;  ///< of the kept mesh before
        std::weak_ptr<const engine::PointMesh> mesh;
        std::weak_ptr<const engine::WideLeaves> leaves;
        std::weak_ptr<const device::BufferPool::Lease> names, normals;
        std::size_t renumbered = 0, pieces = 0, turned = 0;  ///< turned: if the normals are set
        SignRule sign = SignRule::none;
        bool is_inside_out = false;  ///< if the normals are set
    };
    mutable std::mutex mutex_;
    Remembered remembered_;  // guarded by it
};

}  // namespace clsdf::points
