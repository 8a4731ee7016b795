#include "picture/balls_and_boxes.hpp"
#include "picture/scene.hpp"
#include "picture/tracer.hpp"
#include "support/throws.hpp"

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <random>

using clsdf::Band;
using clsdf::Device;
using clsdf::ErrorCode;
using clsdf::Field;
using clsdf::Grid;
using clsdf::Output;
using clsdf::RenderHit;
using clsdf::RenderView;
using clsdf::SignRule;
using clsdf::Vec3;
using clsdf::picture::Axis;
using clsdf::picture::Camera;
using clsdf::picture::Hit;
using clsdf::picture::Hits;
using clsdf::picture::Scene;
using clsdf::picture::SurfaceOptions;
using clsdf::picture::SurfacePictures;
using clsdf::picture::View;
using clsdf::test::Agreement;
using clsdf::test::check_agreements;
using clsdf::test::check_throws;
using clsdf::test::distance_to_box;
using clsdf::test::field_of;
using clsdf::test::norm;
using clsdf::test::uneven_grid;

namespace {

using Kind = Hit::Kind;

const Device& device() {
    static const auto* const device =
        new Device(Device::strongest());  // the driver may be gone before static objects are
    return *device;
}

SurfaceOptions options_of(const View& view, int width = 150, int height = 0) {
    SurfaceOptions options;
    options.view = view;
    options.width = width;
    options.height = height;
    return options;
}

std::vector<View> some_views() {
    return {{0, 0, Axis::z, false, 0},  {30, 20, Axis::z, false, 0},  {-110, -50, Axis::y, true, 0},
            {0, 90, Axis::x, false, 0}, {75, 35, Axis::y, false, 40}, {200, -10, Axis::z, true, 90}};
}

struct Ray {
    Vec3 origin;  // in the mesh's space
    Vec3 direction;

    Vec3 at(double t) const {
        return {origin[0] + t * direction[0], origin[1] + t * direction[1], origin[2] + t * direction[2]};
    }
};

double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Ray ray_through(const Camera& camera, const Field& field, int x, int y) {
    const Camera::Ray given = camera.ray(x + 0.5, y + 0.5);
    const Vec3 origin = field.grid.position(0, 0, 0);
    Ray ray{given.origin, given.direction};
    const double length = norm(ray.direction);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        ray.origin[axis] += origin[axis];
        ray.direction[axis] /= length;
    }
    return ray;
}

double depth_of(const Ray& ray, const Vec3& point) {
    return dot(point, ray.direction) - dot(ray.origin, ray.direction);
}

// How far the point is from its ray.
double off(const Ray& ray, const Vec3& point) {
    const Vec3 foot = ray.at(depth_of(ray, point));
    return norm({point[0] - foot[0], point[1] - foot[1], point[2] - foot[2]});
}

// Calls see(ray, hit) for every pixel.
template <class See>
void look_at(const Field& field, const SurfaceOptions& options, std::optional<double> offset, const See& see) {
    const Hits hits = SurfacePictures(field, device(), offset).hits(options);
    const Camera camera = Scene(field, device(), offset).camera(options);
    BOOST_REQUIRE(hits.width == camera.width());
    BOOST_REQUIRE(hits.pixels.size() == static_cast<std::size_t>(hits.width) * static_cast<std::size_t>(hits.height));
    for (int y = 0; y < hits.height; ++y)
        for (int x = 0; x < hits.width; ++x)
            see(ray_through(camera, field, x, y),
                hits.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(hits.width) +
                            static_cast<std::size_t>(x)]);
}

