// Every call of OpenCL may fail. The command then ends with status 4 and a message that names the call, and leaves no
// file; it neither crashes nor hangs. A sample of the calls, or with CLSDF_FAULT_EVERY=1 in the environment all of
// them.
#include "apps/process.hpp"

#include "disguise/disguise.hpp"
#include "support/supposes.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <future>
#include <optional>
#include <random>
#include <set>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using nlohmann::json;

const std::string preload = "LD_PRELOAD=" + path_of_build("CLSDF_DISGUISE_LIBRARY", CLSDF_DISGUISE_LIBRARY);

/// Calls whose failure costs only time.
const std::set<std::string> passed_over{
    "clCreateProgramWithBinary",    // the program is compiled from its source
    "clBuildProgram",               // likewise, if it was a stored one; otherwise it is an error
    "clGetProgramInfo",             // its binary is not kept
    "clCreateBuffer",               // one that may fail: longer than a list needs, or a block of the arena
    "clGetEventInfo",               // the library waits for the event
    "clSetEventCallback",           // likewise
    "clEnqueueMarkerWithWaitList",  // without the marker the library waits for the whole queue
    "clEnqueueMapBuffer",           // copies go from and to memory that is not pinned; otherwise it is an error
    "clEnqueueUnmapMemObject",      // pinned memory is given back
};

// The time limit on a busy machine.
constexpr std::chrono::seconds limit{180};

/// A run of the command whose calls are counted and may fail.
struct Run {
    Outcome outcome;
    bool hung = false;
    std::uint64_t calls = 0;
    std::uint64_t launches = 0;
    std::string failed;  ///< the first call, or the kernel, that failed on purpose; empty: none
    std::string file;    ///< what it wrote; empty: nothing
    std::size_t files = 0;
};

struct Job {
    std::string name;
    std::vector<std::string> arguments;    ///< what follows is -o FILE
    std::vector<std::string> environment;  ///< beside the fault
    std::string ending = ".npy";
};

Run run(const Job& job, const std::string& fault) {
    const TemporaryFolder folder, output;
    const std::string counts = folder.file("counts"), file = output.file("out" + job.ending);
    std::vector<std::string> arguments = job.arguments, environment = job.environment;
    arguments.insert(arguments.end(), {"-o", file, "--quiet"});
    environment.insert(environment.end(),
                       {preload, "CLSDF_DISGUISE_COUNTS=" + counts, "CLSDF_DISGUISE_FAULT=" + fault,
                        "CLSDF_DEVICE_FILES=" + folder.file("none")});  // a GPU of this machine is not looked for
    Run result;
    Process process(arguments, environment);
    std::future<Outcome> ended = std::async(std::launch::async, [&] { return process.wait(); });
    result.hung = ended.wait_for(limit) == std::future_status::timeout;
    if (result.hung) process.send(SIGKILL);
    result.outcome = ended.get();
    if (const std::string line = content_of(counts); !line.empty()) {
        const json values = json::parse(line);
        result.calls = values["all_calls"];
        result.launches = values["launches"];
        result.failed = values.value("failed", "");
    }
    result.file = content_of(file);
    result.files = output.file_count();
    return result;
}

std::uint64_t number_in(const char* name, std::uint64_t otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

std::uint64_t seed() {
    static const std::uint64_t chosen = number_in("CLSDF_FAULT_SEED", std::random_device{}());
    return chosen;
}

/// Fails a random call in each part of a job's calls.
std::vector<std::uint64_t> sample(std::uint64_t calls, std::uint64_t wanted) {
    const std::uint64_t step = number_in("CLSDF_FAULT_EVERY", std::max<std::uint64_t>(calls / wanted, 1));
    std::mt19937_64 random(seed());
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t begin = 1; begin <= calls; begin += step) numbers.push_back(begin + random() % step);
    return numbers;
}

/// So many calls are left when the file is written: a destructor waits for the device.
constexpr std::uint64_t last_calls = 2;

void check_refusal(const Run& run) {
    BOOST_TEST(!run.hung);
    BOOST_TEST(run.outcome.status == 4);
    BOOST_TEST(run.files == 0U);
    BOOST_TEST(run.outcome.error.find("internal error") == std::string::npos);
}

/// One call fails.
void check_one(const Run& run, const Run& whole, bool is_late = false) {
    if (run.outcome.status == 0 && (run.failed.empty() || is_late || passed_over.contains(run.failed))) {
        BOOST_TEST((run.file == whole.file));
        return;
    }
    check_refusal(run);
    BOOST_TEST((!run.failed.empty() && run.outcome.error.find(run.failed) != std::string::npos));
}

