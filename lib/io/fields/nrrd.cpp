#include "io/fields/field_files.hpp"
#include "io/meshes/raw_values.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace clsdf {
namespace {

/// The text before the values of an NRRD file (teem.sourceforge.net/nrrd/format.html).
class NrrdHeader {
public:
    /// Throws Error(unreadable_input) if the header is not one, or has no end.
    explicit NrrdHeader(InputFile& file);

    /// The text of a header field, or null. Case and blanks in names do not count: "space origin" equals "spaceorigin".
    const std::string* find(const std::string& field) const;
    /// Throws if the field is missing; `remedy` says what to do.
    const std::string& require(const std::string& field, const std::string& remedy) const;
    /// The text of a "key:=value" pair, or null.
    const std::string* find_pair(const std::string& key) const;

    /// The sizes of an array of so many dimensions.
    std::vector<std::int64_t> sizes(std::size_t dimensions) const;
    /// Type, byte order and place of the values, which must be raw and attached.
    RawValues values() const;

    /// "field 'sizes': '12 x' ..." with the name of the file before it.
    [[noreturn]] void fail(const std::string& field, const std::string& text, const std::string& what) const;

private:
    void parse_line(std::string_view line, std::size_t number);

    const InputFile& file_;
    std::map<std::string, std::string> fields_;
    std::map<std::string, std::string> pairs_;
    std::uint64_t data_offset_ = 0;
};

constexpr std::size_t largest_header = std::size_t{1} << 20;
constexpr std::string_view blanks = " \t";

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
    });
    return result;
}

// "Space Origin" -> "spaceorigin"; two names of one field become the same.
std::string normalised(std::string_view name) {
    std::string result = lower_case(name);
    std::erase_if(result, [](char letter) { return blanks.find(letter) != std::string_view::npos; });
    return result == "centerings" ? "centers" : result;
}

std::optional<ElementType> parse_type(const std::string& text) {
    static const std::map<std::string, ElementType> types{
        {"float", ElementType::float32},       {"double", ElementType::float64},      {"uint", ElementType::uint32},
        {"unsigned int", ElementType::uint32}, {"uint32", ElementType::uint32},       {"uint32_t", ElementType::uint32},
        {"uchar", ElementType::uint8},         {"unsigned char", ElementType::uint8}, {"uint8", ElementType::uint8},
        {"uint8_t", ElementType::uint8}};
    const auto found = types.find(text);
    return found == types.end() ? std::nullopt : std::optional(found->second);
}

/// A value of a pair with backslashes and line ends as NRRD escapes them, and back.
std::string escaped(std::string_view text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '\\')
            result += "\\\\";
        else if (letter == '\n')
            result += "\\n";
        else
            result += letter;
    }
    return result;
}

std::string unescaped(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool is_escape = text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == '\\' || text[i + 1] == 'n');
        if (is_escape) ++i;
        result += is_escape && text[i] == 'n' ? '\n' : text[i];
    }
    return result;
}

NrrdHeader::NrrdHeader(InputFile& file) : file_(file) {
    const std::string text = file.beginning(largest_header);
    if (!text.starts_with("NRRD000")) file.fail("not an NRRD file: it does not begin with \"NRRD000\" and a version");

    std::size_t begin = 0;
    for (std::size_t number = 1;; ++number) {
        const std::size_t end = text.find('\n', begin);
        if (end == std::string::npos)
            file.fail(
                "the header has no end: an empty line must stand between it and the values; the file is "
                "truncated, or its values lie in another file (save it attached)");
        std::string_view line(text.data() + begin, end - begin);
        begin = end + 1;
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (line.empty()) break;
        if (number > 1) parse_line(line, number);
    }
    data_offset_ = begin;
}

void NrrdHeader::parse_line(std::string_view line, std::size_t number) {
    if (line.starts_with('#')) return;
    const std::size_t colon = line.find(':');
    const std::size_t assignment = line.find(":=");
    if (colon == std::string_view::npos)
        file_.fail(
            fmt::format(R"(header line {}: {} is neither "field: value" nor "key:=value")", number, quoted(line, 80)));
    const bool is_pair = assignment != std::string_view::npos && line.find(": ") > assignment;
    const std::string name = is_pair ? std::string(line.substr(0, assignment)) : normalised(line.substr(0, colon));
    const std::string value =
        is_pair ? unescaped(line.substr(assignment + 2)) : std::string(trimmed(line.substr(colon + 1)));
    if (!(is_pair ? pairs_ : fields_).emplace(name, value).second)
        file_.fail(fmt::format("header line {}: {} is stated a second time", number, quoted(name, 80)));
}

