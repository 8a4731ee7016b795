#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;

namespace {

// A few hundred milliseconds after the mesh has been read, the device is being set up or computes, which would take
// minutes. Only the compilation of a program cannot be interrupted, and takes long on a busy machine.
void check_interrupted_by(int signal) {
    for (const int milliseconds : {0, 100, 500}) {
        BOOST_TEST_CONTEXT("interrupted after " << milliseconds << " ms") {
            const TemporaryFolder folder;
            const std::string mesh = folder.file("mesh.off");
            BOOST_REQUIRE(run_command({"shape", "sphere6", "-o", mesh}).status == 0);
            Process process({"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "700", "--band", "full"});
            process.wait_until([&] { return process.error_so_far().find("sign") != std::string::npos; });
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

void wait_for_files(const Process& process, const TemporaryFolder& folder, std::size_t count) {
    process.wait_until([&] { return folder.file_count() >= count; });
    BOOST_REQUIRE(folder.file_count() == count);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(an_interrupted_command)

BOOST_AUTO_TEST_CASE(ends_soon_with_status_6_and_leaves_nothing) {
    check_interrupted_by(SIGINT);
}

BOOST_AUTO_TEST_CASE(ends_the_same_way_when_it_is_told_to_terminate) {
    check_interrupted_by(SIGTERM);
}

BOOST_AUTO_TEST_CASE(ends_the_same_way_when_its_terminal_hangs_up) {
    check_interrupted_by(SIGHUP);
}

BOOST_AUTO_TEST_CASE(goes_on_when_its_terminal_hangs_up_if_it_was_told_to_by_nohup) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    // A pipe without a reader holds it up until the signal has arrived.
    const std::string pipe = folder.file("field_triangle.npy");
    BOOST_REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    Process process({"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "16", "--with", "triangle"}, {},
                    {}, [] { ::signal(SIGHUP, SIG_IGN); });
    wait_for_files(process, folder, 4);
    process.send(SIGHUP);
    BOOST_TEST(content_of(pipe).size() > 16U * 4);
    BOOST_TEST(process.wait().status == 0);
    BOOST_TEST(std::filesystem::exists(folder.file("field.npy")));
}

BOOST_AUTO_TEST_CASE(leaves_what_it_was_writing_to_the_next_one_if_it_is_killed) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    BOOST_REQUIRE(::mkfifo(folder.file("field_triangle.npy").c_str(), 0600) == 0);
    Process process({"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "16", "--with", "triangle"});
    wait_for_files(process, folder, 4);
    const auto compute_another = [&](const std::string& name) {
        BOOST_REQUIRE(run_command({"compute", mesh, "-o", folder.file(name), "--resolution", "16"}).status == 0);
    };
    compute_another("while_it_lives.nrrd");
    BOOST_TEST(folder.file_count() == 5U);
    process.send(SIGKILL);
    BOOST_TEST(process.wait().status == -SIGKILL);
    BOOST_TEST(folder.file_count() == 5U);
    compute_another("afterwards.nrrd");
    BOOST_TEST(folder.file_count() == 4U);
}

BOOST_AUTO_TEST_CASE(leaves_nothing_where_it_was_writing) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    // A pipe without a reader: distances and description have temporary files, and the triangles wait.
    BOOST_REQUIRE(::mkfifo(folder.file("field_triangle.npy").c_str(), 0600) == 0);
    Process process(
        {"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "16", "--with", "triangle", "--json"});
    wait_for_files(process, folder, 4);
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    BOOST_TEST(outcome.status == 6);
    BOOST_TEST(folder.file_count() == 2U);
    BOOST_TEST(outcome.error.find("cancelled; nothing was written") != std::string::npos);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["error"]["code"] == "cancelled");
}

// The second signal does not wait for the compiler. What the compiler left is no harm to the next process.
BOOST_AUTO_TEST_CASE(does_not_wait_for_a_compiler) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron), compiled = folder.file("pocl");
    const std::vector<std::string> compute{"compute", mesh, "-o", folder.file("field.nrrd"), "--resolution", "16"},
        environment{"CLSDF_CACHE_DIR=" + folder.file("cache"), "POCL_CACHE_DIR=" + compiled};
    Process process(compute, environment);
    process.wait_until([&] { return std::filesystem::exists(compiled); });
    process.send(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    process.send(SIGINT);
    check_refused(process.wait(), 6, {"cancelled"});
    BOOST_TEST(run_command(compute, environment).status == 0);
}

BOOST_AUTO_TEST_CASE(ends_at_once_where_nothing_has_to_be_put_in_order) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off");
    const std::string field = folder.file("field.nrrd");
    BOOST_REQUIRE(run_command({"shape", "sphere6", "-o", mesh}).status == 0);
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", field, "--resolution", "160"}).status == 0);
    Process process({"check", mesh, field, "--complete"});  // for minutes
    // The check is running then: reading both files takes a tenth of this time.
    process.wait_until([&] { return process.cpu_seconds_so_far() >= 1; });
    process.send(SIGINT);
    check_refused(process.wait(), 6, {"cancelled"});
}

BOOST_AUTO_TEST_CASE(stays_ignored_if_it_was_ignored_at_the_start) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    // A pipe without a reader: the command waits for one.
    BOOST_REQUIRE(::mkfifo(folder.file("field.nrrd").c_str(), 0600) == 0);
    Process process({"compute", mesh, "-o", folder.file("field.nrrd"), "--resolution", "16"}, {}, {},
                    [] { std::signal(SIGINT, SIG_IGN); });
    process.wait_until([&] { return process.error_so_far().find("sign") != std::string::npos; });
    process.send(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    BOOST_TEST(content_of(folder.file("field.nrrd")).starts_with("NRRD"));
    BOOST_TEST(process.wait().status == 0);
}

// The compiler sets handlers of its own, as LLVM does.
BOOST_AUTO_TEST_CASE(stays_ignored_while_kernels_are_compiled) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron), field = folder.file("field.nrrd");
    Process process({"compute", mesh, "-o", field, "--resolution", "16"},
                    {"CLSDF_CACHE_DIR=" + folder.file("cache"), "POCL_CACHE_DIR=" + folder.file("pocl")}, {},
                    [] { std::signal(SIGHUP, SIG_IGN); });
    process.wait_until([&] { return process.error_so_far().find("sign") != std::string::npos; });
    process.wait_until([&] {
        process.send(SIGHUP);
        return std::filesystem::exists(field) || process.error_so_far().find("clsdf: ") != std::string::npos;
    });
    const Outcome outcome = process.wait();
    BOOST_TEST(outcome.status == 0, outcome.error);
}

BOOST_AUTO_TEST_SUITE_END()

namespace {

/// A script's shell ignores SIGINT for its background jobs, and the command would inherit that.
struct SignalsOfATerminal {
    SignalsOfATerminal() { std::signal(SIGINT, SIG_DFL); }
};

}  // namespace

BOOST_TEST_GLOBAL_FIXTURE(SignalsOfATerminal);
