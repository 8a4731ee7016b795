#include "papers/pieces.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "topology/face_order.hpp"
#include "topology/topology.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace clsdf::papers {

namespace {

using namespace engine;

/// The cone of a vertex: {u : u . n <= 0 for the directions n to all neighbours} (docs/method.md, 'What an exact
/// polyhedron must contain'), and what bounds its part of the unit ball.
class MauchCone {
public:
    /// normal . u <= 0, or <= 1 if it is a cap; of unit length.
    struct Bound {
        engine::Vector normal;
        bool is_cap;
    };

    void start() { half_spaces_.clear(); }
    void add(const engine::Vector& neighbour) { half_spaces_.push_back({neighbour, 0}); }

    /// False if the cone is empty, or thinner than 2e-13; its bounds are then those of what may be left of it. Of
    /// very many neighbours a few are kept, which bound the cone and little more.
    bool build();

    /// CLSDF_MOST_PLANES at most, which may leave more than the cone if it has very many neighbours: a vertex is a
    /// bound of the distance wherever the sample lies.
    std::span<const Bound> bounds() const { return bounds_; }

private:
    void add_cap(const engine::Vector& normal) { bounds_.push_back({normal, true}); }
    void add_caps_around(const engine::Vector& axis);

    std::vector<HalfSpace> half_spaces_;
    std::vector<Bound> bounds_;
};

constexpr std::size_t cube_caps = 6;
constexpr std::size_t most_walls = CLSDF_MOST_PLANES - cube_caps;

/// Time is proportional to the square of the half-spaces up to this number, and to the number above it.
constexpr std::size_t most_cuts_by_all = 256;
constexpr std::size_t most_deepest_cuts = 32;

ConvexPolyhedron part_of_cube(std::span<const HalfSpace> half_spaces) {
    return clip({{-1, -1, -1}, {1, 1, 1}}, half_spaces);
}

double height_over(const HalfSpace& half_space, const ConvexPolyhedron& solid) {
    double highest = 0;
    for (const Vector& vertex : solid.vertices) highest = std::max(highest, half_space.normal.dot(vertex));
    return highest;
}

/// A few of the half-spaces, which leave little more than all of them: each is the one that cuts most from what those
/// before it have left.
std::vector<HalfSpace> deepest_cuts(std::span<const HalfSpace> half_spaces) {
    std::vector<HalfSpace> chosen;
    ConvexPolyhedron solid = part_of_cube(chosen);
    while (chosen.size() < most_deepest_cuts && !solid.is_empty()) {
        double highest = 0;
        const HalfSpace* deepest = nullptr;
        for (const HalfSpace& half_space : half_spaces)
            if (const double height = height_over(half_space, solid); height > highest) {
                highest = height;
                deepest = &half_space;
            }
        if (deepest == nullptr) break;
        chosen.push_back(*deepest);
        solid = part_of_cube(chosen);
    }
    return chosen;
}

/// Rays to the far corners of what is left of a cube around the vertex.
std::vector<Vector> rays_of(const ConvexPolyhedron& solid) {
    constexpr double near = 0.5;
    std::vector<Vector> rays;
    for (const Vector& corner : solid.vertices)
        if (corner.norm() > near) rays.push_back(corner.normalized());
    return rays;
}

void MauchCone::add_caps_around(const Vector& axis) {
    const Vector across = engine::any_perpendicular(axis);
    const Vector third = axis.cross(across);
    for (const Vector& normal : {axis, across, third}) {
        add_cap(normal);
        add_cap(-normal);
    }
}

bool MauchCone::build() {
    bounds_.clear();
    if (half_spaces_.size() > most_cuts_by_all) half_spaces_ = deepest_cuts(half_spaces_);
    const ConvexPolyhedron solid = part_of_cube(half_spaces_);
    std::vector<std::size_t> walls;
    for (const ConvexPolyhedron::Face& face : solid.faces)
        if (face.half_space != ConvexPolyhedron::start_box) walls.push_back(face.half_space);
    if (solid.is_empty())
        for (std::size_t i = 0; i < half_spaces_.size(); ++i) walls.push_back(i);
    const bool is_whole = walls.size() <= most_walls;
    walls.resize(std::min(walls.size(), most_walls));
    for (const std::size_t wall : walls) bounds_.push_back({half_spaces_[wall].normal, false});

    const std::vector<Vector> rays = rays_of(solid);
    Vector sum = Vector::Zero();
    for (const Vector& ray : rays) sum += ray;
    const double length = sum.norm();
    const Vector axis = length > 1e-3 ? Vector(sum / length) : Vector::UnitX();
    constexpr double narrow = 0.955;  // cosine; the one cap is 5% too high at the rays
    const bool is_narrow = is_whole && !rays.empty() && std::all_of(rays.begin(), rays.end(), [&](const Vector& ray) {
                               return ray.dot(axis) > narrow;
                           });
    if (is_narrow)
        add_cap(axis);
    else
        add_caps_around(axis);
    return !solid.is_empty();
}

constexpr double turn = 2 * std::numbers::pi;

/// The mesh's faces in Morton order.
struct Faces {
    Faces(const Mesh& mesh_in, const LatticeView& lattice_in)
        : mesh(mesh_in), lattice(lattice_in), order(morton_order(mesh_in)), triangles(order.size()) {
        frames.resize(order.size());
        for_each_index(order.size(), [&](std::size_t face) {
            const Triangle& triangle = triangles[face] = mesh.triangles()[order[face]];
            const std::vector<Vec3>& vertices = mesh.vertices();
            frames[face] =
                triangle_frame({vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]}, lattice);
        });
    }