const std::string* NrrdHeader::find(const std::string& field) const {
    const auto found = fields_.find(normalised(field));
    return found == fields_.end() ? nullptr : &found->second;
}

const std::string& NrrdHeader::require(const std::string& field, const std::string& remedy) const {
    const std::string* text = find(field);
    if (text == nullptr) file_.fail(fmt::format("field '{}' is missing; {}", field, remedy));
    return *text;
}

const std::string* NrrdHeader::find_pair(const std::string& key) const {
    const auto found = pairs_.find(key);
    return found == pairs_.end() ? nullptr : &found->second;
}

std::vector<std::int64_t> NrrdHeader::sizes(std::size_t dimensions) const {
    const std::string expected = fmt::format("the field has dimension {}", dimensions);
    const std::string& dimension = require("dimension", expected);
    if (dimension != fmt::format("{}", dimensions)) fail("dimension", dimension, expected);
    const std::string& text = require("sizes", "state the samples along x, y and z");
    std::vector<std::int64_t> sizes(dimensions);
    if (!parse_numbers(text, std::span<std::int64_t>(sizes)))
        fail("sizes", text, fmt::format("expected {} whole numbers", dimensions));
    return sizes;
}

RawValues NrrdHeader::values() const {
    for (const char* field : {"data file", "line skip", "byte skip"})
        if (const std::string* text = find(field); text != nullptr && *text != "0")
            fail(field, *text, "values must follow the header; save it attached (unu save -f nrrd -e raw)");
    const std::string encoding = lower_case(require("encoding", "only raw is read"));
    if (encoding != "raw")
        fail("encoding", encoding, "only raw is read; save it uncompressed (unu save -f nrrd -e raw)");

    const std::string& type_text = require("type", "a distance field is of float or double");
    const std::optional<ElementType> type = parse_type(lower_case(type_text));
    if (!type) fail("type", type_text, "a distance field is of float or double");
    const std::string endian = lower_case(require("endian", "state little or big"));
    if (endian != "little" && endian != "big") fail("endian", endian, "expected little or big");
    return values_to_the_end(file_, *type, endian == "little" ? std::endian::little : std::endian::big, data_offset_);
}

void NrrdHeader::fail(const std::string& field, const std::string& text, const std::string& what) const {
    file_.fail(fmt::format("field '{}': {}: {}", field, quoted(text, 80), what));
}

// Takes "(a,b,c)" from the front of the text, and the blanks before it.
std::optional<Vec3> take_vector(std::string_view& text) {
    const std::size_t open = text.find_first_not_of(" \t");
    const std::size_t close = text.find(')');
    if (open == std::string_view::npos || text[open] != '(' || close == std::string_view::npos) return std::nullopt;
    std::string inner(text.substr(open + 1, close - open - 1));
    text.remove_prefix(close + 1);
    std::size_t commas = 0;
    for (char& letter : inner) {
        commas += letter == ',';
        letter = letter == ',' ? ' ' : letter;
    }
    Vec3 vector{};
    if (commas != 2 || !parse_numbers(inner, std::span<double>(vector))) return std::nullopt;
    return vector;
}

Vec3 read_directions(const NrrdHeader& header, const std::string& text) {
    std::string_view rest = text;
    Vec3 spacing{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::optional<Vec3> direction = take_vector(rest);
        if (!direction) header.fail("space directions", text, "expected three vectors, as (hx,0,0) (0,hy,0) (0,0,hz)");
        // Programs that multiply rotations leave some rounding.
        const double step = std::abs((*direction)[axis]), slack = std::isnan(step) ? 0 : 1e-12 * step;
        for (std::size_t other = 0; other < 3; ++other)
            if (other != axis && !(std::abs((*direction)[other]) <= slack))
                header.fail("space directions", text, "the grid is not parallel to the axes; resample it");
        spacing[axis] = (*direction)[axis];
    }
    return spacing;
}

Vec3 read_spacing(const NrrdHeader& header) {
    if (const std::string* text = header.find("space directions")) return read_directions(header, *text);
    const std::string& text = header.require("spacings", "state it or \"space directions\"");
    Vec3 spacing{};
    if (!parse_numbers(text, std::span<double>(spacing))) header.fail("spacings", text, "expected three numbers");
    return spacing;
}

