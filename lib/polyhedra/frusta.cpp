#include "polyhedra/frusta.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/lateral_planes.hpp"
#include "polyhedra/records.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// Vertices with more neighbours get an unbounded polyhedron instead of a search among all pairs.
constexpr std::size_t few_neighbours = 24;

/// Directions to the vertex' neighbours, each once, in the caller's order.
std::vector<Vector> neighbour_directions(const MeshFaces& faces, std::span<const std::uint32_t> vertices,
                                         const OneRings& rings, std::uint32_t vertex) {
    std::vector<std::uint32_t> neighbours;
    for (std::size_t i = 0; i < rings.size(vertex); ++i) {
        const Corner corner = rings.corner(vertex, i);
        neighbours.push_back(faces.triangles[corner.face][next_of_three(corner.vertex)]);
        neighbours.push_back(faces.triangles[corner.face][previous_of_three(corner.vertex)]);
    }
    std::sort(neighbours.begin(), neighbours.end(),
              [&](std::uint32_t a, std::uint32_t b) { return vertices[a] < vertices[b]; });
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    std::vector<Vector> directions;
    directions.reserve(neighbours.size());
    for (const std::uint32_t neighbour : neighbours)
        directions.push_back(
            ((to_vector(faces.position(neighbour)) - to_vector(faces.position(vertex))) / faces.lattice.unit)
                .normalized());
    return directions;
}

/// The extreme rays of the normal cone {u : u . n <= 0 for all n}, each perpendicular to two neighbours; nullopt where
/// there are too many neighbours, or two of them are too nearly parallel to trust their cross product.
std::optional<std::vector<Vector>> extreme_rays(const std::vector<Vector>& neighbours) {
    constexpr double nearly_parallel = 1e-6;
    constexpr double tolerance = 1e-8;  // above the rounding of a ray, 2^-52 / nearly_parallel
    if (neighbours.size() > few_neighbours) return std::nullopt;
    std::vector<Vector> rays;
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
        for (std::size_t j = i + 1; j < neighbours.size(); ++j) {
            const Vector cross = neighbours[i].cross(neighbours[j]);
            const double length = cross.norm();
            if (!(length > nearly_parallel)) return std::nullopt;
            for (const Vector& ray : {Vector(cross / length), Vector(-cross / length)}) {
                const auto in_cone = [&](const Vector& n) { return n.dot(ray) <= tolerance; };
                if (std::all_of(neighbours.begin(), neighbours.end(), in_cone)) rays.push_back(ray);
            }
        }
    }
    return rays;
}

/// Sets the slopes of a frame around the rays' mean; false where the cone is too wide, or no cone.
bool set_slopes(const std::vector<Vector>& rays, const TriangleFrame& frame, FaceSlopes& slopes) {
    constexpr double lowest = 1e-3;  // sine of a ray's angle to the frame's plane
    constexpr double tolerance = 1e-6;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Vector outward = -frame.inwards[k];
        double slope = 0;
        for (const Vector& ray : rays) {
            const double height = ray.dot(frame.normal);
            if (height < lowest) return false;
            slope = std::max(slope, ray.dot(outward) / height);
        }
        slopes.above[k] = widened(slope + tolerance);
        slopes.below[k] = 0;
    }
    return true;
}

}  // namespace

SiteFrustum point_site(const MeshFaces& faces, std::span<const std::uint32_t> order,
                       std::span<const std::uint32_t> vertices, const OneRings& rings, std::uint32_t vertex) {
    SiteFrustum site;
    site.vertex = vertex;
    site.face = rings.corner(vertex, 0).face;
    for (std::size_t i = 1; i < rings.size(vertex); ++i) {
        const std::uint32_t face = rings.corner(vertex, i).face;
        if (order[face] < order[site.face]) site.face = face;
    }
    const auto rays = extreme_rays(neighbour_directions(faces, vertices, rings, vertex));
    Vector sum = Vector::Zero();
    if (rays)
        for (const Vector& ray : *rays) sum += ray;
    const double length = sum.norm();
    site.normal = length > 1e-3 ? Vector(sum / length) : Vector::UnitZ();
    const TriangleFrame frame = point_frame(Vector::Zero(), site.normal);
    const bool bounded = rays && rays->size() >= 3 && length > 1e-3 && set_slopes(*rays, frame, site.slopes);
    if (!bounded) site.slopes.above = site.slopes.below = {CLSDF_OPEN_SLOPE, CLSDF_OPEN_SLOPE, CLSDF_OPEN_SLOPE};
    return site;
}

