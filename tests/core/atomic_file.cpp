#include "core/files.hpp"
#include "core/unfinished_files.hpp"

#include "support/small_disk.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <vector>

namespace clsdf {

using test::check_throws;
using test::content_of;
using test::TemporaryFolder;

BOOST_AUTO_TEST_CASE(a_committed_file_is_complete_and_alone_in_its_folder) {
    const TemporaryFolder folder;
    AtomicFile file(folder.file("field.raw"));
    file.write("some text, ");
    file.write(std::as_bytes(std::span("and bytes", 9)));
    file.commit();
    BOOST_TEST(content_of(folder.file("field.raw")) == "some text, and bytes");
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(a_file_that_is_replaced_keeps_its_access_rights) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.raw", "private");
    const auto rights = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
    std::filesystem::permissions(path, rights);
    AtomicFile file(path);
    file.write("new");
    file.commit();
    BOOST_TEST(content_of(path) == "new");
    BOOST_CHECK(std::filesystem::status(path).permissions() == rights);
}

BOOST_AUTO_TEST_CASE(a_link_to_a_file_that_does_not_exist_stays_and_the_file_appears) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.file("results"));
    std::filesystem::create_symlink("results/field.raw", folder.file("second.raw"));
    std::filesystem::create_symlink(folder.file("second.raw"), folder.file("first.raw"));
    AtomicFile file(folder.file("first.raw"));
    file.write("new");
    file.commit();
    BOOST_TEST(std::filesystem::is_symlink(folder.file("first.raw")));
    BOOST_TEST(std::filesystem::is_symlink(folder.file("second.raw")));
    BOOST_TEST(content_of(folder.file("results/field.raw")) == "new");
}

BOOST_AUTO_TEST_CASE(without_a_commit_nothing_is_left) {
    const TemporaryFolder folder;
    {
        AtomicFile file(folder.file("field.raw"));
        file.write("half a fie");
        BOOST_TEST(!std::filesystem::exists(folder.file("field.raw")));
    }
    BOOST_TEST(folder.file_count() == 0U);
}

namespace {

// The thread sanitizer does not support threads that start after fork().
#ifdef __SANITIZE_THREAD__
constexpr bool threads_may_follow_fork = false;
#else
constexpr bool threads_may_follow_fork = true;
#endif

}  // namespace

