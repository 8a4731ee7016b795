#include "io/fields/nvdb_tree.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "io/fields/field_files.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

namespace clsdf::nvdb {
namespace {

/// The grid's name, as in the file's header: with a zero at its end.
constexpr std::string_view name_with_zero("distance", 9);
constexpr std::string_view grid_name = name_with_zero.substr(0, 8);

/// Leaves that are made at a time.
constexpr std::size_t batch = 1024;

/// The first brick of the upper or lower node that has this one.
Brick node_of(const Brick& brick, unsigned log_bricks) {
    Brick first{};
    for (std::size_t axis = 0; axis < 3; ++axis) first[axis] = brick[axis] >> log_bricks << log_bricks;
    return first;
}

/// The child's entry in a node that begins at `first`; a child has 2^log_child bricks per side.
std::size_t entry_of(const Brick& child, const Brick& first, unsigned log_children, unsigned log_child) {
    std::size_t entry = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        entry = entry << log_children | static_cast<std::size_t>((child[axis] - first[axis]) >> log_child);
    return entry;
}

template <std::size_t Words>
void set_bit(std::array<std::uint64_t, Words>& mask, std::size_t bit) {
    mask[bit / 64] |= std::uint64_t{1} << bit % 64;
}
template <std::size_t Words>
bool has_bit(const std::array<std::uint64_t, Words>& mask, std::size_t bit) {
    return (mask[bit / 64] >> bit % 64 & 1U) != 0;
}

Int3 first_sample(const Brick& brick) {
    Int3 sample{};
    for (std::size_t axis = 0; axis < 3; ++axis) sample[axis] = brick[axis] * static_cast<std::int32_t>(Leaf::side);
    return sample;
}

/// Every brick that has samples of the grid.
struct BrickBox {
    Brick lower;
    Brick upper;

