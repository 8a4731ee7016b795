#include "segments/sign_bits.hpp"

#include "core/parallel.hpp"
#include "segments/sample_sides.hpp"

#include <cstddef>

namespace clsdf::segments {

void write_sign_bits(const engine::CrossedFaces& faces, SignRule rule, const Grid& grid, const Layout& layout,
                     const std::vector<engine::RecordRange>* near, std::span<std::uint32_t> words) {
    Grid bricks = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        bricks.first[axis] = std::int64_t{layout.brick_first[axis]} * CLSDF_BRICK;
        bricks.size[axis] = std::int64_t{layout.bricks[axis]} * CLSDF_BRICK;
    }
    const SampleBox box(bricks, {}, faces.per_unit);
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
}

}  // namespace clsdf::segments
