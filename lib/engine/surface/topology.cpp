#include "surface/topology.hpp"

#include "core/parallel.hpp"
#include "mesh/equal_vertices.hpp"
#include "surface/double_sided.hpp"
#include "surface/edge_counts.hpp"
#include "surface/open_edges.hpp"
#include "surface/parts.hpp"
#include "surface/surface_search.hpp"
#include "surface/terrain.hpp"

#include <clsdf/topology.hpp>

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Counts the vertices; `first` as of first_equal_vertices().
void count_vertices(std::span<const Triangle> triangles, std::span<const std::uint32_t> first, Topology& report) {
    // Counts the vertices number_of(index) of the triangles' indices.
    const auto count_used = [&](const auto& number_of) {
        std::vector<std::uint8_t> used(first.size());
        for_each_index(triangles.size(), [&](std::size_t t) {
            for (const std::uint32_t index : triangles[t]) {
                const std::atomic_ref flag(used[number_of(index)]);
                if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
            }
        });
        return static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
    };
    bool are_different = true;
    for (std::size_t v = 0; v < first.size(); ++v) are_different = are_different && first[v] == v;
    const std::size_t used = count_used([](std::uint32_t index) { return index; });
    report.unused_vertices = first.size() - used;
    report.coincident_vertices =
        are_different ? 0 : used - count_used([&](std::uint32_t index) { return first[index]; });
}

std::vector<Triangle> triangles_over(std::span<const std::uint32_t> first, std::span<const Triangle> triangles) {
    std::vector<Triangle> result(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t t) {
        for (std::size_t k = 0; k < 3; ++k) result[t][k] = first[triangles[t][k]];
    });
    return result;
}

/// The first five of the edges, and the first five open ones, in the order and the direction of the first triangles
/// that use them.
void report_first_edges(std::vector<UnbalancedEdge> edges, std::span<const Triangle> triangles,
                        const std::vector<Vec3>& vertices, Topology& report) {
    constexpr std::size_t limit = 5;
    const std::size_t wanted = std::min(report.unbalanced_edges, limit);
    const std::size_t open_wanted = std::min(report.open_edges, limit);
    std::vector<Topology::Edge>& first = report.first_unbalanced_edges;
    std::vector<Topology::Edge>& first_open = report.first_open_edges;
    for (std::size_t t = 0; first.size() < wanted || first_open.size() < open_wanted; ++t) {
        if (has_repeated_vertex(triangles[t])) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k];
            const std::uint32_t to = triangles[t][(k + 1) % 3];
            const UnbalancedEdge edge{std::min(from, to), std::max(from, to)};
            const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
            if (found == edges.end() || edge < *found || found->is_noted) continue;
            found->is_noted = true;
            if (first.size() < wanted) first.push_back({vertices[from], vertices[to]});
            if (found->is_open && first_open.size() < open_wanted) first_open.push_back({vertices[from], vertices[to]});
        }
    }
}

void report_inner_walls(std::span<const std::uint32_t> faces, Topology& report) {
    if (faces.empty()) return;
    report.inner_wall_faces = faces.size();
    report.first_inner_wall_face = faces.front();
}

/// Adds two lists of faces that were left out, each ascending.
void add_sheets(const Sheets& more, Sheets& sheets) {
    const auto merge = [](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
        const auto middle = static_cast<std::ptrdiff_t>(to.size());
        to.insert(to.end(), from.begin(), from.end());
        std::inplace_merge(to.begin(), to.begin() + middle, to.end());
    };
    merge(more.left_out, sheets.left_out);
    merge(more.walls, sheets.walls);
    sheets.enclosing = more.enclosing;
    sheets.first_enclosing = more.first_enclosing;
}

void report_sheets(const Sheets& sheets, Topology& report) {
    report.sheet_faces = sheets.left_out.size();
    report.first_sheet_face = !sheets.open.empty()      ? sheets.open.front()
                              : sheets.left_out.empty() ? 0
                                                        : sheets.left_out.front();
    report.enclosing_faces = sheets.enclosing;
    report.first_enclosing_face = sheets.first_enclosing;
    report_inner_walls(sheets.walls, report);
}

/// Of a balanced surface whose faces all count.
void report_doubled_cavities(const Mesh& mesh, std::span<const Triangle> triangles,
                             const std::vector<DoubledFace>& doubled, Topology& report) {
    std::vector<std::uint32_t> firsts;
    for (const DoubledFace& one : doubled)
        if (!one.is_reversed) firsts.push_back(one.first);
    if (firsts.empty()) return;
    std::ranges::sort(firsts);
    const auto repeated = std::ranges::unique(firsts);
    firsts.erase(repeated.begin(), repeated.end());
    const std::vector<std::uint32_t> faces = doubled_cavities(mesh, triangles, std::move(firsts));
    report.doubled_cavity_faces = faces.size();
    report.first_doubled_cavity_face = faces.empty() ? 0 : faces.front();
}

