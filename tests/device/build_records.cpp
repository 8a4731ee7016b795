#include "device/program_cache.hpp"

#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
using device::BuildMarker;
using device::BuildRecords;
using device::BuildSubject;

namespace {

namespace fs = std::filesystem;

const std::string identity = "platform\nplatform 1.2\nvendor\ndevice\nOpenCL 3.0\ndriver 5\n";

BuildSubject subject(const std::string& name) {
    return {identity + name + '\n', name, identity};
}

/// Begins a build in a process of its own, which is killed in the middle of it.
void be_killed_during_a_build(const BuildRecords& records, const BuildSubject& what) {
    const pid_t id = ::fork();
    BOOST_REQUIRE(id >= 0);
    if (id == 0) {
        device::build_once(records, what, {}, [] { ::raise(SIGKILL); });
        ::_exit(0);
    }
    int status = 0;
    BOOST_REQUIRE(::waitpid(id, &status, 0) == id);
    BOOST_REQUIRE(WIFSIGNALED(status));
}

/// Whether build() was called.
bool builds(const BuildRecords& records, const BuildSubject& what, std::vector<std::string>* log = nullptr) {
    bool is_called = false;
    device::BuildWatch watch;
    if (log != nullptr) watch.log = [&](const std::string& message) { log->push_back(message); };
    device::build_once(records, what, watch, [&] { is_called = true; });
    return is_called;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(records_of_builds)

BOOST_AUTO_TEST_CASE(say_what_was_built_once) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("deep") + "/er");
    BOOST_TEST(builds(records, subject("one")));
    BOOST_TEST(!builds(records, subject("one")));
    BOOST_TEST(builds(records, subject("two")));
    BOOST_TEST(!fs::exists(records.marker_of(subject("one").key)));
    BOOST_TEST((fs::status(records.folder()).permissions() == fs::perms::owner_all));
    // The key is compared, not the file's name, which two keys may share.
    fs::rename(records.record_of(subject("one").key), records.record_of(subject("three").key));
    BOOST_TEST(builds(records, subject("three")));
    records.forget(identity);
    BOOST_TEST(builds(records, subject("two")));
    records.forget("platform\nanother");
    BOOST_TEST(!builds(records, subject("two")));
}

BOOST_AUTO_TEST_CASE(are_not_kept_of_what_failed) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    for (int i = 0; i < 4; ++i)
        check_throws(ErrorCode::device_failure, {"of the compiler"}, [&] {
            device::build_once(records, subject("one"), {},
                               [] { throw Error(ErrorCode::device_failure, "of the compiler"); });
        });
    BOOST_TEST(!fs::exists(records.marker_of(subject("one").key)), "an exception is no end of the process");
    BOOST_TEST(builds(records, subject("one")));
}

BOOST_AUTO_TEST_CASE(need_no_files) {
    const TemporaryFolder folder;
    const std::string file = folder.file("file", "no folder");
    for (const std::string& place : {std::string(), file, std::string("/proc/clsdf")}) {
        const BuildRecords records(place);
        BOOST_TEST(builds(records, subject("one")));
        BOOST_TEST(builds(records, subject("one")));
    }
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(are_neither_links_nor_damaged) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    const BuildSubject what = subject("one");
    BOOST_TEST(builds(records, what));
    const fs::path record = records.record_of(what.key);
    fs::rename(record, folder.file("elsewhere"));
    fs::create_symlink(folder.file("elsewhere"), record);
    BOOST_TEST(!records.has(what.key));
    fs::remove(record);
    fs::resize_file(folder.file("elsewhere"), 20);
    fs::rename(folder.file("elsewhere"), record);
    BOOST_TEST(!records.has(what.key));
    // Nor is a marker: what it points to stays as it is.
    const std::string target = folder.file("target", "of the user's");
    fs::create_symlink(target, records.marker_of(what.key));
    BOOST_TEST(builds(records, what));
    BOOST_TEST(content_of(target) == "of the user's");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_build_that_ends_the_process)

BOOST_AUTO_TEST_CASE(is_tried_twice_and_then_refused) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    const BuildSubject what = subject("bricks.cl");
    be_killed_during_a_build(records, what);
    // A user may have killed the first one: it is tried again, with a warning.
    std::vector<std::string> log;
    BOOST_TEST(builds(records, what, &log));
    BOOST_REQUIRE(log.size() == 1U);
    for (const char* part : {"bricks.cl", "device", "platform 1.2", "driver 5"})
        BOOST_TEST(log.front().find(part) != std::string::npos, part);
    records.forget(identity);
    log.clear();

    be_killed_during_a_build(records, what);
    be_killed_during_a_build(records, what);
    const std::string marker = records.marker_of(what.key).string();
    for (int i = 0; i < 2; ++i)
        check_throws(ErrorCode::device_failure,
                     {"bricks.cl", "device", "platform 1.2", "driver 5", marker, "clsdf devices --prepare --again",
                      "CLSDF_DEVICE"},
                     [&] { builds(records, what); });
    BOOST_TEST(builds(records, subject("another.cl"), &log), "others are not concerned");
    BOOST_TEST(log.empty());

    // Both remedies.
    fs::copy_file(marker, folder.file("kept"));
    fs::remove(marker);
    BOOST_TEST(builds(records, what, &log));
    BOOST_TEST(log.empty());
    records.forget(identity);
    fs::copy_file(folder.file("kept"), marker);
    check_throws(ErrorCode::device_failure, {marker}, [&] { builds(records, what); });
    records.forget(identity);
    BOOST_TEST(builds(records, what, &log));
    BOOST_TEST(log.empty());
}

BOOST_AUTO_TEST_CASE(counts_in_a_row_only) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    const BuildSubject what = subject("bricks.cl");
    for (int i = 0; i < 3; ++i) {
        be_killed_during_a_build(records, what);
        BOOST_TEST(builds(records, what));
        fs::remove(records.record_of(what.key));
    }
}

BOOST_AUTO_TEST_CASE(is_not_seen_in_one_that_is_under_way) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    const BuildSubject what = subject("bricks.cl");
    std::atomic<int> built = 0, waited = 0;
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            device::BuildWatch watch;
            bool is_counted = false;
            watch.waiting = [&] { waited += std::exchange(is_counted, true) ? 0 : 1; };
            device::build_once(records, what, watch, [&] {
                ++built;
                for (int ms = 0; waited < 3 && ms < 60000; ++ms)
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            });
        });
    for (std::thread& thread : threads) thread.join();
    BOOST_TEST(built == 1, "one builds, the others wait for it");
    BOOST_TEST(waited == 3);
    BOOST_TEST(!fs::exists(records.marker_of(what.key)));
}

BOOST_AUTO_TEST_CASE(is_waited_for_until_the_caller_has_enough) {
    const TemporaryFolder folder;
    const BuildRecords records(folder.file("cache"));
    const BuildSubject what = subject("bricks.cl");
    BuildMarker builder(records, what.key);
    builder.begin();
    device::BuildWatch watch;
    watch.waiting = [] { throw Error(ErrorCode::cancelled, "enough"); };
    check_throws(ErrorCode::cancelled, {"enough"}, [&] { device::build_once(records, what, watch, [] {}); });
    records.forget(identity);
    BOOST_TEST(fs::exists(builder.path()), "it is held by a process that lives");
}

BOOST_AUTO_TEST_SUITE_END()
