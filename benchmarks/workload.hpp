#pragma once

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf::bench {

/// Samples to be computed by methods that answer point queries, brick by brick of 8 x 8 x 8; within a brick neighbours
/// follow each other, so that the distance of one is a hint for the next.
struct SampleList {
    std::vector<std::uint32_t> samples;  ///< offsets in the field
    std::vector<std::size_t> starts;     ///< of the bricks that have any, and the end

    std::size_t bricks() const { return starts.size() - 1; }
    /// Samples in every stride-th brick.
    std::size_t count(std::size_t stride) const;
};

/// A job, the same for every method.
struct Workload {
    std::string name;       ///< "W1"
    std::string mesh_name;  ///< "bunny00"
    Mesh mesh;
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;
    SampleList list;              ///< the samples within the band
    double largest_distance = 0;  ///< of those samples
};

/// The mean area of a triangle, in faces of a voxel. Its inverse is the number of triangles per voxel of the surface.
double mean_area_voxels(const Workload& workload);

/// A grid around a mesh and a band, as "clsdf compute --cubic" would lay them out.
struct Layout {
    std::string name;
    std::int64_t resolution = 0;
    Length half_width;
};

/// The grid's margin around the mesh's box.
Length margin_of(const Length& half_width);

/// W1: 256 samples on a side, a band of 10%; W2: 512, 3 voxels; W3: 256, every sample; W4: 128, every sample.
const std::vector<Layout>& standard_layouts();

/// The workload with its list, which is taken from a field that `transform` computes. Throws Error(unsupported) if
/// the grid has more samples than 32 bits count.
Workload make_workload(const Layout& layout, const std::string& mesh_name, const Mesh& mesh, const Device& device);

}  // namespace clsdf::bench