    explicit BrickBox(const Grid& grid) : lower{}, upper{} {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = static_cast<std::int32_t>(grid.first[axis] >> Leaf::log_side);
            upper[axis] = static_cast<std::int32_t>((grid.first[axis] + grid.size[axis] - 1) >> Leaf::log_side);
        }
    }
};

/// Calls f(first) for nodes of 2^log_bricks bricks per side that overlap both boxes of bricks, in the tree's order.
template <class Function>
void for_each_node(const BrickBox& box, unsigned log_bricks, const Function& f) {
    const auto step = std::int32_t{1} << log_bricks;
    const Brick begin = node_of(box.lower, log_bricks);
    for (std::int32_t x = begin[0]; x <= box.upper[0]; x += step)
        for (std::int32_t y = begin[1]; y <= box.upper[1]; y += step)
            for (std::int32_t z = begin[2]; z <= box.upper[2]; z += step) f(Brick{x, y, z});
}

/// Sets least, greatest, count, average and squares from the active values of a leaf. Sums have eight parts, which
/// compilers add together in vectors.
void add_values(std::span<const float> values, Summary& summary) {
    constexpr std::size_t parts = 8;
    std::array<float, parts> least{}, greatest{};
    least.fill(summary.least);
    greatest.fill(summary.greatest);
    std::array<double, parts> sums{};
    std::array<std::uint32_t, parts> finite{};
    const auto each = [&](const auto& take) {
        std::size_t i = 0;
        for (; i + parts <= values.size(); i += parts)
            for (std::size_t part = 0; part < parts; ++part) take(values[i + part], part);
        for (std::size_t part = 0; i + part < values.size(); ++part) take(values[i + part], part);
    };
    each([&](float value, std::size_t part) {
        least[part] = value < least[part] ? value : least[part];
        greatest[part] = value > greatest[part] ? value : greatest[part];
        const bool is_finite = value - value == 0;
        sums[part] += is_finite ? static_cast<double>(value) : 0.0;
        finite[part] += is_finite ? 1U : 0U;
    });
    double sum = 0;
    for (std::size_t part = 0; part < parts; ++part) {
        summary.least = std::min(summary.least, least[part]);
        summary.greatest = std::max(summary.greatest, greatest[part]);
        summary.finite_count += finite[part];
        sum += sums[part];
    }
    summary.count = values.size();
    if (summary.finite_count > 0) summary.average = sum / static_cast<double>(summary.finite_count);
    std::array<double, parts> squares{};
    each([&](float value, std::size_t part) {
        const double difference = static_cast<double>(value) - summary.average;
        squares[part] += value - value == 0 ? difference * difference : 0.0;
    });
    for (const double part : squares) summary.squares += part;
}

/// Sets the box of a leaf's active samples.
void set_box(const Int3& origin, Leaf& leaf, Summary& summary) {
    std::uint64_t all_rows = 0;
    int least_x = Leaf::side, greatest_x = -1;
    for (int x = 0; x < Leaf::side; ++x) {
        const std::uint64_t row = leaf.active[static_cast<std::size_t>(x)];
        if (row == 0) continue;
        all_rows |= row;
        least_x = std::min(least_x, x);
        greatest_x = x;
    }
    if (all_rows == 0) {
        leaf.box_lower = origin;
        return;
    }
    // A bit of a row is 8 y + z.
    std::uint64_t columns = all_rows | all_rows >> 32;
    columns |= columns >> 16;
    columns = (columns | columns >> 8) & 0xFF;
    const std::array least{least_x, std::countr_zero(all_rows) / 8, std::countr_zero(columns)};
    const std::array greatest{greatest_x, (63 - std::countl_zero(all_rows)) / 8, 63 - std::countl_zero(columns)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        summary.box.lower[axis] = origin[axis] + least[axis];
        summary.box.upper[axis] = origin[axis] + greatest[axis];
        leaf.box_extent[axis] = static_cast<std::uint8_t>(greatest[axis] - least[axis]);
    }
    leaf.box_lower = summary.box.lower;
    leaf.flags = has_active_box;
}

Summary make_leaf(const Brick& brick, const PackedLeaf& packed, const TreeFill& fill, Leaf& leaf) {
    std::memset(&leaf, 0, offsetof(Leaf, values));
    leaf.values.fill(fill.background);
    leaf.active = packed.masks.active;
    const float* next = packed.values.data();
    for (std::size_t x = 0; x < leaf.active.size(); ++x) {
        float* const row = leaf.values.data() + 64 * x;
        for (std::uint64_t rest = packed.masks.inside[x]; rest != 0; rest &= rest - 1)
            row[std::countr_zero(rest)] = fill.beyond.inside;
        for (std::uint64_t rest = packed.masks.active[x]; rest != 0; rest &= rest - 1)
            row[std::countr_zero(rest)] = *next++;
    }
    Summary summary;
    add_values({packed.values.data(), next}, summary);
    set_box(first_sample(brick), leaf, summary);
    leaf.statistics = summary.statistics(fill.background);
    return summary;
}

/// The first sample of a node without active values, which also states its place.
IntBox box_of(const Summary& summary, const Brick& first) {
    if (summary.count > 0) return summary.box;
    IntBox box{first_sample(first), first_sample(first)};
    for (std::int32_t& upper : box.upper) --upper;
    return box;
}

std::uint64_t flags_of(const Summary& summary) {
    return summary.count > 0 ? has_active_box : has_no_active_value;
}

std::uint64_t entry_of_value(float value) {
    return std::bit_cast<std::uint32_t>(value);
}

std::int64_t distance_between(std::uint64_t from, std::uint64_t to) {
    return static_cast<std::int64_t>(to) - static_cast<std::int64_t>(from);
}

/// The hash by which NanoVDB finds a grid by its name.
std::uint64_t hash_of(std::string_view name) {
    std::uint64_t hash = 0;
    for (const char letter : name) {
        const std::uint64_t overflow = hash >> 56;
        hash = hash * 67 + static_cast<unsigned char>(letter) + overflow;
    }
    return hash;
}

template <class Real>
Matrices<Real> map_of(const Grid& grid) {
    Matrices<Real> map{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        map.matrix[4 * axis] = static_cast<Real>(grid.spacing[axis]);
        map.inverse[4 * axis] = static_cast<Real>(1 / grid.spacing[axis]);
        map.vector[axis] = static_cast<Real>(grid.origin[axis]);
    }
    map.taper = 1;
    return map;
}

/// The cells of all active samples, from the lowest to one past the highest.
DoubleBox world_box(const Grid& grid, const Summary& whole) {
    DoubleBox box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        constexpr double greatest = std::numeric_limits<double>::max();
        const double lower = whole.box.lower[axis], upper = static_cast<double>(whole.box.upper[axis]) + 1;
        box.lower[axis] = whole.count == 0 ? greatest : grid.origin[axis] + lower * grid.spacing[axis];
        box.upper[axis] = whole.count == 0 ? -greatest : grid.origin[axis] + upper * grid.spacing[axis];
    }
    return box;
}

