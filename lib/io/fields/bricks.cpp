#include "io/fields/bricks.hpp"

#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Eight flags, bytes of 0 or 1, as eight bits.
std::uint64_t bits_of(const std::uint8_t* flags) {
    std::uint64_t bytes = 0;
    for (unsigned i = 0; i < 8; ++i) bytes |= std::uint64_t{flags[i]} << 8 * i;
    return bytes * 0x0102040810204080U >> 56;
}

}  // namespace

LeafMasks leaf_masks(const float* ordered, const Fill& fill, const BrickPart& part) {
    const auto outside = std::bit_cast<std::uint32_t>(fill.outside), inside = std::bit_cast<std::uint32_t>(fill.inside);
    // No sample is beyond a band without end.
    const auto has_outside = static_cast<std::uint8_t>(std::isfinite(fill.outside)),
               has_inside = static_cast<std::uint8_t>(std::isfinite(fill.inside));
    // Loops that compilers turn into vectors.
    std::array<std::uint8_t, brick_samples> is_inside, is_active;  // NOLINT: all are set
    for (std::size_t i = 0; i < brick_samples; ++i) {
        const auto bits = std::bit_cast<std::uint32_t>(ordered[i]);
        const auto of_inside = static_cast<std::uint8_t>(has_inside & static_cast<std::uint8_t>(bits == inside));
        const auto of_outside = static_cast<std::uint8_t>(has_outside & static_cast<std::uint8_t>(bits == outside));
        is_inside[i] = of_inside;
        is_active[i] = static_cast<std::uint8_t>(1 ^ (of_inside | of_outside));
    }
    std::uint64_t of_grid = 0;
    for (std::int64_t y = part.begin[1]; y < part.end[1]; ++y)
        for (std::int64_t z = part.begin[2]; z < part.end[2]; ++z) of_grid |= std::uint64_t{1} << (8 * y + z);
    LeafMasks masks;
    for (auto x = static_cast<std::size_t>(part.begin[0]); x < static_cast<std::size_t>(part.end[0]); ++x) {
        for (std::size_t y = 0; y < 8; ++y) {
            masks.active[x] |= bits_of(is_active.data() + 64 * x + 8 * y) << 8 * y;
            masks.inside[x] |= bits_of(is_inside.data() + 64 * x + 8 * y) << 8 * y;
        }
        masks.active[x] &= of_grid;
        masks.inside[x] &= of_grid;
    }
    return masks;
}

void check_indices(const std::string& path, const Grid& grid, const char* reader) {
    constexpr std::int64_t end = std::int64_t{1} << 31;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = grid.first[axis], last = first + grid.size[axis] - 1;
        if (first < -end || last >= end - brick_side)
            refuse_unsupported(
                "{}: the lattice's samples {} to {} along {} exceed the 32 bits of {}; move the "
                "lattice's origin nearer, or choose .nrrd, .npy or .h5",
                path, first, last, "xyz"[axis], reader);
    }
}

namespace {

class SlicesAsBricks final : public FormatWriter {
public:
    SlicesAsBricks(const FieldDescription& field, OutputSet outputs, std::unique_ptr<SparseFormatWriter> bricks)
        : infos_(infos_of(outputs)),
          grid_(field.grid),
          whole_(in_whole_bricks(field.grid)),
          fill_(field.band),
          bricks_(std::move(bricks)),
          pending_(infos_.size()),
          values_(infos_.size()) {
        for (std::size_t axis = 0; axis < 2; ++axis)
            columns_[axis] = static_cast<std::size_t>(whole_.size[axis] / brick_side);
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        const auto slice = static_cast<std::size_t>(grid_.size[0] * grid_.size[1]);
        const std::int64_t end = grid_.first[2] + grid_.size[2];
        const auto slices = static_cast<std::int64_t>(slab.distance().size() / slice);
        for (std::int64_t k = 0; k < slices;) {
            const std::int64_t z = grid_.first[2] + first_slice + k;
            const std::int64_t layer = z & ~(brick_side - 1);
            const std::int64_t layer_end = std::min(layer + brick_side, end);
            const std::int64_t count = std::min(slices - k, layer_end - z);
            Parts parts;
            for (std::size_t i = 0; i < infos_.size(); ++i) {
                const std::size_t bytes = slice * infos_[i].sample_bytes();
                const std::span<const std::byte> part =
                    slab.bytes(infos_[i].output)
                        .subspan(static_cast<std::size_t>(k) * bytes, static_cast<std::size_t>(count) * bytes);
                const bool is_layer = count == layer_end - std::max(layer, grid_.first[2]);
                if (!is_layer) pending_[i].insert(pending_[i].end(), part.begin(), part.end());
                parts.push_back(is_layer ? part : pending_[i]);
            }
            k += count;
            if (z + count < layer_end) continue;
            write_layer(layer, parts);
            for (std::vector<std::byte>& bytes : pending_) bytes.clear();
        }
    }

