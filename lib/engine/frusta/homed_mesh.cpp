#include "frusta/homed_mesh.hpp"

#include <clsdf/error.hpp>

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "frusta/host_part.hpp"
#include "mesh/equal_vertices.hpp"
#include "mesh/moved_mesh.hpp"

#include <utility>

namespace clsdf::engine {

namespace {

using Lease = device::BufferPool::Lease;

template <class Value>
std::shared_ptr<const Value> share(Value&& value) {
    return std::make_shared<const Value>(std::move(value));
}

/// The mesh at positions that the device has, numbered as the topology's.
Mesh read_positions(const DeviceSetUp& set_up, const Lease& positions, const MeshTopology& topology, const Mesh& first,
                    const Box& box) {
    set_up.tools.context.begin_call();
    const KeptArray<std::uint32_t>& used = topology.faces.vertices;
    UninitializedVector<Vec3> ordered(used.size());
    set_up.tools.context.run_or_drain([&] { device::read_values(set_up.tools.context, *positions, ordered); });
    std::vector<Vec3> result = first.vertices();
    for_each_index(used.size(), [&](std::size_t i) { result[used[i]] = ordered[i]; });
    return moved(first, std::move(result), box);
}

}  // namespace

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, std::string name, const Box& box,
                     std::size_t vertex_count, std::size_t face_count)
    : set_up_(tools, SetUpWays(tools, vertex_count, face_count)),
      name_(std::move(name)),
      first_box_(box),
      box_(box),
      vertex_count_(vertex_count),
      face_count_(face_count),
      given_(
          all, MadeOf::caller, UsedBy::both,
          [this] {
              set_up_.tools.context.begin_call();
              return share(mesh_of(given_.if_on_device()->read(set_up_), first_box_, name_));
          },
          nullptr),
      first_(all, MadeOf::caller),
      names_(all, MadeOf::triangles),
      topology_(
          all, MadeOf::triangles, UsedBy::grids,
          [this] {
              if (const auto& made = topology_.if_on_device())
                  return share(made->read(set_up_, made->equal ? first().numbers : std::vector<std::uint32_t>()));
              return share(MeshTopology(*first().mesh));
          },
          [this] { return share(device_topology(set_up_, names(), topology())); }),
      positions_(
          all, MadeOf::caller, UsedBy::grids,
          [this] {
              if (!positions_.is_only_copy()) return first().mesh;
              return share(read_positions(set_up_, *positions_.if_on_device(), topology(), *first().mesh, box_));
          },
          [this] { return share(set_up_.upload(ordered_positions(topology(), on_host().vertices()), "vertices")); }),
      frusta_(
          all, MadeOf::positions, UsedBy::grids,
          [this] {
              require_frusta();
              return frusta_.if_on_host() ? frusta_.if_on_host() : share(frusta_.if_on_device()->read(set_up_));
          },
          [this] {
              require_frusta();
              if (frusta_.if_on_device()) return frusta_.if_on_device();
              return share(device_faces(set_up_, names(),
                                        set_up_.ways.arrays_are_shared ? nullptr : positions_.on_device(),
                                        frusta_.if_on_host()));
          }),
      frusta_sources_(all, MadeOf::triangles) {}

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, Vertices vertices)
    : HomedMesh(all, tools, mesh.name(), mesh.box(), vertices.count(), mesh.triangles().size()) {
    has_equal_ = vertices.are_merged();
    set_up_.ways.topology_by_kernels = false;
    first_.set(share(FirstMesh{share(std::move(mesh)), std::move(vertices)}));
}

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, std::shared_ptr<const Mesh> given, MadeTopology made)
    : HomedMesh(all, tools, given ? given->name() : "mesh", made.box(), made.given_vertices,
                made.topology->face_count()) {
    has_equal_ = made.topology->equal != nullptr;
    if (!given)
        given_.set_only_copy(std::move(made.mesh));
    else if (has_equal_)
        given_.set(std::move(given), nullptr);
    else
        first_.set(share(FirstMesh{std::move(given), Vertices(vertex_count_)}));
    names_.set(made.topology->names);
    topology_.set(nullptr, std::move(made.topology));
    positions_.set(nullptr, share(std::move(made.positions)));
}

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, std::shared_ptr<const MeshTopology> topology)
    : HomedMesh(all, tools, mesh.name(), mesh.box(), mesh.vertices().size(), mesh.triangles().size()) {
    set_up_.ways.topology_by_kernels = false;
    first_.set(share(FirstMesh{share(std::move(mesh)), Vertices(vertex_count_)}));
    topology_.set(std::move(topology), nullptr);
}

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, std::shared_ptr<const MeshTopology> topology,
                     Frusta frusta)
    : HomedMesh(all, tools, std::move(mesh), std::move(topology)) {
    frusta_.set(share(std::move(frusta)), nullptr);
}

