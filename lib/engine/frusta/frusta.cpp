#include "frusta/frusta.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "frusta/gaps.hpp"
#include "frusta/records.hpp"
#include "frusta/slopes.hpp"
#include "mesh/mesh_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <optional>
#include <vector>

namespace clsdf::engine {

namespace {

/// Vertices with more neighbours get an unbounded polyhedron instead of a search among all pairs.
constexpr std::size_t few_neighbours = 24;

/// Directions to the vertex' neighbours, each once, in the caller's order; nullopt where there are too many.
std::optional<std::vector<Vector>> neighbour_directions(const MeshFaces& faces, std::span<const std::uint32_t> vertices,
                                                        const OneRings& rings, std::uint32_t vertex) {
    std::vector<std::uint32_t> neighbours;  // ascending by the caller's numbers
    neighbours.reserve(few_neighbours);
    const auto callers_number = [&](std::uint32_t neighbour) { return vertices[neighbour]; };
    for (std::size_t i = 0; i < rings.size(vertex); ++i) {
        const Corner corner = rings.corner(vertex, i);
        for (const std::uint32_t k : {next_of_three(corner.vertex), previous_of_three(corner.vertex)}) {
            const std::uint32_t neighbour = faces.triangles[corner.face][k];
            const auto place = std::ranges::lower_bound(neighbours, vertices[neighbour], {}, callers_number);
            if (place != neighbours.end() && *place == neighbour) continue;
            if (neighbours.size() == few_neighbours) return std::nullopt;
            neighbours.insert(place, neighbour);
        }
    }
    std::vector<Vector> directions;
    directions.reserve(neighbours.size());
    for (const std::uint32_t neighbour : neighbours)
        directions.push_back(
            ((to_vector(faces.position(neighbour)) - to_vector(faces.position(vertex))) / faces.lattice.unit)
                .normalized());
    return directions;
}

/// The extreme rays of the normal cone {u : u . n <= 0 for all n}, each perpendicular to two neighbours; nullopt where
/// two of them are too nearly parallel to trust their cross product.
std::optional<std::vector<Vector>> extreme_rays(const std::vector<Vector>& neighbours) {
    constexpr double nearly_parallel = 1e-6;
    constexpr double tolerance = 1e-8;  // above the rounding of a ray, 2^-52 / nearly_parallel
    std::vector<Vector> rays;
    rays.reserve(2 * neighbours.size());
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
        for (std::size_t j = i + 1; j < neighbours.size(); ++j) {
            const Vector cross = neighbours[i].cross(neighbours[j]);
            const double length = cross.norm();
            if (!(length > nearly_parallel)) return std::nullopt;
            const Vector ray = cross / length;
            bool is_in_cone = true, is_reverse_in_cone = true;
            for (std::size_t n = 0; n < neighbours.size() && (is_in_cone || is_reverse_in_cone); ++n) {
                const double along = neighbours[n].dot(ray);
                is_in_cone = is_in_cone && along <= tolerance;
                is_reverse_in_cone = is_reverse_in_cone && -along <= tolerance;
            }
            if (is_in_cone) rays.push_back(ray);
            if (is_reverse_in_cone) rays.emplace_back(-ray);
        }
    }
    return rays;
}

/// Sets the slopes of a frame around the rays' mean; false if the cone is too wide, or no cone.
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
    const auto neighbours = neighbour_directions(faces, vertices, rings, vertex);
    const auto rays = neighbours ? extreme_rays(*neighbours) : std::nullopt;
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

std::vector<std::uint32_t> site_blocks(std::span<const SiteFrustum> sites, std::span<const JoinedPart> joined) {
    std::vector<std::uint32_t> blocks;
    blocks.reserve(sites.size());
    auto mesh = joined.begin();
    std::uint32_t first_vertex = 0, first_block = 0;  // of the mesh
    for (const SiteFrustum& site : sites) {
        for (; mesh != joined.end() && site.vertex >= mesh->vertex_end; ++mesh) {
            first_block += (mesh->vertex_end - first_vertex) / site_block + 1;
            first_vertex = mesh->vertex_end;
        }
        blocks.push_back(first_block + (site.vertex - first_vertex) / site_block);
    }
    return blocks;
}

namespace {

constexpr float closed_slope = -1e30F;

}  // namespace

std::vector<SiteFrustum> in_groups(std::span<const SiteFrustum> sites, std::span<const std::uint32_t> blocks) {
    std::vector<SiteFrustum> result;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        result.push_back(sites[i]);
        if (i + 1 < sites.size() && blocks[i + 1] == blocks[i]) continue;
        SiteFrustum filling = sites[i];
        filling.slopes.above = filling.slopes.below = {closed_slope, closed_slope, closed_slope};
        result.resize(in_record_groups(result.size()), filling);
    }
    return result;
}