template <std::size_t Size>
void copy_name(std::string_view name, std::array<char, Size>& room) {
    std::ranges::copy(name, room.begin());
}

template <class Value>
void append_bytes(std::vector<std::byte>& bytes, const Value& value) {
    const auto more = std::as_bytes(std::span(&value, 1));
    bytes.insert(bytes.end(), more.begin(), more.end());
}

}  // namespace

std::size_t PackedLeaf::count() const {
    std::size_t sum = 0;
    for (const std::uint64_t row : masks.active) sum += static_cast<std::size_t>(std::popcount(row));
    return sum;
}

void pack_leaf(const Index3& brick, const float* samples, const Grid& grid, const Fill& beyond, PackedLeaf& packed) {
    std::array<float, Leaf::sample_count> ordered;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are set
    order_as_leaf(samples, ordered.data());
    packed.masks = leaf_masks(ordered.data(), beyond, BrickPart(brick, grid));
    float* next = packed.values.data();
    for (std::size_t x = 0; x < packed.masks.active.size(); ++x) {
        const float* const row = ordered.data() + 64 * x;
        for (std::uint64_t rest = packed.masks.active[x]; rest != 0; rest &= rest - 1)
            *next++ = row[std::countr_zero(rest)];
    }
}

bool precedes(const Brick& one, const Brick& other) {
    for (const unsigned log : {log_upper_bricks, log_lower_bricks, 0U})
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (const auto a = one[axis] >> log, b = other[axis] >> log; a != b) return a < b;
    return false;
}

void Summary::add(const Summary& other) {
    if (other.finite_count > 0) {
        const auto here = static_cast<double>(finite_count), there = static_cast<double>(other.finite_count);
        const double difference = other.average - average, share = there / (here + there);
        average += difference * share;
        squares += other.squares + difference * difference * here * share;
    }
    count += other.count;
    finite_count += other.finite_count;
    least = other.least < least ? other.least : least;
    greatest = other.greatest > greatest ? other.greatest : greatest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], other.box.lower[axis]);
        box.upper[axis] = std::max(box.upper[axis], other.box.upper[axis]);
    }
}

Statistics Summary::statistics(float background) const {
    if (count == 0) return {background, background, 0, 0};
    const double variance = finite_count > 0 ? squares / static_cast<double>(finite_count) : 0;
    return {least, greatest, static_cast<float>(average), static_cast<float>(std::sqrt(variance))};
}

TreeWriter::TreeWriter(AtomicFile& file, const std::string& path, const FieldDescription& field, const TreeFill& fill,
                       std::vector<Brick> leaves, const InsideTiles& tiles)
    : file_(file),
      path_(path),
      field_(field),
      fill_(fill),
      leaves_(std::move(leaves)),
      tiles_(tiles),
      description_(description_text(field)) {
    append_checksum(description_);
    description_length_ = description_.size();
    description_.resize((description_length_ + alignment - 1) / alignment * alignment);
    plan();
    file_.seek(leaves_begin_ + sizeof(FileHeader) + sizeof(FileMetaData) + name_with_zero.size());
}

// Which nodes there are, and where they lie in the file.
void TreeWriter::plan() {
    for_each_node(BrickBox(field_.grid), log_upper_bricks, [&](const Brick& first) { plan_upper(first); });
    if (planned_leaves_ != leaves_.size())
        refuse("{}: {} of {} bricks lie beyond the grid, or are not in the order of a VDB's leaves", path_,
               leaves_.size() - planned_leaves_, leaves_.size());
    if (leaves_.size() > UINT32_MAX)
        refuse_unsupported("{}: {} bricks are more than the 2^32 of a NanoVDB tree; write parts of the field", path_,
                           leaves_.size());
    uppers_begin_ = sizeof(GridData) + sizeof(TreeData) + sizeof(RootData) + root_.size() * sizeof(RootTile);
    lowers_begin_ = uppers_begin_ + uppers_.size() * sizeof(Upper);
    leaves_begin_ = lowers_begin_ + lowers_.size() * sizeof(Lower);
    blind_begin_ = leaves_begin_ + leaves_.size() * sizeof(Leaf);
    bytes_ = blind_begin_ + sizeof(BlindMetaData) + description_.size();
}

