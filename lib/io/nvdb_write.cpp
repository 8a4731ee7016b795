#include "core/files.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "io/bricks.hpp"
#include "io/nvdb_tree.hpp"
#include "io/sparse_files.hpp"

#include <clsdf/error.hpp>
#include <clsdf/sparse.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
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

/// Keeps bricks in an unfinished file until finish(), because the leaves have another order in the final one.
class NvdbWriter : public SparseFormatWriter {
public:
    NvdbWriter(const std::string& path, const FieldDescription& field)
        : path_(path), field_(field), fill_(field.band), background_(fill_), file_(path), spill_(path) {}

    void append(const SparseSlab& slab) override {
        background_.add(slab);
        const std::span<const float> distance = slab.values.distance();
        std::vector<BrickKind> kinds(slab.bricks.size());
        for_each_index(
            kinds.size(),
            [&](std::size_t i) {
                kinds[i] = kind_of(BrickPart(slab.bricks[i], field_.grid), distance.data() + i * brick_samples, fill_);
            },
            64);
        for (std::size_t i = 0; i < kinds.size();) {
            const Brick brick = brick_at(slab.bricks[i]);
            if (kinds[i] == BrickKind::inside) inside_.add(brick, 1);
            if (kinds[i] != BrickKind::values) {
                ++i;
                continue;
            }
            const std::size_t begin = i;
            for (; i < kinds.size() && kinds[i] == BrickKind::values; ++i)
                leaves_.push_back({brick_at(slab.bricks[i]), static_cast<std::uint32_t>(leaves_.size())});
            spill_.append(std::as_bytes(distance.subspan(begin * brick_samples, (i - begin) * brick_samples)));
        }
        for (const BrickRun& run : slab.inside) inside_.add(brick_at(run.first), run.count);
    }

    void finish() override {
        std::ranges::sort(leaves_, precedes, &StoredLeaf::brick);
        std::vector<Brick> bricks;
        bricks.reserve(leaves_.size());
        for (const StoredLeaf& leaf : leaves_) bricks.push_back(leaf.brick);
        TreeWriter tree(file_, path_, field_, {fill_, background_.value()}, std::move(bricks), inside_);
        constexpr std::size_t batch = 1024;
        std::vector<BrickValues> values(std::min(batch, leaves_.size()));
        std::vector<const float*> places;
        for (const BrickValues& brick : values) places.push_back(brick.data());
        for (std::size_t begin = 0; begin < leaves_.size(); begin += batch) {
            const std::size_t count = std::min(batch, leaves_.size() - begin);
            for_each_index(
                count,
                [&](std::size_t i) {
                    spill_.read(std::uint64_t{leaves_[begin + i].number} * sizeof(BrickValues),
                                std::as_writable_bytes(std::span(values[i])));
                },
                64);
            tree.append(std::span(places).first(count));
        }
        tree.finish();
        file_.commit();
    }

private:
    struct StoredLeaf {
        Brick brick;
        std::uint32_t number;  ///< in the order of arrival; a tree has at most 2^32 leaves
    };

    std::string path_;
    FieldDescription field_;
    Fill fill_;
    Background background_;
    AtomicFile file_;
    SpillFile spill_;
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
    check_indices(path, field.grid, "a NanoVDB index");
}

}  // namespace

std::unique_ptr<FormatWriter> nvdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return slices_as_bricks(field, outputs, sparse_nvdb_writer(path, field, outputs));
}

std::unique_ptr<SparseFormatWriter> sparse_nvdb_writer(const std::string& path, const FieldDescription& field,
                                                       OutputSet) {
    check_field(path, field);
    return std::make_unique<NvdbWriter>(path, field);
}

void check_nvdb(const std::string& path, OutputSet) {
    if (!is_supported)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("{}: NanoVDB's files are little-endian, and this machine is not; choose another format", path));
}

}  // namespace clsdf
