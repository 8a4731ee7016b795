// Particles fall on a solid and bounce. In each step one call gives the distance, the normal and the triangle of every
// particle near the surface. The solid turns, so its vertices move between the steps.
//
// example_contact_points [PARTICLES [STEPS]]

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using clsdf::Output;
using clsdf::Vec3;

struct Particles {
    std::vector<Vec3> position, velocity;
    std::vector<float> distance, normal;
    std::vector<std::uint32_t> triangle;

    explicit Particles(std::size_t count)
        : position(count), velocity(count), distance(count), normal(3 * count), triangle(count) {}
};

/// Particles at rest above the solid.
Particles drop(std::size_t count, const clsdf::Box& box) {
    Particles particles(count);
    const Vec3 extent = box.extent();
    for (std::size_t i = 0; i < count; ++i) {
        // Numbers from 0 to 1 that fill a cube evenly.
        const auto part = [&](double step) { return std::fmod(step * static_cast<double>(i + 1), 1.0); };
        particles.position[i] = {box.lower[0] + part(0.8191725133961645) * extent[0],
                                 box.lower[1] + part(0.6710436067037893) * extent[1],
                                 box.upper[2] + part(0.5497004779019703) * 0.2 * extent[2]};
    }
    return particles;
}

std::array<Vec3, 3> turned(double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
}

void fall(Particles& particles, double time) {
    for (std::size_t i = 0; i < particles.position.size(); ++i) {
        particles.velocity[i][2] -= 10 * time;
        for (std::size_t axis = 0; axis < 3; ++axis) particles.position[i][axis] += time * particles.velocity[i][axis];
    }
}

/// Moves particles that overlap the solid to its surface and lets them bounce. Returns their number.
std::size_t bounce(Particles& particles, double radius) {
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < particles.position.size(); ++i) {
        const auto distance = static_cast<double>(particles.distance[i]);
        if (distance >= radius || particles.triangle[i] == clsdf::no_triangle) continue;
        ++contacts;
        double speed = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            speed += particles.velocity[i][axis] * static_cast<double>(particles.normal[3 * i + axis]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto normal = static_cast<double>(particles.normal[3 * i + axis]);
            particles.position[i][axis] += (radius - distance) * normal;
            if (speed < 0) particles.velocity[i][axis] -= 1.5 * speed * normal;
        }
    }
    return contacts;
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const std::size_t count = argument_count > 1 ? std::strtoul(arguments[1], nullptr, 10) : 20000;
        const int steps = argument_count > 2 ? std::atoi(arguments[2]) : 20;
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
        Particles particles = drop(count, mesh.box());
        const double side = mesh.box().longest_side(), radius = 0.004 * side;

        std::size_t all_contacts = 0, inside = 0;
        std::chrono::duration<double> seconds{};
        const auto contacts_of_step = [&](int step) {
            transform.set_motion(turned(0.05 * step), {0, 0, 0});
            // In one step no particle enters the solid deeper than a few hundredths of its longest side.
            transform.query(particles.position, 0.1 * side,
                            {{Output::distance, particles.distance},
                             {Output::triangle, particles.triangle},
                             {Output::gradient, particles.normal}});
        };
        contacts_of_step(0);  // compiles the programs, and tests them the first time on this device
        for (int step = 0; step < steps; ++step) {
            fall(particles, 0.02 * std::sqrt(side));
            // The time includes the motion, and making anew what a query needs of the moved mesh.
            const auto begin = std::chrono::steady_clock::now();
            contacts_of_step(step);
            seconds += std::chrono::steady_clock::now() - begin;
            all_contacts += bounce(particles, radius);
        }
        record(particles.position);
        record(particles.triangle);
        record(particles.normal);
        transform.query(particles.position, 0.1 * side, particles.distance);
        record(particles.distance);
        for (const float distance : particles.distance)
            inside += static_cast<double>(distance) < 0.99 * radius ? 1U : 0U;
        std::printf("%zu particles, %d steps: %zu contacts; %zu particles overlap the solid at the end\n", count, steps,
                    all_contacts, inside);
        std::printf("%.1f ms a step for the motion and the query: %.2f million points a second\n",
                    1e3 * seconds.count() / steps, 1e-6 * static_cast<double>(count) * steps / seconds.count());
        return all_contacts > 0 && inside * 100 < count ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
