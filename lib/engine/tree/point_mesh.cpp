#include "tree/point_mesh.hpp"

#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/records.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

constexpr std::size_t width = CLSDF_TREE_WIDTH;

// Distances to a face are off by less, in units: its frame has roundings of the size of the mesh's box.
constexpr double frame_error = 1e-6;
// In units. Boxes are clamped to it, so that squared distances are finite in floats: infinity marks a child that does
// not exist. Boxes nearer to the mesh do not change.
constexpr double box_limit = 1e18;

float rounded_down(double x) {
    return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float rounded_up(double x) {
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// Holds nothing, infinitely far from every point.
PointNode empty_node() {
    PointNode node;
    std::fill(&node.lower[0][0], &node.lower[0][0] + 3 * width, std::numeric_limits<float>::infinity());
    std::fill(&node.upper[0][0], &node.upper[0][0] + 3 * width, -std::numeric_limits<float>::infinity());
    return node;
}

void add(PointNode& node, std::size_t child, std::size_t axis, float lower, float upper) {
    node.lower[axis][child] = std::min(node.lower[axis][child], lower);
    node.upper[axis][child] = std::max(node.upper[axis][child], upper);
}

/// The box of all children.
void add_children(const PointNode& node, PointNode& parent, std::size_t child) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        add(parent, child, axis, *std::min_element(node.lower[axis], node.lower[axis] + width),
            *std::max_element(node.upper[axis], node.upper[axis] + width));
}

PointTree shape_of(std::size_t faces) {
    PointTree tree{};
    tree.faces = static_cast<clsdf_uint32>(faces);
    clsdf_uint32 first = 0;
    for (std::size_t below = faces; tree.levels == 0 || below > 1;) {
        below = chunk_count(below, width);
        tree.first[tree.levels] = first;
        tree.count[tree.levels] = static_cast<clsdf_uint32>(below);
        first += tree.count[tree.levels++];
    }
    return tree;
}

/// Without the lowest face.
PointFace face_of(const Polyhedron& record) {
    PointFace result{};
    for (std::size_t column = 0; column < 3; ++column)
        result.offset[column] = record.exact_constant_at_origin[column] -
                                record.exact_gradient_x[column] * static_cast<double>(record.origin_x) -
                                record.exact_gradient_y[column] * static_cast<double>(record.origin_y) -
                                record.exact_gradient_z[column] * static_cast<double>(record.origin_z);
    result.triangle = record.triangle;
    return result;
}

/// Frames of neighbours, at most as many as a leaf holds, from the centre of their node's boxes.
PointLeaf leaf_of(const PointNode& node, std::span<const Polyhedron> records, std::span<const PointFace> faces) {
    PointLeaf leaf{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        leaf.origin[axis] = (*std::min_element(node.lower[axis], node.lower[axis] + faces.size()) +
                             *std::max_element(node.upper[axis], node.upper[axis] + faces.size())) /
                            2;
    double extent = 0;
    for (std::size_t lane = 0; lane < width; ++lane) {
        const std::size_t face = std::min(lane, faces.size() - 1);
        const Polyhedron& record = records[face];
        const std::array<const double*, 3> gradients{record.exact_gradient_x, record.exact_gradient_y,
                                                     record.exact_gradient_z};
        double lengths = record.exact_base[0] + record.exact_base[1] + record.exact_altitude;
        for (std::size_t column = 0; column < 3; ++column) {
            double offset = faces[face].offset[column];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                leaf.gradient[axis][column][lane] = static_cast<float>(gradients[axis][column]);
                offset += gradients[axis][column] * static_cast<double>(leaf.origin[axis]);
            }
            leaf.offset[column][lane] = static_cast<float>(offset);
            lengths += std::abs(offset);
        }
        for (std::size_t half = 0; half < 2; ++half) {
            leaf.base[half][lane] = static_cast<float>(record.exact_base[half]);
            leaf.normal_along[half][lane] = static_cast<float>(record.exact_normal_along[half]);
            leaf.normal_across[half][lane] = static_cast<float>(record.exact_normal_across[half]);
        }
        leaf.altitude[lane] = static_cast<float>(record.exact_altitude);
        extent = std::max(extent, lengths);
    }
    leaf.extent = rounded_up(extent);
    return leaf;
}

/// The lower, in the caller's order, of a face and of the one across its first edge if they have the same three
/// vertices.
std::uint32_t lower_of_two(const MeshTopology& topology, std::uint32_t face) {
    const std::span<const Triangle> triangles(topology.faces.triangles);
    const FaceEdges& edges = topology.edges.faces[face];
    constexpr unsigned without_face = edge_open | edge_at_box | edge_non_manifold;
    if ((edges.marks[0] & without_face) != 0) return face;
    const Corner across = Corner::unpack(edges.across[0]);
    const bool is_equal = triangles[across.face][previous_of_three(across.vertex)] == triangles[face][2];
    return is_equal && topology.order[across.face] < topology.order[face] ? across.face : face;
}

/// Sets the lowest face with the same three vertices, in the caller's order, of each face. Faces at edges of more than
/// two are sorted by their vertices: any number of them may be equal.
void set_lowest_equal(const MeshTopology& topology, std::span<PointFace> faces) {
    for_each_index(faces.size(), [&](std::size_t face) {
        faces[face].lowest = lower_of_two(topology, static_cast<std::uint32_t>(face));
    });
    std::vector<std::pair<Triangle, std::uint32_t>> sorted;  // vertices ascending, face
    for (std::uint32_t face = 0; face < faces.size(); ++face)
        if (topology.edges.is_non_manifold(face)) {
            sorted.emplace_back(topology.faces.triangles[face], face);
            std::ranges::sort(sorted.back().first);
        }
    std::ranges::sort(sorted, {},
                      [&](const auto& entry) { return std::pair(entry.first, topology.order[entry.second]); });
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const bool is_first = i == 0 || sorted[i].first != sorted[i - 1].first;
        faces[sorted[i].second].lowest = is_first ? sorted[i].second : faces[sorted[i - 1].second].lowest;
    }
}

