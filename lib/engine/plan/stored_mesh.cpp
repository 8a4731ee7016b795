#include "plan/stored_mesh.hpp"

#include <string>
#include <utility>

namespace clsdf::engine {

namespace {

template <typename Value>
KeptArray<Value> borrowed(const KeptArray<Value>& array) {
    return KeptArray<Value>::borrowed(array);
}

template <typename Value>
KeptArray<Value> borrowed(const device::BufferPool::Lease& lease, std::size_t count) {
    return KeptArray<Value>::borrowed({static_cast<const Value*>(lease.on_host()), count});
}

std::size_t normal_count(std::size_t faces, std::size_t turned) {
    return 18 * faces + turned;
}

}  // namespace

StoredMesh::StoredMesh(KeptMesh& kept_mesh, const SignOfWhole& sign)
    : sign_(static_cast<std::int32_t>(sign.sign)),
      has_floor_(sign.floor ? 1 : 0),
      is_negative_(kept_mesh.encloses_negative_volume() ? 1 : 0),
      floor_(sign.floor.value_or(0)),
      described_(sign.topology),
      name_(kept_mesh.name().begin(), kept_mesh.name().end()),
      box_(kept_mesh.box()),
      vertex_count_(kept_mesh.vertices().count()),
      numbers_here_(kept_mesh.vertices().numbers_here()),
      positions_(KeptArray<Vec3>::borrowed(kept_mesh.present().positions)),
      triangles_(KeptArray<Triangle>::borrowed(kept_mesh.triangles())),
      surface_vertices_(kept_mesh.sign_surface().vertices),
      surface_faces_(kept_mesh.sign_surface().faces) {
    if (const OpenLoops* loops = kept_mesh.open_loops()) {
        has_loops_ = 1;
        loops_have_floor_ = loops->floor ? 1 : 0;
        loops_floor_ = loops->floor.value_or(0);
        loop_vertices_ = loops->vertices;
        loop_begins_ = loops->begins;
    }
    const MeshTopology& topology = kept_mesh.topology();
    are_paired_ = topology.edges.are_paired ? 1 : 0;
    order_ = borrowed(topology.order);
    vertices_ = borrowed(topology.faces.vertices);
    starts_ = borrowed(topology.rings.starts());
    corners_ = borrowed(topology.rings.corners());
    faces_ = borrowed(topology.faces.triangles);
    edges_ = borrowed(topology.edges.faces);
    non_manifold_ends_ = topology.edges.non_manifold_ends;
    const Frusta& frusta = kept_mesh.frusta();
    sites_ = stored_sites(frusta.sites);
    slivers_ = frusta.slivers;
    saddle_vertices_ = frusta.saddle_vertices;
    boxes_ = frusta.boxes;
    ordered_positions_ = borrowed(frusta.positions);
    slopes_ = borrowed(frusta.slopes);
    const std::size_t faces = order_.size();
    names_ = borrowed<std::uint32_t>(kept_mesh.names()->names, faces);
    const auto sites = kept_mesh.sites(true, true);
    site_names_ = borrowed<TriangleSites>(*sites->names, faces);
    site_normals_ = borrowed<float>(*sites->normals, normal_count(faces, surface_faces_.size()));
}

bool StoredMesh::fits() const {
    const std::size_t faces = order_.size(), used = vertices_.size();
    return sign_ > static_cast<std::int32_t>(SignRule::automatic) &&
           sign_ <= static_cast<std::int32_t>(SignRule::below) && faces > 0 && triangles_.size() == faces &&
           faces_.size() == faces && edges_.size() == faces && slopes_.size() == faces && names_.size() == faces &&
           site_names_.size() == faces && site_normals_.size() == normal_count(faces, surface_faces_.size()) &&
           corners_.size() == 3 * faces && starts_.size() == used + 1 && ordered_positions_.size() == used &&
           used <= positions_.size() && (surface_faces_.empty() || surface_faces_.size() == faces) &&
           (surface_vertices_.empty() || surface_vertices_.size() == positions_.size()) &&
           (numbers_here_.empty() ? positions_.size() : numbers_here_.size()) == vertex_count_ &&
           !loop_begins_.empty() && loop_begins_.back() == loop_vertices_.size();
}

SignOfWhole StoredMesh::sign() const {
    return {static_cast<SignRule>(sign_), has_floor_ != 0 ? std::optional(floor_) : std::nullopt, described_};
}

std::unique_ptr<KeptMesh> StoredMesh::make(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                                           const KeptMesh::Options& options) const {
    BorrowedMesh mesh{.name = {name_.begin(), name_.end()},
                      .box = box_,
                      .vertices = Vertices(static_cast<std::size_t>(vertex_count_), numbers_here_),
                      .positions = positions_,
                      .triangles = triangles_,
                      .topology = {},
                      .frusta = {},
                      .names = names_};
    mesh.topology = std::make_shared<const MeshTopology>(
        order_, OrderedFaces{faces_, vertices_}, OneRings(starts_, corners_),
        PairedEdges{.faces = edges_, .non_manifold_ends = non_manifold_ends_, .are_paired = are_paired_ != 0});
    mesh.frusta.sites = sites_of(sites_);
    mesh.frusta.slivers = slivers_;
    mesh.frusta.saddle_vertices = static_cast<std::size_t>(saddle_vertices_);
    mesh.frusta.boxes = static_cast<std::size_t>(boxes_);
    mesh.frusta.positions = ordered_positions_;
    mesh.frusta.slopes = slopes_;
    BorrowedSites sites;
    if (const DeviceSetUp set_up({context, pool, options.programs}); set_up.ways.arrays_are_shared) {
        sites.names = set_up.shared(nullptr, site_names_);
        sites.normals = set_up.shared(nullptr, site_normals_);
    }
    auto kept_mesh = std::make_unique<KeptMesh>(context, pool, std::move(mesh), std::move(sites), options);
    kept_mesh->set_encloses_negative_volume(is_negative_ != 0);
    if (has_loops_ != 0) {
        OpenLoops loops{.vertices = loop_vertices_, .begins = loop_begins_};
        if (loops_have_floor_ != 0) loops.floor = loops_floor_;
        kept_mesh->set_open_loops(std::move(loops));
    }
    kept_mesh->set_sign_surface({.vertices = surface_vertices_, .faces = surface_faces_});
    return kept_mesh;
}

}  // namespace clsdf::engine
