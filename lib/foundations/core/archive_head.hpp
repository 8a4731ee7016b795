#pragma once

#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace clsdf {

/// What precedes archived values, and says whether a program can read them.
struct ArchiveHead {
    std::array<char, 8> name{};
    std::uint32_t byte_order = 0x01020304;
    std::uint32_t layout = 0;  ///< of what follows; another number for each change of it
    std::uint64_t version = CLSDF_VERSION;
    std::uint64_t size = 0;  ///< of what follows
    std::uint64_t hash = 0;  ///< of what follows
};

/// Why a program whose own head is `own` cannot read what follows a head; nothing if it can.
inline std::optional<std::string> obstacle_to_reading(const ArchiveHead& head, const ArchiveHead& own) {
    if (head.name != own.name) return "the head has another name";
    if (head.byte_order != own.byte_order) return "a machine of another byte order was the writer";
    if (head.layout != own.layout || head.version != own.version)
        return fmt::format("clsdf of the version number {} (layout {}) was the writer, and this is {} (layout {})",
                           head.version, head.layout, own.version, own.layout);
    return std::nullopt;
}

}  // namespace clsdf