/// Writes nodes of the first level, their leaves and their faces' records.
class FaceWriter {
public:
    FaceWriter(PointMesh& mesh, std::span<PointLeaf> leaves, std::span<PointFace> faces, std::span<Polyhedron> records)
        : mesh_(mesh), leaves_(leaves), faces_(faces), records_(records) {}

    void write(std::size_t node) const {
        const MeshTopology& topology = *mesh_.topology;
        const std::size_t begin = node * width, count = std::min(width, mesh_.face_count() - begin);
        const std::span<const Triangle> triangles(topology.faces.triangles);
        const MeshFaces faces{mesh_.positions, triangles, mesh_.lattice};
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t face = begin + i;
            records_[face] =
                pack(faces.frame(face), {}, topology.order[face], mesh_.positions, triangles[face], mesh_.lattice);
            faces_[face] = face_of(records_[face]);
            for (const Vec3& corner : mesh_.corners(face)) add_corner(mesh_.nodes[node], i, corner);
        }
        leaves_[node] = leaf_of(mesh_.nodes[node], records_.subspan(begin, count), faces_.subspan(begin, count));
    }

private:
    void add_corner(PointNode& node, std::size_t child, const Vec3& corner) const {
        const Vec3 at = mesh_.in_units(corner);
        for (std::size_t axis = 0; axis < 3; ++axis)
            add(node, child, axis, rounded_down(at[axis] - frame_error), rounded_up(at[axis] + frame_error));
    }

    PointMesh& mesh_;
    std::span<PointLeaf> leaves_;
    std::span<PointFace> faces_;
    std::span<Polyhedron> records_;
};

void set_sign_surface(PointMesh& result, const Mesh& mesh, const SignSurface& surface) {
    const MeshTopology& topology = *result.topology;
    if (!surface.vertices.empty()) {
        const UninitializedVector<std::uint32_t>& vertices = topology.faces.vertices;
        std::vector<bool> is_joined(mesh.vertices().size());
        for (std::uint32_t vertex = 0; vertex < is_joined.size(); ++vertex)
            if (const std::uint32_t other = surface.vertex(vertex); other != vertex)
                is_joined[vertex] = is_joined[other] = true;
        result.sign_positions.resize(vertices.size());
        result.is_joined.resize(vertices.size());
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            result.sign_positions[i] = mesh.vertices()[surface.vertex(vertices[i])];
            result.is_joined[i] = is_joined[vertices[i]];
        }
    }
    if (surface.faces.empty()) return;
    result.sign_counts.resize(result.face_count());
    for_each_index(result.face_count(), [&](std::size_t face) {
        result.sign_counts[face] = static_cast<std::int8_t>(surface.count(topology.order[face]));
    });
}

