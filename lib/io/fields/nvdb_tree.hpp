#pragma once

#include "core/files.hpp"
#include "io/fields/bricks.hpp"
#include "io/fields/level_set.hpp"
#include "io/fields/nvdb_layout.hpp"

#include <clsdf/field.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace clsdf::nvdb {

/// A brick of 8^3 samples of the lattice: its first sample, divided by 8.
using Brick = std::array<std::int32_t, 3>;

/// Bricks per side of a lower and of an upper node.
inline constexpr unsigned log_lower_bricks = Lower::log_side - Leaf::log_side;
inline constexpr unsigned log_upper_bricks = Upper::log_side - Leaf::log_side;

/// The order of a tree's leaves: by upper nodes, by lower nodes, by leaves, each in the order x, y, z with z fastest.
bool precedes(const Brick& one, const Brick& other);

/// A leaf's samples in its own order, z fastest, without the distances beyond the band. So leaves are kept until their
/// places in the file are known.
struct PackedLeaf {
    LeafMasks masks;                               ///< samples in neither have the background
    std::array<float, Leaf::sample_count> values;  ///< of the active samples, one after the other

    std::size_t count() const;  ///< of active samples
    /// The bytes of the masks and of so many values.
    static constexpr std::size_t bytes(std::size_t count) { return sizeof(masks) + count * sizeof(float); }
};

/// samples: of the brick, x fastest. Those beyond the grid are neither active nor inside.
void pack_leaf(const Index3& brick, const float* samples, const Grid& grid, const Fill& beyond, PackedLeaf& packed);

/// The sign of the bricks that have no leaf: a brick is a tile that is inside, or the background.
class InsideTiles {
public:
    InsideTiles() = default;
    InsideTiles(const InsideTiles&) = delete;
    InsideTiles& operator=(const InsideTiles&) = delete;
    virtual ~InsideTiles() = default;

    enum class Share { none, some, all };
    using Bits = Lower::Mask;

    /// How many of the 16^3 bricks from `first` on are inside. If it is `some`, their bits are set, in the order of a
    /// lower node's children; all bits were 0. Bricks that have leaves are not inside.
    virtual Share find(const Brick& first, Bits& bits) const = 0;
};

struct TreeFill {
    Fill beyond;       ///< samples of these values are inactive
    float background;  ///< the value beyond the grid, and where there is neither a leaf nor a tile
};

/// Statistics of active values, and the box of their samples. The sums leave out values that are not finite.
struct Summary {
    std::uint64_t count = 0;
    std::uint64_t finite_count = 0;
    double average = 0;
    double squares = 0;  ///< the sum of (value - average)^2
    float least = std::numeric_limits<float>::infinity();
    float greatest = -std::numeric_limits<float>::infinity();
    IntBox box{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};

    void add(const Summary& other);
    /// Without an active value, the extrema are the background.
    Statistics statistics(float background) const;
};

/// Writes a tree leaf by leaf. It keeps the leaves' bricks and about 100 bytes for each lower node; nodes are made when
/// they are written.
class TreeWriter {
public:
    /// `leaves` are in the order of precedes(), and contain samples of the grid. Everything that is passed by reference
    /// must outlive this. Throws Error(output_failure), or Error(unsupported) for too many nodes.
    TreeWriter(AtomicFile& file, const std::string& path, const FieldDescription& field, const TreeFill& fill,
               std::vector<Brick> leaves, const InsideTiles& tiles);

    const std::vector<Brick>& leaves() const { return leaves_; }

    /// The samples of the next leaves.
    void append(std::span<const PackedLeaf> packed);

    /// Writes everything else. All leaves must have been appended. The file is not committed.
    void finish();

private:
    struct LowerPlan {
        Brick first{};
        std::size_t first_leaf = 0;
        std::size_t leaf_count = 0;
        Summary summary;
    };
    struct UpperPlan {
        Brick first{};
        std::size_t first_lower = 0;
        std::size_t lower_count = 0;
        Upper::Mask inside{};  // tiles
        Summary summary;
    };
    struct RootEntry {
        Brick first;
        bool is_child;  // of the next upper node; else it is a tile that is inside
    };

    void plan();
    void plan_upper(const Brick& first);
    void write_head(const Summary& whole);
    void write_upper(const UpperPlan& upper);
    void write_lower(const LowerPlan& lower);
    template <class Value>
    void write(const Value& value) {
        file_.write(std::as_bytes(std::span(&value, 1)));
    }

    AtomicFile& file_;
    const std::string& path_;
    const FieldDescription& field_;
    TreeFill fill_;
    std::vector<Brick> leaves_;
    const InsideTiles& tiles_;

    std::vector<RootEntry> root_;
    std::vector<UpperPlan> uppers_;
    std::vector<LowerPlan> lowers_;
    std::size_t planned_leaves_ = 0;

    std::size_t appended_ = 0;
    std::size_t lower_ = 0;  // that of the next leaf

    // Offsets from GridData.
    std::uint64_t uppers_begin_ = 0;
    std::uint64_t lowers_begin_ = 0;
    std::uint64_t leaves_begin_ = 0;
    std::uint64_t blind_begin_ = 0;
    std::uint64_t bytes_ = 0;
    std::string description_;  // padded with zeros
    std::size_t description_length_ = 0;
};

}  // namespace clsdf::nvdb
