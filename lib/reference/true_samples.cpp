#include "true_samples.hpp"

#include <clsdf/reference.hpp>
#include <clsdf/topology.hpp>

#include "core/refuse.hpp"
#include "surface/topology.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace clsdf::reference {

namespace {

/// The mesh of another surface that decides the sign; null if it is the mesh.
std::unique_ptr<const Mesh> mesh_of(const SignSurface& surface, const Mesh& mesh) {
    if (surface.open_loops.floor) {
        const Mesh closed = close_down(mesh, *surface.open_loops.floor);
        const SignSurface joined = describe_mesh(closed).surface;
        auto result = mesh_of(joined, closed);
        return result ? std::move(result) : std::make_unique<const Mesh>(closed);
    }
    if (surface.is_mesh()) return nullptr;
    std::vector<Triangle> triangles;
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
        triangles.push_back(surface.triangle(mesh.triangles()[face], face));
    return std::make_unique<const Mesh>(mesh.vertices(), std::move(triangles), mesh.name());
}

SignSurface surface_of(SignSurface described, SignRule sign, std::optional<double> floor) {
    if (sign == SignRule::none) return {};
    if (sign == SignRule::below) {
        if (!floor) refuse("the field has the sign rule below, and its floor is not known; give its z (--floor)");
        described.open_loops.floor = floor;
    }
    return described;
}

/// A field has the rule in use, and the rule `automatic` may have left sheets out for it.
DescribedMesh described_for(const Mesh& mesh, SignRule sign) {
    DescribedMesh described = describe_mesh(mesh);
    const bool has_sheets = described.topology.sheet_faces > 0;
    if (has_sheets && resolve_sign_rule(SignRule::automatic, described.topology).rule == sign) return described;
    return describe_mesh(mesh, sign);
}

}  // namespace

TrueSamples::TrueSamples(const Mesh& mesh, const Grid& grid, SignRule sign, std::optional<double> floor, double reach)
    : TrueSamples(mesh, grid, sign, floor, described_for(mesh, sign), reach) {}

TrueSamples::TrueSamples(const Mesh& mesh, const Grid& grid, SignRule sign, std::optional<double> floor,
                         DescribedMesh described, double reach)
    : grid_(grid),
      sign_(
          resolve_sign_rule(described.topology.sheet_faces > 0 ? SignRule::automatic : sign, described.topology).rule),
      surface_(surface_of(std::move(described.surface), sign_, floor)),
      reach_(reach),
      tree_(mesh),
      sign_mesh_(mesh_of(surface_, mesh)),
      sign_tree_(sign_mesh_ ? std::make_unique<const TriangleTree>(*sign_mesh_) : nullptr),
      rays_(sign_tree_ ? *sign_tree_ : tree_) {
    grid_.validate();
    if (sign_ != SignRule::solid_angle) return;
    const OpenLoops& loops = surface_.open_loops;
    for (std::size_t loop = 0; loop + 1 < loops.begins.size(); ++loop)
        for (std::size_t i = loops.begins[loop]; i < loops.begins[loop + 1]; ++i) {
            const std::size_t next = i + 1 < loops.begins[loop + 1] ? i + 1 : loops.begins[loop];
            open_edges_.push_back({mesh.vertices()[loops.vertices[i]], mesh.vertices()[loops.vertices[next]]});
        }
}

void TrueSamples::measure(const ExactPosition& position, double bound, TrueSample& sample) const {
    std::optional<Nearest> nearest = tree_.nearest(position, bound);
    if (!nearest && bound < reach_) {
        nearest = tree_.nearest(position, reach_);  // the hint was less than the rounding of a far distance
    }
    sample.distance = nearest ? nearest->distance : std::numeric_limits<double>::infinity();
    sample.triangle = nearest ? nearest->triangle : no_triangle;
    if (nearest) {
        sample.site = nearest->site;
        sample.point = nearest->point;
    }
    sample.rounding = 2 * position.rounding();
}

void TrueSamples::take_sign(const std::optional<RayCount>& count, TrueSample& sample) const {
    sample.on_surface = !count;
    sample.inside = count && (sign_ == SignRule::parity ? count->crossings % 2 != 0 : count->winding != 0);
}

