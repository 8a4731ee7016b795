#include "command.hpp"
#include "compute.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include "tools/text.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/papers.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using clsdf::EdgeKind;
using clsdf::VertexKind;

struct InfoOptions {
    std::vector<std::string> mesh;
    MeshReading reading;
    bool self_intersections = false;
    bool outer = false;
};

/// The faces of a group: one or more.
struct Group {
    std::string name;
    std::size_t faces = 0;
    double area = 0;
    clsdf::Box box{};
};

std::vector<Group> groups_of(const clsdf::Mesh& mesh) {
    std::vector<Group> groups;
    for (const std::string& name : mesh.groups().names) groups.push_back({.name = name});
    for (std::size_t face = 0; face < mesh.groups().numbers.size(); ++face) {
        Group& group = groups[mesh.groups().numbers[face]];
        const auto& [i, j, k] = mesh.triangles()[face];
        const clsdf::Vec3 &a = mesh.vertices()[i], &b = mesh.vertices()[j], &c = mesh.vertices()[k];
        if (++group.faces == 1) group.box = {a, a};
        clsdf::Vec3 u, v;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            auto& [lower, upper] = group.box;
            lower[axis] = std::min({lower[axis], a[axis], b[axis], c[axis]});
            upper[axis] = std::max({upper[axis], a[axis], b[axis], c[axis]});
            u[axis] = b[axis] - a[axis];
            v[axis] = c[axis] - a[axis];
        }
        group.area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    }
    return groups;
}

struct Info {
    Info(const InfoOptions& options, const clsdf::Mesh& mesh)
        : box(mesh.box()),
          vertices(mesh.vertices().size()),
          triangles(mesh.triangles().size()),
          topology(describe_topology(mesh)),
          defects(find_defects(mesh)),
          kinds(classify_convexity(mesh)),
          saddles(examine_saddles(mesh)),
          groups(groups_of(mesh)) {
        if (options.outer) outer = clsdf::outer(mesh);
        if (options.self_intersections) self_intersections = clsdf::reference::find_self_intersections(mesh).size();
    }

    clsdf::Box box;
    std::size_t vertices;
    std::size_t triangles;
    clsdf::Topology topology;
    clsdf::Defects defects;
    clsdf::Classification kinds;
    clsdf::SaddleReport saddles;
    std::vector<Group> groups;
    std::optional<clsdf::OuterSurface> outer;
    std::optional<std::size_t> self_intersections;
};

