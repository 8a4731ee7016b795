#include "field/npy_sidecar.hpp"

#include "field/formats.hpp"
#include "field/raw_values.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace clsdf {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t largest_sidecar = std::size_t{1} << 20;

class SidecarReader {
public:
    SidecarReader(const InputFile& file, json object) : file_(file), object_(std::move(object)) {}

    template <class Number>
    std::array<Number, 3> triple(const json::json_pointer& member) const {
        std::array<Number, 3> result{};
        const json* array = find(member);
        if (array == nullptr)
            file_.fail(fmt::format("member '{}' is missing; state three numbers", member.to_string()));
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

    bool has(const json::json_pointer& member) const { return find(member) != nullptr; }

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
        const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 80);
        file_.fail(fmt::format("member '{}': {}: {}", member.to_string(), text, what));
    }

    const InputFile& file_;
    json object_;
};

SidecarReader open_sidecar(InputFile& file) {
    if (file.size() > largest_sidecar)
        file.fail(fmt::format("{} bytes are too many for the description of a field", file.size()));
    try {
        json object = json::parse(file.beginning(largest_sidecar));
        if (!object.is_object()) file.fail("expected a JSON object");
        return {file, std::move(object)};
    } catch (const json::exception& error) {
        file.fail(fmt::format("not JSON: {}", error.what()));
    }
}

}  // namespace

std::string sidecar_path(const std::string& path) {
    return path + ".json";
}

std::string sidecar_text(const Field& field, const std::string& triangle_file) {
    const Grid& grid = field.grid;
    // Infinity, which JSON does not have, becomes null.
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
    if (!triangle_file.empty()) object["triangle"] = triangle_file;
    // A name of a mesh need not be UTF-8.
    return object.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

Sidecar read_sidecar(const std::string& path) {
    InputFile file(path);
    const SidecarReader reader = open_sidecar(file);
    const auto member = [](const char* name) { return json::json_pointer(name); };

    Sidecar result;
    Field& field = result.field;
    field.grid.size = reader.triple<std::int64_t>(member("/size"));
    field.grid.spacing = reader.triple<double>(member("/spacing"));
    field.grid.origin = reader.triple<double>(member("/origin"));
    field.grid.validate();
    if (reader.has(member("/lattice")))
        field.grid = with_lattice(field.grid, reader.triple<double>(member("/lattice/origin")),
                                  reader.triple<std::int64_t>(member("/lattice/first")));
    field.band = {reader.width(member("/band/inside")), reader.width(member("/band/outside"))};
    field.band.validate();
    field.mesh_name = reader.text(member("/mesh"));
    field.sign = reader.has(member("/sign")) ? parse_sign_rule(reader.text(member("/sign"))) : SignRule::automatic;
    result.triangle_file = reader.text(member("/triangle"));
    return result;
}

}  // namespace clsdf