void TreeWriter::plan_upper(const Brick& first) {
    constexpr std::int32_t last = (1 << log_upper_bricks) - 1;
    BrickBox box(field_.grid);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::max(box.lower[axis], first[axis]);
        box.upper[axis] = std::min(box.upper[axis], first[axis] + last);
    }
    UpperPlan upper;
    upper.first = first;
    upper.first_lower = lowers_.size();
    std::size_t inside_count = 0;
    for_each_node(box, log_lower_bricks, [&](const Brick& lower) {
        LowerPlan plan;
        plan.first = lower;
        plan.first_leaf = planned_leaves_;
        while (planned_leaves_ < leaves_.size() && node_of(leaves_[planned_leaves_], log_lower_bricks) == lower)
            ++planned_leaves_;
        plan.leaf_count = planned_leaves_ - plan.first_leaf;
        InsideTiles::Bits bits{};
        const InsideTiles::Share share = plan.leaf_count > 0 ? InsideTiles::Share::some : tiles_.find(lower, bits);
        if (share == InsideTiles::Share::some) {
            lowers_.push_back(plan);
        } else if (share == InsideTiles::Share::all) {
            set_bit(upper.inside, entry_of(lower, first, Upper::log, log_lower_bricks));
            ++inside_count;
        }
    });
    upper.lower_count = lowers_.size() - upper.first_lower;
    const bool is_tile = inside_count == Upper::child_count;
    if (inside_count == 0 && upper.lower_count == 0) return;
    root_.push_back({first, !is_tile});
    if (!is_tile) uppers_.push_back(upper);
}

void TreeWriter::append(std::span<const PackedLeaf> packed) {
    std::vector<Leaf> made(std::min(batch, packed.size()));
    std::vector<Summary> summaries(made.size());
    for (std::size_t begin = 0; begin < packed.size(); begin += batch) {
        const std::size_t count = std::min(batch, packed.size() - begin);
        for_each_index(
            count,
            [&](std::size_t i) { summaries[i] = make_leaf(leaves_[appended_ + i], packed[begin + i], fill_, made[i]); },
            16);
        file_.write(std::as_bytes(std::span(made).first(count)));
        for (std::size_t i = 0; i < count; ++i, ++appended_) {
            while (appended_ >= lowers_[lower_].first_leaf + lowers_[lower_].leaf_count) ++lower_;
            lowers_[lower_].summary.add(summaries[i]);
        }
    }
}

void TreeWriter::finish() {
    if (appended_ != leaves_.size()) refuse("{}: {} bricks are missing", path_, leaves_.size() - appended_);
    BlindMetaData blind{};
    blind.data_offset = sizeof(BlindMetaData);
    blind.value_count = description_length_;
    blind.value_bytes = 1;
    copy_name(description_name, blind.name);
    write(blind);
    file_.write(description_);

    Summary whole;
    for (UpperPlan& upper : uppers_) {
        for (std::size_t i = 0; i < upper.lower_count; ++i) upper.summary.add(lowers_[upper.first_lower + i].summary);
        whole.add(upper.summary);
    }
    file_.seek(0);
    write_head(whole);
    for (const UpperPlan& upper : uppers_) write_upper(upper);
    for (const LowerPlan& lower : lowers_) write_lower(lower);
}

