#include "io/field_files.hpp"
#include "io/raw_values.hpp"

#include <clsdf/mesh.hpp>

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Expat 2.9 deprecates these functions; the replacements return 64 bits on every platform.
#if XML_MAJOR_VERSION > 2 || (XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION >= 9)
#define XML_GetCurrentLineNumber XML_GetCurrentLineNumber64
#define XML_GetCurrentByteIndex XML_GetCurrentByteIndex64
#define XML_GetCurrentByteCount XML_GetCurrentByteCount64
#endif

namespace clsdf {
namespace {

/// An array of a .vti file; its values are in `text`, or follow the document.
struct VtiArray {
    std::string name;
    std::string type;        ///< "Float32", "String", ...
    std::string components;  ///< as written
    std::string format;      ///< "appended", "binary" (base64) or "ascii"
    std::uint64_t offset = 0;
    std::string text;
};

/// The XML part of a .vti file (VTK's ImageData in one piece; the VTK file formats, "XML file formats").
struct VtiDocument {
    std::endian order = std::endian::little;
    std::size_t header_width = 4;  ///< bytes of the number that stands before the values of an array
    std::array<std::int64_t, 6> extent{};
    Vec3 origin{};
    Vec3 spacing{1, 1, 1};
    std::string scalars;  ///< the name of the array that PointData calls so
    std::vector<VtiArray> point_arrays;
    std::vector<VtiArray> field_arrays;
    std::string appended_encoding;  ///< "raw" or "base64"; empty if nothing follows
    std::uint64_t appended_begin = 0;
};

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

constexpr std::size_t chunk = std::size_t{1} << 16;
constexpr std::uint64_t farthest_marker = 4096;  // blanks between <AppendedData> and its underscore

/// Fills a document from the callbacks of expat. No exception may pass through its C code, so the first error is kept
/// and the parser is stopped.
class VtiParser {
public:
    VtiParser() : parser_(XML_ParserCreate(nullptr)) {
        if (!parser_) throw std::bad_alloc();
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(parser_.get(), &VtiParser::on_start, &VtiParser::on_end);
        XML_SetCharacterDataHandler(parser_.get(), &VtiParser::on_text);
        XML_SetStartDoctypeDeclHandler(parser_.get(), &VtiParser::on_doctype);
    }

    VtiDocument parse(InputFile& file) {
        std::vector<char> buffer(chunk);
        for (std::uint64_t begin = 0; begin < file.size() && !stopped_; begin += chunk) {
            const auto part = std::span(buffer).first(std::min<std::uint64_t>(chunk, file.size() - begin));
            file.read(begin, std::as_writable_bytes(part));
            const bool is_last = begin + part.size() == file.size();
            if (XML_Parse(parser_.get(), part.data(), static_cast<int>(part.size()), is_last) == XML_STATUS_ERROR &&
                !stopped_)
                complain(XML_ErrorString(XML_GetErrorCode(parser_.get())));
        }
        if (failure_) std::rethrow_exception(failure_);
        if (!complaint_.empty()) file.fail(complaint_);
        if (!ended_ && document_.appended_encoding.empty()) file.fail("the file is truncated in its XML");
        if (pieces_ != 1) file.fail(fmt::format("{} pieces of an image; save the field as one", pieces_));
        return std::move(document_);
    }

private:
    using Attributes = const XML_Char**;

    static void on_start(void* self, const XML_Char* name, Attributes attributes) noexcept {
        static_cast<VtiParser*>(self)->guarded([&](VtiParser& parser) { parser.start(name, attributes); });
    }
    static void on_end(void* self, const XML_Char*) noexcept {
        static_cast<VtiParser*>(self)->guarded([](VtiParser& parser) { parser.end(); });
    }
    static void on_text(void* self, const XML_Char* text, int length) noexcept {
        static_cast<VtiParser*>(self)->guarded([&](VtiParser& parser) {
            // Not the text of elements within the array, such as an InformationKey.
            if (parser.array_ != nullptr && parser.path_.size() == parser.array_depth_)
                parser.array_->text.append(text, static_cast<std::size_t>(length));
        });
    }
    static void on_doctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) noexcept {
        static_cast<VtiParser*>(self)->guarded(
            [](VtiParser& parser) { parser.complain("a document type is declared, which VTK's files do not"); });
    }

