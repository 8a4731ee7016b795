#pragma once

#include <clsdf/export.hpp>

#include <filesystem>
#include <mutex>
#include <set>
#include <string>

namespace clsdf {

/// The temporary names of the files that this process is writing. Whoever creates, renames or removes one holds the
/// mutex meanwhile.
///
/// A writer locks its file (flock) until the file has its final name or is removed; the system drops the lock when the
/// process ends in whatever way. So an unfinished file that can be locked has no writer any more.
///
/// The shared library shows this to the libraries beside it: there is one list in a process.
struct CLSDF_EXPORT UnfinishedFiles {
    std::mutex mutex;
    std::set<std::string> names;

    /// Never destroyed: threads may outlive main().
    static UnfinishedFiles& of_process();

    /// Removes the files, and lets no thread create, rename or remove one any more.
    void abandon() noexcept;
};

/// A new, locked file ".clsdf-PID-N.part" in the folder, listed in UnfinishedFiles: its descriptor, and `name` becomes
/// its path. Negative, with errno, where it cannot be created. It is not locked on a file system that machines share.
///
/// The process's first file in a folder also removes the stale ones there.
CLSDF_EXPORT int create_unfinished_file(const std::filesystem::path& folder, std::string& name);

/// Removes the unfinished files of this user in the folder whose writers are gone. Removes none on NFS and other file
/// systems that machines share, nor on any that is not known to belong to one machine and to keep locks.
CLSDF_EXPORT void remove_stale_files(const std::filesystem::path& folder) noexcept;

}  // namespace clsdf
