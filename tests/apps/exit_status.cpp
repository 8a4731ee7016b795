#include "apps/process.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <string>

using clsdf::test::content_of;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;
using nlohmann::json;

namespace {

/// Checks status and error, in the text and as JSON.
void check_error(std::vector<std::string> arguments, int status, const std::string& code,
                 const std::vector<std::string>& environment = {}) {
    BOOST_TEST_CONTEXT("clsdf " << arguments.front() << " should end with " << code) {
        BOOST_TEST(clsdf::test::exit_statuses.at(code) == status);
        const Outcome plain = run_command(arguments, environment);
        BOOST_TEST(plain.status == status);
        BOOST_TEST(plain.out.empty());
        BOOST_TEST(plain.error.starts_with("clsdf: "));

        arguments.emplace_back("--json");
        const Outcome outcome = run_command(arguments, environment);
        BOOST_TEST(outcome.status == status);
        BOOST_TEST(outcome.error == plain.error);
        const json error = json::parse(outcome.out)["error"];
        BOOST_TEST(error["code"] == code);
        BOOST_TEST(error["exit_status"] == status);
        BOOST_TEST("clsdf: " + error["message"].get<std::string>() + '\n' == plain.error);
    }
}

struct Files {
    TemporaryFolder folder;
    std::string mesh = folder.file("mesh.off", tetrahedron);
    std::string field = folder.file("field.nrrd");
    std::string missing = folder.file("missing.off");
};

}  // namespace

BOOST_FIXTURE_TEST_SUITE(the_exit_status, Files)

BOOST_AUTO_TEST_CASE(is_0_where_everything_was_done_and_json_is_one_object_then) {
    const std::string picture = folder.file("picture.png");
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"compute", mesh, "-o", field, "--resolution", "16"},
          {"compute", mesh, "--dry-run"},
          {"check", mesh, field},
          {"info", mesh},
          {"slice", field, "-o", picture, "--pixels", "100"},
          {"close", folder.file("roof.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "-o",
           folder.file("closed.off"), "--floor", "-1"},
          {"shape", "torus", "-o", folder.file("torus.off")},
          {"shape", "--list"},
          {"devices"}}) {
        std::vector<std::string> words = arguments;
        words.insert(words.end(), {"--json", "--quiet"});
        const Outcome outcome = run_command(words);
        BOOST_TEST_CONTEXT("clsdf " << arguments.front() << ": " << outcome.error) {
            BOOST_TEST(outcome.status == 0);
            BOOST_TEST(outcome.error.empty());
            const json result = json::parse(outcome.out);
            BOOST_TEST(result.is_object());
            BOOST_TEST(result.size() > 1U);
            BOOST_TEST(result["warnings"].is_array());
            BOOST_TEST(!result.contains("error"));
        }
    }
}

BOOST_AUTO_TEST_CASE(is_1_where_a_check_failed) {
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", field, "--resolution", "16"}).status == 0);
    clsdf::Field wrong = clsdf::read_field(field);
    wrong.distance()[wrong.grid.offset(5, 5, 5)] *= -1;
    write_field(wrong, field);
    const Outcome outcome = run_command({"check", mesh, field, "--complete", "--json"});
    BOOST_TEST(outcome.status == 1);
    BOOST_TEST(json::parse(outcome.out)["passed"] == false);
    BOOST_TEST(!json::parse(outcome.out).contains("error"));
}

BOOST_AUTO_TEST_CASE(is_2_for_what_makes_no_sense_or_is_unsupported) {
    check_error({"compute", mesh, "-o", field, "--resolutoin", "9"}, 2, "invalid_argument");
    check_error({"compte"}, 2, "invalid_argument");
    check_error({"compute", mesh, "-o", field, "--band", "3x"}, 2, "invalid_argument");
    check_error({"compute", mesh, "-o", folder.file("field.vtk")}, 2, "unsupported");
}

BOOST_AUTO_TEST_CASE(is_3_for_unreadable_or_invalid_input) {
    check_error({"info", missing}, 3, "unreadable_input");
    check_error({"check", mesh, field}, 3, "unreadable_input");
    check_error({"slice", field, "-o", folder.file("a.png")}, 3, "unreadable_input");
    check_error({"info", folder.file("none.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n")}, 3, "invalid_mesh");
    check_error({"compute", folder.file("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "--dry-run",
                 "--sign", "parity"},
                3, "invalid_mesh");
}

// HDF5 prints nothing after the message.
BOOST_AUTO_TEST_CASE(is_3_for_a_damaged_field_of_hdf5) {
    const std::string whole = folder.file("whole.h5");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", whole, "--resolution", "16", "--quiet"}).status == 0);
    std::string bytes = content_of(whole);
    const std::size_t header = bytes.find("OHDR");
    BOOST_REQUIRE(header != std::string::npos);
    bytes[header + 8] ^= 1;
    // With the leak sanitizer, whole stacks identify HDF5's known leaks (cmake/leak_suppressions.txt).
    const char* options = std::getenv("ASAN_OPTIONS");
    check_error({"slice", folder.file("damaged.h5", bytes), "-o", folder.file("a.png")}, 3, "unreadable_input",
                {"ASAN_OPTIONS=" + std::string(options ? options : "") + ":fast_unwind_on_malloc=0"});
}

BOOST_AUTO_TEST_CASE(is_4_for_device_and_memory) {
    check_error({"compute", mesh, "-o", field, "--quiet"}, 4, "no_device", no_devices);
    check_error({"compute", missing, "-o", field, "--device", "xyzzy"}, 4, "no_device");
    check_error({"compute", mesh, "--dry-run", "--resolution", "3000000"}, 4, "out_of_memory");
    const Outcome outcome = run_command({"devices", "--json"}, no_devices);
    BOOST_TEST(outcome.status == 4);
    BOOST_TEST(json::parse(outcome.out)["error"]["code"] == "no_device");
}

BOOST_AUTO_TEST_CASE(is_5_where_the_output_cannot_be_written) {
    check_error({"compute", mesh, "-o", folder.file("none/field.nrrd")}, 5, "output_failure");
    check_error({"shape", "torus", "-o", folder.file("none/torus.off")}, 5, "output_failure");
    const Outcome outcome = run_command({"info", mesh, "--json"}, {}, "/dev/full");
    BOOST_TEST(outcome.status == 5);
    BOOST_TEST(outcome.error.find("standard output") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(is_6_where_it_was_interrupted) {
    Process process({"compute", mesh, "-o", field, "--resolution", "700", "--band", "full", "--json"});
    process.wait_until([&] { return process.error_so_far().find("sign") != std::string::npos; });
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    BOOST_TEST(outcome.status == 6);
    BOOST_TEST(outcome.error.ends_with("clsdf: cancelled; nothing was written\n"));
    BOOST_TEST(json::parse(outcome.out)["error"]["code"] == "cancelled");
}

BOOST_AUTO_TEST_SUITE_END()
