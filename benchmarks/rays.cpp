#include "benchmarks/rays.hpp"

#include "benchmarks/cost.hpp"
#include "benchmarks/method.hpp"

#include "core/parallel.hpp"

#include <CGAL/Gmpq.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <utility>

namespace clsdf::bench {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Rays {
    std::vector<Vec3> origins, directions;
};

/// Random rays about a mesh.
class RayMaker {
public:
    RayMaker(const Mesh& mesh, std::uint64_t seed) : mesh_(mesh), random_(seed) {}

    Rays between_points(std::size_t count) {
        Rays rays;
        for (std::size_t i = 0; i < count; ++i) add(rays, in_box(), in_box());
        return rays;
    }

    /// Along z, from below, as the pixels of an image.
    Rays parallel(std::size_t count) {
        Rays rays;
        const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(count)));
        const Box& box = mesh_.box();
        for (std::size_t i = 0; i < side * side; ++i) {
            const std::array<std::size_t, 2> pixel{i % side, i / side};
            Vec3 origin{0, 0, box.lower[2] - side_};
            for (std::size_t axis = 0; axis < 2; ++axis)
                origin[axis] = box.lower[axis] + (box.upper[axis] - box.lower[axis]) *
                                                     (static_cast<double>(pixel[axis]) + 0.5) /
                                                     static_cast<double>(side);
            rays.origins.push_back(origin);
            rays.directions.push_back({0, 0, 1});
        }
        return rays;
    }

    /// From afar to vertices and to the middles of edges.
    Rays to_edges(std::size_t count) {
        Rays rays;
        for (std::size_t i = 0; i < count; ++i) {
            const Triangle& triangle = mesh_.triangles()[random_() % mesh_.triangles().size()];
            const Vec3 &a = mesh_.vertices()[triangle[0]], &b = mesh_.vertices()[triangle[1]];
            Vec3 to = a;
            if (i % 2 == 0)
                for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = (a[axis] + b[axis]) / 2;
            Vec3 from = in_box();
            for (std::size_t axis = 0; axis < 3; ++axis) from[axis] += 2 * (from[axis] - to[axis]);
            add(rays, from, to);
        }
        return rays;
    }

private:
    static void add(Rays& rays, const Vec3& from, const Vec3& to) {
        rays.origins.push_back(from);
        rays.directions.push_back({to[0] - from[0], to[1] - from[1], to[2] - from[2]});
    }

    Vec3 in_box() {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = mesh_.box().lower[axis] - 0.1 * side_, high = mesh_.box().upper[axis] + 0.1 * side_;
            p[axis] = low + part_(random_) * (high - low);
        }
        return p;
    }

    const Mesh& mesh_;
    double side_ = mesh_.box().longest_side();
    std::mt19937_64 random_;
    std::uniform_real_distribution<double> part_{0, 1};
};

/// Finds first faces in rational arithmetic, among all triangles that doubles cannot leave out.
class Judge {
public:
    Judge(const Mesh& mesh, const MeasureOptions& options) : mesh_(mesh), options_(options) {}

    void look_at(std::span<const Vec3> origins, std::span<const Vec3> directions, std::span<const double> t,
                 RayCost& cost) const {
        // A ray takes some milliseconds.
        const std::size_t most = std::clamp<std::size_t>(options_.samples_judged, 1, 500);
        const std::size_t step = std::max<std::size_t>(1, origins.size() / most);
        const std::size_t count = (origins.size() + step - 1) / step;
        std::vector<double> expected(count);
        for_each_index(
            count, [&](std::size_t i) { expected[i] = first_face(origins[i * step], directions[i * step]); }, 1);
        for (std::size_t i = 0; i < count; ++i) {
            const double found = t[i * step];
            const Vec3& d = directions[i * step];
            const double voxels = std::hypot(d[0], d[1], d[2]) / mesh_.box().longest_side() * 256;
            const double error =
                std::isinf(expected[i]) && std::isinf(found) ? 0 : std::abs(found - expected[i]) * voxels;
            ++cost.judged;
            if (error <= 1e-3)
                cost.max_error_voxels = std::max(cost.max_error_voxels, error);
            else
                ++cost.wrong;
        }
    }

private:
    using Exact = CGAL::Gmpq;
    using ExactVector = std::array<Exact, 3>;

