#include "apps/process.hpp"
#include "support/supposes.hpp"

#include <clsdf/turn_to_compile.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

using namespace clsdf::test;
using nlohmann::json;

namespace {

namespace fs = std::filesystem;

/// Empty caches of clsdf and of PoCL, with the settings of a user who has set none: all programs are compiled anew.
class FreshCaches {
public:
    std::vector<std::string> environment() const {
        // A name alone removes the variable.
        return {"CLSDF_CACHE_DIR", "XDG_CACHE_HOME=" + fs::path(folder_.file("x")).parent_path().string(),
                "POCL_CACHE_DIR=" + folder_.file("pocl")};
    }
    /// Without files of clsdf's.
    std::vector<std::string> environment_without_files() const {
        return {"CLSDF_CACHE_DIR=", "POCL_CACHE_DIR=" + folder_.file("pocl")};
    }
    std::vector<std::string> compute(const std::string& name) const {
        return {"compute", folder_.file("mesh.off", tetrahedron), "-o", folder_.file(name), "--resolution", "24"};
    }
    std::string file(const std::string& name) const { return folder_.file(name); }
    std::vector<fs::path> files(const std::string& ending) const {
        std::vector<fs::path> found;
        std::error_code none;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder_.file("clsdf"), none))
            if (entry.path().extension() == ending) found.push_back(entry.path());
        return found;
    }

private:
    TemporaryFolder folder_;
};

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

constexpr const char* compiled = "compiled the kernels for this device, once, in ";

}  // namespace