    Vector direction(std::uint32_t from, std::uint32_t to) const {
        return ((to_vector(mesh.vertices()[to]) - to_vector(mesh.vertices()[from])) / lattice.unit).normalized();
    }

    const Mesh& mesh;
    const LatticeView& lattice;
    UninitializedVector<std::uint32_t> order;  ///< the caller's index of each
    UninitializedVector<Triangle> triangles;
    UninitializedVector<TriangleFrame> frames;
};

/// The directions around an edge that lead away from all its faces, as angles from the inward direction of the face
/// `first`, turning away from it: those from `begin` to `end`.
struct Sector {
    Corner first;
    Corner last;
    double side;  ///< 1 or -1: of the first face, where the sector begins
    double begin;
    double end;

    bool is_empty(double smallest) const { return !(end - begin > smallest); }
};

Sector sector_at(const Faces& faces, std::span<const EdgeEntry> entries) {
    struct Spoke {
        double angle;
        Corner edge;
    };
    const TriangleFrame& first = faces.frames[entries[0].edge().face];
    const Vector x = first.inwards[entries[0].edge().vertex];
    const Vector& y = first.normal;
    std::vector<Spoke> spokes;
    for (const EdgeEntry& entry : entries) {
        const Vector inward = faces.frames[entry.edge().face].inwards[entry.edge().vertex];
        spokes.push_back({std::atan2(inward.dot(y), inward.dot(x)), entry.edge()});
    }
    std::stable_sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) { return a.angle < b.angle; });

    // Between the two faces that are farthest apart; of folded ones the gap may be a whole turn.
    std::size_t widest = spokes.size() - 1;
    double gap = spokes.front().angle + turn - spokes.back().angle;
    for (std::size_t i = 0; i + 1 < spokes.size(); ++i)
        if (spokes[i + 1].angle - spokes[i].angle > gap) {
            gap = spokes[i + 1].angle - spokes[i].angle;
            widest = i;
        }
    const Spoke& begin = spokes[widest];
    const Spoke& end = spokes[widest + 1 < spokes.size() ? widest + 1 : 0];
    const Vector turning = -std::sin(begin.angle) * x + std::cos(begin.angle) * y;
    const double side = faces.frames[begin.edge.face].normal.dot(turning) < 0 ? -1 : 1;
    return {begin.edge, end.edge, side, turn / 4, gap - turn / 4};
}

/// The same length, in samples from another origin.
Affine moved(const Affine& value, const std::array<std::int32_t, 3>& from, const std::array<std::int32_t, 3>& to) {
    Affine result = value;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result.constant +=
            value.gradient[static_cast<Eigen::Index>(axis)] * (static_cast<double>(to[axis]) - from[axis]);
    return result;
}

class MauchPolyhedra {
public:
    struct Counts {
        std::size_t towers = 0, wedges = 0, cones = 0, boxes = 0;
    };

