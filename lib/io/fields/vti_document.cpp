#include "io/fields/vti_document.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

// Expat 2.9 deprecates these functions; the replacements return 64 bits on every platform.
#if XML_MAJOR_VERSION > 2 || (XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION >= 9)
#define XML_GetCurrentLineNumber XML_GetCurrentLineNumber64
#define XML_GetCurrentByteIndex XML_GetCurrentByteIndex64
#define XML_GetCurrentByteCount XML_GetCurrentByteCount64
#endif

namespace clsdf {
namespace {

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
        const std::string_view compressor = find(attributes, "compressor").value_or("");
        document_.is_compressed = compressor == "vtkZLibDataCompressor";
        if (!compressor.empty() && !document_.is_compressed)
            return complain(fmt::format(
                "compressor=\"{}\" is not read; save it with ZLib, or with none (ParaView: Compressor Type)",
                compressor.substr(0, 80)));
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

}  // namespace

VtiDocument parse_vti(InputFile& file) {
    VtiDocument document = VtiParser().parse(file);
    if (!document.appended_encoding.empty()) find_marker(file, document);
    return document;
}

}  // namespace clsdf