    static ExactVector exact(const Vec3& v) { return {Exact(v[0]), Exact(v[1]), Exact(v[2])}; }
    static ExactVector minus(const ExactVector& a, const ExactVector& b) {
        return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    }
    static ExactVector cross(const ExactVector& a, const ExactVector& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
    static Exact dot(const ExactVector& a, const ExactVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

    double first_face(const Vec3& origin, const Vec3& direction) const {
        std::optional<Exact> first;
        for (const Triangle& triangle : mesh_.triangles()) {
            std::array<Vec3, 3> corners{};
            for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh_.vertices()[triangle[k]];
            if (is_surely_missed(corners, origin, direction)) continue;
            const ExactVector a = exact(corners[0]), o = exact(origin), d = exact(direction);
            const ExactVector normal = cross(minus(exact(corners[1]), a), minus(exact(corners[2]), a));
            const Exact approach = dot(normal, d);
            if (approach == 0) continue;
            const Exact t = dot(normal, minus(a, o)) / approach;
            if (t < 0 || (first && *first <= t)) continue;
            const ExactVector meets{o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]};
            bool is_within = true;
            for (std::size_t k = 0; k < 3; ++k) {
                const ExactVector from = exact(corners[k]);
                is_within =
                    is_within && dot(normal, cross(minus(exact(corners[(k + 1) % 3]), from), minus(meets, from))) >= 0;
            }
            if (is_within) first = t;
        }
        return first ? CGAL::to_double(*first) : infinity;
    }

    /// All corners lie farther from the line than the longest edge.
    static bool is_surely_missed(const std::array<Vec3, 3>& corners, const Vec3& origin, const Vec3& direction) {
        double edges = 0, nearest = infinity;
        const double length = std::hypot(direction[0], direction[1], direction[2]);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &a = corners[k], &b = corners[(k + 1) % 3];
            edges = std::max(edges, std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
            const Vec3 p{a[0] - origin[0], a[1] - origin[1], a[2] - origin[2]};
            nearest = std::min(nearest, std::hypot(p[1] * direction[2] - p[2] * direction[1],
                                                   p[2] * direction[0] - p[0] * direction[2],
                                                   p[0] * direction[1] - p[1] * direction[0]) /
                                            length);
        }
        return nearest > 1.01 * edges + 1e-6 * length;
    }

    const Mesh& mesh_;
    const MeasureOptions& options_;
};

/// Measures clsdf, and Embree if it is built in.
class Measurements {
public:
    Measurements(const Mesh& mesh, const Device& device, const MeasureOptions& options)
        : options_(options), judge_(mesh, options), embree_(embree_rays(mesh)), transform_(device, mesh) {}

    void add_first(RayCost cost, const Rays& rays) {
        std::vector<std::uint32_t> triangles(rays.origins.size());
        t_.resize(rays.origins.size());
        measure(cost, rays, true, [&] {
            transform_.rays(rays.origins, rays.directions, {.hits = Hits::faces}, {.t = t_, .triangles = triangles});
        });
        if (!embree_) return;
        cost.method = "Embree, robust";
        measure(cost, rays, true, [&] { embree_(rays.origins, rays.directions, t_); });
    }

    /// What only clsdf is asked for, and is not judged here.
    void add(const RayCost& cost, const Rays& rays, const RayOptions& options, const RayTargets& targets) {
        measure(cost, rays, false, [&] { transform_.rays(rays.origins, rays.directions, options, targets); });
    }

    bool has_walls() const { return transform_.sign() != SignRule::none && transform_.sign() != SignRule::solid_angle; }

    std::vector<RayCost> take() { return std::move(costs_); }

private:
    void measure(RayCost cost, const Rays& rays, bool is_judged, const auto& ask) {
        cost.rays = rays.origins.size();
        std::vector<double> seconds, processor;
        for (std::size_t n = 0; n < options_.repetitions + 1; ++n) {
            if (options_.progress) options_.progress(cost.name);
            std::ranges::fill(t_, std::numeric_limits<double>::quiet_NaN());
            const CostWatch watch;
            ask();
            const Cost of_call = watch.cost();
            if (n == 0) continue;  // warms up
            seconds.push_back(of_call.wall);
            processor.push_back(of_call.processor);
        }
        cost.seconds = spread_of(seconds);
        cost.processor_seconds = spread_of(processor);
        if (is_judged) judge_.look_at(rays.origins, rays.directions, t_, cost);
        costs_.push_back(std::move(cost));
    }

    const MeasureOptions& options_;
    Judge judge_;
    RayPeer embree_;
    DistanceTransform transform_;
    std::vector<double> t_;
    std::vector<RayCost> costs_;
};

}  // namespace

std::vector<RayCost> measure_rays(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                  bool is_quick) {
    RayMaker maker(mesh, options.seed);
    const std::size_t million = is_quick ? 10000 : 1000000;
    Measurements measurements(mesh, device, options);
    const Rays random = maker.between_points(million);
    measurements.add_first({"random", "between points of the mesh's box and 10% around it, the first face"}, random);
    measurements.add_first({"parallel", "along z, the pixels of an image, the first face"}, maker.parallel(million));
    measurements.add_first({"edges", "from afar to vertices and middles of edges, the first face"},
                           maker.to_edges(million));
    std::vector<double> t(million);
    std::vector<std::uint32_t> counts(million);
    std::vector<std::uint8_t> any(million);
    if (measurements.has_walls())
        measurements.add({"random walls", "the same as random, the first wall"}, random, {}, {.t = t});
    measurements.add({"random counts", "the same, the number of all faces"}, random, {.hits = Hits::faces},
                     {.counts = counts});
    measurements.add({"random any", "the same, whether there is any face"}, random, {.hits = Hits::faces},
                     {.any = any});
    return measurements.take();
}

void judge_first_faces(const Mesh& mesh, std::span<const Vec3> origins, std::span<const Vec3> directions,
                       std::span<const double> t, const MeasureOptions& options, RayCost& cost) {
    Judge(mesh, options).look_at(origins, directions, t, cost);
}

}  // namespace clsdf::bench
