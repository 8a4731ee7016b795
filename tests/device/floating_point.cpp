#include "support/exact_field.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

// Solvers trap floating-point exceptions, and set the rounding mode, before they make a device.

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_CASE(a_solver_that_traps_exceptions_can_make_a_device_and_compute) {
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    std::fenv_t environment;
    std::fegetenv(&environment);
    feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
    const int trapped = fegetexcept();  // most processors of Arm trap nothing
#ifdef __x86_64__
    BOOST_TEST_REQUIRE(trapped == (FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW));
#endif
    std::fesetround(FE_UPWARD);
    const Device device = Device::strongest();
    BOOST_TEST(std::fegetround() == FE_UPWARD);
    BOOST_TEST(fegetexcept() == trapped);
    std::fesetround(FE_TONEAREST);

    for (const char* const shape : {"stairs", "needle"}) {
        const Mesh mesh = make_shape(shape);
        DistanceTransform transform(device, mesh);
        const Grid grid = grid_around(mesh, 40, 3);
        const Band band = Band::symmetric(3 * grid.voxel());
        std::vector<Field> fields;
        fields.push_back(transform.compute(grid, band, Output::closest | Output::gradient));
        const std::vector<Vec3> points(20'000, Vec3{0.1, 0.2, 0.3});
        std::vector<float> distance(points.size());
        transform.query(points, 1, distance);
        // The host looks up few points.
        const std::span<const Vec3> vertices = mesh.vertices();
        const std::span<const Vec3> first = vertices.first(std::min<std::size_t>(8, vertices.size()));
        const std::vector<Vec3> few(first.begin(), first.end());
        std::vector<double> exact(few.size()), closest(3 * few.size()), gradient(3 * few.size()),
            barycentric(2 * few.size());
        const OutputTargets targets{{Output::distance, exact},
                                    {Output::closest, closest},
                                    {Output::gradient, gradient},
                                    {Output::barycentric, barycentric}};
        transform.query(few, 1, targets);
        const std::vector<double> rounded_to_nearest = closest;
        std::fesetround(FE_UPWARD);
        transform.query(few, 1, targets);
        BOOST_TEST(std::fegetround() == FE_UPWARD);
        std::fesetround(FE_TONEAREST);
        BOOST_TEST(closest == rounded_to_nearest);
        const std::vector<Box> boxes{grid.box()};
        std::vector<BoxPlace> places(1);
        transform.classify(boxes, 0.1, places);
        transform.set_positions(mesh.vertices());
        fields.push_back(transform.compute(grid, band));
        std::fenv_t traps;
        std::feholdexcept(&traps);
        for (const Field& field : fields) check_exact(mesh, field);
        BOOST_TEST((places.front() == BoxPlace::within));
        std::fesetenv(&traps);
    }

    // Faces that meet, and lines of three bodies.
    const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    const std::vector<Triangle> faces{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const Mesh cube(corners, faces);
    Scene scene(device, {.surface = Surface::outer});
    const double c = std::cos(0.4), s = std::sin(0.4);
    for (int i = 0; i < 6; ++i)
        scene.add(cube, {{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {0.3 * i, 0.1 * (i % 2), 0.5 * (i % 3)}});
    std::vector<Vec3> points;
    for (int i = 0; i < 60; ++i) points.push_back({0.03 * i, 0.4, 0.5});
    std::vector<double> distance(points.size()), upwards(points.size());
    scene.query(points, 1, {{{Output::distance, distance}}});
    const SceneSurface surface = scene.outer();
    const Grid cells = grid_around(surface.surface.mesh, 12, 0.1);
    const Fractions found = fractions(surface.surface, cells);
    std::fesetround(FE_UPWARD);
    scene.set_active(0, false);  // which forgets lines
    scene.set_active(0, true);
    scene.query(points, 1, {{{Output::distance, upwards}}});
    const SceneSurface again = scene.outer();
    const Fractions found_again = fractions(surface.surface, cells);
    std::fesetround(FE_TONEAREST);
    std::fenv_t traps;
    std::feholdexcept(&traps);
    BOOST_TEST(upwards == distance);
    BOOST_TEST((again.surface.mesh.vertices() == surface.surface.mesh.vertices()));
    BOOST_TEST(found.cells.size() == found_again.cells.size());
    for (std::size_t i = 0; i < std::min(found.cells.size(), found_again.cells.size()); ++i)
        BOOST_TEST(found.cells[i].volume == found_again.cells[i].volume);
    std::fesetenv(&traps);
    std::fesetenv(&environment);
#endif
}
