#include "io/field_files.hpp"

#include "core/text.hpp"
#include "io/raw_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace clsdf {
namespace {

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t largest_header = std::size_t{1} << 20;

// Reads the literal {'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 1), } of numpy's headers.
class DictionaryReader {
public:
    explicit DictionaryReader(std::string_view text) : rest_(text) {}

    bool take(char symbol) {
        skip_blanks();
        if (!rest_.starts_with(symbol)) return false;
        rest_.remove_prefix(1);
        return true;
    }

    std::optional<std::string> take_string() {
        skip_blanks();
        if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return std::nullopt;
        const std::size_t end = rest_.find(rest_.front(), 1);
        if (end == std::string_view::npos) return std::nullopt;
        std::string result(rest_.substr(1, end - 1));
        rest_.remove_prefix(end + 1);
        return result;
    }

    std::optional<bool> take_bool() {
        skip_blanks();
        for (const bool value : {false, true}) {
            const std::string_view name = value ? "True" : "False";
            if (rest_.starts_with(name)) {
                rest_.remove_prefix(name.size());
                return value;
            }
        }
        return std::nullopt;
    }

    std::optional<std::vector<std::int64_t>> take_tuple() {
        if (!take('(')) return std::nullopt;
        std::vector<std::int64_t> result;
        while (!take(')')) {
            std::int64_t number = 0;
            skip_blanks();
            const auto [stop, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
            if (error != std::errc()) return std::nullopt;
            rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
            result.push_back(number);
            if (!take(',') && !rest_.starts_with(')')) return std::nullopt;
        }
        return result;
    }

    bool at_end() {
        skip_blanks();
        return rest_.empty();
    }

private:
    void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n"), rest_.size())); }

    std::string_view rest_;
};

struct Dictionary {
    std::optional<std::string> type;
    std::optional<bool> fortran_order;
    std::optional<std::vector<std::int64_t>> shape;
};

// Absent if the text is no such dictionary; members may be absent.
std::optional<Dictionary> parse_dictionary(std::string_view text) {
    DictionaryReader reader(text);
    Dictionary result;
    if (!reader.take('{')) return std::nullopt;
    while (!reader.take('}')) {
        const std::optional<std::string> key = reader.take_string();
        if (!key || !reader.take(':')) return std::nullopt;
        bool understood = false;
        if (*key == "descr")
            understood = (result.type = reader.take_string()).has_value();
        else if (*key == "fortran_order")
            understood = (result.fortran_order = reader.take_bool()).has_value();
        else if (*key == "shape")
            understood = (result.shape = reader.take_tuple()).has_value();
        if (!understood) return std::nullopt;
        reader.take(',');
    }
    return reader.at_end() ? std::optional(result) : std::nullopt;
}

std::uint64_t little_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

void set_type(NpyHeader& header, const InputFile& file, const std::string& type) {
    static const std::map<std::string, ValueType> types{
        {"f4", ValueType::float32}, {"f8", ValueType::float64}, {"u4", ValueType::uint32}, {"u1", ValueType::uint8}};
    const auto found = type.empty() ? types.end() : types.find(type.substr(1));
    if (found == types.end() || (type[0] != '<' && type[0] != '>' && type[0] != '|'))
        file.fail(
            fmt::format("header field 'descr': {} is not read; save the array as float64 ('<f8') or float32 ('<f4')",
                        quoted(type, 80)));
    header.values.type = found->second;
    header.values.order = type[0] == '>' ? std::endian::big : std::endian::little;
}

}  // namespace

NpyHeader read_npy_header(InputFile& file) {
    const std::string text = file.beginning(largest_header);
    if (!text.starts_with(magic)) file.fail(R"(not an .npy file: it does not begin with "\x93NUMPY")");
    const int major = text.size() > 6 ? static_cast<unsigned char>(text[6]) : 0;
    const std::size_t length_bytes = major == 1 ? 2 : 4;
    const std::size_t begin = 8 + length_bytes;
    if (text.size() < begin) file.fail("the file is truncated in its header");
    if (major < 1 || major > 3)
        file.fail(fmt::format("version {} of the .npy format is not known; save it with version 1", major));
    const std::uint64_t length = little_endian(std::string_view(text).substr(8, length_bytes));
    if (length > text.size() - begin)
        file.fail(fmt::format("the header claims {} bytes, but only {} follow; the file is truncated", length,
                              text.size() - begin));

    const auto dictionary_text = std::string_view(text).substr(begin, static_cast<std::size_t>(length));
    const std::optional<Dictionary> dictionary = parse_dictionary(dictionary_text);
    if (!dictionary || !dictionary->type || !dictionary->fortran_order || !dictionary->shape)
        file.fail(fmt::format("header {} does not state one 'descr', 'fortran_order' and 'shape' of a plain array",
                              quoted(dictionary_text, 80)));
    NpyHeader header;
    set_type(header, file, *dictionary->type);
    header.values = values_to_the_end(file, header.values.type, header.values.order, begin + length);
    header.shape = *dictionary->shape;
    header.fortran_order = *dictionary->fortran_order;
    return header;
}

std::string npy_header(std::string_view type, const std::vector<std::int64_t>& shape) {
    std::string dictionary = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({}{}), }}", type,
                                         fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    // The format requires that values are aligned to 64 bytes and follow a line end.
    constexpr std::size_t prefix = 10;
    const std::size_t padding = 63 - (prefix + dictionary.size()) % 64;
    dictionary.append(padding, ' ');
    dictionary += '\n';
    std::string text(magic);
    text += '\x01';
    text += '\x00';
    text += static_cast<char>(dictionary.size() & 0xFFU);
    text += static_cast<char>(dictionary.size() >> 8U);
    return text + dictionary;
}

