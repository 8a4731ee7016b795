#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

using clsdf::test::check_refused;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;

namespace {

// Some hundred milliseconds after the mesh has been read, the device is being set up or computes, which would take
// minutes. Only the compilation of a program cannot be interrupted, and takes long on a busy machine.
void check_interrupted_by(int signal) {
    for (const int milliseconds : {0, 100, 500}) {
        BOOST_TEST_CONTEXT("interrupted after " << milliseconds << " ms") {
            const TemporaryFolder folder;
            const std::string mesh = folder.file("mesh.off");
            BOOST_REQUIRE(run_command({"shape", "sphere6", "-o", mesh}).status == 0);
            Process process({"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "700", "--band", "full"});
            while (process.error_so_far().find("sign") == std::string::npos)
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
            const auto interrupted = std::chrono::steady_clock::now();
            process.send(signal);
            const Outcome outcome = process.wait();
            const std::chrono::duration<double> delay = std::chrono::steady_clock::now() - interrupted;
            BOOST_TEST(outcome.status == 6);
            BOOST_TEST(delay.count() < 30);
            BOOST_TEST(folder.file_count() == 1U);
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(an_interrupted_command)

BOOST_AUTO_TEST_CASE(ends_soon_with_status_6_and_leaves_nothing) {
    check_interrupted_by(SIGINT);
}

BOOST_AUTO_TEST_CASE(ends_the_same_way_when_it_is_told_to_terminate) {
    check_interrupted_by(SIGTERM);
}

BOOST_AUTO_TEST_CASE(leaves_nothing_where_it_was_writing) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    // A pipe without a reader: distances and description have temporary files, and the triangles wait.
    BOOST_REQUIRE(::mkfifo(folder.file("field_triangle.npy").c_str(), 0600) == 0);
    Process process(
        {"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "16", "--with", "triangle", "--json"});
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (folder.file_count() < 4 && std::chrono::steady_clock::now() < give_up)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    BOOST_REQUIRE(folder.file_count() == 4U);
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    BOOST_TEST(outcome.status == 6);
    BOOST_TEST(folder.file_count() == 2U);
    BOOST_TEST(outcome.error.find("cancelled; nothing was written") != std::string::npos);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["error"]["code"] == "cancelled");
}

BOOST_AUTO_TEST_CASE(ends_at_once_where_nothing_has_to_be_put_in_order) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off");
    const std::string field = folder.file("field.nrrd");
    BOOST_REQUIRE(run_command({"shape", "sphere6", "-o", mesh}).status == 0);
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", field, "--resolution", "160"}).status == 0);
    Process process({"check", mesh, field, "--complete"});  // for minutes
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    process.send(SIGINT);
    check_refused(process.wait(), 6, {"cancelled"});
}

BOOST_AUTO_TEST_SUITE_END()
