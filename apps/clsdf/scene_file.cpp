#include "scene_file.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using nlohmann::json;

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::unreadable_input, message);
}

/// No member of an object may be there twice: the library keeps the last one. No text may have the character 0: paths
/// and messages would end there.
json parsed(const std::string& text) {
    std::vector<std::set<std::string>> members;  // of the objects that are open
    return json::parse(text, [&](int, json::parse_event_t event, const json& value) {
        if (value.is_string() && value.get_ref<const std::string&>().find('\0') != std::string::npos)
            refuse(fmt::format("the text {} has the character U+0000; leave it out", value.dump()));
        if (event == json::parse_event_t::object_start) members.emplace_back();
        if (event == json::parse_event_t::object_end) members.pop_back();
        if (event == json::parse_event_t::key && !members.back().insert(value.get<std::string>()).second)
            refuse(fmt::format("an object has the member '{}' twice", value.get<std::string>()));
        return true;
    });
}

/// Calls work() with errors that name the body.
template <typename Work>
void with_name(const SceneFile& file, std::size_t body, const Work& work) {
    try {
        work();
    } catch (const Error& error) {
        throw Error(error.code(),
                    fmt::format("{}: body {}, '{}': {}", file.path, body, file.bodies[body].name, error.what()));
    }
}

void check_members(const json& object, std::initializer_list<std::string_view> known) {
    for (const auto& [name, value] : object.items())
        if (std::ranges::find(known, name) == known.end()) {
            std::string names;
            for (const std::string_view one : known) names += fmt::format("{}{}", names.empty() ? "" : ", ", one);
            refuse(fmt::format("there is no member '{}'; the members are {}", name, names));
        }
}

std::string text_of(const json& value, const char* name) {
    if (!value.is_string()) refuse(fmt::format("'{}' is {}, and must be a text", name, value.dump()));
    return value.get<std::string>();
}

/// Four rows of four numbers, or 16 numbers.
clsdf::Pose pose_from(const json& value) {
    std::vector<double> numbers;
    const auto add = [&](const json& item) {
        if (!item.is_number()) refuse(fmt::format("'pose' has {}, which is no number", item.dump()));
        numbers.push_back(item.get<double>());
    };
    const bool has_rows = value.is_array() && value.size() == 4;
    if (!value.is_array() || (!has_rows && value.size() != 16))
        refuse("'pose' is no 4 x 4 matrix; write four rows of four numbers, or 16 numbers by rows");
    for (const json& item : value)
        if (!has_rows)
            add(item);
        else if (!item.is_array() || item.size() != 4)
            refuse(fmt::format("'pose' has the row {}, and needs four rows of four numbers", item.dump()));
        else
            for (const json& number : item) add(number);
    std::array<double, 16> matrix{};
    std::ranges::copy(numbers, matrix.begin());
    return clsdf::pose_of(matrix);
}

clsdf::SignRule sign_from(const json& value) {
    using enum clsdf::SignRule;
    const std::string text = text_of(value, "sign");
    std::string names;
    for (const clsdf::SignRule rule : {automatic, nonzero, parity, solid_angle, none}) {
        if (text == name_of(rule)) return rule;
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name_of(rule));
    }
    refuse(fmt::format("the sign rule '{}' is not one of {}", text, names));
}

SceneFile::Body body_of(const json& value, const SceneFile& scene) {
    if (!value.is_object()) refuse("it is no object with the members mesh or instance, name, pose and sign");
    check_members(value, {"name", "mesh", "instance", "pose", "sign"});
    SceneFile::Body body;
    body.name = value.contains("name") ? text_of(value["name"], "name") : fmt::format("{}", scene.bodies.size());
    if (std::ranges::find(scene.bodies, body.name, &SceneFile::Body::name) != scene.bodies.end())
        refuse(fmt::format("another body has the name '{}', too", body.name));
    if (value.contains("mesh") == value.contains("instance"))
        refuse("it needs either 'mesh', a file or a list of files, or 'instance', the name of a body before it");
    if (value.contains("mesh")) {
        const std::filesystem::path folder = std::filesystem::path(scene.path).parent_path();
        const json& mesh = value["mesh"];
        for (const json& file : mesh.is_array() ? mesh : json::array({mesh}))
            body.files.push_back((folder / text_of(file, "mesh")).string());
        if (body.files.empty()) refuse("'mesh' is an empty list; name a file");
        if (value.contains("sign")) body.sign = sign_from(value["sign"]);
    } else {
        const std::string of = text_of(value["instance"], "instance");
        const auto found = std::ranges::find(scene.bodies, of, &SceneFile::Body::name);
        if (found == scene.bodies.end()) refuse(fmt::format("no body before it has the name '{}'", of));
        if (value.contains("sign")) refuse("an instance has the sign rule of its mesh; leave 'sign' out");
        body.of = static_cast<std::size_t>(found - scene.bodies.begin());
    }
    if (value.contains("pose")) body.pose = pose_from(value["pose"]);
    return body;
}

}  // namespace

