#include "io/vdb_seal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <stdexcept>

namespace clsdf {
namespace {

// OpenVDB's header: magic number (8 bytes), versions (12), a flag, the UUID as text.
constexpr std::string_view magic(" BDV\0\0\0\0", 8);
constexpr std::size_t uuid_begin = 21;
constexpr std::size_t uuid_length = 36;
constexpr std::size_t header_length = uuid_begin + uuid_length;
constexpr std::string_view uuid_of_ours = "c15df000-0000-8000-";  // then the checksum, as xxxx-xxxxxxxxxxxx
constexpr std::size_t chunk = std::size_t{1} << 16;

// A checksum over words of eight bytes, for speed. Each step is one-to-one, so no change within one word goes
// unnoticed. The rotation moves the upper bits, which do not affect lower bits of a product, to the lower end.
class Checksum {
public:
    void add(std::string_view bytes) {
        constexpr std::size_t width = sizeof(std::uint64_t);
        for (; bytes.size() >= width; bytes.remove_prefix(width)) add(word_of(bytes.data(), width));
        if (!bytes.empty()) add(word_of(bytes.data(), bytes.size()));
    }
    void add(std::uint64_t word) { sum_ = std::rotl((sum_ ^ word) * 0x9E3779B97F4A7C15U, 32); }
    std::string uuid() const {
        return fmt::format("{}{:04x}-{:012x}", uuid_of_ours, sum_ >> 48, sum_ & 0xFFFFFFFFFFFFU);
    }

private:
    /// The lowest byte comes first; bytes that are missing are zero.
    static std::uint64_t word_of(const char* bytes, std::size_t count) {
        std::uint64_t word = 0;
        for (std::size_t i = count; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[i]);
        return word;
    }

    std::uint64_t sum_ = 0;
};

// The checksum of the whole file without the UUID, and of its length, because an incomplete last word is padded with
// zeros.
std::string expected_uuid(InputFile& file) {
    Checksum checksum;
    std::string bytes = file.beginning(header_length);
    checksum.add(std::string_view(bytes).substr(0, uuid_begin));
    for (std::uint64_t begin = header_length; begin < file.size(); begin += chunk) {
        bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(chunk, file.size() - begin)));
        file.read(begin, std::as_writable_bytes(std::span(bytes)));
        checksum.add(bytes);
    }
    checksum.add(file.size());
    return checksum.uuid();
}

}  // namespace

void seal_vdb(const std::string& path) {
    InputFile written(path);
    const std::string uuid = expected_uuid(written);
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.exceptions(std::ios::failbit | std::ios::badbit);
    file.seekp(uuid_begin);
    file.write(uuid.data(), static_cast<std::streamsize>(uuid.size()));
    file.close();
}

bool check_vdb_seal(InputFile& file) {
    const std::string beginning = file.beginning(chunk);
    if (!beginning.starts_with(magic)) file.fail("not a VDB file: it does not begin with \" BDV\"");
    if (beginning.size() < header_length) file.fail("the file is truncated in its header");
    const std::string_view uuid = std::string_view(beginning).substr(uuid_begin, uuid_length);
    // If the first mark, the UUID, is damaged, the description is the second.
    const bool is_ours = uuid.starts_with(uuid_of_ours) || beginning.find(R"("program": "clsdf )") != std::string::npos;
    if (is_ours && uuid != expected_uuid(file)) file.fail("its checksum is wrong: the file is damaged or truncated");
    return is_ours;
}

}  // namespace clsdf
