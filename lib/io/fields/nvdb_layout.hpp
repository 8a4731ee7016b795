#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

/// The file format of NanoVDB, version 32, for one grid of floats: FileHeader, FileMetaData, the grid's name, then the
/// grid as it lies in memory. That is GridData, TreeData, RootData, the root's tiles, and the nodes, breadth first:
/// upper nodes of 32^3 children, lower nodes of 16^3, leaves of 8^3 values. Blind data may follow.
///
/// Numbers are little-endian. Offsets within a grid are multiples of 32; the grid itself lies anywhere in its file.
/// Every byte belongs to a member, so none is left undefined.
namespace clsdf::nvdb {

inline constexpr bool is_supported = std::endian::native == std::endian::little;

inline constexpr std::uint64_t magic = 0x304244566F6E614E;  ///< "NanoVDB0": grids and files, of all versions
inline constexpr std::uint64_t magic_of_newer_grids = 0x314244566F6E614E;  ///< "NanoVDB1", from version 32.6 on
inline constexpr std::uint64_t magic_of_newer_files = 0x324244566F6E614E;  ///< "NanoVDB2", from version 32.6 on

/// Eleven bits, eleven bits and ten bits.
inline constexpr std::uint32_t version_of(std::uint32_t major, std::uint32_t minor, std::uint32_t patch) {
    return major << 21 | minor << 10 | patch;
}
inline constexpr std::uint32_t major_version = 32;
inline constexpr std::uint32_t version = version_of(major_version, 4, 2);
/// From this version on the first checksum ends with TreeData.
inline constexpr std::uint32_t version_of_short_head = version_of(32, 6, 1);

inline constexpr std::uint16_t codec_none = 0;
inline constexpr std::uint32_t type_float = 1;
enum class GridClass : std::uint32_t { unknown = 0, level_set = 1 };

enum GridFlags : std::uint32_t {
    has_box = 1U << 1,
    has_extrema = 1U << 2,
    has_average = 1U << 3,
    has_deviation = 1U << 4,
    is_breadth_first = 1U << 5,
};

/// Of upper nodes, lower nodes and leaves.
enum NodeFlags : std::uint8_t { has_no_active_value = 1, has_active_box = 2 };

using Int3 = std::array<std::int32_t, 3>;
using Double3 = std::array<double, 3>;

/// From the first sample to the last, both included.
struct IntBox {
    Int3 lower;
    Int3 upper;
};

struct DoubleBox {
    Double3 lower;
    Double3 upper;
};

struct FileHeader {
    std::uint64_t magic;
    std::uint32_t version;
    std::uint16_t grid_count;
    std::uint16_t codec;
};
static_assert(sizeof(FileHeader) == 16);

struct FileMetaData {
    std::uint64_t grid_bytes;
    std::uint64_t file_bytes;  ///< of the grid; fewer if it is compressed
    std::uint64_t name_hash;
    std::uint64_t active_count;
    std::uint32_t type;
    GridClass grid_class;
    DoubleBox world_box;
    IntBox box;
    Double3 spacing;
    std::uint32_t name_bytes;  ///< with the zero at its end
    std::array<std::uint32_t, 4> node_counts;
    std::array<std::uint32_t, 3> active_tile_counts;
    std::uint16_t codec;
    std::uint16_t blind_count;
    std::uint32_t version;
};
static_assert(sizeof(FileMetaData) == 176 && offsetof(FileMetaData, world_box) == 40 &&
              offsetof(FileMetaData, spacing) == 112 && offsetof(FileMetaData, codec) == 168);

/// World = matrix * index + vector.
template <class Real>
struct Matrices {
    std::array<Real, 9> matrix;
    std::array<Real, 9> inverse;
    std::array<Real, 3> vector;
    Real taper;
};

struct GridData {
    std::uint64_t magic;
    std::array<std::uint32_t, 2> checksums;  ///< of the head, from `version` on, and of the nodes
    std::uint32_t version;
    std::uint32_t flags;
    std::uint32_t index;
    std::uint32_t count;
    std::uint64_t bytes;
    std::array<char, 256> name;
    Matrices<float> map_float;
    Matrices<double> map;
    DoubleBox world_box;
    Double3 spacing;
    GridClass grid_class;
    std::uint32_t type;
    std::int64_t blind_offset;  ///< of BlindMetaData, from GridData
    std::uint32_t blind_count;
    std::uint32_t reserved;
    std::array<std::uint64_t, 2> more_reserved;
};
static_assert(sizeof(GridData) == 672 && offsetof(GridData, version) == 16 && offsetof(GridData, name) == 40 &&
              offsetof(GridData, map_float) == 296 && offsetof(GridData, map) == 384 &&
              offsetof(GridData, world_box) == 560 && offsetof(GridData, grid_class) == 632 &&
              offsetof(GridData, blind_offset) == 640);

/// A checksum that was not computed.
inline constexpr std::uint32_t no_checksum = ~std::uint32_t{0};

struct TreeData {
    std::array<std::uint64_t, 4> offsets;  ///< from TreeData to the first leaf, lower node, upper node, and RootData
    std::array<std::uint32_t, 3> node_counts;
    std::array<std::uint32_t, 3> active_tile_counts;
    std::uint64_t active_count;
};
static_assert(sizeof(TreeData) == 64 && offsetof(TreeData, node_counts) == 32 &&
              offsetof(TreeData, active_count) == 56);

/// Of active values.
struct Statistics {
    float least;
    float greatest;
    float average;
    float deviation;
};

struct RootData {
    IntBox box;
    std::uint32_t tile_count;
    float background;
    Statistics statistics;
    std::array<std::uint32_t, 4> reserved;
};
static_assert(sizeof(RootData) == 64 && offsetof(RootData, statistics) == 32);

struct RootTile {
    std::uint64_t key;
    std::int64_t child;  ///< from RootData to the upper node; 0: a tile
    std::uint32_t is_active;
    float value;
    std::uint64_t reserved;
};
static_assert(sizeof(RootTile) == 32 && offsetof(RootTile, value) == 20);

/// Child (x, y, z) of a node is entry (x << 2 log) + (y << log) + z of its masks and its table. An entry of the table
/// is the offset of the child from the node, or a value in its first four bytes.
template <unsigned LogChildren, unsigned LogChildSide>
struct InternalNode {
    static constexpr unsigned log = LogChildren;
    static constexpr unsigned log_child_side = LogChildSide;          ///< of a child, in samples
    static constexpr unsigned log_side = LogChildren + LogChildSide;  ///< of the node, in samples
    static constexpr std::size_t child_count = std::size_t{1} << 3 * LogChildren;
    using Mask = std::array<std::uint64_t, child_count / 64>;

