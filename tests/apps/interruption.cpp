#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>

using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;

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

BOOST_AUTO_TEST_SUITE(an_interrupted_computation)

BOOST_AUTO_TEST_CASE(ends_soon_with_status_6_and_leaves_nothing) {
    check_interrupted_by(SIGINT);
}

BOOST_AUTO_TEST_CASE(ends_the_same_way_when_it_is_told_to_terminate) {
    check_interrupted_by(SIGTERM);
}

BOOST_AUTO_TEST_SUITE_END()
