#include "check_points.hpp"

#include "core/stopwatch.hpp"
#include "io/meshes/point_results.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

using clsdf::Vec3;
using clsdf::reference::PointCheckReport;

namespace {

/// The arrays of the files.
struct Given {
    std::vector<Vec3> points;
    std::vector<double> distances;
    std::vector<Vec3> closest;
    std::vector<Vec3> gradients;
    std::vector<std::uint32_t> triangles;

    clsdf::reference::PointResults results() const { return {distances, closest, gradients, triangles}; }
};

Given read(const PointsToCheck& files, Report& report) {
    Given given;
    given.points = clsdf::read_points(files.points, [&](const std::string& message) { report.warn(message); });
    given.distances = clsdf::read_point_numbers(files.distances, "distance");
    if (!files.closest.empty()) given.closest = clsdf::read_point_vectors(files.closest, "closest");
    if (!files.gradients.empty()) given.gradients = clsdf::read_point_vectors(files.gradients, "gradient");
    if (files.triangles.empty()) return given;
    for (const double number : clsdf::read_point_numbers(files.triangles, "triangle"))
        given.triangles.push_back(number >= 0 && number < double{clsdf::no_triangle}
                                      ? static_cast<std::uint32_t>(number)
                                      : clsdf::no_triangle);
    return given;
}

void require_as_many(const PointsToCheck& files, const Given& given) {
    const auto require = [&](const std::string& file, std::size_t size) {
        if (file.empty() || size == given.points.size()) return;
        throw clsdf::Error(clsdf::ErrorCode::unreadable_input,
                           fmt::format("{}: there are {} rows, and {} has {} points; give a row for each point", file,
                                       size, files.points, given.points.size()));
    };
    require(files.distances, given.distances.size());
    require(files.closest, given.closest.size());
    require(files.gradients, given.gradients.size());
    require(files.triangles, given.triangles.size());
}

Json describe(const PointCheckReport& found, const std::vector<Vec3>& points) {
    Json findings = Json::array();
    for (const PointCheckReport::Finding& finding : found.findings)
        findings.push_back({{"point", finding.point}, {"position", points[finding.point]}, {"what", finding.what}});
    return {{"passed", found.passed()},
            {"points", found.points},
            {"max_error", found.max_error},
            {"wrong_distances", found.wrong_distances},
            {"wrong_signs", found.wrong_signs},
            {"wrong_closest", found.wrong_closest},
            {"wrong_gradients", found.wrong_gradients},
            {"wrong_triangles", found.wrong_triangles},
            {"findings", findings}};
}

void print_human(const PointCheckReport& found, const std::vector<Vec3>& points, const std::string& mesh,
                 const char* sign, double seconds) {
    print_text("sign      {}\nlooked at {} of {} points in {:.2f} s\n\n", sign, found.points, points.size(), seconds);
    print_text(
        "| mesh | points | largest error | wrong distances | wrong signs | wrong closest points | wrong gradients "
        "| wrong triangles |\n|-|-:|-:|-:|-:|-:|-:|-:|\n");
    print_text("| {} | {} | {:.3g} | {} | {} | {} | {} | {} |\n\n", mesh, found.points, found.max_error,
               found.wrong_distances, found.wrong_signs, found.wrong_closest, found.wrong_gradients,
               found.wrong_triangles);
    for (const PointCheckReport::Finding& finding : found.findings) {
        const auto& [x, y, z] = points[finding.point];
        print_text("  point {}, ({}, {}, {}): {}\n", finding.point, x, y, z, finding.what);
    }
    print_text("{}\n", found.passed() ? "passed: the results keep the contract" : "FAILED");
}

}  // namespace

void add_options_of_points(Parser& parser, PointsToCheck& points) {
    parser.begin_group("Results at points");
    parser
        .add("--points", points.points, "judge results of any program at these points, not a field: .npy, .csv or .ply")
        .takes("POINTS")
        .excludes("--samples")
        .excludes("--complete")
        .excludes("--seed")
        .excludes("--tolerance-voxels");
    parser.add("--distances", points.distances, "a number for each point, .npy, or .csv with the column distance")
        .takes("FILE")
        .needs("--points");
    parser.add("--closest", points.closest, "the closest points, too: .npy, or .csv with the columns closest_x, ...")
        .takes("FILE")
        .needs("--distances");
    parser.add("--gradients", points.gradients, "the gradients, too: .npy, or .csv with the columns gradient_x, ...")
        .takes("FILE")
        .needs("--distances");
    parser
        .add("--triangles", points.triangles,
             "the nearest triangles, too, from 0: .npy, or .csv with the column triangle")
        .takes("FILE")
        .needs("--distances");
    parser.add("--sign", points.sign.rule, "the rule that decides what is inside, at points")
        .takes_one_of({"auto", "nonzero", "parity", "solid-angle", "below", "none"})
        .needs("--points");
    parser.add("--tolerance", points.tolerance, "an error up to this keeps the contract, in the mesh's units")
        .takes_number_of_0_or_more("X")
        .needs("--points");
    parser.begin_group("Options");
}

ExitStatus check_points(const PointsToCheck& given, const std::vector<std::string>& meshes, const MeshReading& reading,
                        bool positive_inside, const std::optional<double>& floor, clsdf::Surface surface,
                        Report& report) {
    if (given.distances.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "--points: the distances are missing; give them by --distances FILE");
    SignChoice sign = given.sign;
    sign.floor = floor;
    clsdf::reference::PointCheckOptions options;
    options.sign = parse_sign(sign);
    options.floor = floor;
    options.tolerance = given.tolerance;
    if (surface == clsdf::Surface::outer && !given.triangles.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "--triangles: with --surface outer they are those of the faces as given, which the outer "
                           "surface does not have; leave them out");
    clsdf::Mesh mesh = read_body(meshes, reading, report);
    Given found = read(given, report);
    require_as_many(given, found);
    if (positive_inside) {
        for (double& distance : found.distances) distance = -distance;
        for (Vec3& gradient : found.gradients)
            for (double& component : gradient) component = -component;
    }
    if (options.sign == clsdf::SignRule::automatic)
        options.sign = resolve_sign_rule(options.sign, describe_topology(mesh)).rule;
    if (surface == clsdf::Surface::outer) mesh = clsdf::outer(mesh, options.sign).mesh;

    const clsdf::Stopwatch watch;
    const PointCheckReport judged = clsdf::reference::check_points(mesh, found.points, found.results(), options);
    const double seconds = watch.seconds();
    const char* const rule = name_of(options.sign);
    if (!report.quiet || !judged.passed()) print_human(judged, found.points, names_of(meshes), rule, seconds);
    report.result = {{"mesh", paths_of(meshes)},
                     {"points_file", given.points},
                     {"distances", given.distances},
                     {"sign", rule},
                     {"positive_inside", positive_inside},
                     {"tolerance", given.tolerance},
                     {"seconds", seconds}};
    report.result.update(describe(judged, found.points));
    return judged.passed() ? ExitStatus::done : ExitStatus::check_failed;
}