// Every ray meets the ball around 0 where it should, to `tolerance` voxels; those that all but miss it may miss it.
void check_ball(const Field& field, const SurfaceOptions& options, std::optional<double> offset, double radius,
                double tolerance) {
    // Elsewhere the band ends too near, or the distance turns.
    const bool has_gradient = std::min(field.band.inside, field.band.outside) > 0.4;
    const double voxel = field.grid.voxel();
    double worst = 0;
    int wrong = 0;
    int met = 0;
    int all = 0;
    look_at(field, options, offset, [&](const Ray& ray, const Hit& hit) {
        ++all;
        const double along = -dot(ray.origin, ray.direction);
        const double passing = norm(ray.at(along));
        if (hit.kind == Kind::nothing) {
            wrong += passing < radius - tolerance * voxel;
            return;
        }
        ++met;
        const double expected = along - std::sqrt(std::max(0.0, radius * radius - passing * passing));
        const double cosine = std::sqrt(std::max(0.0, 1 - std::pow(passing / radius, 2)));
        const double depth = depth_of(ray, hit.position);
        wrong += passing > radius + tolerance * voxel || hit.kind != Kind::surface;
        worst = std::max({worst, std::abs(norm(hit.position) - radius) / voxel, off(ray, hit.position) / voxel});
        // A ray that comes in flat meets a surface that is a little higher much earlier.
        if (cosine > 0.2) worst = std::max(worst, cosine * std::abs(depth - expected) / voxel);
        wrong += cosine > 0.3 &&
                 dot(hit.gradient, ray.direction) > -(has_gradient ? 0.9 : 0.7) * cosine * norm(hit.gradient);
        wrong += has_gradient && std::abs(norm(hit.gradient) - 1) > 0.05;
    });
    BOOST_TEST(wrong == 0);
    BOOST_TEST(worst < tolerance);
    BOOST_TEST(met > all / 2);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(traced_surface)

BOOST_AUTO_TEST_CASE(of_a_ball_is_met_where_the_ball_is_from_every_side) {
    const Field field = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) - 1; });
    // Between samples the interpolant is above the distance by up to the squared diagonal of a cell, over 8 radii.
    const double tolerance = (0.05 * 0.05 + 0.06 * 0.06 + 0.0725 * 0.0725) / 8 / 0.05 * 1.2;
    for (const View& view : some_views()) BOOST_TEST_CONTEXT("azimuth " << view.azimuth)
    check_ball(field, options_of(view), {}, 1, tolerance);
}

BOOST_AUTO_TEST_CASE(is_whole_where_the_samples_come_to_the_device_in_pieces) {
    const Grid grid{{-1.5, -1.5, -1.5}, {0.025, 0.025, 0.025}, {121, 121, 121}, {}};
    const Field field = field_of(grid, Band::symmetric(0.45), [](const Vec3& p) { return norm(p) - 1; });
    check_ball(field, options_of(some_views()[0]), {}, 1, 0.02);
}

BOOST_AUTO_TEST_CASE(of_a_box_is_met_where_the_box_is_to_a_thousandth_of_a_voxel) {
    const Vec3 half{0.913, 0.777, 0.852};
    const Field field =
        field_of(uneven_grid(), Band::symmetric(0.3), [&](const Vec3& p) { return distance_to_box(p, half); });
    for (const View& view : some_views()) BOOST_TEST_CONTEXT("azimuth " << view.azimuth) {
            double worst = 0;
            int compared = 0;
            look_at(field, options_of(view), {}, [&](const Ray& ray, const Hit& hit) {
                double enters = -1e300;
                double leaves = 1e300;
                std::size_t face = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    if (ray.direction[axis] == 0) continue;
                    const double one = (-half[axis] - ray.origin[axis]) / ray.direction[axis];
                    const double other = (half[axis] - ray.origin[axis]) / ray.direction[axis];
                    if (std::min(one, other) > enters) face = axis;
                    enters = std::max(enters, std::min(one, other));
                    leaves = std::min(leaves, std::max(one, other));
                }
                const Vec3 point = ray.at(enters);
                // Near its edges the box is round between samples.
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (axis != face && std::abs(point[axis]) > half[axis] - 0.15) return;
                if (enters > leaves || std::abs(ray.direction[face]) < 0.1) return;
                ++compared;
                BOOST_REQUIRE((hit.kind == Kind::surface));
                worst = std::max(worst, std::abs(depth_of(ray, hit.position) - enters) / 0.05);
                worst = std::max(worst, std::abs(std::abs(hit.gradient[face]) - 1));
            });
            BOOST_TEST(worst < 1e-3);
            BOOST_TEST(compared > 3000);
        }
}