void check_job(const Job& job, std::uint64_t wanted) {
    run(job, "");  // compiles programs that are not kept
    const Run whole = run(job, "");
    BOOST_REQUIRE_MESSAGE(whole.outcome.status == 0, whole.outcome.error);
    BOOST_REQUIRE(!whole.file.empty());
    const std::vector<std::uint64_t> numbers = sample(whole.calls, wanted);
    BOOST_TEST_MESSAGE(job.name << ": " << whole.calls << " calls, " << numbers.size() << " of them fail; seed "
                                << seed());
    for (const std::uint64_t number : numbers) {
        const bool is_late = number + last_calls > whole.calls;
        const Run one = run(job, std::to_string(number));
        BOOST_TEST_CONTEXT(job.name << ", call " << number << " fails, " << one.failed << "; seed " << seed()
                                    << "; the command said: " << one.outcome.error)
        check_one(one, whole, is_late);
        if (number % 4 != 0 && number_in("CLSDF_FAULT_EVERY", 0) != 1) continue;
        const Run all = run(job, std::to_string(number) + '+');
        BOOST_TEST_CONTEXT(job.name << ", all calls fail from call " << number << ", " << all.failed << ", on; seed "
                                    << seed() << "; the command said: " << all.outcome.error) {
            // A process that crashes or is killed writes no counts: `failed` is then empty too.
            if (all.outcome.status == 0 && (is_late || all.failed.empty()))
                BOOST_TEST((all.file == whole.file));
            else
                check_refusal(all);
        }
    }
}

const TemporaryFolder& inputs() {
    static const TemporaryFolder folder;
    return folder;
}

const std::string& mesh() {
    static const std::string path = [] {
        std::string file = inputs().file("mesh.off");
        BOOST_REQUIRE(run_command({"shape", "torus", "-o", file, "--quiet"}).status == 0);
        return file;
    }();
    return path;
}

std::vector<std::string> compute(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"compute", mesh(), "--resolution", "30", "--band", "3v"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

/// Four slabs.
std::vector<std::string> compute_in_slabs() {
    static const std::string few_triangles = inputs().file("tetrahedron.off", tetrahedron);
    return {"compute", few_triangles, "--resolution", "72", "--band", "3v"};
}
const std::string small_device = "CLSDF_MAX_ALLOCATION=600000";
const std::string as_gpu = "CLSDF_DISGUISE=gpu";

const std::string all_outputs = "triangle,site,closest,gradient,barycentric,offset";

/// Few points are looked up one by one; so many that they outnumber the faces are, on processors, scanned in groups.
std::vector<std::string> query(std::size_t points) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
    std::string table = "x,y,z\n";
    for (std::size_t i = 0; i < points; ++i)
        table += fmt::format("{},{},{}\n", coordinate(random), coordinate(random), coordinate(random));
    return {"query", mesh(), inputs().file(fmt::format("{}.csv", points), table), "--with", all_outputs};
}
constexpr std::size_t searched_points = 500, many_points = 17000;

/// Processes with a failing call, of a job: what follows from it in the library is a matter of failing_calls.cpp.
constexpr std::uint64_t wanted = 2;

}  // namespace

// The calls of PoCL on a processor and as a GPU, and PoCL's names.
BOOST_AUTO_TEST_SUITE(on_a_known_driver, *boost::unit_test::precondition(on_pocl))

BOOST_AUTO_TEST_SUITE(the_command_survives_a_failing_call)

BOOST_AUTO_TEST_CASE(on_a_processor) {
    check_job({"whole", compute({"--with", "triangle"}), {}}, wanted);
}

BOOST_AUTO_TEST_CASE(on_a_gpu) {
    check_job({"whole as on a GPU", compute({"--with", "triangle"}), {as_gpu}}, wanted);
}

BOOST_AUTO_TEST_CASE(with_all_outputs) {
    check_job({"all outputs", compute({"--with", all_outputs}), {}}, wanted);
}

BOOST_AUTO_TEST_CASE(with_all_outputs_on_a_gpu) {
    check_job({"all outputs as on a GPU", compute({"--with", all_outputs}), {as_gpu}}, wanted);
}

BOOST_AUTO_TEST_CASE(at_points) {
    check_job({"points", query(searched_points), {}}, wanted);
}

BOOST_AUTO_TEST_CASE(at_points_on_a_gpu) {
    check_job({"points as on a GPU", query(searched_points), {as_gpu}}, wanted);
}

BOOST_AUTO_TEST_CASE(at_many_points) {
    check_job({"many points", query(many_points), {}}, wanted);
}

BOOST_AUTO_TEST_CASE(in_slabs) {
    check_job({"slabs", compute_in_slabs(), {small_device}}, wanted);
}

BOOST_AUTO_TEST_CASE(in_slabs_on_a_gpu) {
    check_job({"slabs as on a GPU", compute_in_slabs(), {as_gpu, small_device}}, wanted);
}

BOOST_AUTO_TEST_CASE(slice_by_slice) {
    check_job({"slices", compute({"--polyhedra", "mauch"}), {}}, wanted);
}

