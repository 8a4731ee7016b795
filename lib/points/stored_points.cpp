#include "points/stored_points.hpp"

#include "homes/device_set_up.hpp"

#include <memory>
#include <span>
#include <utility>

namespace clsdf::points {

namespace {

template <typename Value>
KeptArray<Value> borrowed(const void* values, std::size_t count) {
    return KeptArray<Value>::borrowed({static_cast<const Value*>(values), count});
}

}  // namespace

StoredPoints::StoredPoints(KeptPoints& kept_points, SignRule sign) {
    const auto mesh = kept_points.mesh();
    sign_positions_ = KeptArray<Vec3>::borrowed(mesh->sign_positions);
    sign_counts_ = KeptArray<std::int8_t>::borrowed(mesh->sign_counts);
    is_joined_.assign(mesh->is_joined.begin(), mesh->is_joined.end());
    polyhedra_ = borrowed<Polyhedron>(mesh->polyhedra->on_host(), mesh->count);
    faces_ = borrowed<PointFace>(mesh->faces->on_host(), mesh->count);
    const auto leaves = kept_points.wide_leaves();
    shape_ = leaves->tree->shape;
    nodes_ = KeptArray<PointNode>::borrowed(leaves->tree->nodes);
    leaves_ = borrowed<PointLeaf>(leaves->on_host(), shape_.count[0]);
    if (sign != SignRule::none)
        if (const auto sides = kept_points.face_sides(sign, true))
            sides_ = borrowed<std::uint16_t>(sides->sides.on_host(), mesh->count);
}

bool StoredPoints::fits(std::size_t faces, std::size_t vertices) const {
    const auto is_one_of = [](std::size_t size, std::size_t whole) { return size == 0 || size == whole; };
    return shape_.faces == faces && shape_.levels > 0 && shape_.levels <= CLSDF_TREE_LEVELS &&
           nodes_.size() == std::size_t{shape_.first[shape_.levels - 1]} + 1 && leaves_.size() == shape_.count[0] &&
           polyhedra_.size() == faces && faces_.size() == faces && is_one_of(sides_.size(), faces) &&
           is_one_of(sign_counts_.size(), faces) && is_one_of(sign_positions_.size(), vertices) &&
           is_joined_.size() == sign_positions_.size();
}

void StoredPoints::set(engine::KeptMesh& kept_mesh, KeptPoints& kept_points) const {
    const engine::DeviceSetUp set_up(kept_mesh.tools());
    const bool are_shared = set_up.ways.arrays_are_shared;
    const auto lease = [&](const auto& values) { return set_up.shared(nullptr, values); };
    engine::PointMesh mesh;
    mesh.lattice = engine::lattice_for_points(kept_mesh.box(), kept_mesh.name());
    mesh.box = kept_mesh.box();
    mesh.count = faces_.size();
    mesh.topology = kept_mesh.shared_topology();
    mesh.positions = KeptArray<Vec3>::borrowed(kept_mesh.frusta().positions);
    mesh.sign_positions = sign_positions_;
    mesh.sign_counts = sign_counts_;
    mesh.is_joined.assign(is_joined_.begin(), is_joined_.end());
    if (are_shared) {
        mesh.polyhedra = std::make_shared<const device::BufferPool::Lease>(lease(polyhedra_));
        mesh.faces = std::make_shared<const device::BufferPool::Lease>(lease(faces_));
    }
    engine::WideLeaves leaves;
    leaves.tree = std::make_shared<const engine::WideTree>(engine::WideTree{shape_, nodes_});
    if (are_shared && set_up.tools.programs.body == KernelBody::by_vector) {
        const std::span<const PointNode> upper = std::span<const PointNode>(nodes_).subspan(leaves_.size());
        leaves.device_leaves = lease(leaves_);
        leaves.device_nodes = upper.empty() ? set_up.upload(leaves_, "nodes of the points' tree") : lease(upper);
    } else {
        leaves.leaves = leaves_;
    }
    FaceSides sides;
    if (are_shared) sides.sides = lease(sides_);
    kept_points.set_borrowed(std::move(mesh), std::move(leaves), std::move(sides));
}

}  // namespace clsdf::points
