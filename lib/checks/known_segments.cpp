#include "checks/known_segments.hpp"

#include "core/floating_point.hpp"
#include "device/read_back.hpp"
#include "segments/device_links.hpp"
#include "segments/device_samples.hpp"
#include "segments/links.hpp"
#include "segments/sample_sides.hpp"
#include "sign/exact_sides.hpp"
#include "topology/device_topology.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::checks {

namespace {

struct KnownParts {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    /// Of four corners with positive volume.
    void add(const std::array<Vec3, 4>& corners) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), corners.begin(), corners.end());
        for (const auto& [a, b, c] : std::array<Triangle, 4>{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}})
            triangles.push_back({first + a, first + b, first + c});
    }
    void add_box(const Vec3& a, const Vec3& b) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (std::uint32_t i = 0; i < 8; ++i)
            vertices.push_back({(i & 1) != 0 ? b[0] : a[0], (i & 2) != 0 ? b[1] : a[1], (i & 4) != 0 ? b[2] : a[2]});
        for (const auto& [u, v, w] : std::array<Triangle, 12>{{{0, 2, 3},
                                                               {0, 3, 1},
                                                               {4, 5, 7},
                                                               {4, 7, 6},
                                                               {0, 1, 5},
                                                               {0, 5, 4},
                                                               {2, 6, 7},
                                                               {2, 7, 3},
                                                               {0, 4, 6},
                                                               {0, 6, 2},
                                                               {1, 3, 7},
                                                               {1, 7, 5}}})
            triangles.push_back({first + u, first + v, first + w});
    }
};

/// Boxes on planes of samples that touch and overlap, a large one, and tetrahedra beside the lattice: ties of each
/// kind, steep faces and large ones, several bodies in a row.
struct KnownBodies {
    engine::PointMesh mesh;
    Grid grid{{-0.25, 0.5, 0}, {0.5, 0.25, 0.5}, {38, 21, 17}, {-2, -1, -3}};

    KnownBodies() {
        KnownParts parts;
        parts.add_box({0.25, 1, 0.5}, {3.25, 2.5, 2.5});
        parts.add_box({3.25, 1, 0.5}, {5.25, 2.5, 2.5});
        parts.add_box({1.75, 1.5, 1}, {9.1, 3.75, 3.3});
        parts.add_box({11, 0.9, -1}, {16.5, 30, 20});
        parts.add({{{5.3, 0.6, -0.7}, {8.1, 1.2, -0.1}, {6.2, 4.7, 0.9}, {7.4, 1.3, 5.2}}});
        parts.add({{{0.25, 3, 3}, {6.75, 3, 3}, {3.25, 5, 3}, {3.25, 3.5, 4.5}}});
        const Mesh given(parts.vertices, parts.triangles, "known bodies");
        mesh = engine::make_host_point_mesh(given, {}, std::make_shared<const engine::MeshTopology>(given));
    }
};

/// The known bodies on the device.
struct KnownOnDevice {
    std::shared_ptr<device::BufferPool> pool;
    engine::DeviceTools tools;
    DefaultFloatingPoint usual;
    KnownBodies known;
    engine::CrossedFaces faces{known.mesh};
    engine::CrossedMesh mesh;

    KnownOnDevice(const Device& device, const engine::Programs& programs)
        : pool(std::make_shared<device::BufferPool>(device::shared_context_of(device))),
          tools{device::context_of(device), pool, programs} {
        const engine::DeviceSetUp set_up(tools);
        mesh = {std::make_shared<const engine::NamedFaces>(device_names(set_up, known.mesh.topology)),
                std::make_shared<const device::BufferPool::Lease>(set_up.upload(known.mesh.positions, "vertices")),
                faces.per_unit};
    }
};

std::optional<std::string> difference_of_sides(const Device& device, const engine::Programs& programs, SignRule rule) {
    const KnownOnDevice known(device, programs);
    const segments::SampleBox box(known.known.grid, {1, 2, 0}, known.faces.per_unit);
    const segments::BoxSides expected(known.faces, rule, box);
    const std::size_t words = 2;
    const segments::DeviceSamples samples(known.tools, box, words);
    const auto found =
        engine::find_exact_sides(known.tools, {known.tools.context, {}}, known.mesh, rule, samples.rows, *samples.at);
    if (!found) return "coordinates are taken for others";
    std::vector<std::uint32_t> bits(words * box.row_count());
    device::read_values(known.tools.context, *found->bits, bits);
    for (std::size_t n = 0; n < bits.size(); ++n)
        if (bits[n] != static_cast<std::uint32_t>(expected.row(n / words)[0] >> (n % words * 32)))
            return "samples are on the wrong side";
    return std::nullopt;
}

std::optional<std::string> difference_of_links(const Device& device, const engine::Programs& programs, SignRule rule) {
    const KnownOnDevice known(device, programs);
    std::vector<LinkDirection> directions = stencil("D3Q27");
    directions.push_back({2, -1, 3});
    const Grid& grid = known.known.grid;
    const Links expected = segments::find_links({known.faces, nullptr, rule, {}}, grid, directions, {});
    const segments::DeviceLinkInputs inputs{known.tools, known.mesh, rule, {}};
    const auto found = segments::links_by_kernels(inputs, grid, directions);
    if (!found) return "links are left to the host";
    if (found->inside.bits != expected.inside.bits) return "samples are on the wrong side";
    if (found->samples != expected.samples || found->directions != expected.directions) return "there are other links";
    if (found->triangles != expected.triangles || found->counts != expected.counts || found->flags != expected.flags)
        return "links meet other walls";
    if (found->q != expected.q) return "walls are at wrong places";
    const auto planned = segments::links_on_device(inputs, grid, directions, expected.size());
    if (!planned) return "links are left to the host";
    std::vector<float> floats(expected.size());
    std::vector<std::uint8_t> inside(grid.sample_count());
    device::read_values(known.tools.context, *planned->q_floats, floats);
    device::read_values(known.tools.context, *planned->inside, inside);
    for (std::size_t n = 0; n < floats.size(); ++n)
        if (floats[n] != as_float_part(expected.q[n])) return "places of walls are wrong floats";
    for (std::size_t n = 0; n < inside.size(); ++n)
        if ((inside[n] != 0) != expected.inside.is_inside(n)) return "samples are on the wrong side";
    return std::nullopt;
}

}  // namespace

TestSubject exact_sides_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "exact sides";
    subject.build = [&programs](const device::BuildWatch& watch) {
        return std::vector{programs.exact_sides.get(watch), programs.scan.get(watch)};
    };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        for (const SignRule rule : {SignRule::nonzero, SignRule::parity})
            if (auto difference = difference_of_sides(device, programs, rule)) return difference;
        return std::nullopt;
    };
    return subject;
}

TestSubject links_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "links";
    subject.build = [&programs](const device::BuildWatch& watch) {
        return std::vector{programs.exact_sides.get(watch), programs.links.get(watch), programs.scan.get(watch)};
    };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        for (const SignRule rule : {SignRule::nonzero, SignRule::parity})
            if (auto difference = difference_of_links(device, programs, rule)) return difference;
        return std::nullopt;
    };
    return subject;
}

}  // namespace clsdf::checks
