#include <clsdf/clsdf.hpp>
#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <cmath>
#include <iostream>

// A cube's field by Mauch's polyhedra, slice by slice, is that by ours, by bricks; and its edges are counted.
int main() try {
    const clsdf::Mesh cube({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}},
                           {{0, 2, 3},
                            {0, 3, 1},
                            {4, 5, 7},
                            {4, 7, 6},
                            {0, 1, 5},
                            {0, 5, 4},
                            {2, 6, 7},
                            {2, 7, 3},
                            {0, 4, 6},
                            {0, 6, 2},
                            {1, 3, 7},
                            {1, 7, 5}});
    if (clsdf::classify_convexity(cube).count(clsdf::EdgeKind::convex) != 12) return 2;

    const clsdf::Band band = clsdf::Band::symmetric(0.2);
    const clsdf::Grid grid = clsdf::Grid::around(cube, 20, band);
    const clsdf::Device device = clsdf::Device::automatic();
    clsdf::TransformStatistics statistics;
    const clsdf::DistanceTransform by_slices = make_transform(device, cube, {.polyhedra = clsdf::Polyhedra::mauch});
    const clsdf::Field slices = by_slices.compute(grid, band, {}, {}, &statistics);
    const clsdf::Field bricks = clsdf::DistanceTransform(device, cube).compute(grid, band);
    for (std::size_t i = 0; i < bricks.distance().size(); ++i)
        if (!(std::abs(slices.distance()[i] - bricks.distance()[i]) <= 1e-5 * grid.voxel())) return 3;
    for (const clsdf::MethodCount& count : statistics.work->method_counts)
        if (count.name == "active_pieces" && count.value > 0) return 0;
    return 4;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