    MauchPolyhedra(const Faces& faces, const OneRings& rings, double half_width, std::span<const Polyhedron> records)
        : faces_(faces),
          rings_(rings),
          half_width_(half_width),
          sliver_(1e-8 * std::max(1.0, half_width)),
          records_(records) {}

    void add_face(std::size_t face, PieceCollector& collector, Counts& counts) const {
        const RecordFrame record(records_[face]);
        PieceBounds bounds;
        add_slab(record.height(), half_width_, bounds);
        if (is_box(face)) {
            bounds.add(record.outward(CLSDF_EDGE_BASE) - half_width_);
            bounds.add(-1 * record.outward(CLSDF_EDGE_BASE) - (faces_.frames[face].face.altitude + half_width_));
            bounds.add(record.past(CLSDF_EDGE_BASE) - half_width_);
            bounds.add(record.before(CLSDF_EDGE_BASE) - half_width_);
            ++counts.boxes;
            collector.add(record.origin(), static_cast<std::uint32_t>(face), bounds.span());
            return;
        }
        for (std::size_t edge = 0; edge < 3; ++edge) bounds.add(record.outward(edge));
        // The slack of two walls that meet at a small angle is long, and the plane of the face goes on there.
        if (!record.is_compact()) {
            bounds.add(record.past(CLSDF_EDGE_BASE));
            bounds.add(record.before(CLSDF_EDGE_BASE));
        }
        ++counts.towers;
        collector.add(record.origin(), static_cast<std::uint32_t>(face), bounds.span(), CLSDF_SITE_FACE);
    }

    void add_edge(std::span<const EdgeEntry> entries, PieceCollector& collector, Counts& counts) const {
        const auto at_box = [&](const EdgeEntry& entry) { return is_box(entry.edge().face); };
        if (std::any_of(entries.begin(), entries.end(), at_box)) return;
        const Sector sector = sector_at(faces_, entries);
        // A wedge that is left out lies within the slack of the towers beside it.
        if (sector.is_empty(std::min(2e-12, 0.1 * CLSDF_PIECE_SLACK / half_width_))) return;

        const RecordFrame record(records_[sector.first.face]);
        const std::size_t edge = edge_of(sector.first);
        const Affine outward = record.outward(edge);
        PieceBounds bounds;
        bounds.add(record.before(edge));
        bounds.add(record.past(edge));
        bounds.add(-1 * outward);
        if (sector.last.face != sector.first.face) {
            const RecordFrame other(records_[sector.last.face]);
            bounds.add(moved(-1 * other.outward(edge_of(sector.last)), other.origin(), record.origin()));
        }
        const auto cap = [&](double angle) {
            bounds.add(-std::cos(angle) * outward + sector.side * std::sin(angle) * record.height() - half_width_);
        };
        constexpr double narrow = 0.6;  // a single cap is 5% too wide at the ends
        cap((sector.begin + sector.end) / 2);
        if (sector.end - sector.begin > narrow) {
            cap(sector.begin);
            cap(sector.end);
        }
        const EdgeEntry& lowest = *std::min_element(
            entries.begin(), entries.end(),
            [&](const EdgeEntry& a, const EdgeEntry& b) { return index(a.edge().face) < index(b.edge().face); });
        ++counts.wedges;
        collector.add(record.origin(), lowest.edge().face, bounds.span(),
                      CLSDF_SITE_EDGE + static_cast<std::uint32_t>(edge_of(lowest.edge())));
    }

    void add_vertex(std::uint32_t vertex, MauchCone& cone, PieceCollector& collector, Counts& counts) const {
        Corner lowest = rings_.corner(vertex, 0);
        double least_sine = 1;
        std::vector<std::uint32_t> neighbours;
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) {
            const Corner corner = rings_.corner(vertex, i);
            if (is_box(corner.face)) return;
            if (index(corner.face) < index(lowest.face)) lowest = corner;
            const TriangleFrame& frame = faces_.frames[corner.face];
            // The sine of the corner's angle: the edge that ends there, seen from the one that begins there.
            least_sine = std::min(least_sine, sine_at(frame, corner.vertex));
            neighbours.push_back(faces_.triangles[corner.face][next_of_three(corner.vertex)]);
            neighbours.push_back(faces_.triangles[corner.face][previous_of_three(corner.vertex)]);
        }
        std::sort(neighbours.begin(), neighbours.end());
        neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
        cone.start();
        for (const std::uint32_t neighbour : neighbours) cone.add(faces_.direction(vertex, neighbour));
        // An empty cone is a thin one; it lies within the slack of its neighbours unless a corner is all but closed.
        if (!cone.build() && least_sine > 1e-6 * std::max(1.0, half_width_)) return;