BOOST_AUTO_TEST_CASE(while_it_draws) {
    const std::string field = inputs().file("field.npy");
    std::vector<std::string> arguments = compute();
    arguments.insert(arguments.end(), {"-o", field, "--quiet"});
    BOOST_REQUIRE(run_command(arguments).status == 0);
    check_job({"render", {"render", field, "--size", "64x48"}, {}, ".png"}, wanted);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_CASE(a_kernel_that_fails_is_named_and_leaves_no_file) {
    for (const Job& job : {Job{"whole", compute(), {}}, Job{"whole as on a GPU", compute(), {as_gpu}},
                           Job{"slabs", compute_in_slabs(), {small_device}},
                           Job{"points as on a GPU", query(searched_points), {as_gpu}}}) {
        run(job, "");  // compiles programs that are not kept
        const Run whole = run(job, "");
        BOOST_REQUIRE_MESSAGE(whole.outcome.status == 0, whole.outcome.error);
        for (const std::uint64_t number : sample(whole.launches, 3)) {
            const Run one = run(job, "kernel:" + std::to_string(number));
            BOOST_TEST_CONTEXT(job.name << ", launch " << number << " fails, " << one.failed << "; seed " << seed()
                                        << "; the command said: " << one.outcome.error) {
                // How many launches a long job is divided into depends on their times.
                if (one.failed.empty()) {
                    BOOST_TEST(one.launches < number);
                    BOOST_TEST((one.file == whole.file));
                    continue;
                }
                check_refusal(one);
                BOOST_TEST((!one.failed.empty() && one.outcome.error.find(one.failed) != std::string::npos));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(a_call_that_is_named_fails_wherever_it_is_made) {
    // The calls that wait for values, that find the device, and others.
    for (const char* call : {"clWaitForEvents", "clFinish", "clGetPlatformIDs", "clGetDeviceIDs", "clBuildProgram",
                             "clEnqueueUnmapMemObject", "clEnqueueMapBuffer", "clFlush"}) {
        const Run whole = run({"whole", compute(), {}}, "");
        for (const char* onwards : {"", "+"}) {
            const Run one = run({"whole", compute(), {}}, std::string(call) + ":1" + onwards);
            BOOST_TEST_CONTEXT(call << onwards << "; the command said: " << one.outcome.error) {
                // Nobody waits for events that have ended already.
                const bool is_made =
                    one.failed == call || (one.failed.empty() && call == std::string("clWaitForEvents"));
                BOOST_TEST(is_made);
                check_one(one, whole);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(a_device_whose_compiler_is_known_to_crash_is_listed_and_not_taken) {
    const std::vector<std::string> environment{preload, "CLSDF_DISGUISE=pocl-3.0", "CLSDF_DEVICE="};
    const Outcome listed = run_command({"devices", "--json"}, environment);
    const json devices = json::parse(listed.out);
    BOOST_REQUIRE(!devices["devices"].empty());
    BOOST_TEST(devices["taken"].is_null());
    for (const json& device : devices["devices"]) {
        BOOST_TEST(device["usable"] == false);
        const std::string why_not = device["why_not"];
        for (const char* fragment : {"Portable Computing Language", "PoCL 3.0-rc2", "LLVM 14.0.6", "install PoCL 3.1"})
            BOOST_TEST(why_not.find(fragment) != std::string::npos, "no '" << fragment << "' in " << why_not);
    }
    const TemporaryFolder folder;
    std::vector<std::string> arguments = compute();
    arguments.insert(arguments.end(), {"-o", folder.file("field.npy")});
    const Outcome refused = run_command(arguments, environment);
    check_refused(refused, 4, {"PoCL 3.0-rc2", "cannot compile vectors", "install PoCL 3.1", "clsdf devices"});
    BOOST_TEST(refused.error.find("install an OpenCL driver") == std::string::npos, refused.error);
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(a_device_whose_driver_does_not_answer_is_listed_with_what_is_known) {
    const std::string name = "a device of Portable Computing Language";
    // The platform lists no devices; then a device tells nothing; then its name alone.
    for (const char* fault : {"clGetDeviceIDs:1+", "clGetDeviceInfo:1+", "clGetDeviceInfo:3+"}) {
        const std::vector<std::string> environment{preload, std::string("CLSDF_DISGUISE_FAULT=") + fault,
                                                   "CLSDF_DEVICE="};
        const bool has_name = fault == std::string("clGetDeviceInfo:3+");
        const Outcome listed = run_command({"devices", "--json"}, environment);
        BOOST_TEST_CONTEXT(fault << "; the command said: " << listed.error) {
            BOOST_TEST(listed.status == 4);
            const std::string& text = listed.error;
            const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
            BOOST_TEST(has("cannot be used: it fails at clGet"));
            BOOST_TEST(has("update the driver"));
            BOOST_TEST(has("   platform  Portable Computing Language\n"));
            for (const char* part : {"install", "\"\"", "; ,", "driver \n", "0 compute units", "fp64", "memory"})
                BOOST_TEST(!has(part), "'" << part << "'");
            const json devices = json::parse(listed.out)["devices"];
            BOOST_REQUIRE(!devices.empty());
            for (const json& device : devices) {
                BOOST_TEST((device["name"] == name) == !has_name);
                BOOST_TEST(device["platform"] == "Portable Computing Language");
                BOOST_TEST(device["usable"] == false);
                for (const char* property :
                     {"version", "driver", "kind", "compute_units", "clock_megahertz", "memory_bytes",
                      "largest_allocation_bytes", "fp64", "atomics64", "float_width"})
                    BOOST_TEST(device[property].is_null(), property);
            }
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()
