#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::engine {

/// Where the vertices of a mesh are, and what messages and lattices need beside. The mesh must outlive it.
struct PlacedVertices {
    std::span<const Vec3> positions;
    const Box& box;
    const std::string& name;

    PlacedVertices(std::span<const Vec3> positions_in, const Box& box_in, const std::string& name_in)
        : positions(positions_in), box(box_in), name(name_in) {}
    // NOLINTNEXTLINE(google-explicit-constructor): a part of what a mesh is
    PlacedVertices(const Mesh& mesh) : PlacedVertices(mesh.vertices(), mesh.box(), mesh.name()) {}
};

/// The vertices of the caller's mesh as a transform has them: those of equal coordinates count as one. Edges between
/// vertices that are equal but not one would be open ones: exact, but slow.
class Vertices {
public:
    /// All of so many vertices.
    explicit Vertices(std::size_t count = 0) : count_(count) {}
    /// Of so many vertices, with the numbers that numbers_here() has given; empty if they are the same.
    Vertices(std::size_t count, std::vector<std::uint32_t> numbers_here)
        : count_(count), welded_(std::move(numbers_here)) {}
    /// Merges vertices that are equal, and drops those that no triangle uses. `first`: first_equal_vertices() of the
    /// mesh.
    Vertices(Mesh& mesh, const std::vector<std::uint32_t>& first);

    /// Of the caller's.
    std::size_t count() const { return count_; }
    /// Whether some count as one, and the mesh has other numbers than the caller.
    bool are_merged() const { return !welded_.empty(); }
    const std::vector<std::uint32_t>& numbers_here() const { return welded_; }

    /// The number of each of the caller's vertices here, whether a triangle uses it or not. `first`: as above; empty if
    /// they are the same.
    static std::vector<std::uint32_t> numbers(const std::vector<std::uint32_t>& first);

    /// The caller's number of a vertex: the first of those that are equal.
    std::size_t callers_number(std::uint32_t vertex) const;
    /// The same of the first `count` vertices, ascending.
    std::vector<std::uint32_t> callers_numbers(std::size_t count) const;

    /// New positions of the transform's mesh from those of the caller's. Throws Error(invalid_argument) if their number
    /// is another one, or if vertices that count as one move apart.
    std::vector<Vec3> moved(const Mesh& mesh, std::span<const Vec3> positions) const;

    /// New positions R x + t from the first ones, x, of the transform's mesh; see DistanceTransform::set_motion().
    /// Throws Error(invalid_argument) if R is no rotation.
    static std::vector<Vec3> moved(std::span<const Vec3> first, const std::array<Vec3, 3>& rotation,
                                   const Vec3& translation);

private:
    std::size_t count_;                  // of the caller's mesh
    std::vector<std::uint32_t> welded_;  // of each of them its index here, or no_vertex; empty if they are the same

    static constexpr std::uint32_t no_vertex = 0xFFFFFFFFU;
};

}  // namespace clsdf::engine
