#pragma once

#include <mutex>
#include <set>
#include <string>

namespace clsdf {

/// The temporary names of the files that this process is writing. Whoever creates, renames or removes one holds the
/// mutex meanwhile.
struct UnfinishedFiles {
    std::mutex mutex;
    std::set<std::string> names;

    /// Never destroyed: threads may outlive main().
    static UnfinishedFiles& of_process();
};

}  // namespace clsdf
