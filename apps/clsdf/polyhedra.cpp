#include "command.hpp"
#include "interruption.hpp"
#include "option_values.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/papers.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>

namespace {

using clsdf::BoundingSolid;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::FaceColour;
using clsdf::Mesh;
using clsdf::SolidPart;

struct PolyhedraOptions {
    std::vector<std::string> mesh;
    MeshReading reading;
    std::string output;
    std::optional<std::uint32_t> around;
    std::vector<std::uint32_t> triangles;
    std::string polyhedra = "leaned";
    std::string half_width = "10%";
    bool no_closing = false;
};

// Okabe and Ito's, which readers with any colour vision tell apart, then lighter ones.
constexpr std::array<FaceColour, 12> palette{{{230, 159, 0},
                                              {86, 180, 233},
                                              {0, 158, 115},
                                              {240, 228, 66},
                                              {0, 114, 178},
                                              {213, 94, 0},
                                              {204, 121, 167},
                                              {153, 221, 204},
                                              {255, 201, 128},
                                              {170, 170, 221},
                                              {187, 204, 85},
                                              {238, 153, 153}}};
constexpr FaceColour grey{128, 128, 128};

FaceColour colour_of(const BoundingSolid& solid, std::size_t place) {
    if (solid.part == SolidPart::point_site) return grey;
    FaceColour colour = palette[place % palette.size()];
    if (solid.part == SolidPart::back)
        for (std::uint8_t& part : colour) part = static_cast<std::uint8_t>(part * 3 / 5);
    return colour;
}

const char* name_of(SolidPart part) {
    switch (part) {
        case SolidPart::both_sides:
            return "both sides";
        case SolidPart::front:
            return "front";
        case SolidPart::back:
            return "back";
        default:
            return "point site";
    }
}

double volume(const Mesh& mesh) {
    const clsdf::Vec3& origin = mesh.vertices().front();
    double sum = 0;
    for (const clsdf::Triangle& triangle : mesh.triangles()) {
        std::array<clsdf::Vec3, 3> p{};
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis) p[k][axis] = mesh.vertices()[triangle[k]][axis] - origin[axis];
        sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return sum / 6;
}

/// The first vertex at which the paper's polyhedra leave a gap, else the first saddle, else the first in use.
std::uint32_t interesting_vertex(const Mesh& mesh) {
    const std::vector<std::uint32_t> gaps = examine_saddles(mesh).gaps;
    if (!gaps.empty()) return gaps.front();
    const std::vector<clsdf::VertexKind> kinds = classify_convexity(mesh).vertices;
    const auto saddle = std::find(kinds.begin(), kinds.end(), clsdf::VertexKind::saddle);
    if (saddle != kinds.end()) return static_cast<std::uint32_t>(saddle - kinds.begin());
    return mesh.triangles().front().front();
}

double half_width_of(const std::string& text, const Mesh& mesh) {
    const auto wrong = [&](const std::string& what) {
        return Error(ErrorCode::invalid_argument,
                     fmt::format("--half-width: {}; give a length in the mesh's units, or in percent of the longest "
                                 "side of its box",
                                 what));
    };
    const clsdf::Length length = clsdf::Length::parse(text, "--half-width");
    if (length.is_infinite()) throw wrong("polyhedra have an end");
    if (length.unit == clsdf::Length::Unit::voxels) throw wrong("there are no voxels here");
    const double side = mesh.box().longest_side(), result = length.resolve(0, side);
    if (!(result > 0)) throw wrong(fmt::format("'{}' is no positive length", text));
    constexpr double most = 1e6;
    if (result > most * side || result < side / most)
        throw wrong(fmt::format("'{}' is not between {:g} and {:g} times the longest side of the mesh, {:g}", text,
                                1 / most, most, side));
    return result;
}

std::vector<BoundingSolid> make_solids(const PolyhedraOptions& options, const Mesh& mesh,
                                       const std::vector<std::uint32_t>& triangles) {
    const double half_width = half_width_of(options.half_width, mesh);
    if (options.polyhedra == "peikert-sigg")
        return peikert_sigg_solids(mesh, triangles, half_width, !options.no_closing);
    if (options.no_closing)
        throw Error(ErrorCode::invalid_argument,
                    "--no-closing: leaned polyhedra have no gaps to close; it goes with --polyhedra peikert-sigg");
    return leaned_solids(mesh, triangles, half_width);
}

struct ColouredMesh {
    Mesh mesh;
    std::vector<FaceColour> colours;
};

ColouredMesh join(const std::vector<BoundingSolid>& solids, const std::vector<std::uint32_t>& triangles) {
    std::vector<clsdf::Vec3> vertices;
    std::vector<clsdf::Triangle> faces;
    std::vector<FaceColour> colours;
    std::unordered_map<std::uint32_t, std::size_t> places;
    for (std::size_t place = 0; place < triangles.size(); ++place) places.emplace(triangles[place], place);
    for (const BoundingSolid& solid : solids) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), solid.mesh.vertices().begin(), solid.mesh.vertices().end());
        for (const auto& [a, b, c] : solid.mesh.triangles()) faces.push_back({a + first, b + first, c + first});
        colours.resize(faces.size(), colour_of(solid, places.at(solid.triangle)));
    }
    return {Mesh(std::move(vertices), std::move(faces), "polyhedra"), std::move(colours)};
}