// The position of the first sample. An axis' minimum is the first sample of nodes, or the near end of the first cell.
Vec3 read_origin(const NrrdHeader& header, const Vec3& spacing) {
    if (const std::string* text = header.find("space origin")) {
        std::string_view rest = *text;
        const std::optional<Vec3> origin = take_vector(rest);
        if (!origin) header.fail("space origin", *text, "expected (x,y,z)");
        return *origin;
    }
    const std::string& text = header.require("axis mins", "state it or \"space origin\": where the first sample lies");
    Vec3 origin{};
    if (!parse_numbers(text, std::span<double>(origin))) header.fail("axis mins", text, "expected three numbers");
    const std::string centers = header.require("centers", "with \"axis mins\", state node or cell for each axis");
    if (centers == "cell cell cell") {
        for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] += spacing[axis] / 2;
    } else if (centers != "node node node") {
        header.fail("centers", centers, R"(expected "node node node" or "cell cell cell")");
    }
    return origin;
}

template <class Number>
std::optional<std::array<Number, 3>> read_pair(const NrrdHeader& header, const std::string& key) {
    const std::string* text = header.find_pair(key);
    if (text == nullptr) return std::nullopt;
    std::array<Number, 3> numbers{};
    if (!parse_numbers(*text, std::span<Number>(numbers))) header.fail(key, *text, "expected three numbers");
    return numbers;
}

Grid read_grid(const NrrdHeader& header, const Index3& size) {
    Grid grid;
    grid.size = size;
    grid.spacing = read_spacing(header);
    grid.origin = read_origin(header, grid.spacing);
    grid.validate();
    const auto lattice_origin = read_pair<double>(header, "clsdf_lattice_origin");
    const auto lattice_first = read_pair<std::int64_t>(header, "clsdf_lattice_first");
    return lattice_origin && lattice_first ? with_lattice(grid, *lattice_origin, *lattice_first) : grid;
}

double read_half_width(const NrrdHeader& header, const std::string& key) {
    const std::string* text = header.find_pair(key);
    if (text == nullptr) return Band::full().outside;
    double width = 0;
    if (!parse_numbers(*text, std::span(&width, 1))) header.fail(key, *text, "expected one number");
    return width;
}

void read_extra(const std::string& path, const OutputInfo& info, Field& field) {
    InputFile file(path);
    const NrrdHeader header(file);
    const RawValues values = header.values();
    if (!reads_as(values.type, info.type))
        header.fail("type", *header.find("type"), fmt::format("{} is of another type", info.description));
    std::vector<std::int64_t> expected(field.grid.size.begin(), field.grid.size.end());
    if (info.components > 1) expected.insert(expected.begin(), static_cast<std::int64_t>(info.components));
    if (header.sizes(expected.size()) != expected)
        header.fail("sizes", *header.find("sizes"), "the field has other sizes; compute both again");
    checked_count(file, values, expected);
    read_output(file, values, info, field);
}

}  // namespace

namespace {

std::map<std::string, std::string> files_of(const NrrdHeader& header) {
    std::map<std::string, std::string> files;
    for (const OutputInfo& info : extra_outputs())
        if (const std::string* name = header.find_pair(fmt::format("clsdf_{}_file", info.name)))
            files.emplace(info.name, *name);
    return files;
}

}  // namespace

std::map<std::string, std::string> files_of_nrrd(const std::string& path) {
    InputFile file(path);
    return files_of(NrrdHeader(file));
}

Field read_nrrd(const std::string& path, OutputSet wanted) {
    InputFile file(path);
    const NrrdHeader header(file);
    const RawValues values = header.values();
    if (is_whole(values.type)) header.fail("type", *header.find("type"), "a distance field is of float or double");
    const std::vector<std::int64_t> size = header.sizes(3);
    checked_count(file, values, size);

    Field field;
    field.grid = read_grid(header, {size[0], size[1], size[2]});
    const std::string* signs = header.find_pair("clsdf_band_signs");
    field.band = band_of(read_half_width(header, "clsdf_band_inside"), read_half_width(header, "clsdf_band_outside"),
                         signs != nullptr && *signs == "exact");
    field.band.validate();
    if (const std::string* mesh = header.find_pair("clsdf_mesh")) field.mesh_name = *mesh;
    const std::string* sign = header.find_pair("clsdf_sign");
    field.sign = sign == nullptr ? SignRule::automatic : sign_rule_of(*sign);
    if (header.find_pair("clsdf_floor") != nullptr) field.floor = read_half_width(header, "clsdf_floor");
    if (const std::string* inside = header.find_pair("clsdf_inside"))
        field.positive_inside = is_positive_inside(*inside);
    read_output(file, values, info_of(Output::distance), field);
    const std::map<std::string, std::string> files = files_of(header);
    for (const OutputInfo& info : extra_outputs()) {
        const auto name = files.find(info.name);
        if (name == files.end() || !wanted.contains(info.output)) continue;
        const std::string beside = path_beside(path, name->second);
        if (is_there(beside)) read_extra(beside, info, field);
    }
    return field;
}