namespace {

struct MarkedVertices {
    std::size_t saddles = 0;
    std::vector<std::uint32_t> gaps{};  ///< ascending
};

MarkedVertices marked_vertices(std::span<const std::uint8_t> marks) {
    constexpr std::size_t stretch = 4096;
    std::vector<MarkedVertices> parts(stretch_count(marks.size(), stretch));
    for_each_stretch(marks.size(), stretch, [&](std::size_t part, std::size_t begin, std::size_t end) {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            parts[part].saddles += (marks[vertex] & vertex_saddle) != 0 ? 1U : 0U;
            if ((marks[vertex] & vertex_gap) != 0) parts[part].gaps.push_back(static_cast<std::uint32_t>(vertex));
        }
    });
    MarkedVertices all;
    for (const MarkedVertices& part : parts) {
        all.saddles += part.saddles;
        all.gaps.insert(all.gaps.end(), part.gaps.begin(), part.gaps.end());
    }
    return all;
}

/// Whether a frame is one of triangle_frame()'s special cases, or nearly, in any lattice. Lengths are as in view_of().
bool is_sliver(const TriangleFrame& frame) {
    constexpr double thin = 2e-4;  // an altitude, beside its base
    constexpr double vanishing = 1e-20;
    return !(frame.altitude > thin * frame.base_length()) || !(frame.base_length() > vanishing);
}

PairedEdges copy_of(const PairedEdges& edges) {
    PairedEdges copy{UninitializedVector<FaceEdges>(edges.faces.size()), edges.non_manifold_ends,
                     edges.non_manifold_corners};
    for_each_index(copy.faces.size(), [&](std::size_t face) { copy.faces[face] = edges.faces[face]; });
    return copy;
}

}  // namespace

LatticeView view_of(std::span<const Vec3> positions) {
    double largest = 0;
    for (const Vec3& position : positions)
        for (const double x : position) largest = std::max(largest, std::abs(x));
    return {{}, largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 8) : 1.0};
}

std::size_t Frusta::bytes() const {
    return positions.size() * sizeof(Vec3) + slopes.size() * sizeof(FaceSlopes) + sites.size() * sizeof(SiteFrustum) +
           slivers.size() * sizeof(std::uint32_t);
}

Frusta make_frusta(const MeshTopology& topology, std::span<const Vec3> positions, const FirstRecords* first,
                   const FrustaOptions& options) {
    const OneRings& rings = topology.rings;
    const std::size_t count = topology.order.size();
    Frusta result;
    result.positions.resize(topology.faces.vertices.size());
    for_each_index(result.positions.size(),
                   [&](std::size_t i) { result.positions[i] = positions[topology.faces.vertices[i]]; });
    const LatticeView lattice = first != nullptr ? first->lattice : view_of(result.positions);
    const MeshFaces faces{result.positions, topology.faces.triangles, lattice};

    PairedEdges edges = copy_of(topology.edges);  // whose marks depend on the positions, too
    const std::vector<EdgeSlope> of_non_manifold = non_manifold_slopes(faces, rings, edges, CLSDF_OPEN_SLOPE);

    result.slopes.resize(count);
    UninitializedVector<FramePlanes::Directions> directions(count);
    UninitializedVector<std::uint8_t> marks(rings.vertex_count());
    for_each_index(marks.size(), [&](std::size_t vertex) { marks[vertex] = 0; });
    tbb::enumerable_thread_specific<GapScreen> screens(
        [&] { return GapScreen(topology.faces.first_vertices, edges.faces, rings, rejection_margin, marks); });
    std::atomic<std::size_t> boxes = 0;
    tbb::enumerable_thread_specific<std::vector<std::uint32_t>> slivers;
    measure_edges(faces, edges.faces, of_non_manifold, CLSDF_OPEN_SLOPE, [&](EdgeSlopes& stretch) {
        std::size_t boxes_here = 0;
        for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
            const TriangleFrame& frame = stretch.frame(face);
            if (options.lean) lean(frame, stretch.slopes(face));
            boxes_here += frame.is_box ? 1U : 0U;
            if (is_sliver(frame)) slivers.local().push_back(static_cast<std::uint32_t>(face));
            result.slopes[face] = stretch.slopes(face);
            directions[face] = {frame.normal, frame.inwards};
            if (first != nullptr) write_face_record(topology, result, lattice, face, frame, first->records[face]);
        }
        boxes += boxes_here;
        screens.local().look_at(stretch);
    });
    std::vector<std::uint32_t> left;
    for (GapScreen& screen : screens) {
        const auto& of_screen = screen.finish();
        left.insert(left.end(), of_screen.begin(), of_screen.end());
    }
    find_gaps(faces, edges.faces, rings, FramePlanes(directions, result.slopes), rejection_margin, left, marks);

    result.boxes = boxes;
    for (const std::vector<std::uint32_t>& some : slivers)
        result.slivers.insert(result.slivers.end(), some.begin(), some.end());
    std::sort(result.slivers.begin(), result.slivers.end());
    const MarkedVertices marked = marked_vertices(marks);
    result.saddle_vertices = marked.saddles;
    if (!options.point_sites) return result;
    result.sites.resize(marked.gaps.size());
    for_each_index(marked.gaps.size(), [&](std::size_t i) {
        result.sites[i] = point_site(faces, topology.order, topology.faces.vertices, rings, marked.gaps[i]);
    });
    return result;
}

}  // namespace clsdf::polyhedra
