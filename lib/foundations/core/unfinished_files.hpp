#pragma once

#include <clsdf/export.hpp>

#include <filesystem>
#include <mutex>
#include <set>
#include <string>

namespace clsdf {

/// The temporary names of the files that this process is writing. A thread holds the mutex while it creates, renames or
/// removes one.
///
/// A writer locks its file (flock) until the file has its final name or is removed. The system releases the lock when
/// the process ends for any reason. So an unfinished file that can be locked has no writer any more.
///
/// Every library of clsdf uses the core's list: abandon() must find the files of all of them. So a shared core exports
/// this header's functions, and the internals that other libraries link lack them (cmake/Libraries.cmake).
struct UnfinishedFiles {
    std::mutex mutex;
    std::set<std::string> names;

    /// Never destroyed: threads may outlive main().
    CLSDF_EXPORT static UnfinishedFiles& of_process();

    /// Removes the files, and lets no thread create, rename or remove one any more.
    CLSDF_EXPORT void abandon() noexcept;
};

/// Creates and locks a file ".clsdf-MACHINE-PID-N.part" in the folder, and lists it in UnfinishedFiles. Returns its
/// descriptor and sets `name` to its path; returns a negative number, with errno, if it cannot be created. The file is
/// not locked on a file system that machines share.
///
/// The process's first file in a folder also removes the stale ones there.
CLSDF_EXPORT int create_unfinished_file(const std::filesystem::path& folder, std::string& name);

/// Removes the unfinished files in the folder that this machine and user began and whose writers have ended. Removes
/// none on NFS, or on any other file system that is not known to belong to one machine and to support locks.
CLSDF_EXPORT void remove_stale_files(const std::filesystem::path& folder) noexcept;

}  // namespace clsdf
