#include "field/formats.hpp"
#include "field/nrrd_header.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>

namespace clsdf {
namespace {

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
        for (std::size_t other = 0; other < 3; ++other)
            if (other != axis && (*direction)[other] != 0)
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

void read_extra(const std::string& path, const OutputKind& kind, Field& field) {
    InputFile file(path);
    const NrrdHeader header(file);
    const RawValues values = header.values();
    if (!reads_as(values.type, kind.type))
        header.fail("type", *header.find("type"), fmt::format("{} is of another type", kind.content));
    std::vector<std::int64_t> expected(field.grid.size.begin(), field.grid.size.end());
    if (kind.components > 1) expected.insert(expected.begin(), kind.components);
    if (header.sizes(expected.size()) != expected)
        header.fail("sizes", *header.find("sizes"), "the field has other sizes; compute both again");
    checked_count(file, values, expected);
    read_output(file, values, kind, field);
}

}  // namespace

Field read_nrrd(const std::string& path) {
    InputFile file(path);
    const NrrdHeader header(file);
    const RawValues values = header.values();
    if (values.type == ValueType::uint32)
        header.fail("type", *header.find("type"), "a distance field is of float or double");
    const std::vector<std::int64_t> size = header.sizes(3);
    checked_count(file, values, size);

    Field field;
    field.grid = read_grid(header, {size[0], size[1], size[2]});
    field.band = {read_half_width(header, "clsdf_band_inside"), read_half_width(header, "clsdf_band_outside")};
    field.band.validate();
    if (const std::string* mesh = header.find_pair("clsdf_mesh")) field.mesh_name = *mesh;
    const std::string* sign = header.find_pair("clsdf_sign");
    field.sign = sign == nullptr ? SignRule::automatic : parse_sign_rule(*sign);
    read_output(file, values, distance_kind(), field);
    for (const OutputKind& kind : extra_kinds()) {
        const std::string* name = header.find_pair(fmt::format("clsdf_{}_file", kind.name));
        if (name == nullptr) continue;
        const std::string beside = path_beside(path, *name);
        if (std::filesystem::exists(beside)) read_extra(beside, kind, field);
    }
    return field;
}

}  // namespace clsdf