    IntBox box;  ///< of active values, so the node's origin is its lower corner, rounded down
    std::uint64_t flags;
    Mask values;
    Mask children;
    Statistics statistics;
    std::array<std::uint64_t, 2> reserved;
    std::array<std::uint64_t, child_count> table;
};
using Lower = InternalNode<4, 3>;
using Upper = InternalNode<5, 7>;
static_assert(sizeof(Lower) == 33856 && offsetof(Lower, statistics) == 1056 && offsetof(Lower, table) == 1088);
static_assert(sizeof(Upper) == 270400 && offsetof(Upper, statistics) == 8224 && offsetof(Upper, table) == 8256);

/// Sample (x, y, z) of a leaf is value 64 x + 8 y + z.
struct Leaf {
    static constexpr unsigned log_side = 3;
    static constexpr std::int64_t side = 8;
    static constexpr std::size_t sample_count = 512;

    Int3 box_lower;
    std::array<std::uint8_t, 3> box_extent;
    std::uint8_t flags;
    std::array<std::uint64_t, 8> active;
    Statistics statistics;
    std::array<float, sample_count> values;
};
static_assert(sizeof(Leaf) == 2144 && offsetof(Leaf, statistics) == 80 && offsetof(Leaf, values) == 96);

struct BlindMetaData {
    std::int64_t data_offset;  ///< from BlindMetaData
    std::uint64_t value_count;
    std::uint32_t value_bytes;
    std::uint32_t semantic;
    std::uint32_t data_class;
    std::uint32_t type;
    std::array<char, 256> name;
};
static_assert(sizeof(BlindMetaData) == 288 && offsetof(BlindMetaData, name) == 32);

inline constexpr std::size_t alignment = 32;

/// The name of the blind data that hold the field's description: a text, a zero, and the checksum of both.
inline constexpr const char* description_name = "clsdf";

/// The CRC-32 of ISO 3309, as zlib's.
inline std::uint32_t checksum_of(std::span<const std::byte> bytes) {
    std::uint32_t sum = ~std::uint32_t{0};
    for (const std::byte byte : bytes) {
        sum ^= static_cast<std::uint32_t>(byte);
        for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ ((sum & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    return ~sum;
}

inline std::uint32_t checksum_of(std::string_view text) {
    return checksum_of(std::as_bytes(std::span(text)));
}

/// Appends a zero and the checksum to a text.
inline void append_checksum(std::string& text) {
    text.push_back('\0');
    const std::uint32_t sum = checksum_of(text);
    text.append(reinterpret_cast<const char*>(&sum), sizeof(sum));
}

/// Whether the text ends with a zero and the checksum; removes them.
inline bool remove_checksum(std::string& text) {
    std::uint32_t sum = 0;
    if (text.size() <= sizeof(sum)) return false;
    std::memcpy(&sum, text.data() + text.size() - sizeof(sum), sizeof(sum));
    text.resize(text.size() - sizeof(sum));
    if (text.back() != '\0' || checksum_of(text) != sum) return false;
    text.pop_back();
    return true;
}

/// A tile of the root is found by the 20 upper bits of its indices, each in 21 bits.
inline constexpr unsigned key_bits = 21;
inline std::uint64_t key_of(const Int3& sample) {
    std::uint64_t key = 0;
    for (const std::int32_t index : sample)
        key = key << key_bits | static_cast<std::uint32_t>(index) >> Upper::log_side;
    return key;
}
inline Int3 origin_of(std::uint64_t key) {
    Int3 origin{};
    for (std::size_t axis = 3; axis-- > 0; key >>= key_bits)
        origin[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(key) << Upper::log_side);
    return origin;
}

}  // namespace clsdf::nvdb
