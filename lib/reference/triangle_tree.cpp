#include "triangle_tree.hpp"
#include "aabb_tree.hpp"
#include "core/parallel.hpp"
#include "triangle.hpp"

#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::reference {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;

/// An element of the tree: the index of a triangle, and a pointer to its mesh.
class Primitive {
public:
    using Id = std::uint32_t;
    using Point = Kernel::Point_3;
    using Datum = Kernel::Triangle_3;

    Primitive() = default;
    Primitive(const Mesh& mesh, Id id) : mesh_(&mesh), id_(id) {}

    Id id() const { return id_; }
    Point reference_point() const { return corner(0); }
    Datum datum() const { return {corner(0), corner(1), corner(2)}; }

private:
    Point corner(std::size_t index) const {
        const Vec3& vertex = mesh_->vertices()[mesh_->triangles()[id_][index]];
        return {vertex[0], vertex[1], vertex[2]};
    }

    const Mesh* mesh_ = nullptr;
    Id id_ = 0;
};

using Traits = AabbTraits<Kernel, Primitive>;
using Tree = CGAL::AABB_tree<Traits>;
using Node = CGAL::AABB_node<Traits>;

double gap(double value, double lower, double upper) {
    return value < lower ? lower - value : (value > upper ? value - upper : 0);
}

double squared_distance_to_box(const ExactPosition& query, const CGAL::Bbox_3& box) {
    const double x = gap(query.head[0], box.xmin(), box.xmax());
    const double y = gap(query.head[1], box.ymin(), box.ymax());
    const double z = gap(query.head[2], box.zmin(), box.zmax());
    return x * x + y * y + z * z;
}

/// CGAL's traversal by priority: the nearer box first; boxes beyond the best distance are skipped.
class NearestTraversal {
public:
    using Priority = double;

    NearestTraversal(const std::vector<TriangleFrame>& frames, const std::vector<std::uint32_t>& slots,
                     const ExactPosition& query, double extent, double bound)
        : frames_(frames),
          slots_(slots),
          slack_(8 * std::numeric_limits<double>::epsilon() * extent + 2 * query.rounding()) {
        set_bound(bound);
    }

    bool go_further() const { return true; }

    bool do_intersect(const ExactPosition& query, const Node& node) const {
        return squared_distance_to_box(query, node.bbox()) <= squared_bound_;
    }

    std::pair<bool, Priority> do_intersect_with_priority(const ExactPosition& query, const Node& node) const {
        const double squared = squared_distance_to_box(query, node.bbox());
        return {squared <= squared_bound_, -squared};
    }

    void intersection(const ExactPosition& query, const Primitive& primitive) {
        const std::uint32_t index = primitive.id();
        const TriangleFrame& frame = frames_[slots_[index]];
        if (frame.height_bound(query) > bound_) {
            return;
        }
        const TriangleFrame::Closest closest = frame.closest(query);
        if (closest.distance < bound_ || (closest.distance == bound_ && (!found_ || index < nearest_.triangle))) {
            found_ = true;
            nearest_ = {closest.distance, index, closest.site, closest.point};
            set_bound(closest.distance);
        }
    }

    std::optional<Nearest> result() const { return found_ ? std::optional(nearest_) : std::nullopt; }

private:
    // A box at the distance of the bound may contain a triangle that is as near as the best one and has a lower index.
    // The slack covers the rounding of both distances, the last summand the underflow of squares.
    void set_bound(double bound) {
        bound_ = bound;
        const double widened = bound * (1 + 16 * std::numeric_limits<double>::epsilon()) + slack_;
        squared_bound_ = widened * widened + std::numeric_limits<double>::min();
    }

    const std::vector<TriangleFrame>& frames_;
    const std::vector<std::uint32_t>& slots_;
    double slack_;
    double bound_ = 0;
    double squared_bound_ = 0;
    bool found_ = false;
    Nearest nearest_;
};

/// The triangles in the order in which the tree's leaves lie.
class LeafOrder {
public:
    bool go_further() const { return true; }
    bool do_intersect(int, const Node&) const { return true; }
    void intersection(int, const Primitive& primitive) { triangles.push_back(primitive.id()); }

    std::vector<std::uint32_t> triangles;
};

struct RayQuery {
    double x, y, z;
};

class RayTraversal {
public:
    explicit RayTraversal(std::vector<std::uint32_t>& triangles) : triangles_(triangles) {}

    bool go_further() const { return true; }

    bool do_intersect(const RayQuery& ray, const Node& node) const { return meets(ray, node.bbox()); }

    void intersection(const RayQuery& ray, const Primitive& primitive) {
        if (meets(ray, primitive.datum().bbox())) {
            triangles_.push_back(primitive.id());
        }
    }

private:
    static bool meets(const RayQuery& ray, const CGAL::Bbox_3& box) {
        return ray.x <= box.xmax() && box.ymin() <= ray.y && ray.y <= box.ymax() && box.zmin() <= ray.z &&
               ray.z <= box.zmax();
    }

