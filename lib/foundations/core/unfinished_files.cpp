#include "core/unfinished_files.hpp"

#include "core/file_locks.hpp"
#include "core/files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/utsname.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <exception>
#include <fstream>
#include <functional>
#include <string_view>
#include <system_error>

namespace clsdf {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view beginning = ".clsdf-";
constexpr std::string_view ending = ".part";

/// What the names of this machine's unfinished files begin with: ".clsdf-MACHINE-". The machines that share a folder
/// differ in it, because a machine does not see the locks of another one.
const std::string& beginning_here() {
    static const std::string& kept = *new std::string([] {
        std::string identity;
        std::ifstream("/etc/machine-id") >> identity;  // systemd's; empty if there is none
        utsname system{};
        if (::uname(&system) == 0) identity.append("@").append(system.nodename);
        return fmt::format("{}{:08x}-", beginning, std::hash<std::string>()(identity) & 0xFFFFFFFFU);
    }());
    return kept;
}

/// ".clsdf-MACHINE-PID-N.part" of this machine.
bool is_name_of_unfinished(std::string_view name) {
    if (!name.starts_with(beginning_here()) || !name.ends_with(ending)) return false;
    name.remove_prefix(beginning_here().size());
    name.remove_suffix(ending.size());
    return std::ranges::count(name, '-') == 1 && name.front() != '-' && name.back() != '-' &&
           name.find_first_not_of("0123456789-") == std::string_view::npos;
}

bool is_removed(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && status.st_nlink == 0;
}

/// Whether the path still names the open file. Only the holder of its lock removes or renames a file.
bool is_named(int descriptor, const std::string& path) {
    struct stat opened {};
    struct stat named {};
    return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

bool is_own_file(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid();
}

/// Whether this is the process's first file in the folder.
bool is_first_file_in(const fs::path& folder) {
    static std::mutex mutex;
    static std::set<std::string>& known = *new std::set<std::string>;
    std::error_code error;
    const std::string path = fs::absolute(folder, error).string();
    const std::lock_guard lock(mutex);
    return !error && known.insert(path).second;
}

}  // namespace

UnfinishedFiles& UnfinishedFiles::of_process() {
    static UnfinishedFiles& files = *new UnfinishedFiles;
    return files;
}

int create_unfinished_file(const fs::path& folder, std::string& name) {
    if (const fs::path here = folder.empty() ? "." : folder; is_first_file_in(here)) remove_stale_files(here);
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    const std::lock_guard lock(files.mutex);
    for (unsigned attempt = 0;; ++attempt) {
        // Not derived from the target's name, which may already have the greatest length.
        name = (folder / fmt::format("{}{}-{}{}", beginning_here(), ::getpid(), attempt, ending)).string();
        const int descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor < 0 && errno == EEXIST) continue;
        if (descriptor < 0) return descriptor;
        // Another process may have removed it as stale before it was locked.
        if (is_of_one_machine(descriptor) && (!try_to_lock(descriptor) || is_removed(descriptor))) {
            ::close(descriptor);
            continue;
        }
        files.names.insert(name);
        return descriptor;
    }
}

void remove_stale_files(const fs::path& folder) noexcept {
    try {
        const Descriptor opened_folder(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (opened_folder.number() < 0 || !is_of_one_machine(opened_folder.number())) return;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            if (!is_name_of_unfinished(entry.path().filename().string())) continue;
            const std::string path = entry.path().string();
            const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
            if (file.number() >= 0 && is_own_file(file.number()) && try_to_lock(file.number()) &&
                is_named(file.number(), path))
                ::unlink(path.c_str());
        }
    } catch (const std::exception&) {
        // A file that cannot be removed does no harm.
    }
}

void UnfinishedFiles::abandon() noexcept {
    // Once: libraries that share this list call it one after another.
    static std::once_flag once;
    std::call_once(once, [this] {
        mutex.lock();  // for ever: nothing may be created or renamed from here on
        for (const std::string& name : names) ::unlink(name.c_str());
    });
}

}  // namespace clsdf
