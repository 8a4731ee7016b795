#include "io/fields/field_files.hpp"
#include "io/fields/vti_document.hpp"
#include "io/meshes/raw_values.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

// The six bits of a letter, or -1.
int bits_of(char letter) {
    if (letter >= 'A' && letter <= 'Z') return letter - 'A';
    if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
    if (letter >= '0' && letter <= '9') return letter - '0' + 52;
    if (letter == '+') return 62;
    return letter == '/' ? 63 : -1;
}

bool is_blank(char letter) {
    return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n';
}

/// The bytes of a text in base64 (RFC 4648), blanks between the letters; padded parts may follow one another. Null
/// if it is none.
std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3);
    std::uint32_t group = 0;
    int letters = 0, padding = 0;
    for (const char letter : text) {
        if (is_blank(letter)) continue;
        const int bits = letter == '=' ? 0 : bits_of(letter);
        padding += letter == '=';
        const bool is_misplaced = letter == '=' ? letters < 2 : padding > 0;
        if (bits < 0 || is_misplaced) return std::nullopt;
        group = group << 6 | static_cast<std::uint32_t>(bits);
        if (++letters < 4) continue;
        for (int i = 0; i < 3 - padding; ++i) bytes.push_back(static_cast<std::byte>(group >> (16 - 8 * i) & 0xFFU));
        group = 0;
        letters = padding = 0;
    }
    if (letters != 0) return std::nullopt;
    return bytes;
}

/// The stored bytes of an array, one part after the other: those of the file, or encoded as base64 in the file or in a
/// text.
class StoredBytes {
public:
    StoredBytes(InputFile& file, std::uint64_t begin, bool is_base64)
        : file_(&file), at_(begin), end_(file.size()), is_base64_(is_base64) {}
    explicit StoredBytes(std::string letters) : letters_(std::move(letters)), is_base64_(true) {
        std::erase_if(letters_, is_blank);
        end_ = letters_.size();
    }

    /// The next bytes, which stay the next ones; null if there are not as many, or no base64.
    std::optional<std::vector<std::byte>> peek(std::uint64_t count) {
        if (count > end_ || length_of(count) > end_ - at_) return std::nullopt;
        std::string stored(static_cast<std::size_t>(length_of(count)), '\0');
        if (file_ != nullptr)
            file_->read(at_, std::as_writable_bytes(std::span(stored)));
        else
            stored = letters_.substr(static_cast<std::size_t>(at_), stored.size());
        std::optional<std::vector<std::byte>> bytes;
        if (is_base64_)
            bytes = decode_base64(stored);
        else
            bytes.emplace(std::as_bytes(std::span(stored)).begin(), std::as_bytes(std::span(stored)).end());
        if (bytes && bytes->size() < count) return std::nullopt;
        if (bytes) bytes->resize(static_cast<std::size_t>(count));
        return bytes;
    }

    /// In base64 the bytes that follow are encoded by themselves.
    std::optional<std::vector<std::byte>> next(std::uint64_t count) {
        std::optional<std::vector<std::byte>> bytes = peek(count);
        if (bytes) at_ += length_of(count);
        return bytes;
    }

    /// Whether nothing of a text is left.
    bool is_read() const { return file_ != nullptr || at_ == end_; }

private:
    std::uint64_t length_of(std::uint64_t count) const { return is_base64_ ? (count + 2) / 3 * 4 : count; }

    InputFile* file_ = nullptr;
    std::string letters_;
    std::uint64_t at_ = 0, end_ = 0;
    bool is_base64_;
};

constexpr std::uint64_t largest_description = std::uint64_t{1} << 20;

std::optional<ElementType> parse_type(const std::string& type) {
    if (type == "Float32") return ElementType::float32;
    if (type == "Float64") return ElementType::float64;
    if (type == "UInt32") return ElementType::uint32;
    if (type == "UInt8") return ElementType::uint8;
    return std::nullopt;
}

/// The values of the arrays of a document.
class VtiValues {
public:
    VtiValues(InputFile& file, const VtiDocument& document) : file_(file), document_(document) {}

    [[noreturn]] void fail(const VtiArray& array, const std::string& what) const {
        file_.fail(fmt::format("array '{}': {}", array.name.substr(0, 80), what));
    }

