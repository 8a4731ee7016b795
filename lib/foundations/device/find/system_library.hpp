#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace clsdf::device {

/// The files of this name in the folders of the system's loader, the first one first: those of LD_LIBRARY_PATH, of the
/// loader's cache (/etc/ld.so.conf) and the usual ones. Not all of them need be of this machine's architecture.
///
/// dlopen of a bare name would also search the folders that a program or library names for itself (RPATH, RUNPATH), and
/// the working folder if LD_LIBRARY_PATH has an empty or relative entry: others may write there.
std::vector<std::filesystem::path> system_libraries(const std::string& name);

}  // namespace clsdf::device
