#include "polyhedra/morton_order.hpp"

#include "core/parallel.hpp"
#include "core/several_targets.hpp"
#include "polyhedra/lanes.hpp"
#include "polyhedra/prefetch.hpp"
#include "polyhedra/vector.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

namespace {

constexpr std::uint32_t cells = 1024;
constexpr unsigned digit_bits = 10;
constexpr std::size_t digits = 3;
constexpr std::size_t digit_values = 1u << digit_bits;

struct Keyed {
    std::uint32_t code;
    std::uint32_t triangle;
};

/// The ten bits of `x`, each followed by two zeros.
inline std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

inline std::uint32_t cell(double fraction) {
    const double positive = fraction > 0 ? fraction * cells : 0;
    return spread(static_cast<std::uint32_t>(static_cast<std::int32_t>(positive < cells - 1 ? positive : cells - 1)));
}

/// The codes of triangles, as many at a time as a processor's vectors hold.
class CentroidCodes {
public:
    using Codes = std::array<std::uint32_t, lanes>;

    explicit CentroidCodes(const Mesh& mesh) : mesh_(mesh), lower_(to_vector(mesh.box().lower)) {
        const double longest = mesh.box().longest_side();
        if (longest > 0) three_sides_ = 3 * longest;
    }

    /// Starts to bring their vertices near the processor.
    void fetch_ahead(std::size_t first) const {
        for (std::size_t i = first; i < std::min(first + lanes, mesh_.triangles().size()); ++i)
            for (const std::uint32_t vertex : mesh_.triangles()[i]) prefetch(&mesh_.vertices()[vertex]);
    }

    /// Of triangles from `first` on, where there are so many.
    Codes of(std::size_t first) const {
        LaneVectors sums{};
        for (std::size_t i = 0; i < lanes; ++i) {
            const auto& [a, b, c] = mesh_.triangles()[std::min(first + i, mesh_.triangles().size() - 1)];
            sums.set(i, (from_lower(a) + from_lower(b)) + from_lower(c));
        }
        Codes codes;
        encode(sums, three_sides_, codes);
        return codes;
    }

private:
    Vector from_lower(std::uint32_t vertex) const { return to_vector(mesh_.vertices()[vertex]) - lower_; }

    static void encode(const LaneVectors& sums, double three_sides, Codes& codes);

    const Mesh& mesh_;
    Vector lower_;
    double three_sides_ = 1;
};

CLSDF_SEVERAL_TARGETS void CentroidCodes::encode(const LaneVectors& sums, double three_sides, Codes& codes) {
    for (std::size_t i = 0; i < lanes; ++i)
        codes[i] =
            cell(sums.x[i] / three_sides) | cell(sums.y[i] / three_sides) << 1 | cell(sums.z[i] / three_sides) << 2;
}

/// One stable pass of a radix sort, in blocks: every block knows where its first triangle of each digit goes.
void sort_by_digit(std::span<const Keyed> from, std::span<Keyed> to, unsigned shift) {
    constexpr std::size_t block = 1u << 14;
    std::vector<std::array<std::uint32_t, digit_values>> next(stretch_count(from.size(), block));
    const auto digit = [shift](const Keyed& keyed) { return keyed.code >> shift & (digit_values - 1); };
    const auto for_each_block = [&](const auto& f) {
        for_each_stretch(from.size(), block, [&](std::size_t b, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) f(b, from[i]);
        });
    };
    for_each_block([&](std::size_t b, const Keyed& keyed) { ++next[b][digit(keyed)]; });
    // Some digits at a time, block by block: there are as many blocks as the mesh is large.
    std::array<std::uint32_t, digit_values> first{};
    const auto for_each_counter = [&](const auto& f) {
        for_each_stretch(digit_values, digit_values / 16, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (auto& counts : next)
                for (std::size_t value = begin; value < end; ++value) f(value, counts[value]);
        });
    };
    for_each_counter([&](std::size_t value, std::uint32_t count) { first[value] += count; });
    std::exclusive_scan(first.begin(), first.end(), first.begin(), 0U);
    for_each_counter(
        [&](std::size_t value, std::uint32_t& count) { first[value] += std::exchange(count, first[value]); });
    for_each_block([&](std::size_t b, const Keyed& keyed) { to[next[b][digit(keyed)]++] = keyed; });
}

}  // namespace

UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh, ScratchMemory* scratch) {
    const std::size_t count = mesh.triangles().size();
    const CentroidCodes centroids(mesh);
    UninitializedVector<Keyed> memory(2 * count, scratch);  // in one piece, as large as what is needed next
    std::span<Keyed> sorted = std::span(memory).first(count);
    std::span<Keyed> other = std::span(memory).subspan(count);
    for_each_range(count, [&](std::size_t begin, std::size_t end) {
        for (std::size_t first = begin; first < end; first += lanes) {
            centroids.fetch_ahead(first + 8 * lanes);
            const CentroidCodes::Codes codes = centroids.of(first);
            for (std::size_t t = first; t < std::min(end, first + lanes); ++t)
                sorted[t] = {codes[t - first], static_cast<std::uint32_t>(t)};
        }
    });
    for (std::size_t pass = 0; pass < digits; ++pass) {
        sort_by_digit(sorted, other, static_cast<unsigned>(pass) * digit_bits);
        std::swap(sorted, other);
    }
    UninitializedVector<std::uint32_t> order(count, scratch);
    for_each_index(count, [&](std::size_t i) { order[i] = sorted[i].triangle; });
    return order;
}

}  // namespace clsdf::polyhedra
