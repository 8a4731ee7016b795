// From arrays in memory to a signed distance field, and a use of it.
//
// A simulation has a solid as arrays of vertices and triangles. It needs to know which of its cells are solid, the
// solid share of a cell on the surface, and the triangle of the wall that is nearest to a fluid particle.

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <vector>

namespace {

/// The simulation's own arrays: x0 y0 z0 x1 ..., and three indices a triangle, counter-clockwise seen from outside.
struct Solid {
    std::vector<double> vertices;
    std::vector<std::uint32_t> triangles;
};

Solid torus(double ring_radius, double tube_radius, std::uint32_t around, std::uint32_t across) {
    Solid solid;
    for (std::uint32_t i = 0; i < around; ++i) {
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double radius = ring_radius + tube_radius * std::cos(v);
            solid.vertices.insert(solid.vertices.end(),
                                  {radius * std::cos(u), radius * std::sin(u), tube_radius * std::sin(v)});
            const auto vertex = [&](std::uint32_t a, std::uint32_t b) { return a % around * across + b % across; };
            solid.triangles.insert(solid.triangles.end(), {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1),  //
                                                           vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    }
    return solid;
}

/// The exact volume, by the divergence theorem.
double volume_of(const Solid& solid) {
    double six_volumes = 0;
    for (std::size_t t = 0; t < solid.triangles.size(); t += 3) {
        const double* a = &solid.vertices[3 * solid.triangles[t]];
        const double* b = &solid.vertices[3 * solid.triangles[t + 1]];
        const double* c = &solid.vertices[3 * solid.triangles[t + 2]];
        six_volumes += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six_volumes / 6;
}

}  // namespace

int main() {
    try {
        const Solid solid = torus(1.0, 0.4, 120, 48);

        // A view refers to the arrays; a mesh is a checked copy of them. One transform serves many grids.
        const clsdf::MeshView view(solid.vertices, solid.triangles);
        const clsdf::Mesh mesh(view, "torus");
        const clsdf::Device device = clsdf::Device::automatic();
        clsdf::CallOptions call;
        call.log = [](const std::string& message) { std::printf("clsdf says: %s\n", message.c_str()); };
        clsdf::DistanceTransform transform(device, mesh, {}, call);

        // 96 samples on the longest side, and distances up to a tenth of a unit on both sides of the surface.
        const clsdf::Band band = clsdf::Band::symmetric(0.1);
        const clsdf::Grid grid = clsdf::Grid::around(mesh, 96, band);
        const clsdf::Field field = transform.compute(grid, band, clsdf::Output::triangle);
        record(field.distance());
        record(field.triangle());

        // A cell is solid if its centre is inside, in the band or beyond it. The distance gives the solid share of a
        // cell on the surface.
        const double h = grid.voxel();
        double cells = 0, solid_cells = 0;
        for (const float distance : field.distance()) {
            cells += distance < 0 ? 1 : 0;
            solid_cells += std::clamp(0.5 - static_cast<double>(distance) / h, 0.0, 1.0);
        }
        const double exact = volume_of(solid);
        const double by_counting = cells * h * h * h, by_distance = solid_cells * h * h * h;
        std::printf("volume: %.5f by the triangles, %.5f by counting cells, %.5f by the distance\n", exact, by_counting,
                    by_distance);

        // A particle beside the tube's outer rim: its distance to the wall, and the nearest triangle.
        const auto sample = [&](std::size_t axis, double x) { return std::lround((x - grid.origin[axis]) / h); };
        const std::size_t particle = grid.offset(sample(0, 1.45), sample(1, 0), sample(2, 0));
        const std::uint32_t triangle = field.triangle()[particle];
        std::printf("a particle %.5f from the wall, nearest to triangle %u\n",
                    static_cast<double>(field.distance()[particle]), triangle);

        const bool right = std::abs(by_counting - exact) < 0.01 * exact &&
                           std::abs(by_distance - exact) < 0.001 * exact && triangle < mesh.triangles().size();
        std::puts(right ? "as it should be" : "WRONG");
        return right ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
