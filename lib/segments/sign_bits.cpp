#include "segments/sign_bits.hpp"

#include "core/parallel.hpp"
#include "lattice/layout_of.hpp"
#include "segments/device_samples.hpp"
#include "segments/sample_sides.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace clsdf::segments {

namespace {

/// The samples of all bricks of a part.
SampleBox box_of_bricks(const Grid& grid, const Layout& layout, double per_unit) {
    Grid bricks = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        bricks.first[axis] = std::int64_t{layout.brick_first[axis]} * CLSDF_BRICK;
        bricks.size[axis] = std::int64_t{layout.bricks[axis]} * CLSDF_BRICK;
    }
    return {bricks, {}, per_unit};
}

}  // namespace

std::optional<device::BufferPool::Lease> sign_bits_by_kernels(const engine::DeviceTools& tools,
                                                              const engine::ShortLaunches& launches,
                                                              const engine::CrossedMesh& mesh, SignRule rule,
                                                              const Grid& grid, const Layout& layout) {
    const DeviceSamples samples(tools, box_of_bricks(grid, layout, mesh.per_unit),
                                static_cast<std::size_t>(layout.sign_words));
    auto sides = engine::find_exact_sides(tools, launches, mesh, rule, samples.rows, *samples.at);
    if (!sides) return std::nullopt;
    return std::move(sides->bits);
}

device::BufferPool::Lease sign_bits_by_host(const engine::DeviceTools& tools, const engine::CrossedFaces& faces,
                                            SignRule rule, const Grid& grid, const Layout& layout,
                                            const std::vector<engine::RecordRange>* near) {
    device::HostFilling filling(tools.context, tools.pool, engine::sign_bytes(layout), "sign bits");
    auto* const words = static_cast<std::uint32_t*>(filling.memory());
    const SampleBox box = box_of_bricks(grid, layout, faces.per_unit);
    const BoxSides sides(faces, rule, box, near);
    const auto of_row = static_cast<std::size_t>(layout.sign_words);
    constexpr std::size_t rows_together = 1024;
    for_each_index(
        box.row_count(),
        [&](std::size_t row) {
            const std::uint64_t* const from = sides.row(row);
            for (std::size_t word = 0; word < of_row; ++word)
                words[row * of_row + word] = static_cast<std::uint32_t>(from[word / 2] >> (word % 2 * 32));
        },
        rows_together);
    return filling.finish();
}

}  // namespace clsdf::segments