std::vector<std::string> SceneFile::files() const {
    std::vector<std::string> all{path};
    for (const Body& body : bodies) all.insert(all.end(), body.files.begin(), body.files.end());
    return all;
}

SceneFile read_scene(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file) refuse(fmt::format("cannot read '{}': {}", path, std::generic_category().message(errno)));
    SceneFile scene{path, {}};
    std::size_t number = 0;
    try {
        const json root = parsed(text);
        if (root.is_object()) check_members(root, {"bodies"});
        if (!root.is_object() || !root.contains("bodies") || !root["bodies"].is_array())
            refuse("it is no object with the member 'bodies', a list");
        if (root["bodies"].empty()) refuse("'bodies' is an empty list; a scene needs a body");
        for (const json& value : root["bodies"]) {
            ++number;
            scene.bodies.push_back(body_of(value, scene));
        }
    } catch (const json::exception& error) {
        refuse(fmt::format("{}: {}", path, error.what()));
    } catch (const Error& error) {
        refuse(number == 0 ? fmt::format("{}: {}", path, error.what())
                           : fmt::format("{}: body {}, counted from 0: {}", path, number - 1, error.what()));
    }
    return scene;
}

std::size_t SceneMeshes::triangles() const {
    std::size_t sum = 0;
    for (const clsdf::Mesh& mesh : meshes) sum += mesh.triangles().size();
    return sum;
}

void refuse_beside_scene(const std::vector<std::string>& meshes, const SignChoice& sign,
                         const std::vector<std::string>& with) {
    const char* const option = meshes.size() > 1                          ? "several files"
                               : sign.rule != "auto"                      ? "--sign"
                               : sign.floor                               ? "--floor"
                               : std::ranges::count(with, group_word) > 0 ? "--with group"
                                                                          : nullptr;
    if (option != nullptr)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: '{}' is a scene, which {}; leave it out", option,
                                *std::ranges::find_if(meshes, is_scene_file),
                                meshes.size() > 1                            ? "is given alone"
                                : option == std::string_view("--with group") ? "has groups of each mesh by itself"
                                                                             : "has the sign rules of its bodies"));
}

SceneMeshes read_meshes(const SceneFile& file, const MeshReading& reading, Report& report) {
    SceneMeshes result;
    for (const SceneFile::Body& body : file.bodies) {
        const std::size_t number = result.mesh_of.size();
        result.mesh_of.push_back(body.of ? result.mesh_of[*body.of] : result.meshes.size());
        if (!body.of) with_name(file, number, [&] { result.meshes.push_back(read_body(body.files, reading, report)); });
    }
    return result;
}

clsdf::Scene make_scene(const SceneFile& file, const SceneMeshes& meshes, const clsdf::Device& device,
                        const clsdf::CallOptions& call, clsdf::Surface surface) {
    clsdf::Scene scene(device, {.surface = surface});
    for (std::size_t i = 0; i < file.bodies.size(); ++i) {
        const SceneFile::Body& body = file.bodies[i];
        with_name(file, i, [&] {
            if (body.of)
                scene.add_instance(static_cast<std::uint32_t>(*body.of), body.pose);
            else
                scene.add(meshes.meshes[meshes.mesh_of[i]], body.pose, body.sign, call);
        });
    }
    return scene;
}

Json describe(const SceneFile& file, const SceneMeshes& meshes, const clsdf::Scene& scene) {
    Json bodies = Json::array();
    for (std::size_t i = 0; i < file.bodies.size(); ++i) {
        const clsdf::Mesh& mesh = meshes.meshes[meshes.mesh_of[i]];
        bodies.push_back({{"name", file.bodies[i].name},
                          {"mesh", mesh.name()},
                          {"triangles", mesh.triangles().size()},
                          {"sign", name_of(scene.sign(static_cast<std::uint32_t>(i)))}});
    }
    return bodies;
}
