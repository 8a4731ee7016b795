#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <sys/resource.h>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;

namespace {

void replace_by_full_disk(int stream) {
    ::dup2(::open("/dev/full", O_WRONLY), stream);
}

void replace_by_pipe_without_reader(int stream) {
    int ends[2];
    if (::pipe(ends) != 0) ::_exit(126);
    ::dup2(ends[1], stream);
    for (const int end : ends) ::close(end);
}

void close(std::initializer_list<int> streams) {
    for (const int stream : streams) ::close(stream);
}

Outcome run_prepared(const std::vector<std::string>& arguments, const std::function<void()>& prepare) {
    return Process(arguments, {}, {}, prepare).wait();
}

struct Preparation {
    const char* name;
    std::function<void()> prepare;
};

struct Files {
    TemporaryFolder folder;
    std::string mesh = folder.file("mesh.off", tetrahedron);
    std::string field = folder.file("field.nrrd");
};

}  // namespace

BOOST_FIXTURE_TEST_SUITE(what_cannot_be_said, Files)

BOOST_AUTO_TEST_CASE(changes_neither_the_status_nor_a_file) {
    const Preparation preparations[] = {
        {"standard error on a full disk", [] { replace_by_full_disk(STDERR_FILENO); }},
        {"standard error without a reader", [] { replace_by_pipe_without_reader(STDERR_FILENO); }},
        {"standard error closed", [] { close({STDERR_FILENO}); }},
        {"both outputs closed",
         [] {
             close({STDOUT_FILENO, STDERR_FILENO});
         }},
        {"input and error closed",
         [] {
             close({STDIN_FILENO, STDERR_FILENO});
         }},
        {"all closed", [] {
             close({STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO});
         }}};
    // Open: a warning is said even with --quiet.
    const std::string open_mesh = folder.file("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const std::string picture = folder.file("picture.png");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", field, "--resolution", "12"}).status == 0);
    const std::string bytes = content_of(field);
    for (const Preparation& preparation : preparations) BOOST_TEST_CONTEXT(preparation.name) {
            const auto status = [&](const std::vector<std::string>& arguments) {
                return run_prepared(arguments, preparation.prepare).status;
            };
            std::filesystem::remove(field);
            BOOST_TEST(status({"compute", mesh, "-o", field, "--resolution", "12"}) == 0);
            BOOST_CHECK(content_of(field) == bytes);
            BOOST_TEST(status({"compute", open_mesh, "--dry-run", "--quiet"}) == 0);
            BOOST_TEST(status({"info", mesh}) == 0);
            BOOST_TEST(status({"check", mesh, field}) == 0);
            BOOST_TEST(status({"slice", field, "-o", picture, "--pixels", "100"}) == 0);
            BOOST_TEST(status({"devices"}) == 0);
            BOOST_TEST(status({}) == 2);
            BOOST_TEST(status({"compute", mesh, "--resolutoin", "9"}) == 2);
            BOOST_TEST(status({"info", folder.file("missing.off")}) == 3);
            BOOST_TEST(status({"compute", mesh, "-o", folder.file("none/field.nrrd")}) == 5);
        }
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_FIXTURE_TEST_SUITE(a_result_asked_for, Files)

BOOST_AUTO_TEST_CASE(that_standard_output_does_not_take_is_an_error) {
    const Preparation preparations[] = {{"a full disk", [] { replace_by_full_disk(STDOUT_FILENO); }},
                                        {"no reader", [] { replace_by_pipe_without_reader(STDOUT_FILENO); }},
                                        {"closed", [] { close({STDOUT_FILENO}); }},
                                        {"all closed but standard error", [] {
                                             close({STDIN_FILENO, STDOUT_FILENO});
                                         }}};
    for (const Preparation& preparation : preparations)
        for (const std::vector<std::string>& arguments : {std::vector<std::string>{"info", mesh, "--json"},
                                                          {"compute", mesh, "--dry-run", "--json"},
                                                          {"devices", "--json"},
                                                          {"shape", "--list"},
                                                          {"help", "compute"},
                                                          {"compute", "--help"},
                                                          {"--version"}})
            BOOST_TEST_CONTEXT(preparation.name << ": clsdf " << arguments.front())
    check_refused(run_prepared(arguments, preparation.prepare), 5,
                  {"clsdf: standard output: the result cannot be written: "});
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_FIXTURE_TEST_SUITE(a_field_beyond_the_limit_on_the_size_of_files, Files)

BOOST_AUTO_TEST_CASE(is_an_error_and_leaves_the_earlier_file) {
    // 8 MB; PoCL writes smaller files even if its programs are compiled, which the first run sees to.
    const std::vector<std::string> arguments{"compute", mesh, "-o", field, "--resolution", "128", "--band", "full"};
    BOOST_REQUIRE(run_command(arguments).status == 0);
    folder.file("field.nrrd", "earlier");
    const Outcome outcome = run_prepared(arguments, [] {
        const rlimit limit{4000000, 4000000};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    });
    check_refused(outcome, 5, {"field.nrrd", "File too large"});
    BOOST_TEST(content_of(field) == "earlier");
    BOOST_TEST(folder.file_count() == 2U);
}

// LLVM calls exit(1) then; other drivers may report an error, or need no file. Without a cache of clsdf's: PoCL 3.1
// aborts the process if it cannot unpack a stored program.
BOOST_AUTO_TEST_CASE(or_of_the_drivers_files_is_an_error_of_the_device_and_leaves_nothing) {
    BOOST_REQUIRE(std::filesystem::create_directory(folder.file("cache")));
    const Outcome outcome = Process({"compute", mesh, "-o", field, "--resolution", "32", "--json"},
                                    {"POCL_CACHE_DIR=" + folder.file("cache"), "CLSDF_CACHE_DIR="}, {},
                                    [] {
                                        const rlimit limit{4096, 4096};
                                        ::setrlimit(RLIMIT_FSIZE, &limit);
                                    })
                                .wait();
    BOOST_TEST_CONTEXT("message: " << outcome.error) {
        BOOST_TEST((outcome.status == 4 || outcome.status == 5));
        BOOST_TEST(nlohmann::json::parse(outcome.out)["error"]["exit_status"] == outcome.status);
    }
    BOOST_TEST(folder.file_count() == 2U);
}

BOOST_AUTO_TEST_SUITE_END()
