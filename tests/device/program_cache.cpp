#include "support/temporary_folder.hpp"

#include <clsdf/device.hpp>

#include "device/context.hpp"

#include <boost/test/unit_test.hpp>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
using device::ProgramCache;

namespace {

namespace fs = std::filesystem;

using Binary = ProgramCache::Binary;

constexpr const char* options = "-cl-std=CL1.2 -DLANES=1";

Binary numbers(std::size_t size) {
    return Binary(size, 7);
}

/// Sets an environment variable for a while; without a value it removes it.
class Variable {
public:
    Variable(const char* name, const std::optional<std::string>& value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        set(value);
    }
    ~Variable() { set(before_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    void set(const std::optional<std::string>& value) const {
        BOOST_REQUIRE((value ? ::setenv(name_, value->c_str(), 1) : ::unsetenv(name_)) == 0);
    }

    const char* name_;
    std::optional<std::string> before_;
};

/// A device with a context of its own that keeps records and programs there, with PoCL, too.
Device device_with(const std::string& folder) {
    Device device = Device::strongest();
    device.keep_records(folder);
    device::context_of(device).keep_programs(folder);
    return device;
}

/// Whether the program works: the prefix sums of 1, 2, ..., 10.
bool computes(const Device& device, const cl::Program& program) {
    return device::guarded([&] {
        const device::Context& context = device::context_of(device);
        std::vector<cl_uint> values(10);
        std::iota(values.begin(), values.end(), 1U);
        const cl::Buffer in(context.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(cl_uint),
                            values.data());
        const cl::Buffer sums(context.context(), CL_MEM_READ_WRITE, 2 * sizeof(cl_ulong));
        cl::Kernel kernel(program, "scan_sums");
        kernel.setArg(0, cl_uint{10});
        kernel.setArg(1, in);
        kernel.setArg(2, sums);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        cl_ulong sum = 0;
        context.queue().enqueueReadBuffer(sums, CL_TRUE, 0, sizeof sum, &sum);
        return sum == 55;
    });
}

/// A program of a device, and whether its source was compiled for it.
struct Built {
    cl::Program program;
    bool is_compiled = false;
};

Built build(const Device& device, const char* kernel_file, const std::string& with = options) {
    Built built;
    device::BuildWatch watch;
    watch.begins = [&] { built.is_compiled = true; };
    built.program = device::context_of(device).program(kernel_file, with, watch);
    return built;
}

std::string path_of(const TemporaryFolder& folder) {
    return fs::path(folder.file("x")).parent_path().string();
}

/// There are records of the programs that were built, too.
std::vector<fs::path> programs_in(const TemporaryFolder& folder) {
    std::vector<fs::path> programs;
    for (const fs::directory_entry& entry : fs::directory_iterator(path_of(folder)))
        if (entry.path().extension() == ".program") programs.push_back(entry.path());
    return programs;
}

fs::path only_program(const TemporaryFolder& folder) {
    BOOST_REQUIRE(programs_in(folder).size() == 1U);
    return programs_in(folder).front();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_cache_of_programs)

BOOST_AUTO_TEST_CASE(gives_back_what_was_stored_under_the_very_same_key) {
    const TemporaryFolder folder;
    const ProgramCache cache(folder.file("deep") + "/er");
    BOOST_TEST(!cache.find("key").has_value());
    const Binary binary = numbers(100000);
    cache.store("key", binary);
    BOOST_REQUIRE(cache.find("key").has_value());
    BOOST_TEST((*cache.find("key") == binary));
    BOOST_TEST(!cache.find("key ").has_value());
    cache.store("key", numbers(3));
    BOOST_TEST((*cache.find("key") == numbers(3)));
    // Nobody else reads it.
    BOOST_TEST((fs::status(folder.file("deep") + "/er").permissions() == fs::perms::owner_all));
}

BOOST_AUTO_TEST_CASE(does_not_take_one_key_for_another_of_the_same_name) {
    const TemporaryFolder folder;
    const ProgramCache cache(path_of(folder));
    cache.store("one", numbers(9));
    fs::rename(cache.path_of("one"), cache.path_of("two"));
    BOOST_TEST(!cache.find("two").has_value());
}

BOOST_AUTO_TEST_CASE(does_not_take_a_damaged_file) {
    const TemporaryFolder folder;
    const ProgramCache cache(path_of(folder));
    const Binary binary = numbers(50);
    cache.store("key", binary);
    const std::string name = cache.path_of("key").filename().string();
    const std::string whole = content_of(cache.path_of("key").string());
    for (std::size_t length = 0; length < whole.size(); ++length) {
        folder.file(name, std::string_view(whole).substr(0, length));
        BOOST_REQUIRE_MESSAGE(!cache.find("key").has_value(), "cut to " << length << " bytes");
    }
    folder.file(name, whole + "x");
    BOOST_TEST(!cache.find("key").has_value());
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        folder.file(name, damaged);
        BOOST_REQUIRE_MESSAGE(!cache.find("key").has_value(), "byte " << i << " changed");
    }
    folder.file(name, whole);
    BOOST_TEST(cache.find("key").has_value());
    cache.store("key", binary);
    BOOST_TEST((*cache.find("key") == binary));
}

BOOST_AUTO_TEST_CASE(does_not_follow_links_nor_read_what_is_no_file) {
    const TemporaryFolder folder;
    const ProgramCache cache(path_of(folder));
    cache.store("key", numbers(50));
    const fs::path path = cache.path_of("key");
    fs::rename(path, folder.file("elsewhere"));
    fs::create_symlink(folder.file("elsewhere"), path);
    BOOST_TEST(!cache.find("key").has_value());
    fs::remove(path);
    fs::create_directory(path);
    BOOST_TEST(!cache.find("key").has_value());
    cache.store("key", numbers(50));  // in vain, and no error
    BOOST_TEST(!cache.find("key").has_value());
}

BOOST_AUTO_TEST_CASE(keeps_nothing_without_a_folder_or_where_none_can_be) {
    const TemporaryFolder folder;
    const std::string file = folder.file("file", "no folder");
    for (const std::string& place : {std::string(), file, file + "/below", std::string("/proc/clsdf")}) {
        const ProgramCache cache(place);
        cache.store("key", numbers(5));
        BOOST_TEST(!cache.find("key").has_value());
    }
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(deletes_what_was_not_used_for_longest_when_it_is_full) {
    const TemporaryFolder folder;
    const ProgramCache cache(path_of(folder), 10000);
    const auto days_ago = [&](const std::string& key, int days) {
        fs::last_write_time(cache.path_of(key), fs::file_time_type::clock::now() - std::chrono::hours(24 * days));
    };
    for (const char* key : {"a", "b", "c"}) cache.store(key, numbers(3000));
    days_ago("a", 3);
    days_ago("b", 5);
    days_ago("c", 4);
    BOOST_TEST(cache.find("b").has_value());  // used: now it is the youngest
    cache.store("d", numbers(3000));
    BOOST_TEST(!cache.find("c").has_value());
    for (const char* key : {"a", "b", "d"}) BOOST_TEST(cache.find(key).has_value(), key);
}

BOOST_AUTO_TEST_CASE(deletes_what_killed_processes_left_and_nothing_of_others) {
    const TemporaryFolder folder;
    const ProgramCache cache(path_of(folder), 1);
    folder.file(".clsdf-1-0.part", "without a writer");
    folder.file("notes.txt", "of the user's");
    cache.store("key", numbers(5));
    BOOST_TEST(!fs::exists(folder.file(".clsdf-1-0.part")));
    BOOST_TEST(fs::exists(folder.file("notes.txt")));
    BOOST_TEST(fs::exists(cache.path_of("key")), "the newest is kept, however large it is");
}

BOOST_AUTO_TEST_CASE(serves_many_threads_that_write_and_read_the_same_programs) {
    const TemporaryFolder folder;
    std::atomic<int> wrong = 0;
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            const ProgramCache cache(path_of(folder), 20000);
            for (int i = 0; i < 100; ++i) {
                const std::string key = std::to_string(i % 5);
                const std::size_t size = 5000 + static_cast<std::size_t>(i % 5);
                if (const auto found = cache.find(key); found && *found != numbers(size)) ++wrong;
                cache.store(key, numbers(size));
            }
        });
    for (std::thread& thread : threads) thread.join();
    BOOST_TEST(wrong == 0);
    BOOST_TEST(folder.file_count() <= 5U, "a temporary file is left");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(the_folder_of_programs)

BOOST_AUTO_TEST_CASE(is_chosen_by_the_environment_if_a_program_asks_for_it) {
    const auto with = [](const std::optional<std::string>& own, const std::optional<std::string>& xdg,
                         const std::optional<std::string>& home) {
        const Variable a("CLSDF_CACHE_DIR", own), b("XDG_CACHE_HOME", xdg), c("HOME", home);
        const Device device = Device::strongest();
        BOOST_TEST(device.record_folder().empty());
        device.keep_records(Device::default_record_folder());
        return device.record_folder();
    };
    BOOST_TEST(with("/own", "/xdg", "/home/me") == "/own");
    BOOST_TEST(with("", "/xdg", "/home/me").empty());
    BOOST_TEST(with("own", "/xdg", "/home/me") == (fs::current_path() / "own").string());
    BOOST_TEST(with(std::nullopt, "/xdg", "/home/me") == "/xdg/clsdf");
    BOOST_TEST(with(std::nullopt, "relative", "/home/me") == "/home/me/.cache/clsdf");
    BOOST_TEST(with(std::nullopt, std::nullopt, "/home/me") == "/home/me/.cache/clsdf");
    BOOST_TEST(with(std::nullopt, std::nullopt, "").empty());
    BOOST_TEST(with(std::nullopt, std::nullopt, std::nullopt).empty());
}

BOOST_AUTO_TEST_CASE(has_no_programs_of_a_driver_that_keeps_them_itself) {
    const TemporaryFolder folder;
    const Device device = Device::strongest();
    device.keep_records(path_of(folder));
    build(device, "scan.cl");
    BOOST_TEST(programs_in(folder).empty() == (device.platform() == "Portable Computing Language"));
    BOOST_TEST(folder.file_count() > 0U);
}

BOOST_AUTO_TEST_CASE(knows_programs_by_the_variables_that_change_what_compilers_make) {
    const auto identity = [](const std::string& folder) { return device::context_of(device_with(folder)).identity(); };
    const std::string plain = identity("/records");
    for (const char* name : {"POCL_WORK_GROUP_METHOD", "POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_SPECIALIZATION",
                             "POCL_PREGION_VALUE_REMAT", "POCL_FORCE_PARALLEL_OUTER_LOOP", "AMD_OCL_BUILD_OPTIONS",
                             "AMD_OCL_BUILD_OPTIONS_APPEND", "IGC_EnableDPEmulation", "OverrideDefaultFP64Settings"}) {
        const Variable variable(name, "1");
        BOOST_TEST(identity("/records") != plain, name);
        BOOST_TEST(identity("") == plain, "nothing is read without records");
    }
    BOOST_TEST(identity("/records") == plain);
}

BOOST_AUTO_TEST_CASE(gets_each_program_once_and_gives_it_to_the_next_process) {
    const TemporaryFolder folder;
    for (const bool first : {true, false}) {
        const Device device = device_with(path_of(folder));
        const Built built = build(device, "scan.cl");
        BOOST_TEST(built.is_compiled == first);
        BOOST_TEST(computes(device, built.program));
        BOOST_TEST(programs_in(folder).size() == 1U);
    }
    const Device device = device_with(path_of(folder));
    BOOST_TEST(build(device, "scan.cl", std::string(options) + " -DOTHER").is_compiled);
    BOOST_TEST(build(device, "sign_sweep.cl").is_compiled);
    BOOST_TEST(programs_in(folder).size() == 3U);
}

BOOST_AUTO_TEST_CASE(is_not_touched_unless_a_program_asks_for_it) {
    const TemporaryFolder folder;
    const Variable environment("CLSDF_CACHE_DIR", path_of(folder));
    const Device device = Device::strongest();
    BOOST_TEST(computes(device, device::context_of(device).program("scan.cl", options)));
    BOOST_TEST(folder.file_count() == 0U);
}

// A binary that the driver refuses, although it is the stored one.
BOOST_AUTO_TEST_CASE(is_mended_where_a_program_in_it_is_none) {
    const TemporaryFolder folder;
    device::context_of(device_with(path_of(folder))).program("scan.cl", options);
    const fs::path path = only_program(folder);
    const std::string whole = content_of(path.string());
    // The key lies after the mark and three numbers of eight bytes.
    std::uint64_t key_size = 0;
    std::memcpy(&key_size, whole.data() + 16, sizeof key_size);
    ProgramCache(path_of(folder)).store(whole.substr(40, key_size), numbers(1000));
    BOOST_REQUIRE(only_program(folder) == path);
    for (const std::string& content : {content_of(path.string()), whole.substr(0, whole.size() / 2), std::string()}) {
        folder.file(path.filename().string(), content);
        const Device device = device_with(path_of(folder));
        const Built built = build(device, "scan.cl");
        BOOST_TEST(built.is_compiled);
        BOOST_TEST(computes(device, built.program));
        BOOST_TEST(content_of(path.string()).size() == whole.size());
        BOOST_TEST(!build(device_with(path_of(folder)), "scan.cl").is_compiled);
    }
}

BOOST_AUTO_TEST_CASE(may_be_write_protected_or_impossible) {
    const TemporaryFolder folder;
    const std::string file = folder.file("file", "no folder");
    for (const std::string& place : {file, std::string("/proc/clsdf")}) {
        const Device device = device_with(place);
        BOOST_TEST(computes(device, device::context_of(device).program("scan.cl", options)));
    }
    // Root may write all the same; the file is used in either case.
    device::context_of(device_with(folder.file("protected"))).program("scan.cl", options);
    fs::permissions(folder.file("protected"), fs::perms::owner_read | fs::perms::owner_exec);
    const Device device = device_with(folder.file("protected"));
    BOOST_TEST(!build(device, "scan.cl").is_compiled);
    BOOST_TEST(build(device, "sign_sweep.cl").is_compiled);
    fs::permissions(folder.file("protected"), fs::perms::owner_all);
}

BOOST_AUTO_TEST_SUITE_END()