void fill_upper_levels(PointMesh& mesh) {
    const PointTree& tree = mesh.tree;
    for (std::size_t level = 1; level < tree.levels; ++level)
        for (std::size_t child = 0; child < tree.count[level - 1]; ++child)
            add_children(mesh.nodes[tree.first[level - 1] + child], mesh.nodes[tree.first[level] + child / width],
                         child % width);
}

}  // namespace

LatticeView lattice_for_points(const Mesh& mesh) {
    const double longest = mesh.box().longest_side();
    LatticeView lattice;
    lattice.origin = mesh.box().lower;
    if (longest > 0) lattice.unit = std::ldexp(1.0, std::max(std::ilogb(longest) - 8, -1000));
    constexpr auto smallest = static_cast<double>(std::numeric_limits<float>::min()),
                   largest = static_cast<double>(std::numeric_limits<float>::max());
    if (!(lattice.unit >= smallest && lattice.unit <= largest / 512))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the longest side of {}, {}, is beyond the floats that distances are given in; scale "
                                "the mesh",
                                mesh.name(), longest));
    return lattice;
}

UnitBox::UnitBox(const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = rounded_down(p[axis]);
        upper[axis] = rounded_up(p[axis]);
    }
}

UnitBox::UnitBox(const Box& box, const LatticeView& lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto in_units = [&](double x) {
            return std::clamp((x - lattice.origin[axis]) / lattice.unit, -box_limit, box_limit);
        };
        lower[axis] = rounded_down(in_units(box.lower[axis]));
        upper[axis] = rounded_up(in_units(box.upper[axis]));
    }
}

void UnitBox::add(const UnitBox& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], other.lower[axis]);
        upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
}

ChosenChildren overlapped_children(const PointNode& node, const UnitBox& box) {
    std::array<unsigned char, width> is_met{};
    for (std::size_t i = 0; i < width; ++i) {
        unsigned is_met_on_axes = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            is_met_on_axes &= static_cast<unsigned>(node.lower[axis][i] <= box.upper[axis]) &
                              static_cast<unsigned>(node.upper[axis][i] >= box.lower[axis]);
        is_met[i] = static_cast<unsigned char>(is_met_on_axes);
    }
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < width; ++i) bits |= static_cast<std::uint32_t>(is_met[i]) << i;
    return {bits, static_cast<std::uint32_t>(std::countr_zero(bits))};
}

UnitBox face_box(const PointMesh& mesh, std::size_t face) {
    UnitBox box;
    const PointNode& node = mesh.nodes[face / width];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = node.lower[axis][face % width];
        box.upper[axis] = node.upper[axis][face % width];
    }
    return box;
}

PointMesh make_point_mesh(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                          std::shared_ptr<const MeshTopology> topology) {
    PointMesh result;
    result.lattice = lattice_for_points(mesh);
    result.box = mesh.box();
    result.topology = std::move(topology);
    const UninitializedVector<std::uint32_t>& vertices = result.topology->faces.vertices;
    result.positions.resize(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t i) { result.positions[i] = mesh.vertices()[vertices[i]]; });

    set_sign_surface(result, mesh, surface);

    result.tree = shape_of(result.face_count());
    result.nodes.assign(result.tree.first[result.tree.levels - 1] + 1, empty_node());
    device::HostFilling leaves(tools.context, tools.pool, result.tree.count[0] * sizeof(PointLeaf),
                               "leaves of the points' tree");
    device::HostFilling records(tools.context, tools.pool, result.face_count() * sizeof(Polyhedron), "polyhedra");
    device::HostFilling faces(tools.context, tools.pool, result.face_count() * sizeof(PointFace),
                              "faces of the points' tree");
    const FaceWriter writer(result, {static_cast<PointLeaf*>(leaves.memory()), result.tree.count[0]},
                            {static_cast<PointFace*>(faces.memory()), result.face_count()},
                            {static_cast<Polyhedron*>(records.memory()), result.face_count()});
    for_each_chunk(result.tree.count[0], width, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t node = begin; node < end; ++node) writer.write(node);
    });
    set_lowest_equal(*result.topology, {static_cast<PointFace*>(faces.memory()), result.face_count()});
    fill_upper_levels(result);
    result.leaves = leaves.finish();
    result.polyhedra = records.finish();
    result.faces = faces.finish();
    result.device_nodes = device::uploaded(
        tools.context, tools.pool, std::span(result.nodes).subspan(result.tree.count[0]), "nodes of the points' tree");
    return result;
}

}  // namespace clsdf::engine
