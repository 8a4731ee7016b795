// Runs a fuzzer without libFuzzer: the kept inputs, sound files cut short and sound files damaged at random, the same
// on every run. Options: those of one_input.cpp, and
//   --runs=N    damaged files [2000]
//   --seed=S    of the damage [1]
//   FILE...     reads these files only
// A finding ends the process; the last line names the input, and --keep=FILE keeps its bytes.

#include "fuzz/readers.hpp"
#include "support/damage.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <thread>

// NOLINTBEGIN(readability-identifier-naming): libFuzzer's names
extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
// NOLINTEND(readability-identifier-naming)

namespace clsdf::fuzz {
const Reader& reader_of_process();
}

namespace {

using namespace clsdf;

#ifdef __SANITIZE_ADDRESS__
constexpr bool is_sanitized = true;
#else
constexpr bool is_sanitized = false;
#endif
constexpr double longest_seconds = is_sanitized ? 10 : 1;  // of processor time, for files of some kilobytes
constexpr unsigned longest_wait = 120;                     // by the clock, on a busy machine
constexpr std::size_t most_memory = std::size_t{256} << 20;
constexpr std::size_t memory_of_thread = std::size_t{128} << 20;  // addresses for its stack and its heap

// Static, because signal handlers may not allocate.
char input_name[128] = "the sound files";
std::string keep_path;
const std::string* input = nullptr;

void report(int signal) {
    const auto say = [](const char* text) { return write(STDERR_FILENO, text, std::strlen(text)) >= 0; };
    const bool said = say(signal == SIGALRM ? "fuzz_readers: a hang, at " : "fuzz_readers: ended by ") &&
                      say(input_name) && say("\n");
    _exit(said ? 1 : 2);
}

void try_one(const std::string& bytes, const std::string& name) {
    std::snprintf(input_name, sizeof input_name, "%s", name.c_str());
    input = &bytes;
    if (!keep_path.empty()) std::ofstream(keep_path, std::ios::binary) << bytes;
    alarm(longest_wait);
    const std::clock_t start = std::clock();
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (seconds > longest_seconds && bytes.size() < (std::size_t{1} << 16))
        fuzz::fail("a file of " + std::to_string(bytes.size()) + " bytes took " + std::to_string(seconds) + " s");
}

/// Limits memory, so that the allocation of a size that a damaged file states fails. (A sanitizer needs all addresses.)
void limit_memory() {
    if (is_sanitized) return;
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + most_memory +
                         std::thread::hardware_concurrency() * memory_of_thread;
    const rlimit limits{limit, limit};
    setrlimit(RLIMIT_AS, &limits);
}

int run(int count, char** arguments) {
    std::size_t runs = 2000;
    std::uint32_t seed = 1;
    std::vector<std::string> files;
    for (int i = 1; i < count; ++i) {
        const std::string argument = arguments[i];
        if (argument.starts_with("--runs="))
            runs = std::stoul(argument.substr(7));
        else if (argument.starts_with("--seed="))
            seed = static_cast<std::uint32_t>(std::stoul(argument.substr(7)));
        else if (argument.starts_with("--keep="))
            keep_path = argument.substr(7);
        else if (!argument.starts_with("--"))
            files.push_back(argument);
    }
    for (const std::string& file : files) {
        std::ifstream in(file, std::ios::binary);
        try_one({std::istreambuf_iterator<char>(in), {}}, file);
    }
    if (!files.empty()) return 0;

    const std::vector<std::string> inputs = fuzz::sound_and_kept(fuzz::reader_of_process());
    std::printf("%s: %zu inputs, %zu damaged ones, seed %u\n", fuzz::reader_of_process().format.c_str(), inputs.size(),
                runs, seed);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        try_one(inputs[i], "input " + std::to_string(i));
        const std::size_t step = inputs[i].size() / 200 + 1;
        for (std::size_t length = 0; length < inputs[i].size(); length += step)
            try_one(inputs[i].substr(0, length), "input " + std::to_string(i) + " cut to " + std::to_string(length));
    }
    test::Dice dice(seed);
    for (std::size_t n = 0; n < runs; ++n)
        try_one(test::damaged(inputs[n % inputs.size()], dice),
                "damaged input " + std::to_string(n) + " of seed " + std::to_string(seed));
    return 0;
}

}  // namespace

int main(int count, char** arguments) {
    for (const int signal : {SIGALRM, SIGABRT}) std::signal(signal, report);
    if (!is_sanitized)
        for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, report);
    LLVMFuzzerInitialize(&count, &arguments);
    limit_memory();
    return run(count, arguments);
}