    std::vector<std::uint32_t>& triangles_;
};

}  // namespace

struct TriangleTree::State {
    const Mesh& mesh;
    Tree tree;
    std::vector<TriangleFrame> frames;  ///< in the order of the leaves, for locality
    std::vector<std::uint32_t> slots;   ///< index of a triangle's frame
    double extent = 0;
};

TriangleTree::TriangleTree(const Mesh& mesh) : state_(new State{mesh, {}, {}, {}}) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles().size());
    for (std::uint32_t index = 0; index < count; ++index) {
        state_->tree.insert(Primitive(mesh, index));
    }
    // Built now and not at the first query, because queries come from several threads.
    state_->tree.build();
    LeafOrder order;
    state_->tree.traversal(0, order);

    state_->frames.resize(count);
    state_->slots.resize(count);
    for_each_index(count, [&](std::size_t slot) {
        const std::uint32_t index = order.triangles[slot];
        const Triangle& triangle = mesh.triangles()[index];
        state_->slots[index] = static_cast<std::uint32_t>(slot);
        state_->frames[slot] =
            TriangleFrame(mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]], mesh.vertices()[triangle[2]]);
    });
    const Vec3 extent = mesh.box().extent();
    state_->extent = extent[0] + extent[1] + extent[2];
}

TriangleTree::~TriangleTree() = default;

std::optional<Nearest> TriangleTree::nearest(const ExactPosition& query, double bound) const {
    NearestTraversal traversal(state_->frames, state_->slots, query, state_->extent, bound);
    state_->tree.traversal_with_priority(query, traversal);
    return traversal.result();
}

TriangleFrame::Closest TriangleTree::closest_on(std::uint32_t triangle, const ExactPosition& query) const {
    return state_->frames[state_->slots[triangle]].closest(query);
}

double TriangleTree::distance_to(std::uint32_t triangle, const ExactPosition& query) const {
    return closest_on(triangle, query).distance;
}

void TriangleTree::meet_ray(double x, double y, double z, std::vector<std::uint32_t>& triangles) const {
    triangles.clear();
    RayTraversal traversal(triangles);
    state_->tree.traversal(RayQuery{x, y, z}, traversal);
}

const Mesh& TriangleTree::mesh() const {
    return state_->mesh;
}

namespace {

Corners corners_of(const Mesh& mesh, std::uint32_t index) {
    const Triangle& triangle = mesh.triangles()[index];
    return {mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]], mesh.vertices()[triangle[2]]};
}

/// The points of the row that lie on a triangle parallel to the row.
void mark_points_on(const Corners& triangle, std::span<const double> x, double y, double z,
                    std::vector<char>& on_surface) {
    const auto [lower, upper] = std::minmax({triangle[0][0], triangle[1][0], triangle[2][0]});
    const auto first = std::lower_bound(x.begin(), x.end(), lower) - x.begin();
    const auto last = std::upper_bound(x.begin(), x.end(), upper) - x.begin();
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
        if (!on_surface[i] && lies_on(triangle, {x[i], y, z})) {
            on_surface[i] = 1;
        }
    }
}

}  // namespace

std::vector<std::optional<RayCount>> RayCounter::count_along_row(std::span<const double> x, double y, double z) const {
    std::vector<std::optional<RayCount>> counts(x.size());
    if (x.empty()) {
        return counts;
    }
    std::vector<std::uint32_t> candidates;
    tree_.meet_ray(x.front(), y, z, candidates);

    // ends_at[i]: crossings whose last point before the plane is i - 1; summed from the end of the row.
    std::vector<RayCount> ends_at(x.size() + 1);
    std::vector<char> on_surface(x.size(), 0);
    for (const std::uint32_t index : candidates) {
        const Corners triangle = corners_of(tree_.mesh(), index);
        const LineMeeting meeting = meet_line(triangle, y, z);
        if (!meeting.touches) {
            continue;
        }
        if (meeting.facing == 0) {
            mark_points_on(triangle, x, y, z, on_surface);
            continue;
        }
        const auto side = [&](double at) { return side_along_x(triangle, meeting.facing, {at, y, z}); };
        const auto plane = std::partition_point(x.begin(), x.end(), [&](double at) { return side(at) < 0; });
        for (auto at = plane; at != x.end() && side(*at) == 0; ++at) {
            on_surface[static_cast<std::size_t>(at - x.begin())] = 1;
        }
        if (meeting.crossing != 0) {
            RayCount& end = ends_at[static_cast<std::size_t>(plane - x.begin())];
            end.winding += meeting.crossing;
            end.crossings += 1;
        }
    }
    RayCount count;
    for (std::size_t i = x.size(); i-- > 0;) {
        count.winding += ends_at[i + 1].winding;
        count.crossings += ends_at[i + 1].crossings;
        if (!on_surface[i]) {
            counts[i] = count;
        }
    }
    return counts;
}

}  // namespace clsdf::reference
