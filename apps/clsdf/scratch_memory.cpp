#include "scratch_memory.hpp"

#include "scratch_blocks.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/vfs.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <string_view>
#include <system_error>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;

/// Magic numbers of statfs(2): tmpfs and ramfs.
constexpr std::array<std::uint32_t, 2> file_systems_in_memory{0x01021994, 0x858458F6};
/// NFS, CIFS, SMB, SMB 2, 9p, AFS, Coda, Ceph, Lustre, GPFS, BeeGFS, FUSE.
constexpr std::array<std::uint32_t, 12> file_systems_of_networks{0x6969,     0xFF534D42, 0x517B,     0xFE534D42,
                                                                 0x01021997, 0x5346414F, 0x73757245, 0x00C36400,
                                                                 0x0BD00BD0, 0x47504653, 0x19830326, 0x65735546};

constexpr const char* remedy = "name a folder of another disk of this machine (--scratch)";

[[noreturn]] void refuse(const std::string& folder, const std::string& reason) {
    throw Error(ErrorCode::unsupported, fmt::format("the scratch folder '{}' {}; {}", folder, reason, remedy));
}

void check_file_system(const std::string& folder, int descriptor) {
    struct statfs status {};
    if (::fstatfs(descriptor, &status) != 0) return;
    const auto is_one_of = [type = static_cast<std::uint32_t>(status.f_type)](const auto& types) {
        return std::ranges::find(types, type) != types.end();
    };
    if (is_one_of(file_systems_in_memory)) refuse(folder, "is in memory itself (tmpfs)");
    if (is_one_of(file_systems_of_networks))
        refuse(folder, "is on a file system that a server may have, for which pages of memory would wait");
}

/// Each block is a file, and the usual limit is 1,024.
void allow_more_files() {
    struct rlimit limit {};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

int open_folder(const std::string& folder) {
    const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (opened < 0)
        throw Error(ErrorCode::invalid_argument, fmt::format("the scratch folder '{}' cannot be opened: {}; {}", folder,
                                                             std::generic_category().message(errno), remedy));
    return opened;
}

/// A page of a block that cannot be read or written. Its thread is not within a function of the library that has locks
/// of unfinished files: these have no blocks.
extern "C" void end_at_lost_page(int signal, siginfo_t* info, void*) {
    if (!ScratchBlocks::of_process().contains(info->si_addr)) {
        ::signal(signal, SIG_DFL);  // the instruction is repeated, and ends the process
        return;
    }
    constexpr std::string_view message =
        "clsdf: the scratch folder has lost a page: its disk fails, or is full; name another folder (--scratch)\n";
    clsdf::abandon_unfinished_files();
    if (::write(STDERR_FILENO, message.data(), message.size()) < 0) {
        // The exit status says it.
    }
    ::_exit(5);
}

}  // namespace

ScratchMemory::ScratchMemory(const std::string& folder, std::size_t memory, std::size_t least_block)
    : folder_(folder), opened_(open_folder(folder)), watcher_(memory) {
    check_file_system(folder, opened_.number());
    allow_more_files();
    ScratchBlocks& blocks = ScratchBlocks::of_process();
    blocks.open_folder(opened_.number(), least_block);
    // One block shows whether the folder takes any.
    bool is_full = false;
    void* const block = blocks.add(1, 0, is_full);
    if (block == nullptr) {
        const int error = is_full ? blocks.failure().error : EMFILE;
        blocks.close_folder();
        if (error == ENOSPC || error == EDQUOT || error == EFBIG) throw_if_full();
        refuse(folder, fmt::format("takes no files: {}", std::generic_category().message(error)));
    }
    blocks.remove(block);
    struct sigaction action {};
    action.sa_sigaction = end_at_lost_page;
    action.sa_flags = SA_SIGINFO;
    ::sigaction(SIGBUS, &action, nullptr);
}

ScratchMemory::~ScratchMemory() {
    ScratchBlocks::of_process().close_folder();
    ::signal(SIGBUS, SIG_DFL);
}

void ScratchMemory::throw_if_full() const {
    const auto [error, bytes, used] = ScratchBlocks::of_process().failure();
    if (error == 0) return;
    const auto gigabytes = [](std::size_t n) { return static_cast<double>(n) / 1e9; };
    throw Error(
        ErrorCode::output_failure,
        fmt::format("the scratch folder '{}' has no room for {:.3f} GB more, beside {:.3f} GB of other arrays: "
                    "{}; most meshes take up to 240 bytes a triangle there: free its disk, or {}",
                    folder_, gigabytes(bytes), gigabytes(used), std::generic_category().message(error), remedy));
}

ScratchMemory::Use ScratchMemory::use() const {
    const ScratchBlocks& blocks = ScratchBlocks::of_process();
    return {blocks.most_bytes(), watcher_.most_resident(), blocks.made(), blocks.missed(), watcher_.stopped_seconds()};
}