namespace {

/// The sum of the solid angles of all faces over that of a sphere (A. van Oosterom and J. Strackee, 1983).
double winding_by_faces(const Mesh& mesh, const Vec3& point) {
    struct Seen {
        Eigen::Vector3d offset;
        double length;
    };
    thread_local std::vector<Seen> seen;
    seen.resize(mesh.vertices().size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        seen[i].offset = Eigen::Vector3d(mesh.vertices()[i].data()) - Eigen::Vector3d(point.data());
        seen[i].length = seen[i].offset.norm();
    }
    // Most angles are small: eight together, as a product of complex numbers, take one arc tangent.
    constexpr double small = 0.1;
    constexpr int together = 8;
    double sum = 0;
    std::complex<double> product = 1;
    int count = 0;
    for (const auto& [a, b, c] : mesh.triangles()) {
        const auto& [x, lx] = seen[a];
        const auto& [y, ly] = seen[b];
        const auto& [z, lz] = seen[c];
        const double volume = x.dot(y.cross(z));
        const double rest = lx * ly * lz + x.dot(y) * lz + y.dot(z) * lx + z.dot(x) * ly;
        if (std::abs(volume) < small * rest) {
            const double tangent = volume / rest;
            product = {product.real() - product.imag() * tangent, product.imag() + product.real() * tangent};
            if (++count < together) continue;
            sum += std::arg(product);
            product = 1;
            count = 0;
        } else if (volume != 0 || rest != 0) {
            sum += std::atan2(volume, rest);
        }
    }
    return (sum + std::arg(product)) / (2 * std::numbers::pi);
}

}  // namespace

void TrueSamples::take_sign(const Vec3& point, TrueSample& sample) const {
    const Mesh& mesh = sign_mesh_ ? *sign_mesh_ : tree_.mesh();
    const double winding = winding_by_faces(mesh, point);
    // docs/accuracy.md: 1e-8, or more beside an open edge; and the rounding of the sum.
    double doubt = 1e-8 + 1e-15 * static_cast<double>(mesh.triangles().size());
    for (const auto& [from, to] : open_edges_) {
        const double length = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        const double distance = nearest_on_triangle(point, from, to, to).distance;
        doubt = std::max(doubt, 1e-15 * length / distance);
    }
    sample.on_surface = sample.distance == 0;
    sample.inside = std::abs(winding) >= 0.5;
    sample.in_doubt = std::abs(std::abs(winding) - 0.5) < doubt;
}

TrueSample TrueSamples::at(const ExactPosition& position) const {
    TrueSample sample;
    measure(position, reach_, sample);
    if (!open_edges_.empty()) {
        take_sign(position.head, sample);
    } else if (is_signed()) {
        const Vec3& point = position.head;
        take_sign(rays_.count_along_row({point.data(), 1}, point[1], point[2]).front(), sample);
    }
    if (surface_.open_loops.floor) doubt_near_walls(position, sample);
    return sample;
}

void TrueSamples::row(std::int64_t j, std::int64_t k, std::vector<TrueSample>& samples) const {
    samples.assign(static_cast<std::size_t>(grid_.size[0]), {});
    std::vector<double> x(samples.size());
    ExactPosition position;
    // The distance cannot change by more than the step from one sample to the next.
    double bound = reach_;
    const double step = 1.001 * grid_.spacing[0];
    for (std::size_t i = 0; i < samples.size(); ++i) {
        position = exact_position(grid_, {static_cast<std::int64_t>(i), j, k});
        x[i] = position.head[0];
        measure(position, bound, samples[i]);
        bound = std::min(reach_, samples[i].distance + step + 2 * samples[i].rounding);
    }
    if (!open_edges_.empty()) {
        for (std::size_t i = 0; i < samples.size(); ++i)
            take_sign(exact_position(grid_, {static_cast<std::int64_t>(i), j, k}).head, samples[i]);
    } else if (is_signed()) {
        const auto counts = rays_.count_along_row(x, position.head[1], position.head[2]);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            take_sign(counts[i], samples[i]);
            if (surface_.open_loops.floor)
                doubt_near_walls(exact_position(grid_, {static_cast<std::int64_t>(i), j, k}), samples[i]);
        }
    }
}

void TrueSamples::doubt_near_walls(const ExactPosition& position, TrueSample& sample) const {
    // docs/accuracy.md: 1e-6 voxel.
    sample.in_doubt = sign_tree_->nearest(position, std::max(1e-6 * grid_.voxel(), sample.rounding)).has_value();
    // A sample on a wall or the floor has a distance, too.
    sample.on_surface = sample.on_surface && sample.distance == 0;
}

namespace {

using Eigen::Vector3d;

/// std::mt19937_64 is the same everywhere; the standard's distributions are not.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

    std::int64_t index(std::int64_t count) {
        return std::min(count - 1, static_cast<std::int64_t>(uniform() * static_cast<double>(count)));
    }

