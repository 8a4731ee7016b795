#include "core/files.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "io/fields/bricks.hpp"
#include "io/fields/nvdb_tree.hpp"
#include "io/fields/sparse_files.hpp"

#include <clsdf/sparse.hpp>

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

/// Keeps packed leaves in an unfinished file until finish(), because the leaves have another order in the final one.
class NvdbWriter : public SparseFormatWriter {
public:
    NvdbWriter(const std::string& path, const FieldDescription& field)
        : path_(path), field_(field), fill_(field.band), background_(fill_), file_(path), spill_(path) {}

    void append(const SparseSlab& slab) override {
        background_.add(slab);
        constexpr std::size_t batch = 1024;
        const std::size_t bricks = slab.bricks.size();
        std::vector<PackedLeaf> packed(std::min(batch, bricks));
        std::vector<BrickKind> kinds(packed.size());
        std::vector<std::byte> bytes;
        for (std::size_t begin = 0; begin < bricks; begin += batch) {
            const std::size_t count = std::min(batch, bricks - begin);
            for_each_index(
                count,
                [&](std::size_t i) {
                    const Index3& brick = slab.bricks[begin + i];
                    const float* const values = slab.values.distance().data() + (begin + i) * brick_samples;
                    kinds[i] = kind_of(BrickPart(brick, field_.grid), values, fill_);
                    if (kinds[i] == BrickKind::values) pack_leaf(brick, values, field_.grid, fill_, packed[i]);
                },
                16);
            bytes.clear();
            for (std::size_t i = 0; i < count; ++i) {
                const Brick brick = brick_at(slab.bricks[begin + i]);
                if (kinds[i] == BrickKind::inside) inside_.add(brick, 1);
                if (kinds[i] != BrickKind::values) continue;
                const std::size_t values = packed[i].count();
                leaves_.push_back({brick, static_cast<std::uint16_t>(values), spill_.size() + bytes.size()});
                const auto kept = std::as_bytes(std::span(&packed[i], 1)).first(PackedLeaf::bytes(values));
                bytes.insert(bytes.end(), kept.begin(), kept.end());
            }
            spill_.append(bytes);
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
        std::vector<PackedLeaf> packed(std::min(batch, leaves_.size()));
        for (std::size_t begin = 0; begin < leaves_.size(); begin += batch) {
            const std::size_t count = std::min(batch, leaves_.size() - begin);
            for_each_index(
                count,
                [&](std::size_t i) {
                    const StoredLeaf& leaf = leaves_[begin + i];
                    spill_.read(leaf.offset,
                                std::as_writable_bytes(std::span(&packed[i], 1)).first(PackedLeaf::bytes(leaf.values)));
                },
                64);
            tree.append(std::span(packed).first(count));
        }
        tree.finish();
        file_.commit();
    }

private:
    struct StoredLeaf {
        Brick brick;
        std::uint16_t values;  ///< that are active
        std::uint64_t offset;  ///< of its PackedLeaf in the unfinished file
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
        refuse_unsupported(
            "{}: NanoVDB's programs take a field to be negative inside; write it so, or choose "
            "another format",
            path);
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
        refuse_unsupported("{}: NanoVDB's files are little-endian, and this machine is not; choose another format",
                           path);
}

}  // namespace clsdf