    template <class Action>
    void guarded(const Action& action) noexcept {
        if (stopped_) return;
        try {
            action(*this);
        } catch (...) {
            failure_ = std::current_exception();
            stop();
        }
    }

    void complain(std::string what) {
        complaint_ = fmt::format("line {}: {}", XML_GetCurrentLineNumber(parser_.get()), what);
        stop();
    }

    void stop() {
        stopped_ = true;
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    static std::optional<std::string_view> find(Attributes attributes, std::string_view name) {
        for (; *attributes != nullptr; attributes += 2)
            if (name == attributes[0]) return attributes[1];
        return std::nullopt;
    }

    static std::string text(Attributes attributes, std::string_view name, std::string_view otherwise = {}) {
        return std::string(find(attributes, name).value_or(otherwise));
    }

    template <class Number>
    void numbers(Attributes attributes, const char* name, std::span<Number> values) {
        const std::optional<std::string_view> value = find(attributes, name);
        if (value && !parse_numbers(*value, values))
            complain(fmt::format("{}=\"{}\": expected {} numbers", name, value->substr(0, 80), values.size()));
    }

    void start(std::string_view name, Attributes attributes) {
        if (path_.size() > 16) return complain("elements are nested deeper than in any .vti file");
        if (path_.empty() && name != "VTKFile") return complain("not a .vti file: it does not begin with <VTKFile>");
        path_.emplace_back(name);
        if (name == "VTKFile") start_file(attributes);
        if (name == "ImageData") start_image(attributes);
        if (name == "Piece") start_piece(attributes);
        if (name == "PointData") document_.scalars = text(attributes, "Scalars");
        if (name == "DataArray" || name == "Array") start_array(attributes);
        if (name == "AppendedData") start_appended(attributes);
    }

    void start_file(Attributes attributes) {
        const std::string type = text(attributes, "type");
        if (type != "ImageData") return complain(fmt::format("type=\"{}\": a field is ImageData", type.substr(0, 80)));
        if (find(attributes, "compressor"))
            return complain("its values are compressed; save it with no compressor (ParaView: Compressor Type None)");
        document_.order = text(attributes, "byte_order") == "BigEndian" ? std::endian::big : std::endian::little;
        document_.header_width = text(attributes, "header_type") == "UInt64" ? 8 : 4;
    }

    void start_image(Attributes attributes) {
        numbers(attributes, "WholeExtent", std::span<std::int64_t>(document_.extent));
        numbers(attributes, "Origin", std::span<double>(document_.origin));
        numbers(attributes, "Spacing", std::span<double>(document_.spacing));
        std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
        const auto along_the_axes = direction;
        numbers(attributes, "Direction", std::span<double>(direction));
        if (!stopped_ && direction != along_the_axes) complain("Direction: the grid is not parallel to the axes");
    }

    void start_piece(Attributes attributes) {
        ++pieces_;
        std::array<std::int64_t, 6> extent = document_.extent;
        numbers(attributes, "Extent", std::span<std::int64_t>(extent));
        if (!stopped_ && extent != document_.extent)
            complain("a piece is not the whole image; save the field as one piece");
    }

    void start_array(Attributes attributes) {
        const std::string_view parent = path_.size() > 1 ? std::string_view(path_[path_.size() - 2]) : "";
        std::vector<VtiArray>* const arrays = parent == "PointData"   ? &document_.point_arrays
                                              : parent == "FieldData" ? &document_.field_arrays
                                                                      : nullptr;
        if (arrays == nullptr) return;
        VtiArray array{text(attributes, "Name"),
                       text(attributes, "type"),
                       text(attributes, "NumberOfComponents", "1"),
                       text(attributes, "format"),
                       0,
                       {}};
        std::int64_t offset = 0;
        numbers(attributes, "offset", std::span(&offset, 1));
        if (offset < 0) return complain(fmt::format("offset=\"{}\" lies before the values", offset));
        array.offset = static_cast<std::uint64_t>(offset);
        arrays->push_back(std::move(array));
        array_ = &arrays->back();
        array_depth_ = path_.size();
    }

    void start_appended(Attributes attributes) {
        document_.appended_encoding = text(attributes, "encoding");
        document_.appended_begin = static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get())) +
                                   static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
        // The appended data need not be XML.
        stop();
    }

