// The entry points of a fuzzer in libFuzzer's form. Options begin with --, which libFuzzer leaves to others:
//   --format=NAME    the reader; readers.cpp lists them
//   --seeds=FOLDER   writes sound files and the kept inputs there, for libFuzzer to start from

#include "fuzz/readers.hpp"

#include <clsdf/error.hpp>

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>

namespace clsdf::fuzz {

namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, std::string_view content) {
    fs::remove(path);
    std::ofstream out(path, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    if (!out.flush().good()) fail("cannot write " + path.string());
}

/// The reader of this process, and a folder of its own.
class Target {
public:
    explicit Target(const std::string& format)
        : folder_(fs::temp_directory_path() / ("clsdf-fuzz-" + std::to_string(getpid()))) {
        fs::create_directory(folder_);
        reader_ = reader_of(format, folder_);
        for (const auto& [name, content] : reader_.beside) write(folder_ / name, content);
    }
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;
    ~Target() { remove_files(); }

    void remove_files() const {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }

    const Reader& reader() const { return reader_; }

    void take(std::string_view content) const {
        write(folder_ / reader_.damaged, content);
        const std::string path = (folder_ / reader_.read).string();
        std::size_t beside = 0;
        for (const auto& file : reader_.beside) beside += file.second.size();
        try {
            const std::size_t bytes = reader_.take(path);
            constexpr std::size_t small = 4096;
            if (bytes > reader_.expansion * (content.size() + beside) + small)
                fail("a file of " + std::to_string(content.size()) + " bytes became " + std::to_string(bytes));
        } catch (const Error& error) {
            check(error);
        } catch (const std::exception& error) {
            fail(std::string("another exception than clsdf::Error: ") + error.what());
        }
    }

private:
    void check(const Error& error) const {
        const std::string message = error.what();
        if (message.find(folder_.string() + '/') == std::string::npos)
            fail("the message does not name the file: " + message);
        if (error.code() != ErrorCode::unreadable_input && error.code() != ErrorCode::invalid_mesh &&
            error.code() != ErrorCode::unsupported)
            fail("the error is not one of the file's: " + message);
        for (const char c : message)
            if (static_cast<unsigned char>(c) < 0x20 && c != '\n')
                fail("a control character is in the message: " + message);
    }

    fs::path folder_;
    Reader reader_;
};

std::unique_ptr<Target>& target() {
    static std::unique_ptr<Target> only;
    return only;
}

void write_seeds(const fs::path& folder) {
    fs::create_directories(folder);
    std::size_t number = 0;
    for (const std::string& input : sound_and_kept(target()->reader()))
        write(folder / ("seed-" + std::to_string(number++)), input);
}

std::string option(int count, char** arguments, const char* name) {
    for (int i = 1; i < count; ++i)
        if (std::strncmp(arguments[i], name, std::strlen(name)) == 0) return arguments[i] + std::strlen(name);
    return {};
}

}  // namespace

const Reader& reader_of_process() {
    return target()->reader();
}

void fail(const std::string& what) {
    std::fprintf(stderr, "fuzz_readers: %s\n", what.c_str());
    if (target() != nullptr) target()->remove_files();
    std::abort();
}

}  // namespace clsdf::fuzz

// NOLINTBEGIN(readability-identifier-naming): libFuzzer's names
extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
    using namespace clsdf::fuzz;
    target() = std::make_unique<Target>(option(*count, *arguments, "--format="));
    const std::string seeds = option(*count, *arguments, "--seeds=");
    if (!seeds.empty()) write_seeds(seeds);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clsdf::fuzz::target()->take({reinterpret_cast<const char*>(data), size});
    return 0;
}
// NOLINTEND(readability-identifier-naming)
