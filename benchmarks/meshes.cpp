#include "benchmarks/meshes.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <unordered_map>

namespace clsdf::bench {

namespace {

const char* const noisy_name = "noisy_sphere";

Vec3 between(const Vec3& a, const Vec3& b, double share) {
    return {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])};
}

Vec3 scaled(const Vec3& v, double factor) {
    return {v[0] * factor, v[1] * factor, v[2] * factor};
}

double length(const Vec3& v) {
    return std::hypot(v[0], v[1], v[2]);
}

struct Icosahedron {
    std::vector<Vec3> vertices;
    std::vector<Triangle> faces;

    Icosahedron() {
        const double golden = (1 + std::sqrt(5.0)) / 2;
        for (const double one : {-1.0, 1.0})
            for (const double g : {-golden, golden})
                for (const Vec3& v : {Vec3{0, one, g}, Vec3{one, g, 0}, Vec3{g, 0, one}}) vertices.push_back(v);
        // Its faces are the triples of vertices that are two apart from each other.
        const auto apart = [&](std::uint32_t a, std::uint32_t b) {
            const Vec3 &p = vertices[a], &q = vertices[b];
            return std::abs(length({p[0] - q[0], p[1] - q[1], p[2] - q[2]}) - 2) < 1e-9;
        };
        for (std::uint32_t a = 0; a < 12; ++a)
            for (std::uint32_t b = a + 1; b < 12; ++b)
                for (std::uint32_t c = b + 1; c < 12; ++c)
                    if (apart(a, b) && apart(b, c) && apart(a, c)) faces.push_back(outwards({a, b, c}));
    }

private:
    Triangle outwards(const Triangle& t) const {
        const Vec3 &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
        const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                              a[2] * (b[0] * c[1] - b[1] * c[0]);
        return volume > 0 ? t : Triangle{t[0], t[2], t[1]};
    }
};

std::string describe_seed(std::uint64_t seed) {
    return fmt::format("{} (seed {})", noisy_name, seed);
}

}  // namespace

const std::vector<std::string>& standard_meshes() {
    static const std::vector<std::string> names{"bunny00",       "sphere6",          "armadillo",
                                                "fandisk_large", "refined_elephant", noisy_name};
    return names;
}

std::vector<std::string> mesh_names() {
    std::vector<std::string> names = standard_meshes();
    for (const ShapeName& shape : shape_names())
        if (std::find(names.begin(), names.end(), shape.name) == names.end()) names.push_back(shape.name);
    return names;
}

std::string short_name(const std::string& name_or_file) {
    return std::filesystem::path(name_or_file).stem().string();
}

Mesh load_mesh(const std::string& name_or_file, const std::string& folder, std::uint64_t seed) {
    if (name_or_file == noisy_name) return noisy_sphere(71, 0.5, seed);
    const std::vector<ShapeName> shapes = shape_names();
    if (std::any_of(shapes.begin(), shapes.end(), [&](const ShapeName& shape) { return shape.name == name_or_file; }))
        return make_shape(name_or_file);
    const std::vector<std::string>& known = standard_meshes();
    if (std::find(known.begin(), known.end(), name_or_file) == known.end()) return read_mesh(name_or_file);
    const std::string file = (std::filesystem::path(folder) / (name_or_file + ".off")).string();
    if (!std::filesystem::exists(file))
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: there is no {}; scripts/fetch-meshes brings it, --meshes names another folder",
                                name_or_file, file));
    return read_mesh(file);
}

Mesh noisy_sphere(std::uint32_t frequency, double noise, std::uint64_t seed) {
    const Icosahedron solid;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    // Neighbouring faces make the same points of an edge: these are one vertex.
    std::map<std::array<std::int64_t, 3>, std::uint32_t> known;
    const auto vertex_at = [&](const Vec3& p) {
        constexpr double grain = 1e9;
        const std::array<std::int64_t, 3> key{std::llround(p[0] * grain), std::llround(p[1] * grain),
                                              std::llround(p[2] * grain)};
        const auto [found, is_new] = known.emplace(key, static_cast<std::uint32_t>(vertices.size()));
        if (is_new) vertices.push_back(p);
        return found->second;
    };
    for (const Triangle& face : solid.faces) {
        const Vec3 &a = solid.vertices[face[0]], &b = solid.vertices[face[1]], &c = solid.vertices[face[2]];
        const auto point = [&](std::uint32_t i, std::uint32_t j) {
            const double f = frequency;
            const Vec3 p = between(between(a, b, i / f), between(c, b, i / f), i < frequency ? j / (f - i) : 0);
            return vertex_at(scaled(p, 1 / length(p)));
        };
        // Row i runs from the side a-b to the side c-b, with frequency - i steps.
        for (std::uint32_t i = 0; i < frequency; ++i)
            for (std::uint32_t j = 0; j < frequency - i; ++j) {
                triangles.push_back({point(i, j), point(i + 1, j), point(i, j + 1)});
                if (j + 1 < frequency - i) triangles.push_back({point(i, j + 1), point(i + 1, j), point(i + 1, j + 1)});
            }
    }
    // The mean length of 3 T / 2 edges: T equilateral triangles have the sphere's area.
    const double edge =
        std::sqrt(4 * 3.14159265358979323846 / static_cast<double>(triangles.size()) * 4 / std::sqrt(3.0));
    std::mt19937_64 random(seed);
    for (Vec3& vertex : vertices) {
        const double uniform = static_cast<double>(random() >> 11U) * 0x1p-52 - 1;
        vertex = scaled(vertex, 1 + noise * edge * uniform);
    }
    return {std::move(vertices), std::move(triangles), describe_seed(seed)};
}

double triangle_area(const Mesh& mesh, std::size_t triangle) {
    const auto& [a, b, c] = mesh.triangles()[triangle];
    const Vec3 &p = mesh.vertices()[a], &q = mesh.vertices()[b], &r = mesh.vertices()[c];
    const Vec3 u{q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
    return length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}) / 2;
}

double mean_triangle_area(const Mesh& mesh) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) sum += triangle_area(mesh, t);
    return sum / static_cast<double>(mesh.triangles().size());
}

Mesh split_triangles(const Mesh& mesh) {
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles;
    triangles.reserve(4 * mesh.triangles().size());
    std::unordered_map<std::uint64_t, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
        const auto [found, is_new] = middles.emplace(key, static_cast<std::uint32_t>(vertices.size()));
        if (is_new) vertices.push_back(between(vertices[std::min(a, b)], vertices[std::max(a, b)], 0.5));
        return found->second;
    };
    for (const auto& [a, b, c] : mesh.triangles()) {
        const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
        triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return {std::move(vertices), std::move(triangles), mesh.name()};
}

}  // namespace clsdf::bench
