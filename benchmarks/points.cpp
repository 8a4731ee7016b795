#include "benchmarks/points.hpp"

#include "benchmarks/cost.hpp"
#include "benchmarks/meshes.hpp"
#include "benchmarks/method.hpp"

#include "device/context.hpp"

#include <clsdf/reference.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <utility>

namespace clsdf::bench {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// Random points about a mesh.
class PointMaker {
public:
    PointMaker(const Mesh& mesh, std::uint64_t seed) : mesh_(mesh), random_(seed) {
        double area = 0;
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) areas_.push_back(area += triangle_area(mesh, t));
    }

    /// In the box and 10% of its longest side around it.
    std::vector<Vec3> uniform(std::size_t count) {
        std::vector<Vec3> points(count);
        for (Vec3& p : points) p = in_box();
        return points;
    }

    /// A point of the surface, and up to 1.2% of the longest side away from it on each axis.
    std::vector<Vec3> near(std::size_t count) {
        std::vector<Vec3> points(count);
        for (Vec3& p : points) {
            p = on_surface();
            for (double& x : p) x += 0.012 * side_ * (2 * part_(random_) - 1);
        }
        return points;
    }

    /// Rays between two points of the box, 1,000 points along each.
    std::vector<Vec3> along_rays(std::size_t count) {
        constexpr std::size_t of_ray = 1000;
        std::vector<Vec3> points(count);
        Vec3 from{}, to{};
        for (std::size_t i = 0; i < count; ++i) {
            if (i % of_ray == 0) {
                from = in_box();
                to = in_box();
            }
            const double share = static_cast<double>(i % of_ray) / static_cast<double>(of_ray);
            for (std::size_t axis = 0; axis < 3; ++axis) points[i][axis] = from[axis] + share * (to[axis] - from[axis]);
        }
        return points;
    }

private:
    const Vec3& corner(std::size_t triangle, std::size_t k) const {
        return mesh_.vertices()[mesh_.triangles()[triangle][k]];
    }

    Vec3 in_box() {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = mesh_.box().lower[axis] - 0.1 * side_, high = mesh_.box().upper[axis] + 0.1 * side_;
            p[axis] = low + part_(random_) * (high - low);
        }
        return p;
    }

    Vec3 on_surface() {
        const double place = part_(random_) * areas_.back();
        const auto found = std::upper_bound(areas_.begin(), areas_.end() - 1, place);
        const auto triangle = static_cast<std::size_t>(found - areas_.begin());
        double a = part_(random_), b = part_(random_);
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = corner(triangle, 0)[axis] + a * (corner(triangle, 1)[axis] - corner(triangle, 0)[axis]) +
                      b * (corner(triangle, 2)[axis] - corner(triangle, 0)[axis]);
        return p;
    }

    const Mesh& mesh_;
    double side_ = mesh_.box().longest_side();
    std::vector<double> areas_;  ///< of the triangles up to each, summed
    std::mt19937_64 random_;
    std::uniform_real_distribution<double> part_{0, 1};
};

/// Compares results with the reference.
class Judge {
public:
    Judge(const Mesh& mesh, const MeasureOptions& options)
        : oracle_(mesh), voxel_(mesh.box().longest_side() / 256), options_(options) {}

    void look_at(std::span<const Vec3> points, std::span<const float> distance, bool with_sign, PointCost& cost) const {
        const std::size_t most = options_.samples_judged == 0 ? points.size() : options_.samples_judged;
        const std::size_t step = std::max<std::size_t>(1, points.size() / most);
        for (std::size_t i = 0; i < points.size(); i += step) {
            const double expected = oracle_.nearest(points[i]).distance;
            const std::optional<int> winding = oracle_.winding_number(points[i]);
            const bool is_inside = with_sign && winding.value_or(0) != 0;
            const double error = std::abs(std::abs(static_cast<double>(distance[i])) - expected);
            const double ulp = expected * static_cast<double>(std::numeric_limits<float>::epsilon());
            ++cost.judged;
            if (!(error <= std::max(2 * ulp, 1e-5 * voxel_))) ++cost.wrong;
            if (std::signbit(distance[i]) != is_inside) ++cost.wrong_signs;
            cost.max_error_voxels = std::max(cost.max_error_voxels, error / voxel_);
        }
    }

private:
    reference::Oracle oracle_;
    double voxel_;
    const MeasureOptions& options_;
};

/// Measures clsdf, and Embree if it is built in, at one set of points after the other.
class Measurements {
public:
    Measurements(const Mesh& mesh, const Device& device, const MeasureOptions& options, std::size_t most_points)
        : mesh_(mesh),
          device_(device),
          options_(options),
          judge_(mesh, options),
          embree_(embree_points(mesh)),
          distance_(most_points) {
        renew();
    }

    /// By both, in one call.
    void add(PointCost cost, std::span<const Vec3> points) {
        add_ours(cost, points);
        if (!embree_) return;
        cost.method = "Embree";
        cost.limit.reset();
        // It takes many times as long.
        measure(embree_, cost, points, std::min<std::size_t>(options_.repetitions, 3), [] {});
    }