    void read(const VtiArray& array, const OutputInfo& info, Field& field) {
        const std::optional<ElementType> type = parse_type(array.type);
        if (!type || !reads_as(*type, info.type))
            fail(array, fmt::format("type=\"{}\" is not that of {}", array.type.substr(0, 80), info.description));
        if (array.components != fmt::format("{}", info.components))
            fail(array, fmt::format("NumberOfComponents=\"{}\": {} has {}", array.components.substr(0, 80),
                                    info.description, info.components));
        std::vector<std::int64_t> sizes(field.grid.size.begin(), field.grid.size.end());
        sizes.push_back(static_cast<std::int64_t>(info.components));
        if (is_in_place(array)) {
            const RawValues values = in_place(array, *type);
            checked_count(file_, values, sizes);
            read_output(file_, values, info, field);
        } else {
            RawValues values{*type, document_.order, 0, 0};
            std::vector<std::byte> bytes = unpacked(array, [&](std::uint64_t count) {
                values.bytes = count;
                checked_count_of(file_, values, sizes);
            });
            convert_values(bytes, values, info.type, allocate_output(info, field));
        }
    }

    /// The letters of a text that lies somewhere in the file.
    std::string text(const VtiArray& array) {
        std::string letters;
        if (array.format == "ascii") {
            letters = letters_of(array);
        } else {
            const auto check = [&](std::uint64_t count) {
                if (count > largest_description) fail(array, "it is too long for the description of a field");
            };
            for (const std::byte letter : unpacked(array, check)) letters += static_cast<char>(letter);
        }
        return letters.substr(0, letters.find('\0'));
    }

private:
    // Whether the values lie in the file as they are.
    bool is_in_place(const VtiArray& array) const {
        return array.format == "appended" && document_.appended_encoding == "raw" && !document_.is_compressed;
    }

    std::uint64_t begin_of(const VtiArray& array) const {
        const std::uint64_t room = file_.size() - document_.appended_begin;
        if (room < document_.header_width || array.offset > room - document_.header_width)
            fail(array, fmt::format("offset=\"{}\" lies behind the end of the file; it is truncated", array.offset));
        return document_.appended_begin + array.offset;
    }

    RawValues in_place(const VtiArray& array, ElementType type) {
        const std::uint64_t begin = begin_of(array);
        std::array<std::byte, 8> header{};
        const auto bytes = std::span(header).first(document_.header_width);
        file_.read(begin, bytes);
        return {type, document_.order, begin + document_.header_width, number(bytes)};
    }

    StoredBytes stored_of(const VtiArray& array) const {
        if (array.format == "binary") return StoredBytes(array.text);
        if (array.format != "appended")
            fail(array, fmt::format("format=\"{}\" is not read; save it as binary or appended data",
                                    array.format.substr(0, 80)));
        const std::string& encoding = document_.appended_encoding;
        if (encoding != "raw" && encoding != "base64")
            fail(array, fmt::format("appended data encoded as \"{}\" are not read; save them raw or as base64",
                                    encoding.substr(0, 80)));
        return StoredBytes(file_, begin_of(array), encoding == "base64");
    }

    // The bytes of values that do not lie in the file as they are. `check` gets their number before they are allocated.
    std::vector<std::byte> unpacked(const VtiArray& array, const std::function<void(std::uint64_t)>& check) {
        StoredBytes stored = stored_of(array);
        const std::size_t width = document_.header_width;
        const auto start = stored.peek(width);
        if (!start) fail(array, "its values are not base64, or they are truncated");
        std::vector<std::byte> bytes =
            document_.is_compressed ? inflated(array, stored, number(*start), check) : plain(array, stored, check);
        if (!stored.is_read()) fail(array, "its values are more than they begin with");
        return bytes;
    }

    // Their number stands before them.
    std::vector<std::byte> plain(const VtiArray& array, StoredBytes& stored,
                                 const std::function<void(std::uint64_t)>& check) {
        const std::size_t width = document_.header_width;
        const std::uint64_t count = number(*stored.peek(width));
        check(count);
        // VTK encodes both together, other programs each by itself.
        StoredBytes apart = stored;
        std::optional<std::vector<std::byte>> bytes = stored.next(width + count);
        if (!bytes || !stored.is_read()) {
            if (!apart.next(width) || !(bytes = apart.next(count)))
                fail(array, "its values are not base64, or not as many as they begin with");
            stored = apart;
            return std::move(*bytes);
        }
        bytes->erase(bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(width));
        return std::move(*bytes);
    }

