#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <functional>
#include <random>

using namespace clsdf;
using namespace clsdf::test;

namespace {

// Some file systems make the disk catch up when a file is overwritten, but not when it is new.
void replace(const TemporaryFolder& folder, const std::string& name, const std::string& content) {
    std::filesystem::remove(folder.file(name));
    folder.file(name, content);
}

// Whether it is read at all; the only other answer is the error of an unreadable file.
bool can_be_read(const std::string& path) {
    try {
        const Field field = read_field(path);
        BOOST_TEST(field.distance().size() == field.grid.sample_count());
        return true;
    } catch (const Error& error) {
        BOOST_CHECK(error.code() == ErrorCode::unreadable_input);
        return false;
    }
}

// Runs a statement for each file that makes up a field, in a folder with undamaged ones: `damaged` is its name, `whole`
// its content, and `path` what is read.
void for_each_file(const std::function<void(const TemporaryFolder& folder, const std::string& path,
                                            const std::string& damaged, const std::string& whole)>& statement) {
    for_each_format([&](const TemporaryFolder& folder, const Format& format) {
        const std::string path = folder.file("field" + format.ending);
        write_field(example_field(format), path);
        for (const auto& [name, content] : all_contents(folder)) {
            if (name.ends_with(".xdmf")) continue;  // for other programs
            statement(folder, path, name, content);
            replace(folder, name, content);
        }
    });
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_damaged_field)

BOOST_AUTO_TEST_CASE(is_refused_wherever_it_is_cut_off) {
    for_each_file([](const TemporaryFolder& folder, const std::string& path, const std::string& damaged,
                     const std::string& whole) {
        // Nobody misses the last brackets and line ends of a text.
        const std::size_t enough = damaged.ends_with(".json") ? 2 : damaged.ends_with(".vti") ? 31 : 0;
        const std::size_t step = whole.size() < 10000 ? 1 : 997;
        for (std::size_t length = 0; length + enough < whole.size(); length += step) {
            BOOST_TEST_CONTEXT(damaged << " cut to " << length << " bytes") {
                replace(folder, damaged, whole.substr(0, length));
                BOOST_TEST(!can_be_read(path));
            }
        }
    });
}

BOOST_AUTO_TEST_CASE(is_read_or_refused_but_nothing_else_whatever_bytes_change) {
    for_each_file([](const TemporaryFolder& folder, const std::string& path, const std::string& damaged,
                     const std::string& whole) {
        constexpr unsigned seed = 3;
        std::mt19937 random(seed);
        for (int round = 0; round < 2000; ++round) {
            BOOST_TEST_CONTEXT("seed " << seed << ", round " << round << " of " << damaged) {
                std::string mutated = whole;
                for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
                    const std::size_t position = random() % mutated.size();
                    switch (random() % 3) {
                        case 0:
                            mutated[position] = static_cast<char>(random());
                            break;
                        case 1:
                            mutated.insert(position, 1, "0123456789 -,.()\n"[random() % 17]);
                            break;
                        default:
                            mutated.erase(position, 1 + random() % 3);
                            break;
                    }
                    if (mutated.empty()) break;
                }
                replace(folder, damaged, mutated);
                can_be_read(path);
            }
        }
    });
}

BOOST_AUTO_TEST_SUITE_END()