    void add_ours(const PointCost& cost, std::span<const Vec3> points, bool is_new_each_time = false) {
        const auto ask = [&](std::span<const Vec3> part, std::span<float> results) {
            transform_->query(part, no_limit, results);
        };
        measure(ask, cost, points, options_.repetitions, [&] {
            if (is_new_each_time) renew();
        });
    }

    /// From memory of the device to memory of the device: by queries, or by runs of a plan.
    void add_on_device(const PointCost& cost, std::span<const Vec3> points, bool by_plan) {
        const device::Context& context = device::context_of(device_);
        const std::size_t bytes = points.size() * sizeof(float);
        cl::Buffer from, to;
        device::guarded([&] {
            // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): it is read only
            from = cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, points.size_bytes(),
                              const_cast<Vec3*>(points.data()));
            to = cl::Buffer(context.context(), CL_MEM_READ_WRITE, bytes);
        });
        const InputArray positions(from(), ElementType::float64, points.size());
        std::optional<PointPlan> plan;
        if (by_plan) plan = transform_->plan_points(points.size(), no_limit);
        const auto ask = [&](std::span<const Vec3>, std::span<float>) {
            if (!plan) {
                transform_->query(positions, no_limit, to());
                return;
            }
            cl_event done = nullptr;
            plan->enqueue(nullptr, positions, to(), {}, &done);
            device::guarded([&] { cl::Event(done).wait(); });
        };
        const auto fetch = [&] {
            device::guarded([&] { context.queue().enqueueReadBuffer(to, CL_TRUE, 0, bytes, distance_.data()); });
        };
        measure(
            ask, cost, points, options_.repetitions, [] {}, fetch);
    }

    std::vector<PointCost> take() { return std::move(costs_); }

private:
    void renew() {
        transform_.reset();
        transform_.emplace(device_, mesh_);
    }

    /// fetch: brings the results to distance_.
    void measure(
        const auto& query, PointCost cost, std::span<const Vec3> points, std::size_t repetitions, const auto& prepare,
        const std::function<void()>& fetch = [] {}) {
        cost.points = points.size();
        const std::size_t of_call = points.size() / cost.calls;
        std::vector<double> seconds, processor;
        for (std::size_t n = 0; n < repetitions + 1; ++n) {
            if (options_.progress) options_.progress(cost.name);
            std::fill(distance_.begin(), distance_.end(), std::numeric_limits<float>::quiet_NaN());
            prepare();
            const CostWatch watch;
            for (std::size_t begin = 0; begin < points.size(); begin += of_call)
                query(points.subspan(begin, of_call), std::span(distance_).subspan(begin, of_call));
            const Cost of_calls = watch.cost();
            if (n == 0) continue;  // warms up
            seconds.push_back(of_calls.wall);
            processor.push_back(of_calls.processor);
        }
        cost.seconds = spread_of(seconds);
        cost.processor_seconds = spread_of(processor);
        fetch();
        judge_.look_at(points, std::span(distance_).first(points.size()), transform_->sign() != SignRule::none, cost);
        costs_.push_back(std::move(cost));
    }

    const Mesh& mesh_;
    const Device& device_;
    const MeasureOptions& options_;
    Judge judge_;
    PointPeer embree_;
    std::optional<DistanceTransform> transform_;
    std::vector<float> distance_;
    std::vector<PointCost> costs_;
};

}  // namespace

std::vector<PointCost> measure_points(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                      bool is_quick) {
    PointMaker maker(mesh, options.seed);
    const std::size_t million = is_quick ? 20000 : 1000000, thousand = is_quick ? 200 : 1000;
    Measurements measurements(mesh, device, options, million);
    const auto limited = [&](PointCost cost, double limit) {
        if (!is_quick) cost.limit = limit;
        return cost;
    };
    measurements.add(limited({"uniform", "in the mesh's box and 10% of its longest side around it, in one call"}, 4e6),
                     maker.uniform(million));
    measurements.add(
        limited({"near", "within 1.2% of the longest side from the surface on each axis, in one call"}, 5e6),
        maker.near(million));
    measurements.add({"rays", "along rays through the box, 1,000 points each, in one call"}, maker.along_rays(million));
    PointCost many = limited({"calls", "uniform, as many points a call as there are calls"}, 5e5);
    many.calls = thousand;
    measurements.add_ours(many, maker.uniform(million / thousand * thousand));
    measurements.add_ours({"first", "uniform, with a transform that has prepared nothing"}, maker.uniform(thousand),
                          true);
    for (const bool by_plan : {false, true}) {
        const std::string by = by_plan ? ", by a run of a plan" : ", by a query";
        const char* const suffix = by_plan ? " plan" : " device";
        measurements.add_on_device({std::string("uniform") + suffix, "uniform, in memory of the device" + by},
                                   maker.uniform(million), by_plan);
        measurements.add_on_device({std::string("near") + suffix, "near, in memory of the device" + by},
                                   maker.near(million), by_plan);
    }
    return measurements.take();
}

std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
    return PointMaker(mesh, seed).uniform(count);
}

std::vector<PointCost> measure_these_points(const Mesh& mesh, std::span<const Vec3> points, const Device& device,
                                            const MeasureOptions& options) {
    Measurements measurements(mesh, device, options, points.size());
    measurements.add({"file", "the points of a file, in one call"}, points);
    return measurements.take();
}

}  // namespace clsdf::bench