    void finish() override { bricks_->finish(); }

private:
    using Parts = std::vector<std::span<const std::byte>>;  // the layer's slices, of each output

    Index3 brick_at(std::size_t column, std::int64_t layer) const {
        return {whole_.first[0] + static_cast<std::int64_t>(column % columns_[0]) * brick_side,
                whole_.first[1] + static_cast<std::int64_t>(column / columns_[0]) * brick_side, layer};
    }

    /// The offset in the layer's slices of a sample of a brick.
    std::size_t offset_in_slices(const Index3& brick, std::size_t sample) const {
        const auto at = static_cast<std::int64_t>(sample);
        const std::int64_t x = brick[0] + at % brick_side - grid_.first[0];
        const std::int64_t y = brick[1] + at / brick_side % brick_side - grid_.first[1];
        const std::int64_t z = brick[2] + at / (brick_side * brick_side) - std::max(brick[2], grid_.first[2]);
        return static_cast<std::size_t>((z * grid_.size[1] + y) * grid_.size[0] + x);
    }

    /// Whether all bytes of a brick's samples in the slices are set.
    bool is_left_out(const Index3& brick, const BrickPart& part, std::span<const std::byte> slices,
                     std::size_t width) const {
        return part.all_rows([&](std::size_t sample, std::size_t count) {
            const std::span<const std::byte> row =
                slices.subspan(offset_in_slices(brick, sample) * width, count * width);
            return std::ranges::all_of(row, [](std::byte byte) { return byte == std::byte{0xFF}; });
        });
    }

    BrickKind kind_in(const Index3& brick, const Parts& parts) const {
        const BrickPart part(brick, grid_);
        for (std::size_t i = 1; i < infos_.size(); ++i)
            if (!is_left_out(brick, part, parts[i], infos_[i].sample_bytes())) return BrickKind::values;
        const auto* const distance = reinterpret_cast<const float*>(parts[0].data());
        std::array<bool, 2> is_all{true, true};  // outside, inside
        part.all_rows([&](std::size_t sample, std::size_t count) {
            const float* const row = distance + offset_in_slices(brick, sample);
            is_all[0] = is_all[0] && std::all_of(row, row + count, [&](float d) { return fill_.is_outside(d); });
            is_all[1] = is_all[1] && std::all_of(row, row + count, [&](float d) { return fill_.is_inside(d); });
            return is_all[0] || is_all[1];
        });
        return is_all[0] ? BrickKind::outside : is_all[1] ? BrickKind::inside : BrickKind::values;
    }

    void write_layer(std::int64_t layer, const Parts& parts) {
        std::vector<BrickKind> kinds(columns_[0] * columns_[1]);
        constexpr std::size_t grain = 16;
        for_each_index(
            kinds.size(), [&](std::size_t column) { kinds[column] = kind_in(brick_at(column, layer), parts); }, grain);
        std::vector<Index3> bricks;
        std::vector<BrickRun> inside;
        for (std::size_t column = 0; column < kinds.size(); ++column) {
            const Index3 brick = brick_at(column, layer);
            if (kinds[column] == BrickKind::values) bricks.push_back(brick);
            if (kinds[column] != BrickKind::inside) continue;
            if (column % columns_[0] > 0 && kinds[column - 1] == BrickKind::inside)
                ++inside.back().count;
            else
                inside.push_back({brick, 1});
        }
        SparseSlab slab{whole_, bricks, {}, inside};
        slab.part.first[2] = layer;
        slab.part.size[2] = brick_side;
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            const std::size_t width = infos_[i].sample_bytes();
            values_[i].resize(bricks.size() * brick_samples * width);
            for_each_index(
                bricks.size(),
                [&](std::size_t n) {
                    const BrickPart part(bricks[n], grid_);
                    std::byte* const room = values_[i].data() + n * brick_samples * width;
                    if (!part.is_whole()) std::memset(room, 0, brick_samples * width);
                    part.all_rows([&](std::size_t sample, std::size_t count) {
                        std::memcpy(room + sample * width,
                                    parts[i].data() + offset_in_slices(bricks[n], sample) * width, count * width);
                        return true;
                    });
                },
                grain);
            slab.values.set(infos_[i].output, values_[i]);
        }
        bricks_->append(slab);
    }

    std::vector<OutputInfo> infos_;
    Grid grid_;
    Grid whole_;  // the grid's bricks
    Fill fill_;
    std::unique_ptr<SparseFormatWriter> bricks_;
    std::array<std::size_t, 2> columns_{};         // bricks of a layer along x and y
    std::vector<std::vector<std::byte>> pending_;  // slices of a layer that is not yet whole
    std::vector<std::vector<std::byte>> values_;   // of the layer's bricks
};

}  // namespace

std::unique_ptr<FormatWriter> slices_as_bricks(const FieldDescription& field, OutputSet outputs,
                                               std::unique_ptr<SparseFormatWriter> bricks) {
    return std::make_unique<SlicesAsBricks>(field, outputs, std::move(bricks));
}

}  // namespace clsdf
