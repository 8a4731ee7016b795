#include "output_contracts.hpp"

#include "judge.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

// Each output beside the distance: its plain value, PlainOutputs::NAME, and its contract in docs/accuracy.md,
// OutputsOfSample::wrong_NAME. Both follow the table of outputs (clsdf/output_table.h).
namespace clsdf::reference {

namespace {

// In voxels.
constexpr double closest_tolerance = 1e-6;
constexpr double direction_tolerance_voxels = 2e-6;
constexpr double direction_tolerance = 1e-5;
// Nearer than this a sample has no direction of its own.
constexpr double on_surface_voxels = 1e-10;

Eigen::Vector3d vector_of(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

/// From a point to a sample.
Eigen::Vector3d offset_of(const ExactPosition& sample, const Vec3& point) {
    return {(sample.head[0] - point[0]) + sample.tail[0], (sample.head[1] - point[1]) + sample.tail[1],
            (sample.head[2] - point[2]) + sample.tail[2]};
}

/// The rounding error of a sum of coordinates of this size.
double rounding_of(const ExactPosition& sample, const Vec3& point) {
    return 4 * std::numeric_limits<double>::epsilon() *
           std::max(vector_of(sample.head).cwiseAbs().maxCoeff(), vector_of(point).cwiseAbs().maxCoeff());
}

/// A site, its point closest to a sample, and the distance to the plane, the line or the point that contains the site.
struct ClosestOfSite {
    Vec3 point{};
    double distance = 0;
    double to_extension = 0;
};

ClosestOfSite closest_of(const ExactPosition& sample, const SiteCorners& site) {
    const auto& [a, b, c] = site.positions;
    if (site.count == 1) {
        const double distance = offset_of(sample, a).norm();
        return {a, distance, distance};
    }
    const TriangleFrame::Closest closest = TriangleFrame(a, b, site.count == 2 ? b : c).closest(sample);
    const Eigen::Vector3d along = vector_of(b) - vector_of(a), from = offset_of(sample, a);
    if (site.count == 2) {
        const double length = along.norm();
        const Eigen::Vector3d direction = length > 0 ? Eigen::Vector3d(along / length) : Eigen::Vector3d::Zero();
        return {closest.point, closest.distance, (from - from.dot(direction) * direction).norm()};
    }
    const Eigen::Vector3d normal = along.cross(vector_of(c) - vector_of(a)).stableNormalized();
    return {closest.point, closest.distance, std::fabs(normal.dot(from))};
}

template <typename Values>
Vec3 vector_at(const Values& values, std::size_t sample) {
    return {static_cast<double>(values[3 * sample]), static_cast<double>(values[3 * sample + 1]),
            static_cast<double>(values[3 * sample + 2])};
}

/// Whether a sample has the value beyond the band.
template <typename Values>
bool is_left(const Values& values, std::size_t sample, std::size_t sample_count) {
    const std::size_t components = values.size() / sample_count;
    using Value = typename Values::value_type;
    for (std::size_t c = 0; c < components; ++c) {
        const Value value = values[sample * components + c];
        if constexpr (std::is_floating_point_v<Value>) {
            if (!std::isnan(value)) return false;
        } else {
            if (value != std::numeric_limits<Value>::max()) return false;
        }
    }
    return true;
}

/// The plain values of a sample of the band.
struct PlainOutputs : OutputSources {
    std::uint32_t triangle() const { return truth.triangle; }
    std::uint8_t site() const { return static_cast<std::uint8_t>(truth.site); }
    Vec3 closest() const { return truth.point; }
    Vec3 gradient() const;
    std::array<double, 2> barycentric() const;
    Vec3 offset() const;
    std::uint32_t body() const { return 0; }
};

/// On the surface it is the pseudonormal; NaN if all faces there have no area.
Vec3 PlainOutputs::gradient() const {
    Vec3 gradient{};
    if (truth.distance > 0) {
        gradient = offset();
        const double length = std::hypot(gradient[0], gradient[1], gradient[2]);
        for (double& component : gradient) component *= (truth.inside ? 1 : -1) / length;
        return gradient;
    }
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    gradient = sites.pseudonormal(truth.triangle, truth.site).value_or(Vec3{none, none, none});
    if (truths.is_signed() && sites.is_inside_out())
        for (double& component : gradient) component = -component;
    return gradient;
}

Vec3 PlainOutputs::offset() const {
    const Eigen::Vector3d from = offset_of(truths.position(index), truth.point);
    return {-from[0], -from[1], -from[2]};
}

/// By the areas that the closest point spans with two vertices.
std::array<double, 2> PlainOutputs::barycentric() const {
    const auto number = static_cast<std::size_t>(truth.site);
    std::array<double, 3> weights{};
    if (number < 3) {
        weights[number] = 1;
        return {weights[1], weights[2]};
    }
    using Wide = Eigen::Matrix<long double, 3, 1>;
    std::array<Wide, 3> to_corners;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 corner = sites.corners(truth.triangle, Site::face).positions[k];
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            to_corners[k][axis] = static_cast<long double>(corner[a]) - static_cast<long double>(truth.point[a]);
        }
    }
    if (number < 6) {
        const std::size_t from = number - 3, to = (number - 2) % 3;
        const Wide along = to_corners[to] - to_corners[from];
        const long double way = along.squaredNorm() > 0 ? -to_corners[from].dot(along) / along.squaredNorm() : 0;
        weights[to] = static_cast<double>(way);
        weights[from] = static_cast<double>(1 - way);
        return {weights[1], weights[2]};
    }
    const Wide normal = (to_corners[1] - to_corners[0]).cross(to_corners[2] - to_corners[0]);
    for (std::size_t k = 0; k < 3; ++k)
        weights[k] = static_cast<double>(to_corners[(k + 1) % 3].cross(to_corners[(k + 2) % 3]).dot(normal) /
                                         normal.squaredNorm());
    return {weights[1], weights[2]};
}

template <typename Value>
void store(std::span<Value> values, std::size_t sample, Value value) {
    values[sample] = value;
}
template <typename Value, std::size_t components>
void store(std::span<Value> values, std::size_t sample, const std::array<double, components>& vector) {
    for (std::size_t c = 0; c < components; ++c) values[components * sample + c] = static_cast<Value>(vector[c]);
}

}  // namespace

