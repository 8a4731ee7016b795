#include "picture/camera.hpp"

#include "core/real_numbers.hpp"
#include "core/refuse.hpp"
#include "core/vectors.hpp"
#include "mesh/box_index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace clsdf::picture {

namespace {

constexpr double room = 0.03;  // of the longer side, around what is seen
constexpr double degree = 0.017453292519943295;

Vec3 sum(double p, const Vec3& a, double q, const Vec3& b) {
    return {p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]};
}

struct Window {
    double left = std::numeric_limits<double>::infinity();
    double right = -left;
    double bottom = left;
    double top = -left;

    void include(double x, double y, double around) {
        left = std::min(left, x - around);
        right = std::max(right, x + around);
        bottom = std::min(bottom, y - around);
        top = std::max(top, y + around);
    }
};

bool parse(const std::string& text, double& number) {
    const auto [stop, error] = read_real(text.data(), text.data() + text.size(), number);
    return error == std::errc() && stop == text.data() + text.size() && std::isfinite(number);
}

}  // namespace

void set_direction(View& view, const std::string& text) {
    struct Named {
        const char* name;
        double azimuth;
        double elevation;
    };
    static constexpr Named named[] = {
        {"front", 0, 0}, {"back", 180, 0}, {"left", -90, 0},   {"right", 90, 0},
        {"side", 90, 0}, {"top", 0, 90},   {"bottom", 0, -90}, {"iso", 45, 35.264389682754654}};
    for (const Named& direction : named)
        if (text == direction.name) {
            view.azimuth = direction.azimuth;
            view.elevation = direction.elevation;
            return;
        }
    const std::size_t comma = text.find(',');
    double azimuth = 0;
    double elevation = 0;
    if (comma == std::string::npos || !parse(text.substr(0, comma), azimuth) ||
        !parse(text.substr(comma + 1), elevation) || std::abs(elevation) > 90)
        refuse(
            "there is no view \"{}\"; choose front, back, left, right, side, top, bottom, iso, or "
            "AZIMUTH,ELEVATION in degrees, as 30,20, the elevation from -90 to 90",
            text);
    view.azimuth = azimuth;
    view.elevation = elevation;
}

void set_up(View& view, const std::string& text) {
    if (text == "auto") {
        view.up.reset();
        view.up_is_negative = false;
        return;
    }
    const bool is_negative = text.starts_with('-');
    for (const Axis axis : {Axis::x, Axis::y, Axis::z})
        if (text.substr(is_negative ? 1 : 0) == name_of(axis)) {
            view.up = axis;
            view.up_is_negative = is_negative;
            return;
        }
    refuse("\"{}\" is no direction upwards; choose auto, x, y, z, -x, -y or -z", text);
}

ViewFrame frame_of(const View& view) {
    if (!std::isfinite(view.azimuth) || !(std::abs(view.elevation) <= 90))
        refuse(
            "a view from azimuth {} and elevation {}; choose finite degrees, the elevation from "
            "-90 to 90",
            view.azimuth, view.elevation);
    Vec3 up{};
    const Axis axis = view.up.value_or(Axis::z);
    up[static_cast<std::size_t>(axis)] = view.up_is_negative ? -1 : 1;
    const Vec3 right = axis == Axis::x ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
    const Vec3 front = cross(right, up);
    const double turn = view.azimuth * degree;
    const double rise = view.elevation * degree;
    ViewFrame frame{};
    frame.right = sum(std::cos(turn), right, -std::sin(turn), front);
    const Vec3 level = sum(std::cos(turn), front, std::sin(turn), right);
    frame.back = sum(std::cos(rise), level, std::sin(rise), up);
    frame.up = cross(frame.back, frame.right);
    return frame;
}

Camera::Camera(const View& view, std::span<const Vec3> points, double around, int width, int height)
    : frame_(frame_of(view)), is_parallel_(view.perspective == 0) {
    if (!(view.perspective >= 0 && view.perspective < 120))
        refuse("a perspective of {} degrees; choose 0 (none) to 119", view.perspective);
    Box box = empty_box;
    for (const Vec3& point : points) add(box, {point, point});
    const Vec3 diagonal = sum(1, box.upper, -1, box.lower);
    const double radius = 0.5 * std::sqrt(dot(diagonal, diagonal)) + around;
    const double distance = is_parallel_ ? 2 * radius : radius / std::sin(0.5 * view.perspective * degree);
    eye_ = sum(1, sum(0.5, box.lower, 0.5, box.upper), distance, frame_.back);

    Window window;
    for (const Vec3& point : points) {
        const Vec3 seen = sum(1, point, -1, eye_);
        const double scale = is_parallel_ ? 1 : -1 / dot(seen, frame_.back);
        window.include(scale * dot(seen, frame_.right), scale * dot(seen, frame_.up), scale * around);
    }
    const double across = window.right - window.left;
    const double along = window.top - window.bottom;
    const double margin = room * std::max(across, along);
    centre_ = {0.5 * (window.left + window.right), 0.5 * (window.bottom + window.top)};
    const double full[] = {across + 2 * margin, along + 2 * margin};
    if (height == 0) {
        pixel_ = std::max(full[0], full[1]) / width;
        width_ = std::max(16, static_cast<int>(std::lround(full[0] / pixel_)));
        height_ = std::max(16, static_cast<int>(std::lround(full[1] / pixel_)));
    } else {
        width_ = width;
        height_ = height;
        pixel_ = std::max(full[0] / width, full[1] / height);
    }
}