BOOST_AUTO_TEST_CASE(commands_that_start_at_once_compile_one_after_the_other) {
    const FreshCaches caches;
    // With PoCL's own programs: what is left are the tests.
    const std::vector<std::string> environment{"CLSDF_CACHE_DIR=" + caches.file("clsdf")};
    std::optional<clsdf::TurnToCompile> turn(std::in_place, caches.file("clsdf"), [](double) { return false; });
    BOOST_TEST_REQUIRE(turn->is_taken());

    Process waiting(caches.compute("a.nrrd"), environment);
    const auto says_so = [&] { return has(waiting.error_so_far(), "waiting for another process that compiles"); };
    for (int i = 0; i < 2000 && !says_so(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    BOOST_TEST(says_so());
    BOOST_TEST(caches.files(".tested").empty());
    BOOST_TEST(!fs::exists(caches.file("a.nrrd")));
    turn.reset();
    const Outcome outcome = waiting.wait();
    BOOST_TEST(outcome.status == 0, outcome.error);
    BOOST_TEST(!caches.files(".tested").empty());

    // Where records are, nobody waits.
    turn.emplace(caches.file("clsdf"), [](double) { return false; });
    BOOST_TEST_REQUIRE(turn->is_taken());
    const Outcome second = run_command(caches.compute("b.nrrd"), environment);
    BOOST_TEST(second.status == 0, second.error);
    BOOST_TEST(!has(second.error, "waiting"), second.error);
}

// They look into PoCL's folder of compiled programs, and know what it compiles when.
BOOST_AUTO_TEST_SUITE(kernels, *boost::unit_test::precondition(on_pocl))

BOOST_AUTO_TEST_CASE(are_said_to_be_compiled_when_they_are) {
    const FreshCaches caches;
    const Outcome first = run_command(caches.compute("a.nrrd"), caches.environment());
    BOOST_TEST(first.status == 0);
    BOOST_TEST(has(first.error, compiled), first.error);
    BOOST_TEST(has(first.error, "computed in "), first.error);
    const Outcome second = run_command(caches.compute("b.nrrd"), caches.environment());
    BOOST_TEST(!has(second.error, "compiled"), second.error);
    BOOST_TEST(has(second.error, "computed in "), second.error);

    // Another variant of the kernels.
    std::vector<std::string> with_triangle = caches.compute("c.nrrd");
    with_triangle.insert(with_triangle.end(), {"--with", "triangle", "--json", "--quiet"});
    for (const bool is_first : {true, false}) {
        const Outcome outcome = run_command(with_triangle, caches.environment());
        const json result = json::parse(outcome.out);
        BOOST_TEST(result["first_use"] == is_first);
        // Compilation is in none of the other times.
        const double compile = result["seconds"]["compile"], compute = result["seconds"]["compute"],
                     setup = result["seconds"]["setup"];
        BOOST_TEST(compile > 0);
        BOOST_TEST(compile + compute + setup <= outcome.seconds);
        BOOST_TEST(result["samples_per_second"].get<double>() ==
                   result["statistics"]["samples"].get<double>() / compute);
    }
}

BOOST_AUTO_TEST_CASE(of_queries_are_compiled_in_none_of_the_times_of_a_query) {
    const FreshCaches caches;
    const TemporaryFolder folder;
    std::string points = "x,y,z\n";
    for (int n = 0; n < 500; ++n) points += "0.1,0.1,0.1\n";  // the host answers few without a kernel
    const std::vector<std::string> query{"query",
                                         folder.file("mesh.off", tetrahedron),
                                         folder.file("points.csv", points),
                                         "-o",
                                         folder.file("found.csv"),
                                         "--json",
                                         "--quiet"};
    for (const bool is_first : {true, false}) {
        const Outcome outcome = run_command(query, caches.environment());
        BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
        const json result = json::parse(outcome.out), seconds = result["seconds"];
        BOOST_TEST(result["first_use"] == is_first);
        const auto of = [&](const char* name) { return seconds[name].get<double>(); };
        BOOST_TEST(of("compile") > 0);
        BOOST_TEST(of("nearest") > 0);
        BOOST_TEST(of("query") >= of("set_up") + of("nearest") + of("sign"));
        BOOST_TEST(of("read") + of("compile") + of("query") + of("write") <= outcome.seconds);
    }
}

BOOST_AUTO_TEST_CASE(are_right_in_many_processes_that_start_at_once_and_after_one_that_was_killed) {
    const FreshCaches caches;
    {
        Process killed(caches.compute("killed.nrrd"), caches.environment());
        killed.wait_until([&] { return killed.cpu_seconds_so_far() >= 1; });
        killed.send(SIGKILL);
        BOOST_TEST(killed.wait().status == -SIGKILL);
    }
    std::vector<std::unique_ptr<Process>> processes;
    for (int i = 0; i < 3; ++i)
        processes.push_back(
            std::make_unique<Process>(caches.compute(std::to_string(i) + ".nrrd"), caches.environment()));
    for (const auto& process : processes) {
        const Outcome outcome = process->wait();
        BOOST_TEST(outcome.status == 0, outcome.error);
    }
    BOOST_TEST(run_command(caches.compute("usual.nrrd")).status == 0);
    for (const char* name : {"0.nrrd", "1.nrrd", "2.nrrd"})
        BOOST_TEST((content_of(caches.file(name)) == content_of(caches.file("usual.nrrd"))), name);
}

BOOST_AUTO_TEST_CASE(of_usual_calls_are_prepared_for_later_calls) {
    const FreshCaches caches;
    const Outcome prepared = run_command({"devices", "--prepare", "--json"}, caches.environment());
    BOOST_TEST(prepared.status == 0, prepared.error);
    const json devices = json::parse(prepared.out)["prepared"];
    BOOST_REQUIRE(!devices.empty());
    for (const json& device : devices)
        for (const json& step : device["steps"]) {
            BOOST_TEST(step["seconds"].get<double>() > 0);
            // Another process may have prepared queries meanwhile.
            const bool is_field = step["name"] != "render" && step["name"] != "query";
            BOOST_TEST((step["tested"].get<bool>() || !is_field), step);
            BOOST_TEST(has(prepared.error, step["name"].get<std::string>()));
        }
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{}, {"--band", "full"}, {"--with", "triangle"}}) {
        std::vector<std::string> arguments = caches.compute("a.nrrd");
        arguments.insert(arguments.end(), options.begin(), options.end());
        for (const bool counts : {false, true}) {
            if (counts) arguments.push_back("--json");
            const Outcome outcome = run_command(arguments, caches.environment());
            BOOST_TEST(outcome.status == 0);
            BOOST_TEST(!has(outcome.error, "compiled"), outcome.error);
        }
    }
    for (const std::size_t count : {std::size_t{1}, std::size_t{1} << 14U}) {
        const TemporaryFolder folder;
        std::string points = "x,y,z\n";
        for (std::size_t i = 0; i < count; ++i) points += "0.1,0.2,0.3\n";
        const Outcome outcome =
            run_command({"query", folder.file("mesh.off", tetrahedron), folder.file("points.csv", points), "-o",
                         folder.file("found.csv"), "--json"},
                        caches.environment());
        BOOST_TEST(outcome.status == 0, outcome.error);
        BOOST_TEST(json::parse(outcome.out)["first_use"] == false);
    }
    // Another machine without a compiler's cache takes the programs from the folder.
    BOOST_TEST(!caches.files(".program").empty());
    const auto seconds = [&](const std::string& folder) {
        std::vector<std::string> arguments = caches.compute("b.nrrd");
        arguments.push_back("--json");
        fs::remove_all(caches.file("empty"));
        const Outcome outcome =
            run_command(arguments, {"CLSDF_CACHE_DIR=" + folder, "POCL_CACHE_DIR=" + caches.file("empty")});
        BOOST_TEST(outcome.status == 0, outcome.error);
        return outcome.cpu_seconds;
    };
    const double with_programs = seconds(caches.file("clsdf"));
    std::string programs;
    for (const fs::path& file : caches.files(".program")) programs += content_of(file.string());
    // PoCL compiles nothing that the programs lack, e.g. a kernel for another size of groups.
    std::size_t kernels = 0;
    for (const fs::path& file : fs::recursive_directory_iterator(caches.file("empty"))) {
        if (file.extension() != ".so") continue;
        const fs::path groups = file.parent_path(), kernel = groups.parent_path();
        const std::string name = (kernel.filename() / groups.filename() / file.filename()).string();
        BOOST_TEST(has(programs, name), name);
        ++kernels;
    }
    BOOST_TEST(kernels > 0);
    BOOST_TEST(2 * with_programs < seconds(""));
    // Nothing is left to do, unless that is asked for.
    const auto tested = [&](std::vector<std::string> arguments) {
        const json result = json::parse(run_command(arguments, caches.environment()).out)["prepared"][0]["steps"][0];
        return result["tested"].get<bool>();
    };
    BOOST_TEST(!tested({"devices", "--prepare", "--json", "--quiet"}));
    BOOST_TEST(tested({"devices", "--prepare", "--again", "--json", "--quiet", "--device", "0"}));
}