// The kernel's steps are bounded by slopes; here a march in steps of a hundredth of a voxel says what they must find,
// in fields that are no distances at all.
BOOST_AUTO_TEST_CASE(is_the_first_zero_of_the_interpolant_in_any_field) {
    for (unsigned seed = 0; seed < 4; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> value(-0.25, 1);
            const Grid grid{{3, -4, 5}, {0.1, 0.25, 0.16}, {11, 8, 9}, {}};
            const Field field = field_of(grid, Band::full(), [&](const Vec3&) { return value(random); });
            const auto interpolated = [&](const Vec3& p) {
                double cell[3];
                double part[3];
                for (std::size_t a = 0; a < 3; ++a) {
                    const double last = static_cast<double>(grid.size[a] - 1);
                    const double at = std::clamp((p[a] - grid.origin[a]) / grid.spacing[a], 0.0, last);
                    cell[a] = std::min(std::floor(at), last - 1);
                    part[a] = at - cell[a];
                }
                double sum = 0;
                for (int corner = 0; corner < 8; ++corner) {
                    double weight = 1;
                    std::int64_t at[3];
                    for (std::size_t a = 0; a < 3; ++a) {
                        const int bit = corner >> a & 1;
                        weight *= bit == 1 ? part[a] : 1 - part[a];
                        at[a] = static_cast<std::int64_t>(cell[a]) + bit;
                    }
                    sum += weight * static_cast<double>(field.distance()[grid.offset(at[0], at[1], at[2])]);
                }
                return sum;
            };
            const auto in_grid = [&](const Vec3& p) {
                for (std::size_t a = 0; a < 3; ++a)
                    if (p[a] < grid.origin[a] ||
                        p[a] > grid.origin[a] + static_cast<double>(grid.size[a] - 1) * grid.spacing[a])
                        return false;
                return true;
            };
            int different = 0;
            int compared = 0;
            for (const View& view : {some_views()[1], some_views()[4]})
                look_at(field, options_of(view, 48), {}, [&](const Ray& ray, const Hit& hit) {
                    ++compared;
                    for (double t = 0; t < 12; t += 0.001) {
                        const Vec3 p = ray.at(t);
                        if (!in_grid(p) || interpolated(p) >= 0) continue;
                        different += hit.kind == Kind::nothing || std::abs(depth_of(ray, hit.position) - t) > 0.004;
                        return;
                    }
                    different += hit.kind != Kind::nothing;
                });
            BOOST_TEST(compared > 2000);
            // Rays that graze it: what is thinner than a step may be passed over by either.
            BOOST_TEST(different <= compared / 250);
        }
}

BOOST_AUTO_TEST_CASE(lies_where_it_does_also_in_bands_of_one_side_and_narrower_than_a_voxel) {
    const auto ball = [](const Vec3& p) { return norm(p) - 1; };
    const Grid grid{{-1.37, -1.41, -1.45}, {0.05, 0.05, 0.05}, {57, 57, 57}, {}};
    for (const Band& band : {Band{0, 0.3}, Band{0.3, 0}, Band{0.03, 0.3}, Band{0, 10}})
        BOOST_TEST_CONTEXT("band " << band.inside << ", " << band.outside)
    check_ball(field_of(grid, band, ball), options_of(some_views()[1]), {}, 1, 0.15);
}

BOOST_AUTO_TEST_CASE(at_an_offset_is_the_ball_that_has_grown_or_shrunk) {
    const Field field = field_of(uneven_grid(), Band::symmetric(0.3), [](const Vec3& p) { return norm(p) - 1; });
    for (const double offset : {0.29, 0.1, -0.1, -0.29}) BOOST_TEST_CONTEXT("offset " << offset)
    check_ball(field, options_of(some_views()[1]), offset, 1 + offset, 0.1);
}

BOOST_AUTO_TEST_CASE(of_a_field_without_sign_is_a_voxel_away_from_the_mesh) {
    const Field field = field_of(
        uneven_grid(), Band::symmetric(0.3), [](const Vec3& p) { return std::abs(norm(p) - 1); }, SignRule::none);
    BOOST_TEST(SurfacePictures(field, device()).offset() == 0.0725);
    check_ball(field, options_of(some_views()[1]), {}, 1.0725, 0.1);
    check_ball(field, options_of(some_views()[1]), 0.2, 1.2, 0.1);
}

BOOST_AUTO_TEST_CASE(is_opened_by_cuts_which_show_the_distance_there) {
    const Field field = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) - 1; });
    SurfaceOptions options = options_of({40, 30, Axis::z, false, 0});
    options.cuts = {{Axis::x, 0.21}, {Axis::y, {}}, {Axis::z, -0.1}};
    int on[3] = {};
    int wrong = 0;
    look_at(field, options, {}, [&](const Ray& ray, const Hit& hit) {
        if (hit.kind == Kind::nothing) return;
        BOOST_REQUIRE((hit.kind != Kind::border));
        // Seen from the right, the front (smaller y) and above.
        const Vec3& p = hit.position;
        const double depths[] = {p[0] - 0.21, -p[1], p[2] + 0.1};
        wrong += std::min({depths[0], depths[1], depths[2]}) > 0.05;
        wrong += off(ray, p) > 1e-4 || norm(p) > 1.001;
        if (hit.kind != Kind::cut) return;
        wrong += std::abs(hit.distance - (norm(p) - 1)) > 0.01 || hit.distance >= 0;
        int planes = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (std::abs(depths[axis]) < (axis == 1 ? 0.05 : 1e-5)) {
                ++on[axis];
                ++planes;
            }
        wrong += planes == 0;
    });
    BOOST_TEST(wrong == 0);
    for (const int count : on) BOOST_TEST(count > 200);
}

