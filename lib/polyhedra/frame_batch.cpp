#include "polyhedra/frame_batch.hpp"

#include "core/several_targets.hpp"
#include "polyhedra/lanes.hpp"
#include "polyhedra/one_rings.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::polyhedra {

namespace {

/// Triangles by their base, lane by lane, and what their frames consist of.
struct Batch {
    LaneVectors base;       // edges, each from its first end
    LaneVectors to_apex;    // from the base's end
    LaneVectors from_apex;  // to the base's start
    LaneVectors apex;       // from the nearer end of the base
    Lanes squared_base;

    LaneVectors along;
    LaneVectors across;
    LaneVectors normal;
    LaneVectors inward_right;
    LaneVectors inward_left;
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

/// triangle_frame() in triangle_frame.cpp, operation by operation, without its special cases.
CLSDF_SEVERAL_TARGETS void compute(Batch& t) {
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
        const double first = dot_of_lane(t.apex, t.along, i);
        double x = t.apex.x[i] - first * t.along.x[i];
        double y = t.apex.y[i] - first * t.along.y[i];
        double z = t.apex.z[i] - first * t.along.z[i];
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
}

}  // namespace

void triangle_frames(const Mesh& mesh, std::span<const Triangle> triangles, const LatticeView& lattice,
                     std::span<TriangleFrame> frames) {
    constexpr double plain = 1e-4;  // of a triangle's altitude to its base, far from all special cases
    constexpr double short_side = 1e-50;
    constexpr double long_side = 1e50;
    Batch batch;
    std::array<Vec3, lanes> near_ends;
    std::array<std::uint32_t, lanes> nearer_halves;
    const InUnits in_units(lattice.unit);
    std::array<std::uint32_t, lanes> bases;
    for (std::size_t begin = 0; begin < triangles.size(); begin += lanes) {
        const std::size_t count = std::min(lanes, triangles.size() - begin);
        for (std::size_t i = 0; i < lanes; ++i) {
            const Triangle& triangle = triangles[begin + std::min(i, count - 1)];
            const std::array<Vec3, 3> corners{mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]],
                                              mesh.vertices()[triangle[2]]};
            const TriangleEdges edges(corners, in_units);
            bases[i] = edges.base;
            nearer_halves[i] = edges.nearer_half();
            near_ends[i] = corners[edges.near_end()];
            batch.base.set(i, edges.vectors[edges.base]);
            batch.to_apex.set(i, edges.vectors[next_of_three(edges.base)]);
            batch.from_apex.set(i, edges.vectors[previous_of_three(edges.base)]);
            batch.apex.set(i, edges.apex());
            batch.squared_base[i] = edges.squared[edges.base];
        }
        compute(batch);
        for (std::size_t i = 0; i < count; ++i) {
            TriangleFrame& frame = frames[begin + i];
            const double length = batch.length[i];
            if (!(batch.height[i] > plain * length) || !(length > short_side) || !(length < long_side)) {
                const auto& [a, b, c] = triangles[begin + i];
                frame = triangle_frame({mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]}, lattice);
                continue;
            }
            frame.normal = batch.normal.get(i);
            frame.inwards[bases[i]] = batch.across.get(i);
            frame.inwards[next_of_three(bases[i])] = batch.inward_right.get(i);
            frame.inwards[previous_of_three(bases[i])] = batch.inward_left.get(i);
            frame.altitude = batch.altitude[i];
            frame.turn = batch.turn[i];
            frame.base_edge = bases[i];
            frame.is_box = false;
            frame.along = batch.along.get(i);
            frame.base = {batch.right[i], batch.left[i]};
            frame.normal_along = {batch.along_right[i], batch.along_left[i]};
            frame.normal_across = {batch.across_right[i], batch.across_left[i]};
            frame.foot = foot_of(frame, near_ends[i], nearer_halves[i], lattice, in_units);
        }
    }
}

}  // namespace clsdf::polyhedra