    // Before them: the number of blocks, the bytes of a block and of the last one (0: as of a block), and those of each
    // when it is compressed.
    std::vector<std::byte> inflated(const VtiArray& array, StoredBytes& stored, std::uint64_t blocks,
                                    const std::function<void(std::uint64_t)>& check) {
        const std::size_t width = document_.header_width;
        std::optional<std::vector<std::byte>> header;
        constexpr std::uint64_t most_blocks = std::uint64_t{1} << 30;
        if (blocks < std::min(file_.size(), most_blocks)) header = stored.next(width * (3 + blocks));
        if (!header) fail(array, "the sizes of its compressed blocks are truncated");
        const auto size_at = [&](std::uint64_t n) {
            return number(std::span(*header).subspan(static_cast<std::size_t>(n) * width, width));
        };
        const std::uint64_t of_block = size_at(1), of_last = size_at(2) == 0 ? of_block : size_at(2);
        constexpr std::uint64_t largest_block = std::uint64_t{1} << 32;
        std::uint64_t packed_bytes = 0;
        for (std::uint64_t n = 0; n < blocks; ++n) packed_bytes += std::min(size_at(3 + n), file_.size());
        const std::uint64_t count = blocks == 0 ? 0 : (blocks - 1) * std::min(of_block, largest_block) + of_last;
        constexpr std::uint64_t best_ratio = 1032;  // of zlib
        if (of_block > largest_block || of_last > of_block || count / best_ratio > packed_bytes)
            fail(array, "the sizes of its compressed blocks are wrong");
        check(count);
        const std::optional<std::vector<std::byte>> packed = stored.next(packed_bytes);
        if (!packed) fail(array, "its compressed values are truncated");
        std::vector<std::byte> bytes(static_cast<std::size_t>(count));
        std::size_t from = 0, to = 0;
        for (std::uint64_t n = 0; n < blocks; ++n) {
            const std::uint64_t size = n + 1 == blocks ? of_last : of_block;
            uLongf got = size;
            if (uncompress(reinterpret_cast<Bytef*>(bytes.data() + to), &got,
                           reinterpret_cast<const Bytef*>(packed->data() + from), size_at(3 + n)) != Z_OK ||
                got != size)
                fail(array, fmt::format("its compressed block {} is damaged", n));
            to += size;
            from += size_at(3 + n);
        }
        return bytes;
    }

    std::string letters_of(const VtiArray& array) const {
        std::string letters;
        std::string_view rest = array.text;
        while (true) {
            rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
            if (rest.empty()) return letters;
            const std::string_view code = rest.substr(0, rest.find_first_of(" \t\r\n"));
            rest.remove_prefix(code.size());
            std::int64_t letter = 0;
            if (!parse_numbers(code, std::span(&letter, 1)) || letter < 0 || letter > 255)
                fail(array, fmt::format("'{}' is not the number of a letter", code.substr(0, 80)));
            letters += static_cast<char>(letter);
        }
    }

    // The number of bytes that stands before values.
    std::uint64_t number(std::span<const std::byte> bytes) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < document_.header_width; ++i) {
            const std::size_t at = document_.order == std::endian::little ? document_.header_width - 1 - i : i;
            value = value << 8 | std::to_integer<std::uint64_t>(bytes[at]);
        }
        return value;
    }

    InputFile& file_;
    const VtiDocument& document_;
};

Grid grid_of(const InputFile& file, const VtiDocument& document) {
    Grid grid;
    grid.origin = document.origin;
    grid.spacing = document.spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = document.extent[2 * axis], last = document.extent[2 * axis + 1];
        constexpr std::int64_t most = std::int64_t{1} << 53;
        if (first < -most || last > most || last < first)
            file.fail(fmt::format("WholeExtent: {} to {} is no range of samples", first, last));
        grid.first[axis] = first;
        grid.size[axis] = last - first + 1;
    }
    grid.validate();
    return grid;
}

const VtiArray* find(const std::vector<VtiArray>& arrays, const std::string& name) {
    const auto found = std::ranges::find(arrays, name, &VtiArray::name);
    return found == arrays.end() ? nullptr : &*found;
}

const VtiArray& find_distance(const InputFile& file, const VtiDocument& document) {
    const auto& arrays = document.point_arrays;
    for (const std::string& name : {std::string(info_of(Output::distance).name), document.scalars})
        if (const VtiArray* array = find(arrays, name)) return *array;
    if (arrays.size() == 1) return arrays.front();
    file.fail(
        fmt::format("none of its {} point arrays is called \"distance\", and none is the Scalars", arrays.size()));
}

}  // namespace

Field read_vti(const std::string& path, OutputSet wanted) {
    InputFile file(path);
    const VtiDocument document = parse_vti(file);
    VtiValues values(file, document);

    Field field;
    field.grid = grid_of(file, document);
    field.band = Band::full();
    field.sign = SignRule::automatic;
    if (const VtiArray* description = find(document.field_arrays, "clsdf"))
        field = parse_description(path + ": array 'clsdf'", values.text(*description), field.grid).field;
    values.read(find_distance(file, document), info_of(Output::distance), field);
    for (const OutputInfo& info : extra_outputs())
        if (const VtiArray* array = find(document.point_arrays, info.name); array && wanted.contains(info.output))
            values.read(*array, info, field);
    return field;
}

}  // namespace clsdf
