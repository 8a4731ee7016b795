// No subcommand that reads a mesh takes time that grows with the square of the faces at a vertex or an edge. Processor
// time is compared at three sizes, each four times the one before: the increments grow by 4 if time is linear, by 16 if
// it is quadratic. `query` is given as many points as faces. One exception: if many faces are equally near to a
// point, it is compared with each of them, as with faces that coincide, and on the axis of a cone. There the number of
// points stays the same. Another exception is `info --self-intersections`, which compares all pairs of faces whose
// boxes overlap (docs/command.md). `slice` and `render` read fields, whose size the faces do not change.
#include "apps/process.hpp"

#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

using clsdf::Mesh;
using clsdf::Triangle;
using clsdf::Vec3;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;

namespace {

constexpr std::array<std::uint32_t, 3> sizes{1000, 4000, 16000};

Vec3 on_circle(std::uint32_t i, std::uint32_t count, double height) {
    const double angle = 2 * std::numbers::pi * i / count;
    return {std::cos(angle), std::sin(angle), height};
}

/// `pages` triangles at one edge.
Mesh book(std::uint32_t pages) {
    std::vector<Vec3> vertices{{0, 0, 0}, {0, 0, 1}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < pages; ++i) {
        vertices.push_back(on_circle(i, pages, 0.5));
        triangles.push_back({0, 1, i + 2});
    }
    return {std::move(vertices), std::move(triangles), "book"};
}

/// `faces` triangles between a vertex and a ring around it.
template <typename Height>
Mesh ring(std::uint32_t faces, const Height& height) {
    std::vector<Vec3> vertices{{0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < faces; ++i) {
        vertices.push_back(on_circle(i, faces, height(2 * std::numbers::pi * i / faces)));
        triangles.push_back({0, 1 + i, 1 + (i + 1) % faces});
    }
    return {std::move(vertices), std::move(triangles), "ring"};
}

Mesh cone(std::uint32_t faces) {
    return ring(faces, [](double) { return -1; });
}

Mesh disc(std::uint32_t faces) {
    return ring(faces, [](double) { return 0; });
}

Mesh saddle(std::uint32_t faces) {
    return ring(faces, [](double angle) { return 0.6 * std::cos(3 * angle); });
}

/// Every second edge is concave, and all bisector planes nearly meet in a line.
Mesh zigzag(std::uint32_t faces) {
    bool is_up = false;
    return ring(faces, [&](double) { return (is_up = !is_up) ? 0.3 : -0.3; });
}

/// One triangle, over and over.
Mesh pile(std::uint32_t faces) {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(faces, Triangle{0, 1, 2}), "pile"};
}

/// An OBJ file with one polygon of 3 `turns` corners at three vertices.
std::string polygon(std::uint32_t turns) {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (std::uint32_t i = 0; i < turns; ++i) text += " 1 2 3";
    return text + "\n";
}

std::string points(std::uint32_t count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1.2, 1.2);
    std::string text = "x,y,z\n";
    for (std::uint32_t i = 0; i < count; ++i)
        text += fmt::format("{},{},{}\n", coordinate(random), coordinate(random), coordinate(random));
    return text;
}

std::vector<std::vector<std::string>> commands(const std::string& mesh, std::uint32_t point_count,
                                               const std::string& field, const TemporaryFolder& folder) {
    const std::string all_outputs = "triangle,site,closest,gradient,barycentric,offset";
    const std::vector<std::string> compute{"compute", mesh, "-o", field, "--resolution", "8", "--quiet"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), compute.begin(), compute.end());
        return more;
    };
    return {{"info", mesh, "--quiet"},
            with({"--polyhedra", "mauch"}),
            with({"--polyhedra", "peikert-sigg"}),
            with({"--with", all_outputs}),
            {"query", mesh, folder.file("points.csv", points(point_count)), "-o", folder.file("found.npy"), "--with",
             all_outputs, "--quiet"},
            compute,
            {"check", mesh, field, "--samples", "100", "--quiet"},
            {"polyhedra", mesh, "-o", folder.file("all.ply"), "--quiet"},
            {"polyhedra", mesh, "-o", folder.file("papers.ply"), "--polyhedra", "peikert-sigg", "--around", "0",
             "--quiet"}};
}

/// The points of `query`.
enum class Points { as_many_as_faces, few };

void check_growth(const char* name, Points points,
                  const std::function<std::string(std::uint32_t, const TemporaryFolder&)>& write) {
    const TemporaryFolder folder;
    using Seconds = std::array<double, sizes.size()>;
    // Below a fifth of a second the start of the program counts.
    const auto is_nearly_linear = [](const Seconds& of) { return of[2] - of[1] < 8 * std::max(of[1] - of[0], 0.2); };
    std::vector<Seconds> seconds;
    std::vector<std::vector<std::string>> asked;
    std::vector<bool> is_in_doubt;
    // Keeps the least of several measurements, because other work on the machine adds to the processor time, too.
    for (int times = 0; times < 4 && (times == 0 || std::ranges::count(is_in_doubt, true) > 0); ++times) {
        for (std::size_t size = 0; size < sizes.size(); ++size) {
            asked = commands(write(sizes[size], folder), points == Points::few ? 100 : sizes[size],
                             folder.file(fmt::format("field{}.nrrd", size)), folder);
            Seconds none;
            none.fill(std::numeric_limits<double>::infinity());
            seconds.resize(asked.size(), none);
            is_in_doubt.resize(asked.size(), true);
            for (std::size_t i = 0; i < asked.size(); ++i) {
                if (!is_in_doubt[i]) continue;
                const Outcome outcome = run_command(asked[i]);
                BOOST_TEST_CONTEXT(name << ", " << asked[i][0] << ": " << outcome.error)
                BOOST_TEST(outcome.status == 0);
                seconds[i][size] = std::min(seconds[i][size], outcome.cpu_seconds);
            }
        }
        for (std::size_t i = 0; i < asked.size(); ++i) is_in_doubt[i] = !is_nearly_linear(seconds[i]);
    }
    for (std::size_t i = 0; i < asked.size(); ++i) {
        const auto& [small, middle, large] = seconds[i];
        std::string words;
        for (const std::string& word : asked[i]) words += word + " ";
        BOOST_TEST_CONTEXT(name << ": " << words << "took " << small << ", " << middle << " and " << large << " s")
        BOOST_TEST(is_nearly_linear(seconds[i]));
    }
}

void check_mesh_growth(const char* name, Mesh (*make)(std::uint32_t), Points points = Points::as_many_as_faces) {
    check_growth(name, points, [make](std::uint32_t size, const TemporaryFolder& folder) {
        const std::string path = folder.file("mesh.ply");
        write_mesh(make(size), path);
        return path;
    });
}

}  // namespace

BOOST_AUTO_TEST_CASE(faces_at_an_edge) {
    check_mesh_growth("a book", book);
    check_mesh_growth("a pile", pile, Points::few);
}

BOOST_AUTO_TEST_CASE(faces_at_a_regular_vertex) {
    check_mesh_growth("a cone", cone, Points::few);
    check_mesh_growth("a disc", disc);
}

BOOST_AUTO_TEST_CASE(faces_at_a_saddle_vertex) {
    check_mesh_growth("a saddle", saddle);
    check_mesh_growth("a zigzag", zigzag);
}

BOOST_AUTO_TEST_CASE(corners_of_a_polygon) {
    check_growth("a polygon", Points::few, [](std::uint32_t size, const TemporaryFolder& folder) {
        return folder.file("mesh.obj", polygon(size));
    });
}
