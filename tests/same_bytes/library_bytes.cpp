// Computes fixed meshes by every call of the library, and prints a line for each case: its name, and the number of
// bytes and a hash of every array that the call wrote, with the bits of NaN as they are. scripts/same-bytes compares
// the lines of two builds. It uses the public headers alone, so that it compiles with those of an older checkout.
#include "same_bytes/cases.hpp"
#include "same_bytes/plans.hpp"

#include <clsdf/tuning.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <vector>

namespace {

using namespace clsdf;
using namespace clsdf::test;

/// The positions after a step: doubles (1) and strided floats (2) of the host, doubles (3) and strided floats (4) of
/// the device.
void set_positions(DistanceTransform& transform, const Subject& subject, int step) {
    std::vector<Vec3> doubles;
    std::vector<float> floats;  // x y z and a number that is not read
    for (const Vec3& p : subject.mesh.vertices()) {
        doubles.push_back(bent(p, subject.middle, step));
        for (const double x : doubles.back()) floats.push_back(static_cast<float>(x));
        floats.push_back(7);
    }
    const std::size_t count = doubles.size();
    const Buffer memory = step % 2 == 1 ? buffer_of(doubles) : buffer_of(floats);
    switch (step) {
        case 1:
            return transform.set_positions(doubles);
        case 2:
            return transform.set_positions(InputArray(floats.data(), count, 4 * sizeof(float)));
        case 3:
            return transform.set_positions(InputArray(memory.memory(), ElementType::float64, count));
        default: {
            InputArray positions(memory.memory(), ElementType::float32, count);
            positions.strides[0] = 4 * sizeof(float);
            transform.set_positions(positions);
        }
    }
}

/// A transform and its plans through these steps and a motion.
void print_moves(const Subject& subject, DistanceTransform& transform, const std::string& name,
                 const std::array<int, 2>& steps) {
    Plans plans(subject);
    plans.prepare(transform);
    plans.run(name);
    const auto after = [&](const std::string& move) {
        Cases(subject, transform, name + ", " + move).short_list();
        plans.prepare(transform);
        plans.run(name + ", " + move);
    };
    for (const int step : steps) {
        set_positions(transform, subject, step);
        after("step " + std::to_string(step));
    }
    const double c = 0.8, s = 0.6;
    const Vec3 shift{0.02 * subject.side, -0.01 * subject.side, 0.03 * subject.side};
    const Vec3& middle = subject.middle;  // a body that is far away turns around itself
    const Vec3 translation = {middle[0] - (c * middle[0] - s * middle[1]) + shift[0],
                              middle[1] - (s * middle[0] + c * middle[1]) + shift[1], shift[2]};
    transform.set_motion({Vec3{c, -s, 0}, Vec3{s, c, 0}, Vec3{0, 0, 1}}, translation);
    after("motion");
}

void print_mesh(const NamedMesh& named) {
    const Subject subject(named);
    const std::string name = subject.name;
    DistanceTransform transform(the_device(), subject.mesh);
    Cases(subject, transform, name).long_list();
    print_moves(subject, transform, name, {1, 4});

    // The mesh in the caller's arrays: floats on the host, doubles with indices of 64 bits on the device.
    std::vector<float> floats;
    for (const Vec3& p : subject.mesh.vertices())
        for (const double x : p) floats.push_back(static_cast<float>(x));
    const DistanceTransform of_floats(the_device(), MeshView(floats, subject.mesh.triangles()));
    Cases(subject, of_floats, name + " of floats").short_list();

    std::vector<std::array<std::uint64_t, 3>> indices;
    for (const Triangle& t : subject.mesh.triangles()) indices.push_back({t[0], t[1], t[2]});
    const Buffer vertices = buffer_of(subject.mesh.vertices()), triangles = buffer_of(indices);
    DistanceTransform of_device(the_device(),
                                MeshView(InputArray(vertices.memory(), ElementType::float64, floats.size() / 3),
                                         InputArray(triangles.memory(), ElementType::uint64, indices.size())));
    Cases(subject, of_device, name + " of the device").short_list();
    print_moves(subject, of_device, name + " of the device", {2, 3});

    for (const SignRule rule : {SignRule::none, SignRule::parity, SignRule::solid_angle})
        print_case(name + ", sign " + name_of(rule), [&](Line& line) {
            const DistanceTransform other(the_device(), subject.mesh, {.sign = rule, .kept_bytes = 0});
            const Results results(all_outputs(), subject.grid.size), at_points(all_outputs(), some_points);
            other.compute(subject.grid, subject.band, results.targets());
            other.query(std::span(subject.points).first(some_points), infinity, at_points.targets());
            results.report(line);
            at_points.report(line);
        });
}

}  // namespace

int main() {
    try {
        tuning::read_environment();
        for (const NamedMesh& named : fixed_meshes()) print_mesh(named);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "library_bytes: %s\n", error.what());
        return 1;
    }
}