BOOST_AUTO_TEST_CASE(of_bricks_can_be_compiled_by_a_process_beside_the_one_that_needs_them) {
    const FreshCaches alone, ahead;
    const double all = run_command(alone.compute("a.nrrd"), alone.environment()).cpu_seconds;
    const Outcome compiled_ahead = run_command({"compile-ahead"}, ahead.environment());
    BOOST_TEST(compiled_ahead.status == 0);
    BOOST_TEST(compiled_ahead.out + compiled_ahead.error == "");
    const Outcome outcome = run_command(ahead.compute("a.nrrd"), ahead.environment());
    BOOST_TEST(outcome.status == 0, outcome.error);
    // The bricks take nearly half of the time.
    BOOST_TEST(outcome.cpu_seconds < 0.8 * all);
}

BOOST_AUTO_TEST_CASE(are_tested_in_every_process_without_files) {
    const FreshCaches caches;
    for (int i = 0; i < 2; ++i) {
        const Outcome outcome = run_command(caches.compute("a.nrrd"), caches.environment_without_files());
        BOOST_TEST(outcome.status == 0);
        BOOST_TEST(has(outcome.error, "compiled the kernels for this device"), outcome.error);
        BOOST_TEST(!has(outcome.error, "once"), outcome.error);
    }
    BOOST_TEST(caches.files(".tested").empty());
}

BOOST_AUTO_TEST_CASE(are_prepared_on_a_device_that_is_there) {
    check_refused(run_command({"devices", "--prepare", "--device", "xyzzy"}), 4, {"xyzzy"});
    check_refused(run_command({"devices", "--device", "0"}), 2, {"--prepare"});
    check_refused(run_command({"devices", "--again"}), 2, {"--prepare"});
    check_refused(run_command({"devices", "--prepare"}, no_devices), 4, {"pocl-opencl-icd"});
}

BOOST_AUTO_TEST_SUITE_END()
