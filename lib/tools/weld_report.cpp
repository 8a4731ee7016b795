#include <clsdf/mesh_files.hpp>

#include "core/refuse.hpp"
#include "mesh/equal_vertices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

namespace {

bool has_three_vertices(const Triangle& triangle) {
    return triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0];
}

/// The triangles by the first vertices of equal coordinates.
std::vector<Triangle> by_first_vertices(const Mesh& mesh) {
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = first[index];
    return triangles;
}

/// The number of faces whose three vertices another face has, too. The faces with fewer are ignored.
std::size_t count_coinciding(std::vector<Triangle> triangles) {
    std::erase_if(triangles, [](const Triangle& triangle) { return !has_three_vertices(triangle); });
    for (Triangle& triangle : triangles) std::ranges::sort(triangle);
    std::ranges::sort(triangles);
    std::size_t count = 0;
    for (std::size_t begin = 0, end = 0; begin < triangles.size(); begin = end) {
        while (end < triangles.size() && triangles[end] == triangles[begin]) ++end;
        if (end - begin > 1) count += end - begin;
    }
    return count;
}

double volume_of(const Mesh& mesh, const Vec3& apex) {
    double volume = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<Vec3, 3> corner{};
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis)
                corner[k][axis] = mesh.vertices()[triangle[k]][axis] - apex[axis];
        const auto& [a, b, c] = corner;
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0])) /
                  6;
    }
    return volume;
}

/// "8 faces lose their area".
std::string counted(std::size_t count, const char* one, const char* many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string warning_of(const WeldReport& report) {
    if (report.lost_faces == 0 && report.coinciding_faces == 0) return {};
    std::string text;
    if (report.lost_faces > 0) text = counted(report.lost_faces, "face loses its area", "faces lose their area");
    if (report.coinciding_faces > 0)
        text += (text.empty() ? "" : ", ") +
                counted(report.coinciding_faces, "face lies on another now", "faces lie on others now");
    const double change = report.volume_after - report.volume_before;
    text += fmt::format(", the volume changes from {:.6g} to {:.6g}", report.volume_before, report.volume_after);
    constexpr double small = 0.01;  // of the volume
    const bool is_flat = report.coinciding_faces > 0 || !(std::abs(change) <= small * std::abs(report.volume_before));
    return text + (is_flat ? "; walls that are thinner than the length are flat, so give a smaller one"
                           : "; if that is too much, give a smaller length");
}

}  // namespace

WeldReport describe_weld(const Mesh& mesh, const Mesh& welded) {
    if (mesh.triangles().size() != welded.triangles().size())
        refuse("the mesh has {} triangles, and the welded one {}; give the mesh that weld() made of it",
               mesh.triangles().size(), welded.triangles().size());
    const std::vector<Triangle> before = by_first_vertices(mesh), after = by_first_vertices(welded);
    WeldReport report;
    std::vector<Triangle> kept;
    for (std::size_t t = 0; t < before.size(); ++t) {
        if (!has_three_vertices(before[t])) continue;
        if (has_three_vertices(after[t]))
            kept.push_back(before[t]);
        else
            ++report.lost_faces;
    }
    const std::size_t now = count_coinciding(after), had = count_coinciding(kept);
    report.coinciding_faces = now - std::min(now, had);
    const Box& box = mesh.box();
    Vec3 centre{};
    for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] = box.lower[axis] / 2 + box.upper[axis] / 2;
    report.volume_before = volume_of(mesh, centre);
    report.volume_after = volume_of(welded, centre);
    constexpr double rounding = 1e-12;  // of the volume: what is left of faces that cancel each other
    if (std::abs(report.volume_after) <= rounding * std::abs(report.volume_before)) report.volume_after = 0;
    report.warning = warning_of(report);
    return report;
}

}  // namespace clsdf