// In a process of its own, because nothing can be written there afterwards.
BOOST_AUTO_TEST_CASE(abandoned_files_leave_nothing_and_are_not_committed_any_more,
                     *boost::unit_test::enable_if<threads_may_follow_fork>()) {
    const TemporaryFolder folder;
    const pid_t child = ::fork();
    BOOST_REQUIRE(child >= 0);
    if (child == 0) {
        AtomicFile first(folder.file("first.raw"));
        AtomicFile second(folder.file("second.raw"));
        first.write("half a");
        AtomicFile(folder.file("third.raw")).commit();
        std::atomic<bool> are_abandoned = false;
        std::thread([&] {
            abandon_unfinished_files();
            abandon_unfinished_files();  // also returns
            are_abandoned = true;
            std::this_thread::sleep_for(std::chrono::milliseconds(300));
            ::_exit(7);
        }).detach();
        while (!are_abandoned) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        second.commit();  // waits until the process ends
        ::_exit(8);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    BOOST_TEST((WIFEXITED(status) && WEXITSTATUS(status) == 7));
    BOOST_TEST(folder.file_count() == 1U);
    BOOST_TEST(std::filesystem::exists(folder.file("third.raw")));
}

namespace {

/// A process that writes half a file in the folder, and then waits to be killed.
class HalfWriter {
public:
    explicit HalfWriter(const TemporaryFolder& folder) : folder_(folder.file("")) {
        int ends[2];
        BOOST_REQUIRE(::pipe(ends) == 0);
        id_ = ::fork();
        BOOST_REQUIRE(id_ >= 0);
        if (id_ == 0) {
            AtomicFile file(folder.file("half.raw"));
            file.write("half a fie");
            if (::write(ends[1], "!", 1) != 1) ::_exit(1);
            while (true) ::pause();
        }
        char written = 0;
        BOOST_REQUIRE(::read(ends[0], &written, 1) == 1);
        for (const int end : ends) ::close(end);
    }
    ~HalfWriter() {
        if (id_ > 0) kill();
    }
    HalfWriter(const HalfWriter&) = delete;
    HalfWriter& operator=(const HalfWriter&) = delete;

    /// ".clsdf-MACHINE-PID-0.part".
    std::string name() const {
        const std::string end = std::to_string(id_) + "-0.part";
        for (const auto& entry : std::filesystem::directory_iterator(folder_))
            if (const std::string name = entry.path().filename().string();
                name.starts_with(".clsdf-") && name.ends_with(end))
                return name;
        return "none";
    }

    void kill() {
        ::kill(id_, SIGKILL);
        ::waitpid(id_, nullptr, 0);
        id_ = -1;
    }

private:
    std::filesystem::path folder_;
    pid_t id_ = -1;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_later_file_in_the_folder_removes_what_a_killed_writer_left_and_nothing_else) {
    const TemporaryFolder folder;
    const HalfWriter living(folder);
    HalfWriter killed(folder);
    const std::string left = killed.name();
    killed.kill();
    const std::size_t machine_end = left.find('-', std::strlen(".clsdf-"));
    BOOST_REQUIRE(machine_end == std::strlen(".clsdf-12345678"));
    const std::string here = left.substr(0, machine_end);
    for (const char* rest : {"-notes.part", "-1-.part", "-1-2-3.part", ".part"}) folder.file(here + rest, "somebody's");
    for (const char* name : {"clsdf-1-0.part", ".clsdf-1-0.part"}) folder.file(name, "somebody's");
    // A file server sees the files of its clients, and not their locks.
    std::string of_another_machine = left;
    char& digit = of_another_machine[machine_end - 1];
    digit = digit == '0' ? '1' : '0';
    folder.file(of_another_machine, "half a fie");
    std::filesystem::create_directory(folder.file(here + "-1-0.part"));
    BOOST_REQUIRE(folder.file_count() == 10U);
    BOOST_TEST(std::filesystem::exists(folder.file(left)));

    AtomicFile(folder.file("field.raw")).commit();
    BOOST_TEST(!std::filesystem::exists(folder.file(left)));
    BOOST_TEST(std::filesystem::exists(folder.file(living.name())));
    BOOST_TEST(std::filesystem::exists(folder.file(of_another_machine)));
    BOOST_TEST(folder.file_count() == 10U);
}

BOOST_AUTO_TEST_CASE(a_file_that_is_being_written_is_never_taken_for_a_stale_one) {
    const TemporaryFolder folder;
    std::atomic<bool> done = false;
    std::vector<std::thread> cleaners;
    for (int i = 0; i < 2; ++i)
        cleaners.emplace_back([&] {
            while (!done) remove_stale_files(folder.file(""));
        });
    // Between its creation and its lock a file may be lost, and after its lock is gone it must have its name.
    BOOST_CHECK_NO_THROW(for (int i = 0; i < 1000; ++i) {
        AtomicFile file(folder.file("field.raw"));
        file.write(std::to_string(i));
        file.commit();
        if (content_of(folder.file("field.raw")) != std::to_string(i)) throw std::runtime_error("another content");
    });
    done = true;
    for (std::thread& cleaner : cleaners) cleaner.join();
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(an_earlier_file_stays_until_the_commit) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.raw", "earlier");
    AtomicFile file(path);
    file.write("later");
    BOOST_TEST(content_of(path) == "earlier");
    file.commit();
    BOOST_TEST(content_of(path) == "later");
}

BOOST_AUTO_TEST_CASE(two_writers_of_one_file_do_not_mix) {
    const TemporaryFolder folder;
    AtomicFile first(folder.file("field.raw"));
    AtomicFile second(folder.file("field.raw"));
    first.write("first");
    second.write("second");
    first.commit();
    BOOST_TEST(content_of(folder.file("field.raw")) == "first");
    second.commit();
    BOOST_TEST(content_of(folder.file("field.raw")) == "second");
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(a_symbolic_link_stays_a_link_to_the_new_content) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.raw", "earlier");
    std::filesystem::create_symlink(path, folder.file("link.raw"));
    AtomicFile file(folder.file("link.raw"));
    file.write("later");
    file.commit();
    BOOST_TEST(std::filesystem::is_symlink(folder.file("link.raw")));
    BOOST_TEST(content_of(path) == "later");
}

BOOST_AUTO_TEST_CASE(a_device_is_written_directly) {
    AtomicFile file("/dev/null");
    file.write("gone");
    file.commit();
    BOOST_TEST(!std::filesystem::is_regular_file("/dev/null"));
}

BOOST_AUTO_TEST_CASE(a_full_device_is_an_error) {
    check_throws(ErrorCode::output_failure, {"/dev/full", "No space left"}, [] {
        AtomicFile file("/dev/full");
        file.write("a few bytes, which only the commit sends out");
        file.commit();
    });
}

BOOST_AUTO_TEST_CASE(a_write_that_fails_in_the_middle_leaves_the_earlier_file) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.raw", "earlier");
    {
        const test::SmallDisk disk(100000);
        check_throws(ErrorCode::output_failure, {"field.raw", "File too large"}, [&] {
            AtomicFile file(path);
            for (int i = 0; i < 1000; ++i) file.write(std::string(1000, 'x'));
            file.commit();
        });
    }
    BOOST_TEST(content_of(path) == "earlier");
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(a_folder_or_a_missing_folder_is_an_error_before_anything_is_written) {
    const TemporaryFolder folder;
    check_throws(ErrorCode::output_failure, {"Is a directory"}, [&] { AtomicFile file(folder.file("")); });
    check_throws(ErrorCode::output_failure, {"none/field.raw", "no folder"},
                 [&] { AtomicFile file(folder.file("none/field.raw")); });
    check_throws(ErrorCode::output_failure, {"cannot write ''"}, [&] { AtomicFile file(""); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(a_name_of_the_greatest_length_can_be_written) {
    const TemporaryFolder folder;
    AtomicFile file(folder.file(std::string(255, 'n')));
    file.write("long");
    file.commit();
    BOOST_TEST(content_of(folder.file(std::string(255, 'n'))) == "long");
}

}  // namespace clsdf