HomedMesh::HomedMesh(KeptValues& all, const DeviceTools& tools, BorrowedMesh mesh)
    : HomedMesh(all, tools, mesh.name, mesh.box, mesh.vertices.count(), mesh.triangles.size()) {
    has_equal_ = mesh.vertices.are_merged();
    set_up_.ways.topology_by_kernels = false;
    topology_.set(mesh.topology, nullptr);
    if (set_up_.ways.arrays_are_shared) {
        const MeshTopology& topology = *mesh.topology;
        names_.set(share(NamedFaces{face_count_, topology.faces.vertices.size(), mesh.topology,
                                    set_up_.shared(mesh.topology, topology.faces.triangles),
                                    set_up_.shared(mesh.topology, mesh.names)}));
    }
    frusta_.set(share(std::move(mesh.frusta)), nullptr);
    borrowed_ = share(std::move(mesh));
}

PlacedVertices HomedMesh::present() {
    if (borrowed_ && !has_moved_) return {borrowed_->positions, box_, name_};
    return on_host();
}

const HomedMesh::FirstMesh& HomedMesh::first() {
    if (first_) return *first_;
    if (borrowed_) {
        MeshArrays arrays{{borrowed_->positions.begin(), borrowed_->positions.end()},
                          {borrowed_->triangles.begin(), borrowed_->triangles.end()}};
        first_.set(share(FirstMesh{share(mesh_of(std::move(arrays), first_box_, name_)), borrowed_->vertices}));
        return *first_;
    }
    first_.set(share([&] {
        const std::shared_ptr<const Mesh>& given = given_.on_host();
        if (!has_equal_) return FirstMesh{given, Vertices(vertex_count_)};
        set_up_.tools.context.begin_call();
        const auto& made = topology_.if_on_device();
        const std::vector<std::uint32_t> first =
            made && made->equal ? made->equal->read(set_up_) : first_equal_vertices(given->vertices());
        Mesh one_of_each = *given;
        Vertices vertices(one_of_each, first);
        return FirstMesh{share(std::move(one_of_each)), std::move(vertices), Vertices::numbers(first)};
    }()));
    given_.forget();
    return *first_;
}

const std::shared_ptr<const NamedFaces>& HomedMesh::made_names() const {
    const auto& made = topology_.if_on_device();
    return made ? made->names : names_.get();
}

const std::shared_ptr<const NamedFaces>& HomedMesh::names() {
    if (const auto& made = made_names()) return made;
    return names_.get_or([&] { return device_names(set_up_, shared_topology()); });
}

std::optional<PreparedMesh> HomedMesh::make_frusta(const LatticeView* lattice) {
    if (!set_up_.ways.frusta_by_kernels) {
        Frusta made = engine::make_frusta(topology(), on_host().vertices());
        made.sites = in_groups(made.sites, site_blocks(made.sites, topology().joined));
        frusta_.set(share(std::move(made)), nullptr);
        return std::nullopt;
    }
    MadeFrusta made = [&] {
        if (!set_up_.ways.arrays_are_shared)
            return frusta_by_kernels(set_up_, topology_, positions_.on_device(), box_, lattice);
        frusta_sources_.get_or([&] { return FrustaSources(set_up_, topology()); });
        return frusta_by_kernels(set_up_, names(), frusta_sources_.get(), on_host(), lattice);
    }();
    frusta_.set(std::move(made.frusta), share(std::move(made.faces)));
    if (!has_moved_) frusta_sources_.forget();
    return std::move(made.records);
}

