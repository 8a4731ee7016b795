#include "core/files.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "io/field_files.hpp"
#include "io/nvdb_tree.hpp"

#include <clsdf/error.hpp>
#include <clsdf/sparse.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

using namespace nvdb;
using BrickValues = std::array<float, brick_samples>;  // x fastest

Brick brick_at(const Index3& sample) {
    Brick brick{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        brick[axis] = static_cast<std::int32_t>(sample[axis] >> Leaf::log_side);
    return brick;
}

/// Bricks without leaves that are inside: bits for each lower node that has any.
class InsideBricks : public InsideTiles {
public:
    /// `count` bricks from this one on along x.
    void add(Brick brick, std::int64_t count) {
        while (count > 0) {
            const Brick first = node_of(brick);
            Bits& bits = bits_[first];
            std::size_t entry = 0;
            for (std::size_t axis = 0; axis < 3; ++axis)
                entry = entry << Lower::log | static_cast<std::size_t>(brick[axis] - first[axis]);
            constexpr std::size_t next_x = std::size_t{1} << 2 * Lower::log;
            for (; count > 0 && entry < Lower::child_count; --count, ++brick[0], entry += next_x)
                bits[entry / 64] |= std::uint64_t{1} << entry % 64;
        }
    }

    Share find(const Brick& first, Bits& bits) const override {
        const auto found = bits_.find(first);
        if (found == bits_.end()) return Share::none;
        bits = found->second;
        const bool has_all = std::ranges::all_of(bits, [](std::uint64_t word) { return word == ~std::uint64_t{0}; });
        return has_all ? Share::all : Share::some;
    }

private:
    static Brick node_of(const Brick& brick) {
        Brick first = brick;
        for (std::int32_t& index : first) index = index >> log_lower_bricks << log_lower_bricks;
        return first;
    }
    struct Hash {
        std::size_t operator()(const Brick& brick) const {
            std::uint64_t sum = 0;
            for (const std::int32_t index : brick)
                sum = (sum ^ static_cast<std::uint32_t>(index)) * 0x9E3779B97F4A7C15U;
            return static_cast<std::size_t>(sum ^ sum >> 32);
        }
    };

    std::unordered_map<Brick, Bits, Hash> bits_;
};

/// Bricks in the order in which they come, in an unfinished file beside the final one: the final order is known only
/// when all of them have come. The file never gets a name.
class BrickStore {
public:
    explicit BrickStore(const std::string& path)
        : path_(path), file_(path), descriptor_(::open(file_.temporary().c_str(), O_RDWR | O_CLOEXEC)) {
        if (descriptor_.number() < 0) fail(errno);
    }

    void add(const BrickValues& values) {
        pending_.push_back(values);
        if (pending_.size() == most_pending) flush();
    }

    void flush() {
        std::span<const std::byte> bytes = std::as_bytes(std::span(pending_));
        while (!bytes.empty()) {
            const ssize_t count = ::write(descriptor_.number(), bytes.data(), bytes.size());
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) fail(count < 0 ? errno : ENOSPC);
            bytes = bytes.subspan(static_cast<std::size_t>(count));
        }
        pending_.clear();
    }

    /// After flush(). May be called by many threads.
    void read(std::size_t number, BrickValues& values) const {
        const ReadResult result = read_in_parallel(descriptor_, std::uint64_t{number} * sizeof(BrickValues),
                                                   std::as_writable_bytes(std::span(values)));
        if (result.bytes != sizeof(BrickValues)) fail(result.error != 0 ? result.error : EIO);
    }

private:
    static constexpr std::size_t most_pending = 256;

    [[noreturn]] void fail(int error) const {
        throw Error(ErrorCode::output_failure,
                    fmt::format("cannot write '{}': {}", path_, std::generic_category().message(error)));
    }

    std::string path_;
    AtomicFile file_;
    Descriptor descriptor_;
    std::vector<BrickValues> pending_;
};

/// What becomes of a brick: a leaf, a tile that is inside, or nothing if the background suffices.
enum class Kind : std::uint8_t { leaf, inside, outside };

/// By those of its samples that lie in the grid. So the tree is a function of the field.
Kind kind_of(const Brick& brick, const float* values, const Grid& grid, const Fill& fill) {
    std::array<std::int64_t, 3> begin{}, end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = grid.first[axis] - brick[axis] * Leaf::side;
        begin[axis] = std::clamp<std::int64_t>(first, 0, Leaf::side);
        end[axis] = std::clamp<std::int64_t>(first + grid.size[axis], 0, Leaf::side);
    }
    bool all_inside = true, all_outside = true;
    for (std::int64_t z = begin[2]; z < end[2]; ++z)
        for (std::int64_t y = begin[1]; y < end[1]; ++y) {
            for (std::int64_t x = begin[0]; x < end[0]; ++x) {
                const float value = values[x + 8 * y + 64 * z];
                all_inside = all_inside && fill.is_inside(value);
                all_outside = all_outside && fill.is_outside(value);
            }
            if (!all_inside && !all_outside) return Kind::leaf;
        }
    return all_outside ? Kind::outside : Kind::inside;
}