        const Polyhedron& record = records_[lowest.face];
        const std::array<std::int32_t, 3> origin{record.origin_x, record.origin_y, record.origin_z};
        const Vector spacing = to_vector(faces_.lattice.spacing_in_units);
        const Vector from_origin = from_sample(faces_.lattice, faces_.mesh.vertices()[vertex], origin);
        PieceBounds bounds;
        for (const MauchCone::Bound& bound : cone.bounds())
            bounds.add({bound.normal.cwiseProduct(spacing),
                        -bound.normal.dot(from_origin) - (bound.is_cap ? half_width_ : 0)});
        ++counts.cones;
        collector.add(origin, lowest.face, bounds.span(), CLSDF_SITE_VERTEX + vertex_of(lowest));
    }

private:
    bool is_box(std::size_t face) const {
        const TriangleFrame& frame = faces_.frames[face];
        return frame.is_box || !(frame.face.altitude > sliver_ * frame.base_length());
    }
    std::uint32_t index(std::size_t face) const { return faces_.order[face]; }

    std::size_t edge_of(const Corner& edge) const { return faces_.frames[edge.face].polyhedron_edge(edge.vertex); }

    /// The base begins at the left vertex.
    std::uint32_t vertex_of(const Corner& corner) const {
        switch (faces_.frames[corner.face].polyhedron_edge(corner.vertex)) {
            case CLSDF_EDGE_BASE:
                return CLSDF_VERTEX_LEFT;
            case CLSDF_EDGE_RIGHT:
                return CLSDF_VERTEX_RIGHT;
            default:
                return CLSDF_VERTEX_APEX;
        }
    }

    static double sine_at(const TriangleFrame& frame, std::uint32_t vertex) {
        const Vector before = frame.inwards[previous_of_three(vertex)];
        return frame.inwards[vertex].cross(before).norm();
    }

    static void add_slab(const Affine& height, double half_width, PieceBounds& bounds) {
        bounds.add(height - half_width);
        bounds.add(-1 * height - half_width);
    }

    const Faces& faces_;
    const OneRings& rings_;
    double half_width_;
    double sliver_;  ///< height of a box as a part of its length: walls round with its inverse and the half width
    std::span<const Polyhedron> records_;
};

}  // namespace

MauchPieces mauch_pieces(const Mesh& mesh, const LatticeView& lattice, double half_width, const Layout& grid) {
    const Faces faces(mesh, lattice);
    const OneRings rings(faces.triangles, mesh.vertices().size());
    MauchPieces result;
    result.polyhedra.resize(faces.order.size());
    for_each_index(faces.order.size(), [&](std::size_t face) {
        result.polyhedra[face] =
            pack(faces.frames[face], FaceSlopes{}, faces.order[face], mesh.vertices(), faces.triangles[face], lattice);
    });

    struct State {
        MauchPolyhedra::Counts counts;
        MauchCone cone;
        std::vector<EdgeEntry> entries;
    };
    tbb::enumerable_thread_specific<State> states;
    const MauchPolyhedra polyhedra(faces, rings, half_width, result.polyhedra);
    // A vertex, and the edges of which it is the lower end, follow the first face that names it.
    result.pieces = collect_pieces(faces.order.size(), grid, [&](std::size_t face, PieceCollector& collector) {
        State& state = states.local();
        polyhedra.add_face(face, collector, state.counts);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = faces.triangles[face][k];
            if (rings.place(vertex, {static_cast<std::uint32_t>(face), k}) != 0) continue;
            edges_above(faces.triangles, rings, vertex, state.entries);
            for_each_edge(state.entries,
                          [&](std::span<const EdgeEntry> edge) { polyhedra.add_edge(edge, collector, state.counts); });
            polyhedra.add_vertex(vertex, state.cone, collector, state.counts);
        }
    });
    for (const State& state : states) {
        result.towers += state.counts.towers;
        result.wedges += state.counts.wedges;
        result.cones += state.counts.cones;
        result.boxes += state.counts.boxes;
    }
    return result;
}

}  // namespace clsdf::papers
