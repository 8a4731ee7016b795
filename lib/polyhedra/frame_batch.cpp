#include "polyhedra/frame_batch.hpp"

#include "core/several_targets.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/vector.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::polyhedra {

namespace {

/// Triangles, lane by lane, and what their frames consist of.
struct Batch {
    std::array<LaneVectors, 3> corners;  // as given

    std::array<LaneVectors, 3> edges;  // in units; edge k runs from corner k to the next
    Lanes base_edge;                   // 0 to 2, as are all indices here
    Lanes squared_base;
    LaneVectors base;
    LaneVectors to_apex;    // the edge from the base's end
    LaneVectors from_apex;  // the edge to the base's start
    LaneVectors near_end;   // of the base, to the apex; as given
    Lanes nearer_side;      // 1 for the right half, -1 for the left one

    LaneVectors along;
    LaneVectors across;
    LaneVectors normal;
    LaneVectors inward_right;
    LaneVectors inward_left;
    LaneVectors foot;
    Lanes length;
    Lanes height;
    Lanes right;
    Lanes left;
    Lanes along_right;
    Lanes along_left;
    Lanes across_right;
    Lanes across_left;
    Lanes altitude;
    Lanes turn;
};

/// Programs may trap a division by zero, also in lanes that triangle_frame() computes once more.
inline double divisor(double x) {
    return x > 0 ? x : 1;
}

inline void subtract(const LaneVectors& to, const LaneVectors& from, double per_unit, LaneVectors& difference) {
    for (std::size_t i = 0; i < lanes; ++i) {
        difference.x[i] = per_unit * (to.x[i] - from.x[i]);
        difference.y[i] = per_unit * (to.y[i] - from.y[i]);
        difference.z[i] = per_unit * (to.z[i] - from.z[i]);
    }
}

/// The one of three that `index` names.
inline void choose(const LaneVectors& a, const LaneVectors& b, const LaneVectors& c, const Lanes& index,
                   LaneVectors& chosen) {
    for (std::size_t i = 0; i < lanes; ++i) {
        chosen.x[i] = index[i] == 0 ? a.x[i] : index[i] == 1 ? b.x[i] : c.x[i];
        chosen.y[i] = index[i] == 0 ? a.y[i] : index[i] == 1 ? b.y[i] : c.y[i];
        chosen.z[i] = index[i] == 0 ? a.z[i] : index[i] == 1 ? b.z[i] : c.z[i];
    }
}

/// TriangleEdges, operation by operation.
CLSDF_SEVERAL_TARGETS void set_edges(Batch& t, double per_unit) {
    const auto& [a, b, c] = t.corners;
    subtract(b, a, per_unit, t.edges[0]);
    subtract(c, b, per_unit, t.edges[1]);
    subtract(a, c, per_unit, t.edges[2]);
    Lanes near_corner;
    for (std::size_t i = 0; i < lanes; ++i) {
        const double first = dot_of_lane(t.edges[0], t.edges[0], i);
        const double second = dot_of_lane(t.edges[1], t.edges[1], i);
        const double third = dot_of_lane(t.edges[2], t.edges[2], i);
        const bool is_second = !(first >= second);
        const double longer = is_second ? second : first;
        const double next = is_second ? third : second;
        const double previous = is_second ? first : third;
        const bool is_third = third > longer;
        const bool is_right = (is_third ? first : next) <= (is_third ? second : previous);
        const double longer_edge = is_second ? 1 : 0;
        const double base = is_third ? 2 : longer_edge;
        t.base_edge[i] = base;
        t.squared_base[i] = is_third ? third : longer;
        t.nearer_side[i] = is_right ? 1 : -1;
        const double end = is_third ? 0 : base + 1;
        near_corner[i] = is_right ? end : base;
    }
    choose(t.edges[0], t.edges[1], t.edges[2], t.base_edge, t.base);
    choose(t.edges[1], t.edges[2], t.edges[0], t.base_edge, t.to_apex);
    choose(t.edges[2], t.edges[0], t.edges[1], t.base_edge, t.from_apex);
    choose(a, b, c, near_corner, t.near_end);
}

/// triangle_frame() in triangle_frame.cpp, operation by operation, without its special cases.
CLSDF_SEVERAL_TARGETS void compute(Batch& t, const Vec3& origin, double per_unit) {
    for (std::size_t i = 0; i < lanes; ++i) {
        const double length = std::sqrt(t.squared_base[i]);
        const double by_length = divisor(length);
        t.length[i] = length;
        t.along.x[i] = t.base.x[i] / by_length;
        t.along.y[i] = t.base.y[i] / by_length;
        t.along.z[i] = t.base.z[i] / by_length;
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        const double right = -dot_of_lane(t.to_apex, t.along, i);
        const double left = -dot_of_lane(t.from_apex, t.along, i);
        t.right[i] = 0.0 < right ? right : 0.0;
        t.left[i] = 0.0 < left ? left : 0.0;
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        const bool is_right = t.nearer_side[i] > 0;
        double x = is_right ? t.to_apex.x[i] : -t.from_apex.x[i];
        double y = is_right ? t.to_apex.y[i] : -t.from_apex.y[i];
        double z = is_right ? t.to_apex.z[i] : -t.from_apex.z[i];
        const double first = dot(x, y, z, t.along.x[i], t.along.y[i], t.along.z[i]);
        x -= first * t.along.x[i];
        y -= first * t.along.y[i];
        z -= first * t.along.z[i];
        const double second = dot(x, y, z, t.along.x[i], t.along.y[i], t.along.z[i]);
        x -= second * t.along.x[i];
        y -= second * t.along.y[i];
        z -= second * t.along.z[i];
        const double height = std::sqrt(dot(x, y, z, x, y, z));
        const double by_height = divisor(height);
        t.height[i] = height;
        x /= by_height;
        y /= by_height;
        z /= by_height;
        const double third = dot(x, y, z, t.along.x[i], t.along.y[i], t.along.z[i]);
        x -= third * t.along.x[i];
        y -= third * t.along.y[i];
        z -= third * t.along.z[i];
        const double norm = divisor(std::sqrt(dot(x, y, z, x, y, z)));
        t.across.x[i] = x / norm;
        t.across.y[i] = y / norm;
        t.across.z[i] = z / norm;
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        t.normal.x[i] = t.along.y[i] * t.across.z[i] - t.along.z[i] * t.across.y[i];
        t.normal.y[i] = t.along.z[i] * t.across.x[i] - t.along.x[i] * t.across.z[i];
        t.normal.z[i] = t.along.x[i] * t.across.y[i] - t.along.y[i] * t.across.x[i];
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        const double squared_height = t.height[i] * t.height[i];
        const double right = divisor(std::sqrt(t.right[i] * t.right[i] + squared_height));
        const double left = divisor(std::sqrt(t.left[i] * t.left[i] + squared_height));
        t.along_right[i] = t.height[i] / right;
        t.along_left[i] = t.height[i] / left;
        t.across_right[i] = t.right[i] / right;
        t.across_left[i] = t.left[i] / left;
        t.altitude[i] = right * t.along_right[i];
        t.turn[i] = frame_roundings * (t.right[i] + t.left[i]) / divisor(t.altitude[i]);
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        t.inward_right.x[i] = -t.along_right[i] * t.along.x[i] - t.across_right[i] * t.across.x[i];
        t.inward_right.y[i] = -t.along_right[i] * t.along.y[i] - t.across_right[i] * t.across.y[i];
        t.inward_right.z[i] = -t.along_right[i] * t.along.z[i] - t.across_right[i] * t.across.z[i];
        t.inward_left.x[i] = t.along_left[i] * t.along.x[i] - t.across_left[i] * t.across.x[i];
        t.inward_left.y[i] = t.along_left[i] * t.along.y[i] - t.across_left[i] * t.across.y[i];
        t.inward_left.z[i] = t.along_left[i] * t.along.z[i] - t.across_left[i] * t.across.z[i];
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        const double to_foot = t.nearer_side[i] * (t.nearer_side[i] > 0 ? t.right[i] : t.left[i]);
        t.foot.x[i] = per_unit * (t.near_end.x[i] - origin[0]) - to_foot * t.along.x[i];
        t.foot.y[i] = per_unit * (t.near_end.y[i] - origin[1]) - to_foot * t.along.y[i];
        t.foot.z[i] = per_unit * (t.near_end.z[i] - origin[2]) - to_foot * t.along.z[i];
    }
}

/// Whether a frame is one of triangle_frame()'s special cases, or nearly. Where the reciprocal of the unit is infinite
/// all are, because no length is finite.
bool is_special(const Batch& t, std::size_t i) {
    constexpr double plain = 1e-4;  // of a triangle's altitude to its base
    constexpr double short_side = 1e-50;
    constexpr double long_side = 1e50;
    return !(t.height[i] > plain * t.length[i]) || !(t.length[i] > short_side) || !(t.length[i] < long_side);
}

void get(const Batch& t, std::size_t i, TriangleFrame& frame) {
    const auto base = static_cast<std::uint32_t>(t.base_edge[i]);
    frame.normal = t.normal.get(i);
    frame.inwards[base] = t.across.get(i);
    frame.inwards[next_of_three(base)] = t.inward_right.get(i);
    frame.inwards[previous_of_three(base)] = t.inward_left.get(i);
    frame.altitude = t.altitude[i];
    frame.turn = t.turn[i];
    frame.base_edge = base;
    frame.is_box = false;
    frame.along = t.along.get(i);
    frame.foot = t.foot.get(i);
    frame.base = {t.right[i], t.left[i]};
    frame.normal_along = {t.along_right[i], t.along_left[i]};
    frame.normal_across = {t.across_right[i], t.across_left[i]};
}

}  // namespace

void triangle_frames(std::span<const Vec3> positions, std::span<const Triangle> triangles, const LatticeView& lattice,
                     std::span<TriangleFrame> frames) {
    const double per_unit = 1 / lattice.unit;
    Batch batch{};
    for (std::size_t begin = 0; begin < triangles.size(); begin += lanes) {
        const std::size_t count = std::min(lanes, triangles.size() - begin);
        for (std::size_t i = 0; i < lanes; ++i) {
            const Triangle& triangle = triangles[begin + std::min(i, count - 1)];
            for (std::size_t k = 0; k < 3; ++k) batch.corners[k].set(i, positions[triangle[k]]);
        }
        set_edges(batch, per_unit);
        compute(batch, lattice.origin, per_unit);
        for (std::size_t i = 0; i < count; ++i) {
            if (is_special(batch, i)) {
                const auto& [a, b, c] = triangles[begin + i];
                frames[begin + i] = triangle_frame({positions[a], positions[b], positions[c]}, lattice);
            } else {
                get(batch, i, frames[begin + i]);
            }
        }
    }
}

}  // namespace clsdf::polyhedra
