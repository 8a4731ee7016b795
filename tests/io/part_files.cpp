// Files of parts give back the bytes, and name what is wrong.
#include "support/filled_memory.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/part_files.hpp>

#include <boost/test/unit_test.hpp>

#include <sys/resource.h>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// As many as a part of that number has, more than are copied at once.
std::vector<std::byte> bytes_of(std::size_t part) {
    std::vector<std::byte> bytes(1 + part * 5'000'000);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * (i + part) >> 3);
    return bytes;
}

}  // namespace

BOOST_AUTO_TEST_CASE(parts_come_back_by_their_numbers) {
    const TemporaryFolder folder;
    const std::string path = folder.file("parts.h5");
    PartWriter writer(path);
    for (std::size_t part = 0; part < 3; ++part) writer.append(bytes_of(part));
    BOOST_TEST(!std::filesystem::exists(path));
    writer.finish();
    BOOST_TEST(count_parts(path) == 3U);
    for (const std::size_t part : {2U, 0U, 1U}) BOOST_TEST((read_part(path, part) == bytes_of(part)), part);
    check_throws(ErrorCode::invalid_argument, {"no part 3: parts are numbered from 0, and it has 3"},
                 [&] { read_part(path, 3); });
}

// No byte of memory that was there before gets out.
BOOST_AUTO_TEST_CASE(equal_parts_make_equal_files_whatever_was_in_memory_before) {
    const TemporaryFolder folder;
    const auto text_of = [&](unsigned char old) {
        const FilledMemory filled(old);
        const std::string path = folder.file("parts.h5");
        PartWriter writer(path);
        for (std::size_t part = 0; part < 2; ++part) writer.append(bytes_of(part));
        writer.finish();
        std::ifstream file(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    };
    const std::string text = text_of(0x00);
    BOOST_TEST(text.size() > 5'000'000U);
    BOOST_TEST((text_of(0xA5) == text));
    BOOST_TEST((text_of(0x5A) == text));
}

BOOST_AUTO_TEST_CASE(no_file_stays_without_finish) {
    const TemporaryFolder folder;
    {
        PartWriter writer(folder.file("parts.h5"));
        writer.append(bytes_of(1));
    }
    BOOST_TEST(std::filesystem::is_empty(std::filesystem::path(folder.file("parts.h5")).parent_path()));
    check_throws(ErrorCode::invalid_argument, {"there is no part"},
                 [&] { PartWriter(folder.file("parts.h5")).finish(); });
    check_throws(ErrorCode::invalid_argument, {"no bytes"}, [&] { PartWriter(folder.file("parts.h5")).append({}); });
    check_throws(ErrorCode::unsupported, {"parts are written as .h5"}, [&] { PartWriter(folder.file("parts.nrrd")); });
    PartWriter(folder.file("PARTS.H5"));
}

// The next part would begin behind the bytes that were written before the failure.
BOOST_AUTO_TEST_CASE(a_part_that_could_not_be_written_ends_the_file) {
    const TemporaryFolder folder;
    PartWriter writer(folder.file("parts.h5"));
    writer.append(bytes_of(1));
    const auto on_exceeding = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit small{6'000'000, limit.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    check_throws(ErrorCode::output_failure, {"parts.h5"}, [&] { writer.append(bytes_of(1)); });
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, on_exceeding);
    check_throws(ErrorCode::invalid_argument, {"could not be written"}, [&] { writer.append(bytes_of(0)); });
    check_throws(ErrorCode::invalid_argument, {"could not be written"}, [&] { writer.finish(); });
    BOOST_TEST(std::filesystem::is_empty(std::filesystem::path(folder.file("parts.h5")).parent_path()));
}

BOOST_AUTO_TEST_CASE(files_that_are_damaged_or_have_no_parts_are_named) {
    const TemporaryFolder folder;
    const std::string path = folder.file("parts.h5");
    {
        PartWriter writer(path);
        writer.append(bytes_of(1));
        writer.finish();
    }
    const auto all = std::filesystem::file_size(path);
    std::filesystem::resize_file(path, all - 1);
    check_throws(ErrorCode::unreadable_input, {"parts.h5"}, [&] { read_part(path, 0); });
    std::filesystem::resize_file(path, 40);
    check_throws(ErrorCode::unreadable_input, {"parts.h5"}, [&] { count_parts(path); });
    std::ofstream(path) << "v 0 0 0\n";
    check_throws(ErrorCode::unreadable_input, {"not an HDF5 file"}, [&] { read_part(path, 0); });
}
