#include "checks/known_fractions.hpp"

#include "cutting/device_fractions.hpp"
#include "device/read_back.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/outer.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::checks {

namespace {

/// A box whose walls lie in planes between cells, and a tetrahedron with slanted faces beside it.
OuterSurface known_surface() {
    std::vector<Vec3> vertices;
    for (std::uint32_t i = 0; i < 8; ++i)
        vertices.push_back({(i & 1) != 0 ? 3.0 : 1.0, (i & 2) != 0 ? 1.8 : 1.2, (i & 4) != 0 ? 2.5 : 0.5});
    std::vector<Triangle> triangles{{{0, 2, 3},
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
                                     {1, 7, 5}}};
    vertices.insert(vertices.end(), {{3.3, 0.6, -0.7}, {8.1, 1.2, -0.1}, {4.2, 4.7, 0.9}, {5.4, 1.3, 5.2}});
    for (const Triangle& triangle : std::array<Triangle, 4>{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}})
        triangles.push_back({8 + triangle[0], 8 + triangle[1], 8 + triangle[2]});
    return {Mesh(std::move(vertices), std::move(triangles), "known surface"), {}};
}

using cutting::StoredNumbers;

std::optional<std::string> difference_of_rows(const Device& device, const engine::Programs& programs,
                                              const FractionOptions& options) {
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const engine::DeviceTools tools{device::context_of(device), pool, programs};
    const OuterSurface surface = known_surface();
    // A part of the lattice, so that rows begin before it. 0.3 is rounded, and the walls lie in planes all the same.
    const Grid grid{{0, 0, 0.5}, {0.5, 0.3, 0.25}, {14, 12, 18}, {1, 1, -4}};
    const Fractions expected = fractions(surface, grid, options);
    const auto vertices = device::uploaded(tools.context, pool, surface.mesh.vertices(), "vertices");
    cutting::DeviceFractions cuts(tools, surface.mesh, grid, options, true);
    if (!cuts.run_and_make_room(tools, cutting::device_vertices(*vertices, cuts.vertex_count()), SIZE_MAX,
                                [](double) {}))
        return "vertices are taken for others";
    if (cuts.read(tools).rows != expected.cells.size()) return "cells are counted wrongly";
    std::vector<CellFraction> rows(expected.cells.size());
    device::read_values(tools.context, cuts.rows(), rows);
    for (std::size_t n = 0; n < rows.size(); ++n) {
        if (rows[n].cell != expected.cells[n].cell) return "other cells are cut";
        if (rows[n].pieces != expected.cells[n].pieces) return "pieces are counted wrongly";
        if (std::memcmp(&rows[n], &expected.cells[n], sizeof rows[n]) != 0) return "fractions of cells are wrong";
    }
    // The stores: of words, doubles, floats and full cells.
    const auto [nx, ny, nz] = expected.counts();
    const std::size_t cells = nx * ny * nz;
    const auto words = pool->lease(rows.size() * 4, "pieces"), numbers = pool->lease(rows.size() * 24, "centroids"),
               floats = pool->lease(rows.size() * 4, "areas"), full = pool->lease(cells, "full cells");
    const engine::Launches launches(tools.queue(), tools.context.kernels());
    cuts.enqueue_store(tools, launches, {(*words)(), 0, 4, 4, 1, offsetof(CellFraction, pieces), StoredNumbers::words});
    cuts.enqueue_store(tools, launches,
                       {(*numbers)(), 0, 8, static_cast<std::ptrdiff_t>(8 * rows.size()), 3,
                        offsetof(CellFraction, centroid), StoredNumbers::doubles});
    cuts.enqueue_store(tools, launches, {(*floats)(), 0, 4, 4, 1, offsetof(CellFraction, area), StoredNumbers::floats});
    cuts.enqueue_store_full(tools, launches, {(*full)(), 0, 1, 1, 1, 0, StoredNumbers::words});
    std::vector<std::uint32_t> pieces(rows.size());
    std::vector<double> centroids(3 * rows.size());
    std::vector<float> areas(rows.size());
    std::vector<std::uint8_t> are_full(cells);
    device::read_values(tools.context, *words, pieces);
    device::read_values(tools.context, *numbers, centroids);
    device::read_values(tools.context, *floats, areas);
    device::read_values(tools.context, *full, are_full);
    for (std::size_t n = 0; n < rows.size(); ++n)
        if (pieces[n] != rows[n].pieces || areas[n] != static_cast<float>(rows[n].area) ||
            centroids[n] != rows[n].centroid[0] || centroids[rows.size() + n] != rows[n].centroid[1] ||
            centroids[2 * rows.size() + n] != rows[n].centroid[2])
            return "rows are stored wrongly";
    for (std::size_t n = 0; n < cells; ++n)
        if (are_full[n] != expected.is_full(n)) return "cells are full that are not, or the reverse";
    return std::nullopt;
}

}  // namespace

TestSubject fractions_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "fractions of cells";
    subject.build = [&device, &programs](const device::BuildWatch& watch) {
        const std::shared_ptr<device::BufferPool> none;
        std::vector<cl::Program> built =
            cutting::fraction_programs({device::context_of(device), none, programs}, watch);
        built.push_back(programs.scan.get(watch));
        built.push_back(programs.radix_sort.get(watch));
        return built;
    };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        for (const char* const convention : {"plain", "amrex"})
            if (auto difference = difference_of_rows(device, programs, FractionOptions::of(convention)))
                return difference;
        return std::nullopt;
    };
    return subject;
}

}  // namespace clsdf::checks
