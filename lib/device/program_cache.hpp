#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::device {

/// Compiled programs in a folder, a file each. Nothing here fails: what cannot be read, or is not whole, is not there,
/// and what cannot be written is not kept. Any number of threads and processes may use one folder.
class ProgramCache {
public:
    using Binary = std::vector<unsigned char>;

    static constexpr std::uintmax_t default_limit = std::uintmax_t{64} << 20;

    /// An empty folder keeps nothing. The folder is made when the first program is stored.
    explicit ProgramCache(std::filesystem::path folder, std::uintmax_t limit = default_limit)
        : folder_(std::move(folder)), limit_(limit) {}

    const std::filesystem::path& folder() const { return folder_; }

    /// The program stored under the very same key, if it is whole and belongs to this user or to root.
    std::optional<Binary> find(const std::string& key) const noexcept;

    /// Replaces what was stored under the key, and deletes the programs that were not used for longest while all of
    /// them take more than the limit.
    void store(const std::string& key, std::span<const unsigned char> binary) const noexcept;

    /// The path of a key's program.
    std::filesystem::path path_of(const std::string& key) const;

private:
    void prune(const std::filesystem::path& newest) const;

    std::filesystem::path folder_;
    std::uintmax_t limit_;
};

/// The environment variable CLSDF_CACHE_DIR if it is set; a relative path counts from the current folder. Otherwise it
/// is empty if the driver keeps its programs itself, else $XDG_CACHE_HOME/clsdf, else $HOME/.cache/clsdf. It is also
/// empty if neither of these is an absolute path.
std::filesystem::path default_cache_folder(bool driver_keeps_programs);

}  // namespace clsdf::device