namespace {

const char* nrrd_name_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return "double";
        case ElementType::uint32:
            return "unsigned int";
        case ElementType::uint8:
            return "unsigned char";
        default:
            return "float";
    }
}

// The header fields that every reader of NRRD needs. fmt writes the shortest text that reads back as the same double.
// The components of a sample are the first, fastest axis.
std::string basic_header(const Grid& grid, const OutputInfo& info) {
    const Vec3 origin = grid.position(0, 0, 0);
    const bool is_vector = info.components > 1;
    return fmt::format(
        "NRRD0005\n"
        "# Complete NRRD file format specification at:\n"
        "# http://teem.sourceforge.net/nrrd/format.html\n"
        "content: {}\n"
        "type: {}\n"
        "dimension: {}\n"
        "space dimension: 3\n"
        "sizes: {}{} {} {}\n"
        "space directions: {}({},0,0) (0,{},0) (0,0,{})\n"
        "kinds: {}domain domain domain\n"
        "endian: little\n"
        "encoding: raw\n"
        "space origin: ({},{},{})\n",
        info.description, nrrd_name_of(info.type), is_vector ? 4 : 3,
        is_vector ? fmt::format("{} ", info.components) : "", grid.size[0], grid.size[1], grid.size[2],
        is_vector ? "none " : "", grid.spacing[0], grid.spacing[1], grid.spacing[2], is_vector ? "vector " : "",
        origin[0], origin[1], origin[2]);
}

std::string pairs(const FieldDescription& field) {
    return fmt::format(
        "clsdf_version:={}\n"
        "clsdf_mesh:={}\n"
        "clsdf_sign:={}\n"
        "{}{}"
        "clsdf_band_inside:={}\n"
        "clsdf_band_outside:={}\n"
        "{}"
        "clsdf_lattice_origin:={}\n"
        "clsdf_lattice_first:={}\n",
        version(), escaped(field.mesh_name), name_of(field.sign),
        field.floor ? fmt::format("clsdf_floor:={}\n", *field.floor) : "",
        field.positive_inside ? "clsdf_inside:=positive\n" : "", field.band.inside, field.band.outside,
        field.band.has_exact_signs ? "clsdf_band_signs:=exact\n" : "", fmt::join(field.grid.origin, " "),
        fmt::join(field.grid.first, " "));
}

class NrrdWriter : public FormatWriter {
public:
    NrrdWriter(const std::string& path, const FieldDescription& field, OutputSet outputs) : infos_(infos_of(outputs)) {
        std::string header = basic_header(field.grid, infos_.front()) + pairs(field);
        files_.emplace_back(path);
        for (std::size_t i = 1; i < infos_.size(); ++i) {
            const std::string beside = extra_path(path, infos_[i].name);
            header += fmt::format("clsdf_{}_file:={}\n", infos_[i].name, escaped(file_name(beside)));
            files_.emplace_back(beside);
            files_.back().write(basic_header(field.grid, infos_[i]) + '\n');
        }
        files_.front().write(header + '\n');
    }

    void append(const FieldSlab& slab, std::int64_t) override {
        for (std::size_t i = 0; i < infos_.size(); ++i)
            write_little_endian(files_[i], slab.bytes(infos_[i].output), bytes_of(infos_[i].type));
    }

    void finish() override {
        std::vector<AtomicFile*> files;
        for (std::size_t i = files_.size(); i-- > 0;) files.push_back(&files_[i]);
        AtomicFile::commit_all(files);
    }

private:
    std::vector<OutputInfo> infos_;
    std::deque<AtomicFile> files_;  // the distances' first
};

}  // namespace

std::unique_ptr<FormatWriter> nrrd_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return std::make_unique<NrrdWriter>(path, field, outputs);
}

}  // namespace clsdf