/// A file that is written brick by brick, in any order.
class NvdbFile {
public:
    NvdbFile(const std::string& path, const FieldDescription& field)
        : path_(path), field_(field), fill_(field.band), file_(path), store_(path) {}

    const FieldDescription& field() const { return field_; }
    const Fill& fill() const { return fill_; }

    void add_leaf(const Brick& brick, const BrickValues& values) {
        leaves_.push_back({brick, leaves_.size()});
        store_.add(values);
    }
    void add_inside(const Brick& brick, std::int64_t count) { inside_.add(brick, count); }

    /// `background` is the value outside the grid.
    void finish(float background) {
        store_.flush();
        std::ranges::sort(leaves_, precedes, &StoredLeaf::brick);
        std::vector<Brick> bricks;
        bricks.reserve(leaves_.size());
        for (const StoredLeaf& leaf : leaves_) bricks.push_back(leaf.brick);
        TreeWriter tree(file_, path_, field_, {fill_, background}, std::move(bricks), inside_);
        constexpr std::size_t batch = 1024;
        std::vector<BrickValues> values(std::min(batch, leaves_.size()));
        std::vector<const float*> places;
        for (const BrickValues& brick : values) places.push_back(brick.data());
        for (std::size_t begin = 0; begin < leaves_.size(); begin += batch) {
            const std::size_t count = std::min(batch, leaves_.size() - begin);
            for_each_index(
                count, [&](std::size_t i) { store_.read(leaves_[begin + i].number, values[i]); }, 64);
            tree.append(std::span(places).first(count));
        }
        tree.finish();
        file_.commit();
    }

private:
    struct StoredLeaf {
        Brick brick;
        std::size_t number;
    };

    std::string path_;
    FieldDescription field_;
    Fill fill_;
    AtomicFile file_;
    BrickStore store_;
    std::vector<StoredLeaf> leaves_;
    InsideBricks inside_;
};

void check_field(const std::string& path, const FieldDescription& field) {
    check_nvdb(path, {});
    if (field.positive_inside)
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: NanoVDB's programs take a field to be negative inside; write it so, or choose "
                                "another format",
                                path));
    // A brick's samples have 32-bit indices, also those beyond the grid.
    constexpr std::int64_t end = std::int64_t{1} << 31;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = field.grid.first[axis], last = first + field.grid.size[axis] - 1;
        if (first < -end || last >= end - Leaf::side)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: the lattice's samples {} to {} along {} exceed the 32 bits of a NanoVDB "
                                    "index; move the lattice's origin nearer, or choose another format",
                                    path, first, last, "xyz"[axis]));
    }
}

/// Dense slabs, divided into bricks layer by layer.
class NvdbWriter : public FormatWriter {
public:
    NvdbWriter(const std::string& path, const FieldDescription& field) : file_(path, field) {
        const Grid& grid = field.grid;
        first_ = brick_at(grid.first);
        const Brick last = brick_at({grid.first[0] + grid.size[0] - 1, grid.first[1] + grid.size[1] - 1, 0});
        for (std::size_t axis = 0; axis < 2; ++axis)
            counts_[axis] = static_cast<std::size_t>(last[axis] - first_[axis]) + 1;
        columns_.resize(counts_[0] * counts_[1]);
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        const Grid& grid = file_.field().grid;
        const auto slice = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
        const std::int64_t begin = grid.first[2] + first_slice;
        const std::int64_t end = begin + static_cast<std::int64_t>(slab.distance().size() / slice);
        if (!std::isfinite(file_.fill().outside))
            for (const float value : slab.distance())
                if (std::isfinite(value)) farthest_ = std::max(farthest_, value);
        for (std::int64_t z = begin; z < end;) {
            const std::int64_t layer = z >> Leaf::log_side;
            const std::int64_t next = std::min(end, (layer + 1) * Leaf::side);
            const std::span<const float> slices = slab.distance().subspan(static_cast<std::size_t>(z - begin) * slice);
            for_each_index(
                columns_.size(), [&](std::size_t column) { add_slices(column, slices.data(), z, next); }, 16);
            z = next;
            if (z == (layer + 1) * Leaf::side || z == grid.first[2] + grid.size[2])
                finish_layer(static_cast<std::int32_t>(layer));
        }
    }

