#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "frusta/cluster_index.hpp"
#include "frusta/prepared_mesh.hpp"
#include "lists/surface_points.hpp"
#include "mesh/box_index.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace clsdf::engine {

/// The regions of a restricted transform, and the values that it needs of the whole mesh.
class Restriction {
public:
    explicit Restriction(std::vector<Region> regions_in);

    std::vector<Region> regions;
    std::size_t record_count = 0;        ///< that a lattice keeps at most
    std::vector<std::uint32_t> numbers;  ///< of the part's triangles, in the whole mesh
    SurfaceSample sample;                ///< of the whole mesh

    std::size_t host_bytes() const;

    /// Boxes that hold a point of each triangle that decides distances, and signs, of samples of any lattice in the
    /// regions; without `rows` if there is no sign. joined: how far those that decide the sign may lie from the mesh's.
    struct NearBoxes {
        std::vector<Box> boxes, rows;
    };
    NearBoxes near_boxes(SignRule sign, double joined) const;
    /// The triangles that decide distances, and signs, of samples of any lattice in the regions; at least one. Sets
    /// record_count. joined: as above.
    NearRecords near(const ClusterIndex& index, SignRule sign, double joined);
    /// Those that decide distances of samples of a lattice.
    NearRecords near_bricks(const ClusterIndex& index, const Vec3& origin, const Vec3& spacing) const;

    /// Each throws Error(invalid_argument) if the part of the mesh does not suffice for the field, points or boxes.
    /// what: of the grid, for messages.
    void check(const Grid& grid, const Band& band, SignRule sign, const char* what = "the grid's samples") const;
    /// first: the number of the first of these points, for messages.
    void check(std::span<const Vec3> points, double half_width, std::size_t first = 0) const;
    void check(std::span<const Box> boxes, double half_width) const;

    /// Whether a region with such lengths holds the box. slack: of its limits.
    bool holds(const Box& box, double half_width, double spacing, double slack) const;
    /// Throws Error(invalid_argument). what: a clause that says what is asked for.
    [[noreturn]] void refuse(const std::string& what, const Box& box) const;

private:
    BoxIndex index_;  // of the regions
};

}  // namespace clsdf::engine
