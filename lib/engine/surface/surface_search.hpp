#pragma once

#include "surface/edge_counts.hpp"
#include "surface/sign_surface.hpp"

#include <cstddef>
#include <cstdint>
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
    /// Turns around the faces that look otherwise than most of their part.
    void orient_parts(const std::vector<DoubledFace>& doubled);

    bool is_balanced() const { return edges_.unbalanced.empty(); }
    bool is_closed() const { return edges_.open() == 0; }
    std::size_t joined() const { return joined_; }
    std::size_t reoriented() const { return reoriented_; }
    std::size_t uncounted() const;
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const EdgeCounts& edges() const { return edges_; }
    SignSurface take_surface() { return std::move(surface_); }

private:
    /// Adds the parts of another surface whose rims are open edges, if the surface is closed then. Returns their faces.
    std::vector<std::uint32_t> close_with(const std::vector<Triangle>& other);
    bool is_open(std::uint32_t a, std::uint32_t b) const;
    void turn(std::uint32_t face) { std::swap(triangles_[face][1], triangles_[face][2]); }
    void drop(std::uint32_t face) { triangles_[face][1] = triangles_[face][2] = triangles_[face][0]; }
    void count() { edges_ = count_edges(triangles_, mesh_.vertices().size()); }

    const Mesh& mesh_;
    std::vector<Triangle> triangles_;  // the surface so far; those that do not count have one vertex
    EdgeCounts edges_;                 // the surface's edges
    SignSurface surface_;
    std::size_t joined_ = 0;
    std::size_t reoriented_ = 0;
};

}  // namespace clsdf
