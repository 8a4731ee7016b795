#pragma once

#include "coverage.hpp"
#include "support/random_meshes.hpp"

#include <algorithm>

/// Points where polyhedra are most likely to miss something: around vertices, edges and faces, in the normal cones of
/// vertices, and on samples of the lattice.
namespace clsdf::test {

class StressPoints {
public:
    StressPoints(const Mesh& mesh, const CoverageTest& test, double half_width, Random& random)
        : mesh_(mesh), test_(test), half_width_(half_width), random_(random) {}

    /// In samples.
    Vec3 next() {
        const std::uint32_t index = random_.index(test_.triangles().size());
        const auto& corners = test_.triangles()[index].corners();
        Eigen::Vector3d direction = vector(random_.direction());
        Eigen::Vector3d from;
        switch (random_.index(4)) {
            case 0:
                from = inside(corners);
                if (random_.index(2) == 0) direction = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                break;
            case 1:
                from = on_edge(corners);
                break;
            default: {
                const std::uint32_t corner = random_.index(3);
                from = corners[corner];
                direction = in_normal_cone(mesh_.triangles()[index][corner], direction);
            }
        }
        const double length = direction.norm();
        const double distance =
            half_width_ * (random_.index(2) == 0 ? random_.uniform(0, 1) : std::pow(10, random_.uniform(-4, 0)));
        const double side = random_.index(2) == 0 ? 1 : -1;
        Vec3 point = test_.to_samples(length > 0 ? from + side * distance / length * direction : from);
        if (random_.index(4) == 0)
            for (double& coordinate : point) coordinate = std::round(coordinate);
        return point;
    }

private:
    static Eigen::Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

    Eigen::Vector3d inside(const std::array<Eigen::Vector3d, 3>& corners) {
        const double a = random_.uniform(0, 1);
        const double b = random_.uniform(0, 1 - a);
        return a * corners[0] + b * corners[1] + (1 - a - b) * corners[2];
    }

    Eigen::Vector3d on_edge(const std::array<Eigen::Vector3d, 3>& corners) {
        const std::uint32_t edge = random_.index(3);
        const double t = random_.uniform(0, 1);
        return t * corners[edge] + (1 - t) * corners[(edge + 1) % 3];
    }

    /// Pushes a direction into the normal cone of a vertex, if it has one: out of the half-spaces of its neighbours in
    /// turn.
    Eigen::Vector3d in_normal_cone(std::uint32_t vertex, Eigen::Vector3d direction) {
        std::vector<Eigen::Vector3d> neighbours;
        const Vec3& at = mesh_.vertices()[vertex];
        for (const Triangle& triangle : mesh_.triangles()) {
            if (std::find(triangle.begin(), triangle.end(), vertex) == triangle.end()) continue;
            for (const std::uint32_t other : triangle) {
                const Eigen::Vector3d edge = vector(mesh_.vertices()[other]) - vector(at);
                if (edge.norm() > 0) neighbours.push_back(edge.normalized());
            }
        }
        for (int round = 0; round < 12; ++round)
            for (const Eigen::Vector3d& neighbour : neighbours)
                if (const double excess = direction.dot(neighbour); excess > 0) direction -= 1.001 * excess * neighbour;
        return direction;
    }

    const Mesh& mesh_;
    const CoverageTest& test_;
    double half_width_;
    Random& random_;
};

}  // namespace clsdf::test
