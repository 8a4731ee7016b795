#include "core/file_locks.hpp"

#include <sys/file.h>
#include <sys/vfs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>

namespace clsdf {

namespace {

/// Magic numbers of statfs(2), in the order of the header.
constexpr std::array<std::uint32_t, 8> file_systems_of_one_machine{0xEF53,     0x58465342, 0x9123683E, 0xF2F52010,
                                                                   0x2FC12FC1, 0xCA451A4E, 0x01021994, 0x794C7630};

}  // namespace

bool is_of_one_machine(int descriptor) {
    struct statfs status {};
    return ::fstatfs(descriptor, &status) == 0 &&
           std::ranges::count(file_systems_of_one_machine, static_cast<std::uint32_t>(status.f_type)) > 0;
}

bool try_to_lock(int descriptor) {
    while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
        if (errno != EINTR) return false;
    return true;
}

}  // namespace clsdf
