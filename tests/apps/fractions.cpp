#include "apps/process.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/mesh_files.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Two cubes that overlap: a bar of 3 by 2 by 2, whose walls lie half a cell beyond samples.
struct Inputs {
    TemporaryFolder folder;
    std::string mesh = folder.file("bar.off");
    Mesh bar = together({box({-1, -1, -1}, {1, 1, 1}), box({0, -1, -1}, {2, 1, 1})}, "bar");
    Grid grid{{-1.25, -1.25, -1.25}, {0.5, 0.5, 0.5}, {8, 6, 6}, {}};

    Inputs() { write_mesh(bar, mesh); }

    Outcome run(const std::string& output, const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{
            "fractions", mesh, "-o", output, "--size", "8,6,6", "--origin", "-1.25,-1.25,-1.25", "--spacing", "0.5"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_command(arguments);
    }
};

/// The bytes of an array of a .npz file, which is not compressed.
std::string array_of(const std::string& archive, const std::string& name, std::size_t bytes) {
    const std::size_t entry = archive.find(name + ".npy");
    BOOST_REQUIRE_MESSAGE(entry != std::string::npos, name);
    const std::size_t end = archive.find('\n', archive.find("'shape'", entry));
    return archive.substr(end + 1, bytes);
}

}  // namespace

BOOST_AUTO_TEST_CASE(fractions_are_written_in_each_format) {
    const Inputs inputs;
    const Fractions found = fractions(inputs.bar, inputs.grid);
    const std::string npz = inputs.folder.file("bar.npz"), vti = inputs.folder.file("bar.vti"),
                      h5 = inputs.folder.file("bar.h5");
    const Outcome outcome = inputs.run(npz, {"--json"});
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    BOOST_TEST(report["cut_cells"] == found.cells.size());
    BOOST_TEST(report["full_cells"] == 45U);
    BOOST_TEST(std::abs(report["volume"].get<double>() - 12) < 1e-12);
    BOOST_TEST(std::abs(report["area"].get<double>() - 32) < 1e-12);
    BOOST_TEST(report["outer_volume"] == 12);
    const std::string archive = content_of(npz);
    std::string cells, volumes, centroids;
    for (const CellFraction& cell : found.cells) {
        cells.append(reinterpret_cast<const char*>(cell.cell.data()), sizeof cell.cell);
        volumes.append(reinterpret_cast<const char*>(&cell.volume), sizeof cell.volume);
        centroids.append(reinterpret_cast<const char*>(cell.face_centroids.data()), sizeof cell.face_centroids);
    }
    BOOST_TEST((array_of(archive, "cells", cells.size()) == cells));
    BOOST_TEST((array_of(archive, "volume", volumes.size()) == volumes));
    BOOST_TEST((array_of(archive, "face_centroids", centroids.size()) == centroids));
    const std::string full = array_of(archive, "full", 7 * 5 * 5);
    for (std::size_t n = 0; n < full.size(); ++n) BOOST_TEST((full[n] == 1) == found.is_full(n % 7, n / 7 % 5, n / 35));

    BOOST_TEST(inputs.run(h5, {}).status == 0);
    BOOST_TEST((content_of(h5).find("face_fractions") != std::string::npos));

    // All cells, each led by the number of its bytes.
    BOOST_TEST(inputs.run(vti, {"--convention", "vtk"}).status == 0);
    const std::string document = content_of(vti);
    BOOST_TEST(document.find("WholeExtent=\"0 7 0 5 0 5\" Origin=\"-1.25 -1.25 -1.25\"") != std::string::npos);
    const std::size_t begin = document.find("\n_") + 2;
    std::uint64_t size = 0;
    std::memcpy(&size, document.data() + begin, sizeof size);
    BOOST_REQUIRE(size == 7U * 5 * 5 * sizeof(double));
    double sum = 0;
    for (std::size_t n = 0; n < 7U * 5 * 5; ++n) {
        double volume = 0;
        std::memcpy(&volume, document.data() + begin + sizeof size + n * sizeof volume, sizeof volume);
        sum += volume;
    }
    BOOST_TEST(std::abs(sum / 8 - 12) < 1e-12);
}

BOOST_AUTO_TEST_CASE(conventions_of_fractions_are_options) {
    const Inputs inputs;
    const std::string npz = inputs.folder.file("bar.npz");
    const auto report = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = more;
        arguments.emplace_back("--json");
        const Outcome outcome = inputs.run(npz, arguments);
        BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
        return nlohmann::json::parse(outcome.out);
    };
    const nlohmann::json amrex = report({"--convention", "amrex"});
    BOOST_TEST(amrex["part"] == "fluid");
    BOOST_TEST(std::abs(amrex["volume"].get<double>() - (7 * 5 * 5 / 8.0 - 12)) < 1e-12);
    BOOST_TEST(report({"--convention", "amrex", "--part", "solid"})["part"] == "solid");
    BOOST_TEST(report({"--snap", "1e-6"})["cut_cells"] == 130U);
    check_refused(inputs.run(npz, {"--convention", "vof"}), 2, {"--convention", "plain"});
    check_refused(inputs.run(npz, {"--snap", "0.5"}), 2, {"snap", "0.001"});
    check_refused(inputs.run(npz, {"--cell-centred"}), 2, {"--cell-centred", "leave it out"});
    check_refused(inputs.run(inputs.folder.file("bar.csv"), {}), 2, {".npz", ".vti"});
    const std::string open = inputs.folder.file("open.off");
    write_mesh(Mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, "open"), open);
    check_refused(run_command({"fractions", open, "-o", npz}), 2, {"outer surface", "closed mesh"});
}