bool is_filling(const SiteFrustum& site) {
    return site.slopes.above[0] == closed_slope;
}

LatticeView view_of(const Box& box) {
    double largest = 0;
    for (const Vec3& corner : {box.lower, box.upper})
        for (const double x : corner) largest = std::max(largest, std::abs(x));
    return {{}, largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 8) : 1.0};
}

std::size_t FoundFrusta::host_bytes() const {
    return sites.size() * sizeof(SiteFrustum) + slivers.size() * sizeof(std::uint32_t);
}

std::size_t Frusta::host_bytes() const {
    return positions.host_bytes() + slopes.host_bytes() + FoundFrusta::host_bytes();
}

UninitializedVector<Vec3> ordered_positions(const MeshTopology& topology, std::span<const Vec3> positions) {
    UninitializedVector<Vec3> ordered(topology.faces.vertices.size());
    for_each_index(ordered.size(), [&](std::size_t i) { ordered[i] = positions[topology.faces.vertices[i]]; });
    return ordered;
}

namespace {

using Numbers = std::vector<std::uint32_t>;

Numbers all_numbers(std::size_t count) {
    Numbers numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0U);
    return numbers;
}

/// Whether a frame is one of triangle_frame()'s special cases, or nearly, in any lattice. Lengths are as in view_of().
bool is_sliver(const TriangleFrame& frame) {
    constexpr double thin = 2e-4;  // an altitude, beside its base
    constexpr double vanishing = 1e-20;
    return !(frame.face.altitude > thin * frame.base_length()) || !(frame.base_length() > vanishing);
}

/// All faces around the vertices, and `others`; ascending.
Numbers faces_around(std::span<const std::uint32_t> vertices, const OneRings& rings, Numbers others) {
    for (const std::uint32_t vertex : vertices)
        for (std::size_t i = 0; i < rings.size(vertex); ++i) others.push_back(rings.corner(vertex, i).face);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others;
}

}  // namespace

void complete_frusta(const MeshTopology& topology, const Box& box, const LeftToHost& left, Frusta& frusta,
                     const FrustaOptions& options) {
    const std::size_t all = topology.order.size();
    Numbers asked;  // vertices
    std::ranges::set_difference(left.vertices, left.gaps, std::back_inserter(asked));
    const LatticeView lattice = view_of(box);
    const MeshFaces faces{frusta.positions, topology.faces.triangles, lattice};
    const FaceMeasures measures(faces, topology.rings, topology.edges);
    const Numbers numbers = left.faces.size() == all ? left.faces : faces_around(asked, topology.rings, left.faces);
    UninitializedVector<MeasuredFace> measured(numbers.size());
    constexpr std::size_t grain = 32;  // kernels leave few faces
    for_each_index(
        numbers.size(),
        [&](std::size_t i) {
            measured[i] = measures.measure(topology.original(numbers[i]));
            if (options.lean) lean(measured[i].frame, measured[i].slopes);
        },
        grain);
    const MeasuredFaces by_face(measured, numbers.size() == all ? std::span<const std::uint32_t>() : numbers);

    for (const std::uint32_t face : left.faces) {
        const MeasuredFace& own = by_face[face];
        frusta.slopes[face] = own.slopes;
        if (own.frame.is_box) ++frusta.boxes;
        if (is_sliver(own.frame)) frusta.slivers.push_back(face);
    }
    const std::vector<std::uint8_t> marks = find_gaps(faces, topology.edges.faces, topology.rings, by_face, asked);
    Numbers gaps = left.gaps;
    frusta.saddle_vertices = left.saddles_elsewhere + left.gaps.size();
    for (std::size_t i = 0; i < marks.size(); ++i) {
        if ((marks[i] & vertex_saddle) != 0) ++frusta.saddle_vertices;
        if ((marks[i] & vertex_gap) != 0) gaps.push_back(asked[i]);
    }
    std::ranges::inplace_merge(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(left.gaps.size()));
    if (!options.point_sites) return;
    frusta.sites.resize(gaps.size());
    for_each_index(gaps.size(), [&](std::size_t i) {
        frusta.sites[i] = point_site(faces, topology.order, topology.faces.vertices, topology.rings, gaps[i]);
    });
}

Frusta make_frusta(const MeshTopology& topology, std::span<const Vec3> positions, const FrustaOptions& options) {
    Frusta frusta;
    frusta.positions = ordered_positions(topology, positions);
    frusta.slopes.resize(topology.order.size());
    const LeftToHost all{all_numbers(topology.order.size()), all_numbers(frusta.positions.size()), 0};
    Extent extent;
    for (const Vec3& position : frusta.positions) extent.add(position);
    complete_frusta(topology, extent.box, all, frusta, options);
    return frusta;
}

}  // namespace clsdf::engine