    Vector3d direction() {
        for (;;) {
            const Vector3d v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
            const double squared = v.squaredNorm();
            if (squared > 1e-6 && squared <= 1) {
                return v / std::sqrt(squared);
            }
        }
    }

private:
    std::mt19937_64 engine_;
};

class Chooser {
public:
    Chooser(const TrueSamples& truth, const Field& field, std::uint64_t seed)
        : truth_(truth), tree_(truth.tree()), grid_(field.grid), band_(field.band), random_(seed) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            origin_[axis] = grid_.origin[a] + static_cast<double>(grid_.first[a]) * grid_.spacing[a];
            spacing_[axis] = grid_.spacing[a];
            extent_[axis] = static_cast<double>(grid_.size[a] - 1) * grid_.spacing[a];
        }
    }

    Index3 uniform() {
        return {random_.index(grid_.size[0]), random_.index(grid_.size[1]), random_.index(grid_.size[2])};
    }

    /// A point moved along the line through its nearest point until its distance is about a half width. If it is on the
    /// wrong side, it passes through the surface.
    std::optional<Index3> near_limit() {
        const bool inside = truth_.is_signed() && random_.uniform() < 0.5;
        const double limit = half_width(band_, truth_.is_signed(), inside);
        if (!std::isfinite(limit)) {
            return near_corner(true);
        }
        const Index3 start = uniform();
        double side = truth_.at(start).inside == inside ? 1 : -1;
        Vector3d point = position(start);
        for (int step = 0; step < 4; ++step) {
            const std::optional<Nearest> nearest = tree_.nearest({{point[0], point[1], point[2]}, {}});
            if (!nearest || nearest->distance == 0) {
                break;
            }
            const Vector3d foot(nearest->point.data());
            point = foot + side * (limit / nearest->distance) * (point - foot);
            side = 1;
        }
        return sample_at(point + random_.uniform(-1.5, 1.5) * grid_.voxel() * random_.direction());
    }

    /// A point at a random distance, from a hundredth of a voxel to the band's width, from an edge or a vertex.
    std::optional<Index3> near_corner(bool at_vertex) {
        const auto count = static_cast<std::int64_t>(tree_.mesh().triangles().size());
        const Triangle& triangle = tree_.mesh().triangles()[static_cast<std::size_t>(random_.index(count))];
        const auto corner = static_cast<std::size_t>(random_.index(3));
        const Vector3d from(tree_.mesh().vertices()[triangle[corner]].data());
        const Vector3d to(tree_.mesh().vertices()[triangle[(corner + 1) % 3]].data());
        const Vector3d foot = at_vertex ? from : Vector3d(from + random_.uniform() * (to - from));
        const double nearest = 0.01 * grid_.voxel();
        const double farthest = std::max(nearest, std::min(band_.widest(), extent_.norm()));
        const double distance = nearest * std::pow(farthest / nearest, random_.uniform());
        return sample_at(foot + distance * random_.direction());
    }

private:
    Vector3d position(const Index3& sample) const {
        return origin_ +
               Vector3d(static_cast<double>(sample[0]), static_cast<double>(sample[1]), static_cast<double>(sample[2]))
                   .cwiseProduct(spacing_);
    }

    std::optional<Index3> sample_at(const Vector3d& point) const {
        Index3 sample{};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double steps = std::round((point[axis] - origin_[axis]) / spacing_[axis]);
            if (!(steps >= 0 && steps < static_cast<double>(grid_.size[a]))) {
                return std::nullopt;
            }
            sample[a] = static_cast<std::int64_t>(steps);
        }
        return sample;
    }

    const TrueSamples& truth_;
    const TriangleTree& tree_;
    const Grid& grid_;
    Band band_;
    Random random_;
    Vector3d origin_, spacing_, extent_;
};

}  // namespace

std::vector<Index3> choose_samples(const TrueSamples& truth, const Field& field, std::size_t count,
                                   std::uint64_t seed) {
    Chooser chooser(truth, field, seed);
    std::vector<Index3> samples;
    samples.reserve(count);
    while (samples.size() < count / 2) {
        samples.push_back(chooser.uniform());
    }
    // A grid may contain little of the mesh: points outside it are drawn again a few times.
    constexpr int tries = 8;
    while (samples.size() < count) {
        const std::size_t kind = samples.size() % 3;
        std::optional<Index3> sample;
        for (int i = 0; i < tries && !sample; ++i) {
            sample = kind == 0 ? chooser.near_limit() : chooser.near_corner(kind == 1);
        }
        samples.push_back(sample ? *sample : chooser.uniform());
    }
    return samples;
}

}  // namespace clsdf::reference