Camera::Ray Camera::ray(double x, double y) const {
    const double right = centre_[0] + (x - 0.5 * width_) * pixel_;
    const double up = centre_[1] + (0.5 * height_ - y) * pixel_;
    const Vec3 shift = sum(right, frame_.right, up, frame_.up);
    if (is_parallel_) return {sum(1, eye_, 1, shift), sum(-1, frame_.back, 0, shift)};
    return {eye_, sum(-1, frame_.back, 1, shift)};
}

double Camera::pixel_at(const Vec3& point) const {
    return is_parallel_ ? pixel_ : pixel_ * -dot(sum(1, point, -1, eye_), frame_.back);
}

namespace {

constexpr double lowest_part = 0.05;  // of the height, on which a solid stands
constexpr double firm = 0.05;         // as firmness() measures it
constexpr double difference = 0.05;   // less may come from the samples

using Point = std::array<double, 2>;

double turn(const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Counter-clockwise, without points on its sides (Andrew's monotone chain).
std::vector<Point> convex_hull(std::vector<Point> points) {
    std::ranges::sort(points);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return points;
    std::vector<Point> hull;
    const auto add = [&](const Point& point, std::size_t least) {
        while (hull.size() > least && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
        hull.push_back(point);
    };
    for (const Point& point : points) add(point, 1);
    const std::size_t lower = hull.size();
    for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
    hull.pop_back();
    return hull;
}

double area(const std::vector<Point>& hull) {
    double sum = 0;
    for (std::size_t i = 2; i < hull.size(); ++i) sum += turn(hull[0], hull[i - 1], hull[i]);
    return sum / 2;
}

/// The distance to the nearest side; negative outside.
double depth_in(const std::vector<Point>& hull, const Point& point) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Point& a = hull[i];
        const Point& b = hull[(i + 1) % hull.size()];
        least = std::min(least, turn(a, b, point) / std::hypot(b[0] - a[0], b[1] - a[1]));
    }
    return least;
}

Vec3 centre_of_mass(std::span<const Vec3> row_ends, double spacing) {
    Vec3 sum{};
    double mass = 0;
    for (std::size_t i = 0; i + 1 < row_ends.size(); i += 2) {
        const double length = row_ends[i + 1][0] - row_ends[i][0] + spacing;
        mass += length;
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[axis] += 0.5 * length * (row_ends[i][axis] + row_ends[i + 1][axis]);
    }
    for (double& part : sum) part /= mass;
    return sum;
}

/// How far within the hull of its lowest part the centre of mass lies, as a part of the square root of the area that
/// the solid covers, seen from above; negative if the solid would fall over.
double firmness(std::span<const Vec3> points, const Vec3& centre, std::size_t up, double spacing) {
    const std::size_t right = (up + 1) % 3;
    const std::size_t front = (up + 2) % 3;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Vec3& point : points) {
        lowest = std::min(lowest, point[up]);
        highest = std::max(highest, point[up]);
    }
    // A flat base counts with two layers of samples: the lowest one is what the grid happens to hit.
    const double limit = lowest + std::max(lowest_part * (highest - lowest), 1.5 * spacing);
    std::vector<Point> all;
    std::vector<Point> footing;
    for (const Vec3& point : points) {
        all.push_back({point[right], point[front]});
        if (point[up] <= limit) footing.push_back(all.back());
    }
    const std::vector<Point> hull = convex_hull(footing);
    const double covered = area(convex_hull(all));
    if (hull.size() < 3 || !(covered > 0)) return -1;
    return depth_in(hull, {centre[right], centre[front]}) / std::sqrt(covered);
}

}  // namespace

Axis upright_axis(std::span<const Vec3> row_ends, const Vec3& spacing) {
    const Vec3 centre = centre_of_mass(row_ends, spacing[0]);
    const double along_y = firmness(row_ends, centre, 1, spacing[1]);
    const double along_z = firmness(row_ends, centre, 2, spacing[2]);
    if (along_z > firm) return along_y > along_z + difference ? Axis::y : Axis::z;
    return Axis::y;
}

}  // namespace clsdf::picture