BOOST_AUTO_TEST_CASE(shows_the_inside_where_the_grid_ends_in_the_solid) {
    Grid grid = uneven_grid();
    grid.size[0] = 30;  // to x = 0.08
    const Field field = field_of(grid, Band::full(), [](const Vec3& p) { return norm(p) - 1; });
    int borders = 0;
    look_at(field, options_of({90, 0, Axis::z, false, 0}), {}, [&](const Ray&, const Hit& hit) {
        if (hit.kind != Kind::border) return;
        ++borders;
        BOOST_TEST(std::abs(hit.position[0] - 0.08) < 1e-5);
        BOOST_TEST(std::abs(hit.distance - (norm(hit.position) - 1)) < 0.02);
    });
    BOOST_TEST(borders > 10000);
}

BOOST_AUTO_TEST_CASE(is_refused_where_there_is_none) {
    const auto ball = [](const Vec3& p) { return norm(p) - 1; };
    const Field field = field_of(uneven_grid(), Band::symmetric(0.3), ball);
    check_throws(ErrorCode::invalid_argument, {"band ends at distance 0.3", "0.3", "wider band"},
                 [&] { SurfacePictures(field, device(), 0.3); });
    check_throws(ErrorCode::invalid_argument, {"band ends at distance -0.3", "-0.5"},
                 [&] { SurfacePictures(field, device(), -0.5); });
    check_throws(ErrorCode::invalid_argument, {"nan", "finite"},
                 [&] { SurfacePictures(field, device(), std::nan("")); });

    const Field away = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) + 0.5; });
    check_throws(ErrorCode::invalid_argument, {"no surface at distance 0", "from 0.5", "around the mesh"},
                 [&] { SurfacePictures(away, device()); });
    const Field within = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) - 10; });
    check_throws(ErrorCode::invalid_argument, {"no surface at distance 0"}, [&] { SurfacePictures(within, device()); });
    const Field without = field_of(uneven_grid(), Band::symmetric(0.3), ball, SignRule::none);
    check_throws(ErrorCode::invalid_argument, {"0", "no sign"}, [&] { SurfacePictures(without, device(), 0.0); });

    Field damaged = field;
    damaged.distance()[damaged.grid.offset(3, 2, 1)] = std::nanf("");
    check_throws(ErrorCode::invalid_argument, {"(3, 2, 1)", "not a number"},
                 [&] { SurfacePictures(damaged, device()); });
    damaged.resize(Output::distance, damaged.distance().size() - 1);
    check_throws(ErrorCode::invalid_argument, {"values", "samples"}, [&] { SurfacePictures(damaged, device()); });
    Field flat = field_of({{-2, -2, 0}, {0.1, 0.1, 0.1}, {41, 41, 1}, {}}, Band::full(), ball);
    check_throws(ErrorCode::invalid_argument, {"along z is 1", "slice"}, [&] { SurfacePictures(flat, device()); });
}

BOOST_AUTO_TEST_CASE(is_refused_where_the_device_cannot_hold_the_field) {
    const Field field = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) - 1; });
    ::setenv("CLSDF_MAX_ALLOCATION", "400000", 1);
    const Device small = Device::strongest();
    ::unsetenv("CLSDF_MAX_ALLOCATION");
    check_throws(ErrorCode::out_of_memory, {"450016 bytes", "at most 400000 bytes", "another device"},
                 [&] { SurfacePictures(field, small); });
}