const FoundFrusta& HomedMesh::found() {
    require_frusta();
    if (const auto& on_host = frusta_.if_on_host()) return *on_host;
    return *frusta_.if_on_device()->found;
}

WrittenFaces HomedMesh::written_faces(const DeviceFaces& faces) {
    if (faces.part) return {faces.part->topology, faces.part->frusta, faces.part->faces};
    return {topology(), frusta()};
}

bool HomedMesh::is_on_device_alone() const {
    return set_up_.ways.topology_by_kernels && frusta_.is_made() && !frusta_.if_on_host();
}

ClusterIndex HomedMesh::make_index() {
    found();
    if (is_on_device_alone()) return {face_count_, cluster_boxes(set_up_, *faces()), faces()->part->frusta};
    return {face_count_, cluster_boxes(topology().faces.triangles, frusta().positions), frusta()};
}

template <class Positions>
std::optional<MovedVertices> HomedMesh::moved_on_device(const Positions& positions) {
    if (!topology_.if_on_device()) return std::nullopt;
    set_up_.tools.context.begin_call();
    try {
        MovedVertices moved = move_vertices(set_up_, *topology_.if_on_device(), positions);
        if (moved.are_usable) return moved;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::out_of_memory) throw;
    }
    return std::nullopt;
}

void HomedMesh::move(std::vector<Vec3> positions) {
    const FirstMesh& first = this->first();
    std::optional<MovedVertices> on_device;
    // A topology that a GPU has made has the caller's numbers, another one those of the first mesh.
    if (first.numbers.empty() && positions.size() == first.mesh->vertices().size())
        on_device = moved_on_device(std::span<const Vec3>(positions));
    auto present = share(on_device ? moved(*first.mesh, std::move(positions), on_device->box)
                                   : moved(*first.mesh, std::move(positions), topology().faces.vertices));
    auto positions_on_device = on_device ? share(std::move(on_device->positions)) : nullptr;
    if (floor_) check_floor(*floor_, present->box(), name_);
    box_ = present->box();
    has_moved_ = true;
    positions_.set(std::move(present), std::move(positions_on_device));
    frusta_.forget();
}

void HomedMesh::move(std::vector<Vec3> positions, const Box& box) {
    auto present = share(moved(*first().mesh, std::move(positions), box));
    box_ = box;
    has_moved_ = true;
    positions_.set(std::move(present), nullptr);
    frusta_.forget();
}

void HomedMesh::set_frusta(Frusta frusta) {
    frusta_.set(share(std::move(frusta)), nullptr);
}

template <class Positions>
bool HomedMesh::move_on_device(const Positions& positions, std::size_t count) {
    if (count != vertex_count_ || (has_equal_ && !has_equal_on_device())) return false;
    std::optional<MovedVertices> moved = moved_on_device(positions);
    if (!moved) return false;
    if (floor_) check_floor(*floor_, moved->box, name_);
    auto present = share(std::move(moved->positions));
    box_ = moved->box;
    has_moved_ = true;
    positions_.set_only_copy(std::move(present));
    frusta_.forget();
    return true;
}
template bool HomedMesh::move_on_device(const DeviceTriples&, std::size_t);
template bool HomedMesh::move_on_device(const std::span<const Vec3>&, std::size_t);

bool HomedMesh::has_equal_on_device() const {
    return topology_.if_on_device() && topology_.if_on_device()->equal;
}

void HomedMesh::read_only_copies() {
    if (given_.is_only_copy()) first();
    if (positions_.is_only_copy()) on_host();
}

void HomedMesh::leave_device_together() {
    const auto& faces = frusta_.if_on_device();
    if (faces &&
        ((!names_ && !topology_.if_on_device()) || (!set_up_.ways.arrays_are_shared && !positions_.if_on_device())))
        frusta_.leave_device();
}

std::size_t HomedMesh::first_position_bytes() const {
    return has_moved_ && first_ ? first_->mesh->vertices().size() * sizeof(Vec3) : 0;
}

}  // namespace clsdf::engine