void TreeWriter::write_head(const Summary& whole) {
    GridData grid{};
    grid.magic = magic;
    grid.version = version;
    grid.flags = has_extrema | has_average | has_deviation | is_breadth_first | (whole.count > 0 ? has_box : 0U);
    grid.count = 1;
    grid.bytes = bytes_;
    copy_name(grid_name, grid.name);
    grid.map_float = map_of<float>(field_.grid);
    grid.map = map_of<double>(field_.grid);
    grid.world_box = world_box(field_.grid, whole);
    grid.spacing = field_.grid.spacing;
    grid.grid_class = is_level_set(field_) ? GridClass::level_set : GridClass::unknown;
    grid.type = type_float;
    grid.blind_offset = static_cast<std::int64_t>(blind_begin_);
    grid.blind_count = 1;

    TreeData tree{};
    const std::array begins{leaves_begin_, lowers_begin_, uppers_begin_, sizeof(GridData) + sizeof(TreeData)};
    for (std::size_t level = 0; level < begins.size(); ++level) tree.offsets[level] = begins[level] - sizeof(GridData);
    tree.node_counts = {static_cast<std::uint32_t>(leaves_.size()), static_cast<std::uint32_t>(lowers_.size()),
                        static_cast<std::uint32_t>(uppers_.size())};
    tree.active_count = whole.count;

    RootData root{};
    root.box = whole.box;
    root.tile_count = static_cast<std::uint32_t>(root_.size());
    root.background = fill_.background;
    root.statistics = whole.statistics(fill_.background);

    std::vector<std::byte> head;
    append_bytes(head, grid);
    append_bytes(head, tree);
    append_bytes(head, root);
    std::uint64_t upper = uppers_begin_;
    for (const RootEntry& entry : root_) {
        RootTile tile{};
        tile.key = key_of(first_sample(entry.first));
        if (entry.is_child) {
            tile.child = distance_between(begins[3], upper);
            upper += sizeof(Upper);
        } else {
            tile.value = fill_.beyond.inside;
        }
        append_bytes(head, tile);
    }
    grid.checksums = {checksum_of(std::span(head).subspan(offsetof(GridData, version))), no_checksum};
    std::memcpy(head.data(), &grid, sizeof(grid));

    write(FileHeader{magic, version, 1, codec_none});
    FileMetaData about{};
    about.grid_bytes = about.file_bytes = bytes_;
    about.name_hash = hash_of(grid_name);
    about.active_count = whole.count;
    about.type = type_float;
    about.grid_class = grid.grid_class;
    about.world_box = grid.world_box;
    about.box = root.box;
    about.spacing = grid.spacing;
    about.name_bytes = name_with_zero.size();
    std::ranges::copy(tree.node_counts, about.node_counts.begin());
    about.node_counts[3] = 1;
    about.codec = codec_none;
    about.blind_count = 1;
    about.version = version;
    write(about);
    file_.write(name_with_zero);
    file_.write(head);
}

void TreeWriter::write_upper(const UpperPlan& plan) {
    auto node = std::make_unique<Upper>();
    node->box = box_of(plan.summary, plan.first);
    node->flags = flags_of(plan.summary);
    node->statistics = plan.summary.statistics(fill_.background);
    for (std::size_t entry = 0; entry < Upper::child_count; ++entry)
        node->table[entry] = entry_of_value(has_bit(plan.inside, entry) ? fill_.beyond.inside : fill_.background);
    const auto number = static_cast<std::size_t>(&plan - uppers_.data());
    for (std::size_t i = plan.first_lower; i < plan.first_lower + plan.lower_count; ++i) {
        const std::size_t entry = entry_of(lowers_[i].first, plan.first, Upper::log, log_lower_bricks);
        set_bit(node->children, entry);
        node->table[entry] = static_cast<std::uint64_t>(
            distance_between(uppers_begin_ + number * sizeof(Upper), lowers_begin_ + i * sizeof(Lower)));
    }
    write(*node);
}

void TreeWriter::write_lower(const LowerPlan& plan) {
    Lower node{};
    node.box = box_of(plan.summary, plan.first);
    node.flags = flags_of(plan.summary);
    node.statistics = plan.summary.statistics(fill_.background);
    InsideTiles::Bits inside{};
    const InsideTiles::Share share = tiles_.find(plan.first, inside);
    for (std::size_t entry = 0; entry < Lower::child_count; ++entry)
        node.table[entry] = entry_of_value(
            share == InsideTiles::Share::some && has_bit(inside, entry) ? fill_.beyond.inside : fill_.background);
    const auto number = static_cast<std::size_t>(&plan - lowers_.data());
    for (std::size_t i = plan.first_leaf; i < plan.first_leaf + plan.leaf_count; ++i) {
        const std::size_t entry = entry_of(leaves_[i], plan.first, Lower::log, 0);
        set_bit(node.children, entry);
        node.table[entry] = static_cast<std::uint64_t>(
            distance_between(lowers_begin_ + number * sizeof(Lower), leaves_begin_ + i * sizeof(Leaf)));
    }
    write(node);
}

}  // namespace clsdf::nvdb