BOOST_AUTO_TEST_CASE(is_traced_in_the_strangest_fields) {
    for (const double scale : {1e-30, 1.0, 1e30}) BOOST_TEST_CONTEXT("scale " << scale) {
            const Grid grid{{1e3 * scale, -scale, 0}, {scale, 2 * scale, scale}, {9, 7, 8}, {}};
            Field field = field_of(grid, Band::full(), [&](const Vec3& p) {
                return norm({p[0] - 1004 * scale, p[1] - 5 * scale, p[2] - 4 * scale}) - 2.5 * scale;
            });
            field.distance()[5] = std::numeric_limits<float>::infinity();
            const Hits hits = SurfacePictures(field, device()).hits(options_of({0, 0, Axis::z, false, 0}, 40));
            BOOST_TEST(std::count_if(hits.pixels.begin(), hits.pixels.end(),
                                     [](const Hit& hit) { return hit.kind == Kind::surface; }) > 300);
        }
    Field two = field_of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {}}, Band::full(), [](const Vec3& p) { return p[0] - 0.4; });
    for (const Hit& hit : SurfacePictures(two, device()).hits(options_of({90, 0, Axis::z, false, 0}, 20)).pixels)
        if (hit.kind != Kind::nothing) BOOST_TEST(std::abs(hit.position[0] - 0.4) < 1e-4);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(views)

BOOST_AUTO_TEST_CASE(look_from_where_they_say) {
    const auto back = [](const char* direction, const char* up) {
        View view;
        clsdf::picture::set_direction(view, direction);
        clsdf::picture::set_up(view, up);
        const auto frame = clsdf::picture::frame_of(view);
        // Right-handed, of unit vectors.
        for (const Vec3& v : {frame.right, frame.up, frame.back}) BOOST_TEST(std::abs(norm(v) - 1) < 1e-12);
        BOOST_TEST(std::abs(dot(frame.right, frame.up)) < 1e-12);
        BOOST_TEST(frame.right[0] * frame.up[1] - frame.right[1] * frame.up[0] == frame.back[2],
                   boost::test_tools::tolerance(1e-9));
        return Vec3{std::round(10 * frame.back[0]), std::round(10 * frame.back[1]), std::round(10 * frame.back[2])};
    };
    BOOST_TEST((back("front", "z") == Vec3{0, -10, 0}));
    BOOST_TEST((back("back", "z") == Vec3{0, 10, 0}));
    BOOST_TEST((back("side", "z") == Vec3{10, 0, 0}));
    BOOST_TEST((back("left", "z") == Vec3{-10, 0, 0}));
    BOOST_TEST((back("top", "z") == Vec3{0, 0, 10}));
    BOOST_TEST((back("bottom", "z") == Vec3{0, 0, -10}));
    BOOST_TEST((back("front", "y") == Vec3{0, 0, 10}));
    BOOST_TEST((back("front", "-y") == Vec3{0, 0, -10}));
    BOOST_TEST((back("top", "-z") == Vec3{0, 0, -10}));
    BOOST_TEST((back("top", "x") == Vec3{10, 0, 0}));
    BOOST_TEST((back("iso", "z") == Vec3{6, -6, 6}));
    BOOST_TEST((back("90,30", "z") == Vec3{9, 0, 5}));
    for (const char* wrong : {"", "diagonal", "30", "30,", "30,91", "1,2,3", "nan,0"})
        check_throws(ErrorCode::invalid_argument, {std::string("\"") + wrong + "\"", "front", "30,20"},
                     [&] { back(wrong, "z"); });
    for (const char* wrong : {"", "-", "w", "--x", "x-"})
        check_throws(ErrorCode::invalid_argument, {"upwards", "-z"}, [&] { back("front", wrong); });
}

BOOST_AUTO_TEST_CASE(show_the_whole_solid_with_little_room_around_it) {
    const Field field = field_of(uneven_grid(), Band::full(), [](const Vec3& p) { return norm(p) - 1; });
    for (const View& view : some_views()) BOOST_TEST_CONTEXT("azimuth " << view.azimuth) {
            const Hits hits = SurfacePictures(field, device()).hits(options_of(view, 120, 90));
            BOOST_TEST(hits.width == 120);
            BOOST_TEST(hits.height == 90);
            int top = 90;
            int bottom = 0;
            for (int i = 0; i < 120 * 90; ++i)
                if (hits.pixels[static_cast<std::size_t>(i)].kind != Kind::nothing) {
                    top = std::min(top, i / 120);
                    bottom = std::max(bottom, i / 120);
                }
            BOOST_TEST(top >= 2);
            BOOST_TEST(top <= 12);
            BOOST_TEST(bottom <= 87);
            BOOST_TEST(bottom >= 77);
        }
}

BOOST_AUTO_TEST_SUITE_END()