void store_outputs(const OutputSources& sources, Field& field, std::size_t offset) {
    const PlainOutputs plain{sources};
#define CLSDF_STORE(name, description, element, components, number) store(field.name(), offset, plain.name());
    CLSDF_OUTPUTS(CLSDF_STORE)
#undef CLSDF_STORE
}

namespace {

/// The outputs of a field at a sample. Each function returns the fault of an output, or nothing.
struct OutputsOfSample {
    const TrueSamples& truths;
    const Field& field;
    const MeshSites* sites;  ///< if sites or gradients are judged
    const Index3& index;
    const TrueSample& truth;
    std::size_t at;  ///< the sample's place in the field's arrays
    double voxel;
    double tolerance;  ///< of the distance
    std::uint32_t body;

    std::string wrong_triangle() const;
    std::string wrong_site() const;
    std::string wrong_closest() const;
    std::string wrong_gradient() const;
    std::string wrong_barycentric() const;
    std::string wrong_offset() const;
    std::string wrong_body() const;

private:
    /// Of a point that is to be the closest one. allowed: its distance from the surface.
    std::string wrong_point(const ExactPosition& point, double allowed) const;
    std::string wrong_gradient_on_surface(const Vec3& gradient) const;
    /// The triangle that the field names, if it does and the mesh has it.
    std::optional<std::uint32_t> named_triangle() const;
};

std::optional<std::uint32_t> OutputsOfSample::named_triangle() const {
    if (field.triangle().empty()) return std::nullopt;
    const std::uint32_t triangle = field.triangle()[at];
    if (triangle >= truths.tree().mesh().triangles().size()) return std::nullopt;
    return triangle;
}

std::string OutputsOfSample::wrong_triangle() const {
    const std::uint32_t found = field.triangle()[at];
    if (found == no_triangle) return "in the band, but no triangle named";
    if (!named_triangle()) return fmt::format("triangle {} is not in the mesh", found);
    const double distance = truths.distance_to(found, index);
    if (distance - truth.distance <= tolerance) return {};
    return fmt::format("triangle {} is {} away, triangle {} is nearer", found, distance, truth.triangle);
}

std::string OutputsOfSample::wrong_body() const {
    const std::uint32_t found = field.body()[at];
    return found == body ? std::string() : fmt::format("body {} is named instead of {}", found, body);
}

std::string OutputsOfSample::wrong_site() const {
    const std::uint8_t number = field.site()[at];
    if (number > 6) return number == no_site ? "in the band, but no site named" : fmt::format("{} is no site", number);
    const std::optional<std::uint32_t> triangle = named_triangle();
    if (!triangle) return {};
    const auto site = static_cast<Site>(number);
    const ClosestOfSite closest = closest_of(truths.position(index), sites->corners(*triangle, site));
    const double allowed = tolerance;
    if (!(closest.distance <= truth.distance + allowed) || !(closest.to_extension >= truth.distance - allowed))
        return fmt::format("site {} of triangle {} is not nearest: it is {} away, and its line or plane {}", number,
                           *triangle, closest.distance, closest.to_extension);
    const auto [lowest, its_site] = sites->lowest(*triangle, site);
    if (lowest == *triangle && its_site == site) return {};
    return fmt::format("site {} of triangle {} is site {} of triangle {}, which is to be named", number, *triangle,
                       static_cast<int>(its_site), lowest);
}

std::string OutputsOfSample::wrong_closest() const {
    const Vec3 point = vector_at(field.closest(), at);
    const ExactPosition position = truths.position(index);
    const double distance = offset_of(position, point).norm();
    const double rounding = rounding_of(position, point);
    if (!(std::fabs(distance - truth.distance) <= tolerance + rounding))
        return fmt::format("the closest point is {} away", distance);
    return wrong_point({point, {}}, closest_tolerance * voxel + rounding);
}

std::string OutputsOfSample::wrong_point(const ExactPosition& point, double allowed) const {
    const std::optional<std::uint32_t> triangle = named_triangle();
    const double from_surface =
        triangle ? truths.tree().distance_to(*triangle, point) : truths.tree().nearest(point)->distance;
    if (from_surface <= allowed) return {};
    return fmt::format("the closest point is {} off {}", from_surface,
                       triangle ? fmt::format("triangle {}", *triangle) : "the surface");
}

std::string OutputsOfSample::wrong_offset() const {
    const Vec3 to_point = vector_at(field.offset(), at);
    const double length = vector_of(to_point).norm();
    const double rounding = static_cast<double>(std::numeric_limits<float>::epsilon()) * truth.distance;
    if (!(std::fabs(length - truth.distance) <= tolerance + rounding))
        return fmt::format("the offset's length is {}", length);
    const ExactPosition position = truths.position(index);
    ExactPosition point = position;
    for (std::size_t axis = 0; axis < 3; ++axis) point.tail[axis] += to_point[axis];
    return wrong_point(point, closest_tolerance * voxel + rounding + rounding_of(position, position.head));
}

std::string OutputsOfSample::wrong_gradient_on_surface(const Vec3& gradient) const {
    // The faces that count depend on the site.
    const std::optional<std::uint32_t> triangle = named_triangle();
    if (!triangle || field.site().empty() || field.site()[at] > 6) return {};
    const std::optional<Vec3> normal = sites->pseudonormal(*triangle, static_cast<Site>(field.site()[at]));
    if (!normal) return {};
    const bool is_turned = truths.is_signed() && sites->is_inside_out();
    const Eigen::Vector3d expected = (is_turned ? -1.0 : 1.0) * vector_of(*normal);
    const double error = (vector_of(gradient) - expected).norm();
    if (error <= direction_tolerance) return {};
    return fmt::format("on the surface, and the gradient ({}, {}, {}) is off the pseudonormal by {}", gradient[0],
                       gradient[1], gradient[2], error);
}

std::string OutputsOfSample::wrong_gradient() const {
    const Vec3 gradient = vector_at(field.gradient(), at);
    const double distance = truth.distance;
    // Its pseudonormal counts there.
    const bool on_surface = distance <= on_surface_voxels * voxel;
    const double length = vector_of(gradient).norm();
    if (!(std::fabs(length - 1) <= 1e-5)) {
        // Faces without area have no pseudonormal.
        if (std::isnan(length) && on_surface) {
            const auto triangle = named_triangle();
            if (triangle && !field.site().empty() && field.site()[at] <= 6 &&
                !sites->pseudonormal(*triangle, static_cast<Site>(field.site()[at])))
                return {};
        }
        return fmt::format("the gradient's length is {}", length);
    }
    if (on_surface) return wrong_gradient_on_surface(gradient);
    const double allowed = direction_tolerance + direction_tolerance_voxels * voxel / distance;
    if (allowed >= 2) return {};
    // If no triangle is named, the nearest triangle in the direction of the gradient: any of several equally near ones
    // is right.
    const ExactPosition position = truths.position(index);
    // Where the sign is in doubt, the gradient must fit to the one found.
    const bool is_inside = truth.in_doubt ? std::signbit(field.distance()[at]) : truth.inside;
    const double side = is_inside ? -1.0 : 1.0;
    const Eigen::Vector3d to_surface = -side * vector_of(gradient);
    Vec3 there{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        there[axis] = position.head[axis] + distance * to_surface[static_cast<Eigen::Index>(axis)];
    const std::optional<std::uint32_t> named = named_triangle();
    const std::uint32_t triangle = named ? *named : truths.tree().nearest({there, {}})->triangle;
    // Beside the border of two sites both are nearest, within the accuracy of the distance.
    const bool has_site = named && !field.site().empty() && field.site()[at] <= 6;
    const int first = has_site ? field.site()[at] : 0, last = has_site ? first : 6;
    double least = std::numeric_limits<double>::infinity();
    for (int site = first; site <= last; ++site) {
        const ClosestOfSite closest = closest_of(position, sites->corners(triangle, static_cast<Site>(site)));
        if (!(closest.distance - distance <= tolerance)) continue;
        const Eigen::Vector3d direction = side * offset_of(position, closest.point).normalized();
        const double rounding = rounding_of(position, closest.point) / distance;
        least = std::min(least, (vector_of(gradient) - direction).norm() - rounding);
    }
    if (least <= allowed) return {};
    return fmt::format("the gradient ({}, {}, {}) is off by {}", gradient[0], gradient[1], gradient[2], least);
}

std::string OutputsOfSample::wrong_barycentric() const {
    const auto u = static_cast<double>(field.barycentric()[2 * at]),
               v = static_cast<double>(field.barycentric()[2 * at + 1]);
    constexpr double rounding = 2e-7;
    if (!(u >= 0) || !(u <= 1) || !(v >= 0) || !(v <= 1) || !(u + v <= 1 + rounding))
        return fmt::format("({}, {}) are no coordinates of a point of a triangle", u, v);
    const std::optional<std::uint32_t> triangle = named_triangle();
    if (!triangle) return {};
    const Mesh& mesh = truths.tree().mesh();
    const Triangle& corners = mesh.triangles()[*triangle];
    const Eigen::Vector3d a = vector_of(mesh.vertices()[corners[0]]), b = vector_of(mesh.vertices()[corners[1]]) - a,
                          c = vector_of(mesh.vertices()[corners[2]]) - a;
    const Eigen::Vector3d point = a + u * b + v * c;
    const ExactPosition position = truths.position(index);
    const double distance = offset_of(position, {point[0], point[1], point[2]}).norm();
    const double allowed = tolerance + closest_tolerance * voxel + rounding * (b.norm() + c.norm()) +
                           rounding_of(position, {point[0], point[1], point[2]});
    if (std::fabs(distance - truth.distance) <= allowed) return {};
    return fmt::format("the point ({}, {}) of triangle {} is {} away", u, v, *triangle, distance);
}

}  // namespace

void Judge::judge_outputs(const Case& sample) const {
    const OutputsOfSample outputs{truth_,        field_, sites_ ? &*sites_ : nullptr,      sample.index, sample.truth,
                                  sample.offset, voxel_, tolerance(sample.truth.distance), body_};
    const auto judge = [&](Output output, const auto& values, std::string (OutputsOfSample::*wrong)() const) {
        if (values.empty()) return;
        std::size_t& count = sample.tally.report.wrong_outputs[detail::index_of(output)];
        const bool nothing = is_left(values, sample.offset, field_.distance().size());
        if (sample.place == Case::Place::beyond) {
            if (!nothing)
                sample.report(count, fmt::format("beyond the band, but with a value of {}", info_of(output).name),
                              false);
            return;
        }
        if (nothing && sample.place == Case::Place::at_limit) return;
        const std::string what = (outputs.*wrong)();
        if (!what.empty()) sample.report(count, what, false);
    };
#define CLSDF_JUDGE(name, description, element, components, number) \
    judge(Output::name, field_.name(), &OutputsOfSample::wrong_##name);
    CLSDF_OUTPUTS(CLSDF_JUDGE)
#undef CLSDF_JUDGE
}

}  // namespace clsdf::reference
