#include "output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <system_error>

using clsdf::Band;
using clsdf::Grid;
using nlohmann::ordered_json;

namespace {

std::string human_half_width(double width, double voxel) {
    return std::isinf(width) ? "everything" : fmt::format("{:.6g} ({:.4g} voxels)", width, width / voxel);
}

}  // namespace

void print_result(const std::string& text) {
    errno = 0;
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written)
        throw clsdf::Error(
            clsdf::ErrorCode::output_failure,
            fmt::format("standard output: the result cannot be written: {}", std::generic_category().message(errno)));
}

void print_result(const ordered_json& result) {
    // Names of files need not be UTF-8.
    print_result(result.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n');
}

ordered_json describe(const Grid& grid) {
    return {{"origin", grid.position(0, 0, 0)}, {"spacing", grid.spacing}, {"size", grid.size}};
}

ordered_json describe(const Band& band) {
    // JSON has no infinity: it becomes null.
    return {{"inside", band.inside}, {"outside", band.outside}};
}

std::string human_bytes(double bytes) {
    for (const char* unit : {"bytes", "kB", "MB", "GB"}) {
        if (bytes < 1000) return fmt::format("{:.3g} {}", bytes, unit);
        bytes /= 1000;
    }
    return fmt::format("{:.4g} TB", bytes);
}

std::string human_count(double count) {
    if (count < 1e6) return fmt::format("{:.0f}", count);
    return count < 1e9 ? fmt::format("{:.1f} million", count / 1e6) : fmt::format("{:.2f} billion", count / 1e9);
}

std::string human(const Grid& grid) {
    const auto& [hx, hy, hz] = grid.spacing;
    const std::string spacing =
        hx == hy && hy == hz ? fmt::format("{:.6g}", hx) : fmt::format("({:.6g}, {:.6g}, {:.6g})", hx, hy, hz);
    const clsdf::Vec3 origin = grid.position(0, 0, 0);
    return fmt::format("{} x {} x {} samples, {} apart, from ({:.6g}, {:.6g}, {:.6g})", grid.size[0], grid.size[1],
                       grid.size[2], spacing, origin[0], origin[1], origin[2]);
}

std::string human(const Band& band, double voxel) {
    if (band.inside == band.outside)
        return std::isinf(band.outside) ? "none: every sample has its distance"
                                        : human_half_width(band.outside, voxel) + " on both sides";
    return fmt::format("{} inside, {} outside", human_half_width(band.inside, voxel),
                       human_half_width(band.outside, voxel));
}
