#include "points/kept_points.hpp"

#include <utility>

namespace clsdf::points {

KeptPoints::KeptPoints(transform::Stages& stages) : stages_(stages) {
    stages.keep_also([this] { return values(); });
}

std::shared_ptr<const PointMesh> KeptPoints::tree() {
    return stages_.prepare([&] {
        if (!tree_) {
            PointMesh made =
                make_point_mesh(stages_.context(), stages_.pool(), stages_.mesh(), stages_.shared_topology());
            made.is_part = stages_.restriction() != nullptr;
            tree_ = std::make_shared<const PointMesh>(std::move(made));
        }
        return tree_;
    });
}

std::shared_ptr<const ScannedMesh> KeptPoints::scanned_mesh(const cl::Program& program) {
    return stages_.prepare([&] {
        if (!scanned_mesh_) {
            const scan::PreparedMesh polyhedra = stages_.all_records(tree()->lattice);
            scanned_mesh_ = std::make_shared<const ScannedMesh>(
                make_scanned_mesh(stages_.context(), program, stages_.pool(), *tree_, stages_.frusta(), polyhedra));
        }
        return scanned_mesh_;
    });
}

std::shared_ptr<const FaceSides> KeptPoints::face_sides(SignRule sign, bool is_found) {
    return stages_.prepare([&] {
        // In front of a part's faces there may be others that are missing.
        if (!face_sides_ && is_found && stages_.restriction() == nullptr)
            face_sides_ =
                std::make_shared<const FaceSides>(find_face_sides(stages_.context(), stages_.pool(), *tree(), sign));
        return face_sides_;
    });
}

std::optional<PointInputs> KeptPoints::inputs_of_few(OutputSet outputs) const {
    const std::scoped_lock lock(mutex_);
    PointInputs inputs;
    inputs.mesh = remembered_.mesh.lock();
    scan::DeviceSites sites{remembered_.names.lock(), remembered_.normals.lock(), remembered_.renumbered};
    if (!inputs.mesh || (scan::names_sites(outputs) && !sites.names) ||
        (scan::takes_normals(outputs) && !sites.normals))
        return std::nullopt;
    inputs.sites = std::make_shared<const scan::DeviceSites>(std::move(sites));
    inputs.sign = remembered_.sign;
    inputs.is_inside_out = remembered_.is_inside_out;
    return inputs;
}

void KeptPoints::remember(const PointInputs& inputs, OutputSet outputs) {
    const std::scoped_lock lock(mutex_);
    remembered_.mesh = inputs.mesh;
    if (scan::names_sites(outputs)) remembered_.names = inputs.sites->names;
    remembered_.renumbered = inputs.sites->renumbered;
    remembered_.sign = inputs.sign;
    if (!scan::takes_normals(outputs)) return;
    remembered_.normals = inputs.sites->normals;
    remembered_.is_inside_out = inputs.is_inside_out;
}

void KeptPoints::forget_tree() {
    tree_.reset();
    const std::scoped_lock lock(mutex_);
    remembered_ = {};
}

std::vector<transform::Stages::KeptValue> KeptPoints::values() {
    if (!tree_ && !scanned_mesh_ && !face_sides_) return {};
    return {
        {"points' tree", tree_ ? tree_->host_bytes() : 0, tree_ ? tree_->device_bytes() : 0, true, true,
         [this] { forget_tree(); }},
        {"scanned mesh", 0, scanned_mesh_ ? scanned_mesh_->device_bytes() : 0, true, true,
         [this] { scanned_mesh_.reset(); }},
        {"face sides", 0, face_sides_ ? face_sides_->sides.bytes() : 0, true, true, [this] { face_sides_.reset(); }},
    };
}

}  // namespace clsdf::points
