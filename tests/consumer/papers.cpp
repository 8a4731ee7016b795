#include <clsdf/clsdf.hpp>
#include <clsdf/papers.hpp>

#include <cmath>
#include <iostream>

// A cube's field by Mauch's polyhedra, slice by slice, is that by ours, by bricks; and its edges are counted.
int main() try {
    const clsdf::Mesh cube = clsdf::make_shape("cube");
    if (classify(cube).count(clsdf::EdgeKind::convex) != 12) return 2;

    const clsdf::Band band = clsdf::Band::symmetric(0.2);
    const clsdf::Grid grid = clsdf::Grid::around(cube, 20, band);
    clsdf::TransformOptions options;
    options.method = clsdf::papers_method({.polyhedra = clsdf::Polyhedra::mauch});
    const clsdf::Device device = clsdf::Device::best();
    clsdf::TransformStatistics statistics;
    const clsdf::Field slices =
        clsdf::DistanceTransform(device, cube, options)(grid, band, {}, {.statistics = &statistics});
    const clsdf::Field bricks = clsdf::DistanceTransform(device, cube)(grid, band);
    for (std::size_t i = 0; i < bricks.distance.size(); ++i)
        if (!(std::abs(slices.distance[i] - bricks.distance[i]) <= 1e-5 * grid.voxel())) return 3;
    return statistics.method_counts.at("active_pieces").value > 0 ? 0 : 4;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
