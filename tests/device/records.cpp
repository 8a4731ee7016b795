#include "device/records.hpp"

#include "device/context.hpp"
#include "support/temporary_folder.hpp"

#include <clsdf/device.hpp>

#include <boost/test/unit_test.hpp>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
using device::Records;

namespace {

namespace fs = std::filesystem;

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

fs::path only_file(const fs::path& folder) {
    const fs::directory_iterator files(folder);
    BOOST_REQUIRE(std::distance(begin(files), end(files)) == 1);
    return fs::directory_iterator(folder)->path();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(records)

BOOST_AUTO_TEST_CASE(give_back_what_was_stored_under_the_very_same_key) {
    const TemporaryFolder folder;
    const Records records(folder.file("deep") + "/er", ".tested");
    BOOST_TEST(!records.has("one"));
    const std::string content("some\0bytes", 10);
    records.store("one", content);
    records.note("two");
    BOOST_TEST(records.find("one").value() == content);
    BOOST_TEST(records.find("two").value().empty());
    BOOST_TEST(!records.has("one "));
    records.store("one", "other");
    BOOST_TEST(records.find("one").value() == "other");
    records.forget("on");
    BOOST_TEST(!records.has("one"));
    BOOST_TEST(records.has("two"));
}

BOOST_AUTO_TEST_CASE(that_are_damaged_or_of_another_key_count_as_missing) {
    const TemporaryFolder folder;
    const Records records(folder.file("kept"), ".tested");
    records.store("key", "content");
    const fs::path path = only_file(records.folder());
    const std::string name = "kept/" + path.filename().string(), whole = content_of(path.string());
    for (std::size_t length = 0; length < whole.size(); ++length) {
        folder.file(name, std::string_view(whole).substr(0, length));
        BOOST_REQUIRE_MESSAGE(!records.has("key"), "cut to " << length << " bytes");
    }
    folder.file(name, whole + "x");
    BOOST_TEST(!records.has("key"));
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        folder.file(name, damaged);
        BOOST_REQUIRE_MESSAGE(!records.has("key"), "byte " << i << " changed");
    }
    fs::remove(path);
    fs::create_directory(path);
    BOOST_TEST(!records.has("key"));
    records.note("key");  // in vain, and no error
    fs::remove(path);
    // Two keys may have one name.
    records.store("another", "content");
    fs::rename(only_file(records.folder()), path);
    BOOST_TEST(!records.has("key"));
}

BOOST_AUTO_TEST_CASE(need_no_files) {
    const TemporaryFolder folder;
    const std::string file = folder.file("file", "no folder");
    for (const std::string& place : {std::string(), file, file + "/below", std::string("/proc/clsdf")}) {
        const Records records(place, ".tested");
        records.note("key");
        BOOST_TEST(!records.has("key"));
        records.forget("key");
    }
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(serve_many_threads_that_write_and_read_the_same) {
    const TemporaryFolder folder;
    const Records records(folder.file("kept"), ".tested");
    std::atomic<int> wrong = 0;
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 100; ++i) {
                const std::string key = std::to_string(i % 5), content(5000, key[0]);
                if (const auto found = records.find(key); found && *found != content) ++wrong;
                records.store(key, content);
            }
        });
    for (std::thread& thread : threads) thread.join();
    BOOST_TEST(wrong == 0);
    const fs::directory_iterator files(records.folder());
    BOOST_TEST(std::distance(begin(files), end(files)) == 5, "an unfinished file is left");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(the_folder_of_records)

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

BOOST_AUTO_TEST_CASE(has_records_for_the_variables_that_change_what_compilers_make) {
    const auto identity = [](const std::string& folder) {
        const Device device = Device::strongest();
        device.keep_records(folder);
        return device::context_of(device).identity();
    };
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

BOOST_AUTO_TEST_SUITE_END()
