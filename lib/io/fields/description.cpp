#include "core/refuse.hpp"
#include "io/fields/field_files.hpp"

#include "io/fields/sparse_files.hpp"
#include "io/meshes/raw_values.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace clsdf {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t largest_description = std::size_t{1} << 20;

class DescriptionReader {
public:
    DescriptionReader(const std::string& source, const std::string& text) : source_(source) {
        try {
            object_ = json::parse(text);
        } catch (const json::exception& error) {
            fail(fmt::format("not JSON: {}", error.what()));
        }
        if (!object_.is_object()) fail("expected a JSON object");
    }

    template <class Number>
    std::array<Number, 3> triple(const json::json_pointer& member) const {
        std::array<Number, 3> result{};
        const json* array = find(member);
        if (array == nullptr) fail(fmt::format("member '{}' is missing; state three numbers", member.to_string()));
        if (!array->is_array() || array->size() != 3) fail(member, *array, "expected three numbers");
        for (std::size_t axis = 0; axis < 3; ++axis) result[axis] = number<Number>(member, (*array)[axis]);
        return result;
    }

    double width(const json::json_pointer& member) const {
        const json* value = find(member);
        return value == nullptr || value->is_null() ? Band::full().outside : number<double>(member, *value);
    }

    std::string text(const json::json_pointer& member) const {
        const json* value = find(member);
        if (value == nullptr) return {};
        if (!value->is_string()) fail(member, *value, "expected a string");
        return value->get<std::string>();
    }

    bool flag(const json::json_pointer& member) const {
        const json* value = find(member);
        if (value == nullptr) return false;
        if (!value->is_boolean()) fail(member, *value, "expected true or false");
        return value->get<bool>();
    }

    bool has(const json::json_pointer& member) const { return find(member) != nullptr; }

    bool has_object(const json::json_pointer& member) const {
        const json* value = find(member);
        if (value != nullptr && !value->is_object()) fail(member, *value, "expected an object");
        return value != nullptr;
    }

private:
    const json* find(const json::json_pointer& member) const {
        return object_.contains(member) ? &object_.at(member) : nullptr;
    }

    template <class Number>
    Number number(const json::json_pointer& member, const json& value) const {
        const bool fits = std::is_integral_v<Number> ? value.is_number_integer() : value.is_number();
        if (!fits) fail(member, value, std::is_integral_v<Number> ? "expected a whole number" : "expected a number");
        return value.get<Number>();
    }

    [[noreturn]] void fail(const json::json_pointer& member, const json& value, const std::string& what) const {
        // A dump of nested brackets is recursive, and a file may have half a million.
        const std::string text = value.is_structured()
                                     ? value.type_name()
                                     : value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 80);
        fail(fmt::format("member '{}': {}: {}", member.to_string(), text, what));
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", source_, what));
    }

    const std::string& source_;
    json object_;
};

json::json_pointer member(const std::string& name) {
    return json::json_pointer("/" + name);
}

Grid stated_grid(const DescriptionReader& reader) {
    Grid grid;
    grid.size = reader.triple<std::int64_t>(member("size"));
    grid.spacing = reader.triple<double>(member("spacing"));
    grid.origin = reader.triple<double>(member("origin"));
    grid.validate();
    return grid;
}

Description describe(const DescriptionReader& reader, const Grid& stated) {
    Description result;
    Field& field = result.field;
    field.grid = stated;
    if (reader.has_object(member("lattice")))
        field.grid = with_lattice(stated, reader.triple<double>(member("lattice/origin")),
                                  reader.triple<std::int64_t>(member("lattice/first")));
    field.band = Band::full();
    if (reader.has_object(member("band")))
        field.band = band_of(reader.width(member("band/inside")), reader.width(member("band/outside")),
                             reader.flag(member("band/exact_signs")));
    field.band.validate();
    field.mesh_name = reader.text(member("mesh"));
    field.sign = reader.has(member("sign")) ? sign_rule_of(reader.text(member("sign"))) : SignRule::automatic;
    if (reader.has(member("floor"))) field.floor = reader.width(member("floor"));
    field.positive_inside = is_positive_inside(reader.text(member("inside")));
    std::vector<std::string> arrays{bricks_name, runs_name};
    for (const OutputInfo& info : extra_outputs()) arrays.emplace_back(info.name);
    for (const std::string& array : arrays) {
        const std::string file = reader.text(member(array));
        if (!file.empty()) result.files.emplace(array, file);
    }
    return result;
}

}  // namespace

std::string description_text(const FieldDescription& field, const std::map<std::string, std::string>& files) {
    const Grid& grid = field.grid;
    // JSON has no infinity: it becomes null.
    ordered_json object{
        {"program", "clsdf " + version()},
        {"mesh", field.mesh_name},
        {"origin", grid.position(0, 0, 0)},
        {"spacing", grid.spacing},
        {"size", grid.size},
        {"lattice", {{"origin", grid.origin}, {"first", grid.first}}},
        {"band", {{"inside", field.band.inside}, {"outside", field.band.outside}}},
        {"sign", name_of(field.sign)},
    };
    if (field.floor) object["floor"] = *field.floor;
    if (field.band.has_exact_signs) object["band"]["exact_signs"] = true;
    if (field.positive_inside) object["inside"] = "positive";
    for (const auto& [output, file] : files) object[output] = file;
    // A name of a mesh need not be UTF-8.
    return object.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

void check_utf8(const std::string& path, std::string_view reader) {
    try {
        static_cast<void>(json(file_name(path)).dump());
    } catch (const json::exception&) {
        refuse_unsupported("{}: the name is not UTF-8, as {} must be; choose another name", path, reader);
    }
}

Band band_of(double inside, double outside, bool has_exact_signs) {
    return {inside, outside, inside == 0 && outside == 0, has_exact_signs};
}

SignRule sign_rule_of(const std::string& text) {
    for (const SignRule rule : {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::none,
                                SignRule::solid_angle, SignRule::below})
        if (text == name_of(rule)) return rule;
    refuse("{} is no sign rule; there are auto, nonzero, parity, none, solid-angle and below", clsdf::quoted(text));
}

bool is_positive_inside(const std::string& text) {
    if (text.empty() || text == "negative") return false;
    if (text == "positive") return true;
    refuse("{} is no sign of the inside; it is negative or positive", clsdf::quoted(text));
}

Description read_description(const std::string& path) {
    InputFile file(path);
    if (file.size() > largest_description)
        file.fail(fmt::format("{} bytes are too many for the description of a field", file.size()));
    return parse_description(path, file.beginning(largest_description));
}

Description parse_description(const std::string& source, const std::string& text) {
    const DescriptionReader reader(source, text);
    return describe(reader, stated_grid(reader));
}

Description parse_description(const std::string& source, const std::string& text, const Grid& stated) {
    return describe(DescriptionReader(source, text), stated);
}

std::optional<Grid> described_block(const std::string& source, const std::string& text) {
    const DescriptionReader reader(source, text);
    if (!reader.has(member("size"))) return std::nullopt;
    Grid block;
    block.size = reader.triple<std::int64_t>(member("size"));
    if (reader.has_object(member("lattice"))) block.first = reader.triple<std::int64_t>(member("lattice/first"));
    return block;
}

}  // namespace clsdf