ExitStatus run(const PolyhedraOptions& options, Report& report) {
    keep_mesh(options.mesh, options.output);
    const Mesh mesh = read_body(options.mesh, options.reading, report);
    std::optional<std::uint32_t> vertex = options.around;
    if (!vertex && options.triangles.empty()) vertex = interesting_vertex(mesh);
    const std::vector<std::uint32_t> triangles = vertex ? triangles_at(mesh, *vertex) : options.triangles;
    const std::vector<BoundingSolid> solids = make_solids(options, mesh, triangles);
    if (solids.empty())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: the triangles asked for have no polyhedra with volume", paths_of(options.mesh)));
    const ColouredMesh joined = join(solids, triangles);
    write_mesh(joined.mesh, options.output, joined.colours);
    output_is_written();

    report.print("{}{} polyhedra of {} triangles, {} vertices, {} faces -> {}\n",
                 vertex ? fmt::format("vertex {}: ", *vertex) : "", solids.size(), triangles.size(),
                 joined.mesh.vertices().size(), joined.mesh.triangles().size(), options.output);
    Json list = Json::array();
    for (const BoundingSolid& solid : solids)
        list.push_back({{"triangle", solid.triangle},
                        {"part", name_of(solid.part)},
                        {"faces", solid.mesh.triangles().size()},
                        {"volume", volume(solid.mesh)}});
    report.result = {{"mesh", paths_of(options.mesh)}, {"output", options.output}};
    if (vertex) report.result["vertex"] = *vertex;
    report.result["half_width"] = half_width_of(options.half_width, mesh);
    report.result["polyhedra"] = list;
    return ExitStatus::done;
}

}  // namespace

Command add_polyhedra(Parser& program) {
    const auto options = std::make_shared<PolyhedraOptions>();
    Parser parser = program.add_subcommand("polyhedra", "Write the bounding polyhedra of some triangles as a mesh");
    add_mesh_argument(parser, options->mesh);
    parser.add("-o,--output", options->output, "the polyhedra: .ply, which has colours, .off, .obj or .stl")
        .takes("FILE")
        .required();
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    parser.add("--around", options->around, "the triangles at this vertex, from 0; else one with a gap")
        .takes_whole_number("VERTEX", 0, most);
    parser.add("--triangles", options->triangles, "these triangles, from 0, and no others")
        .takes_whole_number("I,J,...", 0, most)
        .separated_by_commas()
        .excludes("--around");
    parser.add("--polyhedra", options->polyhedra, "leaned, which are exact, or peikert-sigg, the paper's")
        .takes_one_of({"leaned", "peikert-sigg"});
    parser.add("--half-width", options->half_width, "of the band: 10% of the mesh's longest side, or 0.05")
        .takes("LENGTH");
    add_skip_option(parser, options->reading);
    parser.add("--no-closing", options->no_closing, "the paper's polyhedra before their gaps are closed");
    parser.set_footer(
        "Every triangle has a colour; the back of a leaned polyhedron is darker, and a point site grey. Without "
        "--around\n"
        "and --triangles the vertex is the first at which the paper's polyhedra leave a gap, else the first saddle.\n\n"
        "Examples:\n"
        "  clsdf polyhedra knot.off -o leaned.ply --half-width 2%\n"
        "  clsdf polyhedra knot.off -o gap.ply --polyhedra peikert-sigg --no-closing --around 12");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