/// Of a balanced surface with faces that are there twice, if nothing is inside beside it.
void report_empty_surface(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report) {
    constexpr std::size_t places = 64;
    std::vector<std::uint32_t> faces;
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (!has_repeated_vertex(triangles[face])) faces.push_back(face);
    WindingTally tally;
    tally.add(WindingView(mesh, triangles, {}).at(points_beside(mesh, triangles, faces, places)));
    if (tally.inside > 0 || tally.tested == 0) return;
    report.tested_points = tally.tested;
    report.inside_points = 0;
}

/// Open edges of a mesh that is not balanced, but for noise and faces that are there twice.
OpenLoops rim_of(const Mesh& mesh, std::span<const Triangle> triangles) {
    SurfaceSearch search(mesh, triangles, count_edges(triangles, mesh.vertices().size()));
    search.join_noise();
    if (!search.is_balanced()) search.count_doubled_once(doubled_faces(search.triangles(), mesh.vertices().size()));
    return loops_of(search.edges());
}

/// If the surface has no sign: leaves sheets beside bodies out.
void leave_out_sheets(SurfaceSearch& search, const std::vector<DoubledFace>& doubled, Sheets& sheets) {
    if (search.is_closed() || search.winding_test().is_clear()) return;
    const Sheets more = search.leave_out_sheets(doubled);
    if (!more.left_out.empty() || !search.winding_test_with_covered_parts().is_clear()) add_sheets(more, sheets);
}

/// Leaves walls of bodies and sheets out, for the rule automatic. Without walls a surface that is not balanced may have
/// less of a sign than with them, as when they close a hole: then it keeps them.
Sheets leave_out_walls_and_sheets(SurfaceSearch& search, const std::vector<DoubledFace>& doubled) {
    const auto quality = [](SurfaceSearch& of) {
        return of.is_balanced() ? 3 : of.is_closed() ? 2 : of.winding_test().is_clear() ? 1 : 0;
    };
    Sheets sheets;
    if (!search.is_balanced() && search.edges().non_manifold > 0) {
        SurfaceSearch without_walls = search;
        sheets = without_walls.leave_out_walls(doubled);
        if (!sheets.left_out.empty() || without_walls.is_balanced()) {
            if (!without_walls.is_balanced()) without_walls.orient_parts(doubled);
            leave_out_sheets(without_walls, doubled, sheets);
            // Without walls, what is left out of the mesh as given may be a part of the skin: it counts only if there
            // is no other sign.
            Sheets as_before;
            const int reached = quality(without_walls), with_all = quality(search);
            if (reached == 0) leave_out_sheets(search, doubled, as_before);
            if (reached >= (reached == 0 ? quality(search) : with_all)) {
                search = std::move(without_walls);
                return sheets;
            }
            return as_before;
        }
        sheets = {};
    }
    leave_out_sheets(search, doubled, sheets);
    return sheets;
}

/// Describes the edges of a mesh's triangles, whose vertices are all different.
SignSurface describe_edges(const Mesh& mesh, std::span<const Triangle> triangles, SignRule asked, Topology& report) {
    constexpr std::size_t grain = 4096;
    report.repeated_vertex_faces = reduce_ranges(
        triangles.size(), grain, std::size_t{0},
        [&](std::size_t begin, std::size_t end, std::size_t count) {
            const auto part = triangles.subspan(begin, end - begin);
            return count + static_cast<std::size_t>(std::count_if(part.begin(), part.end(), has_repeated_vertex));
        },
        std::plus<>());
    EdgeCounts edges = count_edges(triangles, mesh.vertices().size());
    report.non_manifold_edges = edges.non_manifold;
    const bool may_open = asked == SignRule::automatic || asked == SignRule::solid_angle;
    const bool is_balanced = edges.unbalanced.empty();
    std::vector<DoubledFace> doubled;
    if (is_balanced) {
        if (edges.non_manifold > 0) doubled = doubled_faces(triangles, mesh.vertices().size());
        report.duplicate_faces = doubled.size();
        if (doubled.empty()) {
            report.closed = report.balanced = true;
            report.inside_out = encloses_negative_volume(mesh);
            return {};
        }
    }
    SurfaceSearch search(mesh, triangles, std::move(edges));
    if (!is_balanced) {
        search.join_noise();
        doubled = doubled_faces(search.triangles(), mesh.vertices().size());
        if (!search.is_balanced()) search.count_doubled_once(doubled);
    }
    if (asked != SignRule::below) search.count_bodies_once(doubled, may_open);
    if (!search.is_balanced() && (search.is_closed() || may_open)) search.orient_parts(doubled);
    Sheets sheets = asked == SignRule::automatic ? leave_out_walls_and_sheets(search, doubled) : Sheets();
    if (search.is_balanced() && search.uncounted() == 0 && sheets.left_out.empty())
        report_doubled_cavities(mesh, search.triangles(), doubled, report);
    if (search.is_balanced() && !doubled.empty()) report_empty_surface(mesh, search.triangles(), report);
    const auto is_open = [&] {
        return !search.is_balanced() && (asked == SignRule::solid_angle || !search.is_closed());
    };
    report_sheets(sheets, report);
    report.joined_vertices = search.joined();
    report.duplicate_faces = doubled.size();
    report.uncounted_faces = search.uncounted();
    report.reoriented_faces = search.reoriented();
    report.double_sided_faces = search.double_sided();
    report.boundary_edges = search.edges().boundary;
    report.unbalanced_edges = search.edges().unbalanced.size();
    report.open_edges = search.edges().open();
    report_first_edges(search.edges().unbalanced, search.triangles(), mesh.vertices(), report);
    report.closed = search.is_closed();
    report.balanced = search.is_balanced();
    if (report.open_edges > 0 && report.boundary_edges == 0)
        report_inner_walls(inner_walls(mesh, search.triangles()), report);
    std::optional<WindingTest> test;
    if (may_open && is_open()) test = search.winding_test();
    SignSurface surface = search.take_surface();
    if (report.balanced) report.inside_out = encloses_negative_volume(mesh, surface);
    if (test) {
        surface.open_loops = loops_of(search.edges());
        report.tested_points = test->all.tested;
        report.doubtful_points = test->all.doubtful;
        report.inside_points = test->all.inside;
        report.unclear_parts = test->unclear_parts;
        report.first_unclear_face = test->first_unclear_face;
        report.detail_parts = test->detail_parts;
        report.detail_faces = test->detail_faces;
        report.first_detail_face = test->first_detail_face;
        report.inside_out = test->all.sum < 0 && (asked == SignRule::solid_angle || test->is_clear());
    }
    if (!report.closed && asked == SignRule::below) {
        surface.open_loops = loops_of(search.edges());
        if (describe_looks(mesh, triangles, report)) describe_rim(mesh, surface.open_loops, report);
    } else if (asked == SignRule::automatic && (!report.closed || report.sheet_faces > 0)) {
        if (describe_looks(mesh, triangles, report)) describe_rim(mesh, rim_of(mesh, triangles), report);
    }
    return surface;
}

