#include "benchmarks/links.hpp"

#include "benchmarks/cost.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace clsdf::bench {

namespace {

/// Measures the links of a mesh on a grid.
class LinkMeasurements {
public:
    LinkMeasurements(const Mesh& mesh, const Device& device, const MeasureOptions& options, const Grid& grid)
        : mesh_(mesh), device_(device), options_(options), grid_(grid) {}

    void add_first(RayCost cost) {
        // A transform that has prepared nothing, with programs that are compiled.
        measure(
            std::move(cost), [&] { transform_.emplace(device_, mesh_); }, [&] { return find({}); }, true);
    }
    void add_again(RayCost cost) {
        measure(
            std::move(cost), [] {}, [&] { return find({}); }, true);
    }
    void add_faces(RayCost cost) {
        measure(
            std::move(cost), [] {}, [&] { return find({.hits = Hits::faces}); }, false);
    }
    void add_count(RayCost cost) {
        std::size_t count = 0;
        measure(
            std::move(cost), [] {},
            [&] {
                count = transform_->count_links(grid_, directions_);
                return count;
            },
            false);
        // Counted from the sides of the samples: each of these links has a row, and there is no other.
        costs_.back().judged = 1;
        costs_.back().wrong = count == find({}) ? 0 : 1;
    }
    std::size_t count() const { return DistanceTransform(device_, mesh_).count_links(grid_, directions_); }

    std::vector<RayCost> take() { return std::move(costs_); }

private:
    std::size_t find(const LinkOptions& options) {
        links_ = transform_->links(grid_, directions_, options);
        return links_.size();
    }

    void measure(RayCost cost, const auto& prepare, const auto& ask, bool is_judged) {
        std::vector<double> seconds, processor;
        for (std::size_t n = 0; n < options_.repetitions + 1; ++n) {
            if (options_.progress) options_.progress(cost.name);
            prepare();
            const CostWatch watch;
            cost.rays = ask();
            const Cost of_call = watch.cost();
            if (n == 0) continue;  // warms up
            seconds.push_back(of_call.wall);
            processor.push_back(of_call.processor);
        }
        cost.seconds = spread_of(seconds);
        cost.processor_seconds = spread_of(processor);
        if (is_judged) judge(cost);
        costs_.push_back(std::move(cost));
    }

    /// From outside the first wall of a mesh whose parts do not overlap is the first face.
    void judge(RayCost& cost) const {
        std::vector<Vec3> from, along;
        for (std::size_t n = 0; n < links_.size(); ++n) {
            const auto& [x, y, z] = links_.samples[n];
            const LinkDirection& c = directions_[links_.directions[n]];
            // position() counts from Grid::first.
            const Index3 at{x - grid_.first[0], y - grid_.first[1], z - grid_.first[2]};
            from.push_back(grid_.position(at[0], at[1], at[2]));
            const Vec3 to = grid_.position(at[0] + c[0], at[1] + c[1], at[2] + c[2]);
            along.push_back({to[0] - from.back()[0], to[1] - from.back()[1], to[2] - from.back()[2]});
        }
        judge_first_faces(mesh_, from, along, links_.q, options_, cost);
    }

    const Mesh& mesh_;
    const Device& device_;
    const MeasureOptions& options_;
    Grid grid_;
    std::vector<LinkDirection> directions_ = stencil("D3Q19");
    std::optional<DistanceTransform> transform_;
    Links links_;
    std::vector<RayCost> costs_;
};

Mesh scaled(const Mesh& mesh, double factor, double middle) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& v : vertices)
        for (double& x : v) x = middle + factor * x;
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

Mesh cube_between(double low, double high) {
    std::vector<Vec3> vertices;
    for (const double z : {low, high})
        for (const double y : {low, high})
            for (const double x : {low, high}) vertices.push_back({x, y, z});
    return {std::move(vertices),
            {{0, 3, 1},
             {0, 2, 3},
             {4, 5, 7},
             {4, 7, 6},
             {0, 1, 5},
             {0, 5, 4},
             {2, 7, 3},
             {2, 6, 7},
             {0, 6, 2},
             {0, 4, 6},
             {1, 3, 7},
             {1, 7, 5}},
            "cube on planes"};
}

std::vector<RayCost> first_and_again(const Mesh& mesh, const std::string& what, const Device& device,
                                     const MeasureOptions& options, const Grid& grid) {
    LinkMeasurements measurements(mesh, device, options, grid);
    measurements.add_first({mesh.name() + ", first", what + ", with a transform that has prepared nothing"});
    measurements.add_again({mesh.name() + ", again", "the same call again"});
    return measurements.take();
}

}  // namespace

std::vector<RayCost> measure_links(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                   std::int64_t resolution) {
    const Grid grid = Grid::around(mesh.box(), {.resolution = resolution});
    LinkMeasurements measurements(mesh, device, options, grid);
    measurements.add_first(
        {"first", fmt::format("D3Q19 on {} samples on the longest side, with a transform that has prepared nothing",
                              resolution)});
    measurements.add_again({"again", "the same call again"});
    measurements.add_count({"count", "their number alone"});
    measurements.add_faces({"faces", "links that meet faces as given"});
    return measurements.take();
}

std::vector<RayCost> measure_links_of_ties(const Device& device, const MeasureOptions& options,
                                           std::int64_t resolution) {
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {resolution, resolution, resolution}, {}};
    const auto gap = static_cast<double>(resolution / 8);
    const Mesh cube = cube_between(gap, static_cast<double>(resolution) - gap);
    // Links are as many as the surface has area: the radius follows from those of a first ball.
    const double middle = static_cast<double>(resolution) / 2 - 0.3;
    double radius = static_cast<double>(resolution) / 3;
    const Mesh unit = make_shape("sphere6");
    const auto count = [&](const Mesh& mesh) {
        return static_cast<double>(LinkMeasurements(mesh, device, options, grid).count());
    };
    radius *= std::sqrt(count(cube) / count(scaled(unit, radius, middle)));
    const Mesh sphere = scaled(unit, radius, middle);
    const Mesh ball(sphere.vertices(), sphere.triangles(), "ball");
    std::vector<RayCost> costs = first_and_again(
        ball, fmt::format("a ball on {} samples a side, as many links as the cube", resolution), device, options, grid);
    const std::array<double, 2> of_ball{costs[0].seconds.median, costs[1].seconds.median};
    std::vector<RayCost> of_cube =
        first_and_again(cube, "a cube with faces on planes of the lattice", device, options, grid);
    for (std::size_t n = 0; n < 2; ++n) {
        of_cube[n].limit = 3 * of_ball[n];
        costs.push_back(std::move(of_cube[n]));
    }
    return costs;
}

}  // namespace clsdf::bench