Json describe(const Info& info) {
    const auto edges = [&](EdgeKind kind) { return info.kinds.count(kind); };
    const auto vertices = [&](VertexKind kind) { return info.kinds.count(kind); };
    Json defects{{"closed", info.topology.closed},
                 {"balanced", info.topology.balanced},
                 {"inside_out", info.topology.inside_out},
                 {"components", info.defects.components},
                 {"open_edges", info.topology.open_edges},
                 {"boundary_edges", edges(EdgeKind::boundary)},
                 {"non_manifold_edges", edges(EdgeKind::non_manifold)},
                 {"unoriented_edges", edges(EdgeKind::unoriented)},
                 {"boundary_vertices", vertices(VertexKind::boundary)},
                 {"non_manifold_vertices", vertices(VertexKind::non_manifold)},
                 {"unused_vertices", info.topology.unused_vertices},
                 {"coincident_vertices", info.topology.coincident_vertices},
                 {"repeated_vertex_faces", info.topology.repeated_vertex_faces},
                 {"zero_area_faces", info.defects.zero_area_faces},
                 {"duplicate_faces", info.defects.duplicate_faces},
                 {"joined_vertices", info.topology.joined_vertices},
                 {"uncounted_faces", info.topology.uncounted_faces},
                 {"reoriented_faces", info.topology.reoriented_faces},
                 {"inner_wall_faces", info.topology.inner_wall_faces},
                 {"inward_parts", info.topology.inward_parts},
                 {"nested_parts", info.topology.nested_parts},
                 {"tested_points", info.topology.tested_points},
                 {"doubtful_points", info.topology.doubtful_points},
                 {"inside_points", info.topology.inside_points},
                 {"unclear_parts", info.topology.unclear_parts},
                 {"double_sided_faces", info.topology.double_sided_faces},
                 {"doubled_cavity_faces", info.topology.doubled_cavity_faces},
                 {"sheet_faces", info.topology.sheet_faces},
                 {"enclosing_faces", info.topology.enclosing_faces},
                 {"overlapping_parts", info.topology.overlapping_parts},
                 {"downward_faces", info.topology.downward_faces},
                 {"rim_loops", info.topology.rim_loops},
                 {"overlapping_rim_edges", info.topology.overlapping_rim_edges},
                 {"detail_parts", info.topology.detail_parts},
                 {"detail_faces", info.topology.detail_faces}};
    Json outer;  // null unless it is asked for
    if (info.outer)
        outer = {{"triangles", info.outer->faces.size()},
                 {"whole_faces", info.outer->whole_faces},
                 {"partial_faces", info.outer->partial_faces},
                 {"hidden_faces", info.outer->hidden_faces},
                 {"volume", info.outer->volume},
                 {"area", info.outer->area}};
    if (info.self_intersections) defects["self_intersections"] = *info.self_intersections;
    Json groups = Json::array();
    for (const Group& group : info.groups)
        groups.push_back({{"name", group.name},
                          {"faces", group.faces},
                          {"area", group.area},
                          {"lower", group.box.lower},
                          {"upper", group.box.upper}});
    return {{"box", {{"lower", info.box.lower}, {"upper", info.box.upper}}},
            {"vertices", info.vertices},
            {"triangles", info.triangles},
            {"saddle_vertices", vertices(VertexKind::saddle)},
            {"irregular_saddle_vertices", info.saddles.irregular.size()},
            {"gaps", {{"adjacent_pairs", info.saddles.adjacent_gaps.size()}, {"all_pairs", info.saddles.gaps.size()}}},
            {"convex_vertices", vertices(VertexKind::convex)},
            {"concave_vertices", vertices(VertexKind::concave)},
            {"flat_vertices", vertices(VertexKind::flat)},
            {"convex_edges", edges(EdgeKind::convex)},
            {"concave_edges", edges(EdgeKind::concave)},
            {"flat_edges", edges(EdgeKind::flat)},
            {"decisions", info.saddles.decisions},
            {"exact_decisions", info.saddles.exact_decisions},
            {"defects", defects},
            {"outer", outer},
            {"groups", groups}};
}