    void finish() override {
        // Programs compute with the background, so it must be finite: if the band has no end, it is the largest
        // distance.
        file_.finish(std::isfinite(file_.fill().outside) ? file_.fill().outside : farthest_);
    }

private:
    /// A brick of the layer. Its samples are equal and beyond the band, as long as it has no values.
    struct Column {
        std::unique_ptr<BrickValues> values;
        float tile = 0;
        bool is_begun = false;
    };

    Brick brick_of(std::size_t column, std::int32_t layer) const {
        return {first_[0] + static_cast<std::int32_t>(column % counts_[0]),
                first_[1] + static_cast<std::int32_t>(column / counts_[0]), layer};
    }

    /// Slices [z, end) of the lattice; `slices` begins with the first of them.
    void add_slices(std::size_t number, const float* slices, std::int64_t z, std::int64_t end) {
        const Grid& grid = file_.field().grid;
        Column& column = columns_[number];
        const Brick brick = brick_of(number, 0);
        std::array<std::int64_t, 2> from{}, to{}, at{};  // in the slice, and in the brick
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const std::int64_t first = brick[axis] * Leaf::side - grid.first[axis];
            from[axis] = std::max<std::int64_t>(first, 0);
            to[axis] = std::min(first + Leaf::side, grid.size[axis]);
            at[axis] = from[axis] - first;
        }
        const auto count = static_cast<std::size_t>(to[0] - from[0]);
        const auto for_each_row = [&](const auto& f) {
            for (std::int64_t k = z; k < end; ++k)
                for (std::int64_t j = from[1]; j < to[1]; ++j)
                    f(slices + from[0] + grid.size[0] * (j + grid.size[1] * (k - z)),
                      static_cast<std::size_t>(at[0] + 8 * (at[1] + j - from[1]) + 64 * (k & (Leaf::side - 1))));
        };
        if (!column.values) {
            const float first = slices[from[0] + grid.size[0] * from[1]];
            const float tile = column.is_begun ? column.tile : first;
            bool is_tile = file_.fill().is_beyond(tile);
            for_each_row([&](const float* row, std::size_t) {
                for (std::size_t i = 0; i < count; ++i) is_tile = is_tile && Fill::is_same(row[i], tile);
            });
            column.tile = tile;
            column.is_begun = true;
            if (is_tile) return;
            column.values = std::make_unique<BrickValues>();
            column.values->fill(tile);  // slices before
        }
        for_each_row([&](const float* row, std::size_t place) {
            std::copy_n(row, count, column.values->begin() + static_cast<std::ptrdiff_t>(place));
        });
    }

    void finish_layer(std::int32_t layer) {
        for (std::size_t number = 0; number < columns_.size(); ++number) {
            Column& column = columns_[number];
            const Brick brick = brick_of(number, layer);
            if (column.values) {
                file_.add_leaf(brick, *column.values);
            } else if (!file_.fill().is_outside(column.tile)) {
                file_.add_inside(brick, 1);
            }
            column = Column{};
        }
    }

    NvdbFile file_;
    Brick first_{};
    std::array<std::size_t, 2> counts_{};
    std::vector<Column> columns_;
    float farthest_ = 0;
};

/// Layers of a sparse field.
class SparseNvdbWriter : public SparseFormatWriter {
public:
    SparseNvdbWriter(const std::string& path, const FieldDescription& field) : file_(path, field) {}

    void append(const SparseSlab& slab) override {
        const std::span<const float> distance = slab.values.distance();
        std::vector<Kind> kinds(slab.bricks.size());
        for_each_index(
            kinds.size(),
            [&](std::size_t i) {
                kinds[i] = kind_of(brick_at(slab.bricks[i]), distance.data() + i * brick_samples, file_.field().grid,
                                   file_.fill());
            },
            64);
        for (std::size_t i = 0; i < kinds.size(); ++i) {
            const Brick brick = brick_at(slab.bricks[i]);
            if (kinds[i] == Kind::inside) file_.add_inside(brick, 1);
            if (kinds[i] != Kind::leaf) continue;
            BrickValues values;
            std::copy_n(distance.data() + i * brick_samples, brick_samples, values.begin());
            file_.add_leaf(brick, values);
        }
        for (const BrickRun& run : slab.inside) file_.add_inside(brick_at(run.first), run.count);
    }

    void finish() override { file_.finish(file_.fill().outside); }

private:
    NvdbFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> nvdb_writer(const std::string& path, const FieldDescription& field, OutputSet) {
    check_field(path, field);
    return std::make_unique<NvdbWriter>(path, field);
}

std::unique_ptr<SparseFormatWriter> sparse_nvdb_writer(const std::string& path, const FieldDescription& field,
                                                       OutputSet) {
    check_field(path, field);
    return std::make_unique<SparseNvdbWriter>(path, field);
}

void check_nvdb(const std::string& path, OutputSet) {
    if (!is_supported)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("{}: NanoVDB's files are little-endian, and this machine is not; choose another format", path));
}

}  // namespace clsdf
