#include "core/atomic_file.hpp"

#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/unfinished_files.hpp>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

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

BOOST_AUTO_TEST_CASE(without_a_commit_nothing_is_left) {
    const TemporaryFolder folder;
    {
        AtomicFile file(folder.file("field.raw"));
        file.write("half a fie");
        BOOST_TEST(!std::filesystem::exists(folder.file("field.raw")));
    }
    BOOST_TEST(folder.file_count() == 0U);
}

// In a process of its own, because nothing can be written there afterwards.
BOOST_AUTO_TEST_CASE(abandoned_files_leave_nothing_and_are_not_committed_any_more) {
    const TemporaryFolder folder;
    const pid_t child = ::fork();
    BOOST_REQUIRE(child >= 0);
    if (child == 0) {
        AtomicFile first(folder.file("first.raw"));
        AtomicFile second(folder.file("second.raw"));
        first.write("half a");
        AtomicFile(folder.file("third.raw")).commit();
        std::thread([] {
            abandon_unfinished_files();
            std::this_thread::sleep_for(std::chrono::milliseconds(300));
            ::_exit(7);
        }).detach();
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        second.commit();  // waits until the process ends
        ::_exit(8);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    BOOST_TEST((WIFEXITED(status) && WEXITSTATUS(status) == 7));
    BOOST_TEST(folder.file_count() == 1U);
    BOOST_TEST(std::filesystem::exists(folder.file("third.raw")));
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
    // The system's limit on a file's size stands in for a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit earlier{};
    getrlimit(RLIMIT_FSIZE, &earlier);
    rlimit small = earlier;
    small.rlim_cur = 100000;
    setrlimit(RLIMIT_FSIZE, &small);
    check_throws(ErrorCode::output_failure, {"field.raw", "File too large"}, [&] {
        AtomicFile file(path);
        for (int i = 0; i < 1000; ++i) file.write(std::string(1000, 'x'));
        file.commit();
    });
    setrlimit(RLIMIT_FSIZE, &earlier);
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