/// "1 face", "3 faces".
std::string counted(std::size_t count, const char* thing) {
    return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string closedness(const clsdf::Topology& topology) {
    const char* const turned = topology.inside_out ? ", inside out" : "";
    const std::size_t boundary = topology.boundary_edges, others = topology.open_edges - boundary;
    if (!topology.closed && others == 0)
        return fmt::format("open{}: {} with one face", turned, counted(boundary, "edge"));
    if (!topology.closed && boundary == 0)
        return fmt::format("not closed{}: {} with three faces or another odd number", turned, counted(others, "edge"));
    if (!topology.closed)
        return fmt::format("open{}: {} with one face, {} with three or another odd number", turned,
                           counted(boundary, "edge"), others);
    if (!topology.balanced) return "closed, faces not oriented alike";
    return topology.inside_out ? "closed, inside out" : "closed";
}

void print_groups(const std::vector<Group>& groups) {
    constexpr std::size_t most = 50;
    for (std::size_t i = 0; i < std::min(groups.size(), most); ++i) {
        const auto& [lower, upper] = groups[i].box;
        print_text("{}", fmt::format("{} {:<3} {}: {}, area {:.6g}, from ({:.6g}) to ({:.6g})\n",
                                     i == 0 ? "groups   " : "         ", i, clsdf::quoted(groups[i].name),
                                     counted(groups[i].faces, "face"), groups[i].area, fmt::join(lower, ", "),
                                     fmt::join(upper, ", ")));
    }
    if (groups.size() > most) print_text("          and {} more\n", groups.size() - most);
}

void print_human(const Info& info) {
    const auto edges = [&](EdgeKind kind) { return info.kinds.count(kind); };
    const auto vertices = [&](VertexKind kind) { return info.kinds.count(kind); };
    const double part = 100.0 / static_cast<double>(std::max<std::size_t>(info.vertices, 1));
    print_text("mesh      {} vertices, {} triangles, {} {}; {}\n", info.vertices, info.triangles,
               info.defects.components, info.defects.components == 1 ? "component" : "components",
               closedness(info.topology));
    print_text("{}",
               fmt::format("box       ({:.6g}) to ({:.6g}), longest side {:.6g}\n", fmt::join(info.box.lower, ", "),
                           fmt::join(info.box.upper, ", "), info.box.longest_side()));
    print_text("saddles   {} ({:.1f}%), {} of them not regular\n", vertices(VertexKind::saddle),
               part * static_cast<double>(vertices(VertexKind::saddle)), info.saddles.irregular.size());
    print_text("gaps      {} by adjacent pairs of planes, {} by all pairs\n", info.saddles.adjacent_gaps.size(),
               info.saddles.gaps.size());
    print_text("          {} decisions, {} of them beyond interval arithmetic\n", info.saddles.decisions,
               info.saddles.exact_decisions);
    print_text("vertices  {} convex, {} concave, {} flat, {} boundary, {} non-manifold, {} unused\n",
               vertices(VertexKind::convex), vertices(VertexKind::concave), vertices(VertexKind::flat),
               vertices(VertexKind::boundary), vertices(VertexKind::non_manifold), info.topology.unused_vertices);
    print_text("edges     {} convex, {} concave, {} flat, {} boundary, {} non-manifold, {} unoriented\n",
               edges(EdgeKind::convex), edges(EdgeKind::concave), edges(EdgeKind::flat), edges(EdgeKind::boundary),
               edges(EdgeKind::non_manifold), edges(EdgeKind::unoriented));
    print_text("defects   {} faces without area, {} with repeated vertices, {} duplicate; {} coincident vertices\n",
               info.defects.zero_area_faces, info.topology.repeated_vertex_faces, info.defects.duplicate_faces,
               info.topology.coincident_vertices);
    const clsdf::Topology& topology = info.topology;
    if (topology.joined_vertices + topology.uncounted_faces + topology.reoriented_faces + topology.sheet_faces > 0)
        print_text("sign      {} joined, {} not counted, {} turned around, {} left out\n",
                   topology.joined_vertices == 1 ? "1 vertex" : fmt::format("{} vertices", topology.joined_vertices),
                   counted(topology.uncounted_faces, "doubled face"), counted(topology.reoriented_faces, "face"),
                   counted(topology.sheet_faces, "face"));
    if (topology.tested_points > 0)
        print_text(
            "sign      {} of {} points beside faces and in boxes have a winding number in doubt, {} are inside: {}\n",
            topology.doubtful_points, topology.tested_points, topology.inside_points,
            name_of(resolve_sign_rule(clsdf::SignRule::automatic, topology).rule));
    if (topology.detail_parts > 0)
        print_text("sign      {} of {} {} of the body\n", counted(topology.detail_parts, "small open part"),
                   counted(topology.detail_faces, "face"),
                   topology.detail_parts == 1 ? "counts as a detail" : "count as details");
    if (info.outer)
        print_text(
            "outer     volume {:.6g}, area {:.6g}; of the faces {} are on the outer surface, {} in part, {} hidden\n",
            info.outer->volume, info.outer->area, info.outer->whole_faces, info.outer->partial_faces,
            info.outer->hidden_faces);
    print_groups(info.groups);
    if (info.self_intersections)
        print_text("          {}\n", *info.self_intersections == 1
                                         ? "1 pair of triangles intersects"
                                         : fmt::format("{} pairs of triangles intersect", *info.self_intersections));
}

/// Whether the ending is that of a field.
bool is_field(const std::string& path) {
    try {
        static_cast<void>(clsdf::stores_sparse_fields(path));
        return true;
    } catch (const clsdf::Error&) {
        return false;
    }
}

std::vector<std::string> output_names(clsdf::OutputSet outputs) {
    std::vector<std::string> names;
    for (const clsdf::OutputInfo& info : clsdf::output_table())
        if (outputs.contains(info.output) || info.output == clsdf::Output::distance) names.emplace_back(info.name);
    return names;
}

struct BrickCounts {
    std::size_t values = 0;
    std::int64_t inside = 0;
    std::int64_t all = 0;

    explicit BrickCounts(const clsdf::SparseField& field) : values(field.bricks.size()), all(1) {
        for (const clsdf::BrickRun& run : field.inside) inside += run.count;
        for (const std::int64_t size : in_whole_bricks(field.grid).size) all *= size / clsdf::brick_side;
    }
};

/// A field's file: how it was computed, what it has, and how much.
ExitStatus describe_field(const std::string& path, Report& report) {
    clsdf::OutputSet all;
    for (const clsdf::OutputInfo& info : extra_outputs()) all.insert(info.output);
    std::optional<BrickCounts> bricks;
    clsdf::FieldDescription field;
    clsdf::OutputSet outputs;
    std::size_t band_samples = 0;
    std::optional<clsdf::SparseField> sparse;
    // A tree whose band has no end, from a dense field or another program, is described as a dense field.
    try {
        sparse = clsdf::read_sparse_field(path, all);
    } catch (const clsdf::Error& error) {
        if (!clsdf::stores_sparse_fields_only(path) || error.code() != clsdf::ErrorCode::unreadable_input) throw;
    }
    if (sparse) {
        field = *sparse;
        outputs = sparse->outputs();
        bricks.emplace(*sparse);
        band_samples = count_band_samples(field, sparse->slab());
    } else {
        const clsdf::Field dense = clsdf::read_field(path, all);
        field = dense;
        outputs = dense.outputs();
        band_samples = count_band_samples(field, dense.slab());
    }
    report.result = {{"field", path},
                     {"grid", ::describe(field.grid)},
                     {"band", ::describe(field.band)},
                     {"sign", name_of(field.sign)},
                     {"positive_inside", field.positive_inside},
                     {"name", field.mesh_name},
                     {"outputs", output_names(outputs)},
                     {"band_samples", band_samples},
                     {"sparse", bricks.has_value()}};
    if (bricks)
        report.result["bricks"] = {{"values", bricks->values}, {"inside", bricks->inside}, {"all", bricks->all}};
    if (report.quiet) return ExitStatus::done;
    print_text("grid      {}\nband      {}\nsign      {}{}{}\n", human(field.grid),
               human(field.band, field.grid.voxel()), name_of(field.sign),
               field.positive_inside ? "; positive inside" : "",
               field.band.has_exact_signs ? "; exact on the surface" : "");
    print_text("outputs   {}\n", fmt::format("{}", fmt::join(output_names(outputs), ", ")));
    if (bricks)
        print_text("bricks    {} of {} have values ({:.2f}%), {} are inside\n", bricks->values, bricks->all,
                   100 * static_cast<double>(bricks->values) / static_cast<double>(bricks->all), bricks->inside);
    print_text("samples   {} within the band's limits\n", band_samples);
    return ExitStatus::done;
}

ExitStatus run(const InfoOptions& options, Report& report) {
    if (options.mesh.size() == 1 && is_field(options.mesh.front())) {
        if (options.self_intersections || options.outer || options.reading.is_told())
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               fmt::format("{}: options of reading a mesh, --outer and --self-intersections are about "
                                           "meshes, and this is a field; leave them out",
                                           options.mesh.front()));
        return describe_field(options.mesh.front(), report);
    }
    const Info info(options, read_body(options.mesh, options.reading, report));
    if (!report.quiet) print_human(info);
    const std::string warning = resolve_sign_rule(clsdf::SignRule::automatic, info.topology).warning;
    if (!warning.empty()) report.warn(warning);
    report.result["mesh"] = paths_of(options.mesh);
    report.result.update(describe(info));
    return ExitStatus::done;
}

}  // namespace

Command add_info(Parser& program) {
    const auto options = std::make_shared<InfoOptions>();
    Parser parser =
        program.add_subcommand("info", "Count a mesh's saddle vertices, gaps and defects, or describe a field");
    parser
        .add("MESH", options->mesh,
             "the mesh: .off, .obj, .stl or .ply; several files are one body; or a field: .nrrd, .npy, .vti, "
             ".vtkhdf, .h5, .vdb, .nvdb or .sdf")
        .required();
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    add_group_option(parser, options->reading);
    add_placement_options(parser, options->reading);
    parser.add("--outer", options->outer, "volume and area of the outer surface, and faces hidden within others, too");
    parser.add("--self-intersections", options->self_intersections, "count the pairs of triangles that intersect, too");
    parser.set_footer(
        "Saddle vertices have convex and concave edges; at some of them the polyhedra of Peikert & Sigg leave gaps.\n"
        "Both are decided exactly on the coordinates as given. The file of a "
        "field is read whole, and its grid, band,\n"
        "sign, outputs and, if it is sparse, its bricks are told.\n\n"
        "Examples:\n"
        "  clsdf info bunny.off\n"
        "  clsdf info bunny.nvdb\n"
        "  clsdf info bunny.off --self-intersections --json > bunny.json");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