const char* npy_name_of(ValueType type) {
    switch (type) {
        case ValueType::float64:
            return "<f8";
        case ValueType::uint32:
            return "<u4";
        case ValueType::uint8:
            return "|u1";
        default:
            return "<f4";
    }
}

namespace {

std::string sidecar_path(const std::string& path) {
    return path + ".json";
}

std::vector<std::int64_t> shape_of(const Grid& grid) {
    return {grid.size[2], grid.size[1], grid.size[0]};
}

// The components of a sample come last.
std::vector<std::int64_t> shape_of(const Grid& grid, const OutputKind& kind) {
    std::vector<std::int64_t> shape = shape_of(grid);
    if (kind.components > 1) shape.push_back(kind.components);
    return shape;
}

NpyHeader read_field_header(InputFile& file) {
    NpyHeader header = read_npy_header(file);
    if (header.fortran_order)
        file.fail("header field 'fortran_order': True is not read; save numpy.ascontiguousarray(field)");
    return header;
}

void check_shape(const InputFile& file, const NpyHeader& header, const Grid& grid) {
    if (header.shape != shape_of(grid))
        file.fail(fmt::format("header field 'shape': ({}), but '{}' states sizes for the shape ({})",
                              fmt::join(header.shape, ", "), sidecar_path(file.path()),
                              fmt::join(shape_of(grid), ", ")));
}

void read_extra(const std::string& path, const OutputKind& kind, Field& field) {
    InputFile file(path);
    const NpyHeader header = read_field_header(file);
    if (!reads_as(header.values.type, kind.type))
        file.fail(fmt::format("header field 'descr': {} is '{}'", kind.content, npy_name_of(kind.type)));
    const std::vector<std::int64_t> shape = shape_of(field.grid, kind);
    if (header.shape != shape)
        file.fail(fmt::format("header field 'shape': ({}), but the field's is ({}); compute both again",
                              fmt::join(header.shape, ", "), fmt::join(shape, ", ")));
    checked_count(file, header.values, header.shape);
    read_output(file, header.values, kind, field);
}

class NpyWriter : public FormatWriter {
public:
    NpyWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs)
        : kinds_(kinds_of(outputs)), sidecar_(sidecar_path(path)) {
        std::map<std::string, std::string> names;
        for (const OutputKind& kind : kinds_) {
            const bool is_distance = &kind == kinds_.data();
            const std::string file = is_distance ? path : extra_path(path, kind);
            if (!is_distance) names.emplace(kind.name, file_name(file));
            files_.emplace_back(file);
            files_.back().write(npy_header(fmt::format("'{}'", npy_name_of(kind.type)), shape_of(field.grid, kind)));
        }
        sidecar_.write(description_text(field, names));
    }

    void append(const FieldSlab& slab, std::int64_t) override {
        for (std::size_t i = 0; i < kinds_.size(); ++i)
            write_little_endian(files_[i], kinds_[i].bytes(slab), width_of(kinds_[i].type));
    }

    void finish() override {
        std::vector<AtomicFile*> files;
        for (std::size_t i = 1; i < files_.size(); ++i) files.push_back(&files_[i]);
        files.push_back(&sidecar_);
        files.push_back(&files_.front());
        AtomicFile::commit_all(files);
    }

private:
    std::vector<OutputKind> kinds_;
    AtomicFile sidecar_;
    std::deque<AtomicFile> files_;  // the distances' first
};

}  // namespace

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs) {
    return std::make_unique<NpyWriter>(path, field, outputs);
}

void check_npy(const std::string& path, const Outputs& outputs) {
    if (kinds_of(outputs).size() > 1) check_utf8(path, "the description, which names the files of the other outputs,");
}

std::map<std::string, std::string> files_of_npy(const std::string& path) {
    return read_description(sidecar_path(path)).files;
}

Field read_npy(const std::string& path) {
    InputFile file(path);
    const NpyHeader header = read_field_header(file);
    if (is_whole(header.values.type))
        file.fail(fmt::format("header field 'descr': '{}' is not a distance; save the array as float32 ('<f4')",
                              npy_name_of(header.values.type)));
    if (header.shape.size() != 3)
        file.fail(fmt::format("header field 'shape': ({}) has {} dimensions; a distance field has three, (nz, ny, nx)",
                              fmt::join(header.shape, ", "), header.shape.size()));
    checked_count(file, header.values, header.shape);

    const std::string sidecar = sidecar_path(path);
    if (!is_there(sidecar))
        file.fail(
            fmt::format("there is no '{}' beside it, which states where the samples lie: at least \"origin\", "
                        "\"spacing\" and \"size\", each with three numbers along x, y, z",
                        sidecar));
    Description description = read_description(sidecar);
    Field field = std::move(description.field);
    check_shape(file, header, field.grid);
    read_output(file, header.values, distance_kind(), field);
    for (const OutputKind& kind : extra_kinds()) {
        const auto name = description.files.find(kind.name);
        if (name == description.files.end()) continue;
        const std::string beside = path_beside(path, name->second);
        if (is_there(beside)) read_extra(beside, kind, field);
    }
    return field;
}

}  // namespace clsdf