/// The triangles of the surface that decides the sign.
std::vector<Triangle> triangles_of(std::span<const Triangle> given, const SignSurface& surface) {
    std::vector<Triangle> triangles(given.size());
    for_each_index(given.size(), [&](std::size_t face) { triangles[face] = surface.triangle(given[face], face); });
    return triangles;
}

}  // namespace

OpenLoops open_loops_of(const Mesh& mesh, const SignSurface& surface) {
    const std::vector<Triangle> own =
        surface.is_mesh() ? std::vector<Triangle>() : triangles_of(mesh.triangles(), surface);
    const std::span<const Triangle> triangles = surface.is_mesh() ? std::span(mesh.triangles()) : std::span(own);
    return loops_of(count_edges(triangles, mesh.vertices().size()));
}

Topology describe_vertices(const Mesh& mesh, std::span<const std::uint32_t> first) {
    Topology report;
    count_vertices(mesh.triangles(), first, report);
    return report;
}

SignSurface describe_edges(const Mesh& mesh, std::span<const Triangle> neighbours, bool are_paired, SignRule asked,
                           Topology& report) {
    if (are_paired) {
        describe_paired_edges(encloses_negative_volume(mesh), report);
        if (!is_one_part(neighbours, mesh.vertices().size())) describe_parts(mesh, mesh.triangles(), report);
        return {};
    }
    SignSurface surface = describe_edges(mesh, mesh.triangles(), asked, report);
    report.parts = report.balanced ? 1 : 0;
    if (report.balanced && (!surface.is_mesh() || !is_one_part(neighbours, mesh.vertices().size())))
        describe_parts(mesh, triangles_of(mesh.triangles(), surface), report);
    return surface;
}

void describe_paired_edges(bool encloses_negative_volume, Topology& report) {
    report.closed = report.balanced = true;
    report.inside_out = encloses_negative_volume;
    report.parts = 1;
}

DescribedMesh describe_mesh(const Mesh& mesh, SignRule asked) {
    DescribedMesh described;
    auto& [report, surface] = described;
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    count_vertices(mesh.triangles(), first, report);
    const std::vector<Triangle> own =
        report.coincident_vertices > 0 ? triangles_over(first, mesh.triangles()) : std::vector<Triangle>();
    const std::span<const Triangle> triangles = own.empty() ? std::span(mesh.triangles()) : std::span(own);
    surface = describe_edges(mesh, triangles, asked, report);
    report.parts = report.balanced ? 1 : 0;
    if (report.balanced && (!surface.is_mesh() || !is_one_part(triangles, mesh.vertices().size())))
        describe_parts(mesh, triangles_of(triangles, surface), report);
    if (!own.empty() && !surface.is_mesh()) {
        if (surface.vertices.empty())
            surface.vertices = first;
        else
            for (std::size_t v = 0; v < first.size(); ++v) surface.vertices[v] = surface.vertices[first[v]];
    }
    return described;
}

Topology describe_topology(const Mesh& mesh) {
    return describe_mesh(mesh).topology;
}

}  // namespace clsdf