    void end() {
        path_.pop_back();
        if (path_.size() < array_depth_) array_ = nullptr;
        ended_ = path_.empty();
    }

    struct Free {
        void operator()(XML_Parser parser) const { XML_ParserFree(parser); }
    };

    std::unique_ptr<XML_ParserStruct, Free> parser_;
    VtiDocument document_;
    std::vector<std::string> path_;
    VtiArray* array_ = nullptr;  // whose text is being read
    std::size_t array_depth_ = 0;
    int pieces_ = 0;
    bool ended_ = false;
    bool stopped_ = false;
    std::exception_ptr failure_;  // of memory
    std::string complaint_;
};

// The values begin after an underscore.
void find_marker(InputFile& file, VtiDocument& document) {
    std::string text(std::min(farthest_marker, file.size() - std::min(file.size(), document.appended_begin)), '\0');
    file.read(document.appended_begin, std::as_writable_bytes(std::span(text)));
    const std::size_t marker = text.find_first_not_of(" \t\r\n");
    if (marker == std::string::npos || text[marker] != '_')
        file.fail("no '_' stands before the values in <AppendedData>; the file is truncated or damaged");
    document.appended_begin += marker + 1;
}

/// Throws Error(unreadable_input).
VtiDocument parse_vti(InputFile& file) {
    VtiDocument document = VtiParser().parse(file);
    if (!document.appended_encoding.empty()) find_marker(file, document);
    return document;
}

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
        if (array.format == "binary") {
            std::vector<std::byte> bytes = decoded(array);
            const RawValues values{*type, document_.order, 0, bytes.size()};
            checked_count(file_, values, sizes);  // base64 is longer than the values, and lies in the file
            convert_values(bytes, values, info.type, allocate_output(info, field));
        } else {
            const RawValues values = appended(array, *type);
            checked_count(file_, values, sizes);
            read_output(file_, values, info, field);
        }
    }

    /// The letters of a text that lies somewhere in the file.
    std::string text(const VtiArray& array) {
        std::string letters;
        if (array.format == "ascii") {
            letters = letters_of(array);
        } else if (array.format == "binary") {
            for (const std::byte letter : decoded(array)) letters += static_cast<char>(letter);
        } else {
            const RawValues values = appended(array, ElementType::uint32);
            if (values.bytes > largest_description) fail(array, "it is too long for the description of a field");
            letters.resize(static_cast<std::size_t>(values.bytes));
            file_.read(values.offset, std::as_writable_bytes(std::span(letters)));
        }
        return letters.substr(0, letters.find('\0'));
    }

private:
    RawValues appended(const VtiArray& array, ElementType type) {
        if (array.format != "appended")
            fail(array,
                 fmt::format("format=\"{}\" is not read; save it as raw appended data", array.format.substr(0, 80)));
        if (document_.appended_encoding != "raw")
            fail(array, fmt::format("appended data encoded as \"{}\" are not read; save them raw",
                                    document_.appended_encoding.substr(0, 80)));
        const std::uint64_t room = file_.size() - document_.appended_begin;
        if (room < document_.header_width || array.offset > room - document_.header_width)
            fail(array, fmt::format("offset=\"{}\" lies behind the end of the file; it is truncated", array.offset));
        const std::uint64_t begin = document_.appended_begin + array.offset;
        std::array<std::byte, 8> header{};
        const auto bytes = std::span(header).first(document_.header_width);
        file_.read(begin, bytes);
        return {type, document_.order, begin + document_.header_width, number(bytes)};
    }

    // Without the header.
    std::vector<std::byte> decoded(const VtiArray& array) {
        std::optional<std::vector<std::byte>> bytes = decode_base64(array.text);
        if (!bytes || bytes->size() < document_.header_width ||
            number(*bytes) != bytes->size() - document_.header_width)
            fail(array, "its values are not base64, or not as many as they begin with");
        bytes->erase(bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(document_.header_width));
        return std::move(*bytes);
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
