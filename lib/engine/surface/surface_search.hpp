#pragma once

#include "surface/double_sided.hpp"
#include "surface/edge_counts.hpp"
#include "surface/sheets.hpp"
#include "surface/sign_surface.hpp"
#include "surface/winding_test.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

/// Finds the surface that decides the sign: the rules of docs/sign.md in their order, each only if the surface is not
/// balanced after the one before.
class SurfaceSearch {
public:
    /// `triangles`: of the mesh, with numbers of vertices that are all different.
    SurfaceSearch(const Mesh& mesh, std::span<const Triangle> triangles, EdgeCounts edges);

    /// Joins vertices that differ by rounding, at the ends of unbalanced edges.
    void join_noise();
    /// Faces of the same three vertices count by their net number, at most once. If edges stay open, faces that cancel
    /// each other count once where that closes the surface. The surface stays as it is if more edges would be
    /// unbalanced than before, or if it is closed and that would open it, unless it consists of doubled faces alone.
    void count_doubled_once(const std::vector<DoubledFace>& doubled);
    /// Counts bodies once whose faces cancel each other, so that nothing is inside. may_open: also those with a hole.
    void count_bodies_once(const std::vector<DoubledFace>& doubled, bool may_open);
    /// Turns around the faces that look otherwise than most of their part. A closed surface is balanced then, or stays
    /// as it is. An open one has fewer unbalanced edges then, and its winding number is not in doubt at more points.
    void orient_parts(const std::vector<DoubledFace>& doubled);
    /// Leaves inner walls and sheets of bodies out whose faces meet in edges of three or more: what is inside is what
    /// cannot be reached (roles_by_reach()).
    Sheets leave_out_walls(const std::vector<DoubledFace>& doubled);
    /// Leaves sheets and inner walls out that enclose nothing, if the rest has a sign.
    Sheets leave_out_sheets(const std::vector<DoubledFace>& doubled);

    /// Of an open surface.
    const WindingTest& winding_test();
    /// Looks at it again: parts whose holes lie within others may be clear, too.
    const WindingTest& winding_test_with_covered_parts();

    bool is_balanced() const { return edges_.unbalanced.empty(); }
    bool is_closed() const { return edges_.open() == 0; }
    std::size_t joined() const { return joined_; }
    std::size_t reoriented() const;
    std::size_t uncounted() const;
    std::size_t double_sided() const { return double_sided_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const EdgeCounts& edges() const { return edges_; }
    SignSurface take_surface() { return std::move(surface_); }

private:
    /// The lowest faces of those that cancel each other and do not count; null if there are none.
    const SubSurface* cancelled_faces(const std::vector<DoubledFace>& doubled);
    /// Adds the parts of another surface whose rims are open edges, if the surface is closed then. Returns their faces.
    std::vector<std::uint32_t> close_with(const SubSurface& other);
    bool is_open(std::uint32_t a, std::uint32_t b) const;
    void turn(std::uint32_t face) { std::swap(triangles_[face][1], triangles_[face][2]); }
    void leave_out(std::span<const std::uint32_t> faces);
    /// Lets faces that equal others look as these, if those count.
    void direct_equal_faces(const std::vector<DoubledFace>& doubled);
    /// Notes the faces that were turned, and the directions of those that equal them.
    void take_turned(std::span<const std::uint32_t> faces, const std::vector<DoubledFace>& doubled);
    /// Whether a face shares an edge with faces that cancel each other: then it may be of a body on both sides.
    bool are_beside_cancelled_faces(std::span<const std::uint32_t> faces,
                                    const std::vector<DoubledFace>& doubled) const;
    /// A face that is in the surface, as it was given.
    Triangle given(std::uint32_t face) const;
    void drop(std::uint32_t face) { triangles_[face][1] = triangles_[face][2] = triangles_[face][0]; }
    void count() {
        edges_ = count_edges(triangles_, mesh_->vertices().size());
        test_.reset();
    }

    const Mesh* mesh_;
    std::span<const Triangle> given_;
    std::vector<Triangle> triangles_;  // the surface so far; those that do not count have one vertex
    EdgeCounts edges_;                 // the surface's edges
    SignSurface surface_;
    std::vector<bool> is_turned_;  // by face; empty: none is
    std::vector<bool> is_left_out_;
    std::optional<SubSurface> cancelled_;  // by cancelled_faces()
    std::optional<WindingTest> test_;
    std::size_t joined_ = 0;
    std::size_t double_sided_ = 0;
};

}  // namespace clsdf
