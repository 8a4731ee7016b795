#include "core/unfinished_files.hpp"

#include <clsdf/unfinished_files.hpp>

#include <unistd.h>

namespace clsdf {

UnfinishedFiles& UnfinishedFiles::of_process() {
    static UnfinishedFiles& files = *new UnfinishedFiles;
    return files;
}

void abandon_unfinished_files() noexcept {
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    files.mutex.lock();  // for ever: nothing may be created or renamed from here on
    for (const std::string& name : files.names) ::unlink(name.c_str());
}

}  // namespace clsdf
