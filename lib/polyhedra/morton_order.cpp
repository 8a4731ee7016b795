#include "polyhedra/morton_order.hpp"

#include "polyhedra/parallel.hpp"
#include "polyhedra/vector.hpp"

#include <algorithm>
#include <array>
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
std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

class CentroidCode {
public:
    explicit CentroidCode(const Mesh& mesh) : mesh_(mesh), lower_(to_vector(mesh.box().lower)) {
        const double longest = mesh.box().longest_side();
        if (longest > 0) three_sides_ = 3 * longest;
    }

    std::uint32_t operator()(const Triangle& triangle) const {
        Vector sum = Vector::Zero();
        for (const std::uint32_t vertex : triangle) sum += to_vector(mesh_.vertices()[vertex]) - lower_;
        const Vector fraction = sum / three_sides_;
        return cell(fraction.x()) | cell(fraction.y()) << 1 | cell(fraction.z()) << 2;
    }

private:
    static std::uint32_t cell(double fraction) {
        if (!(fraction > 0)) return 0;
        return spread(static_cast<std::uint32_t>(std::min(fraction * cells, cells - 1.0)));
    }

    const Mesh& mesh_;
    Vector lower_;
    double three_sides_ = 1;
};

/// One stable pass of a radix sort, in blocks: every block knows where its first triangle of each digit goes.
void sort_by_digit(std::span<const Keyed> from, std::span<Keyed> to, unsigned shift) {
    constexpr std::size_t block = 1u << 15;
    const std::size_t blocks = (from.size() + block - 1) / block;
    std::vector<std::array<std::uint32_t, digit_values>> next(blocks);
    const auto digit = [shift](const Keyed& keyed) { return keyed.code >> shift & (digit_values - 1); };
    const auto for_each_block = [&](const auto& f) {
        tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
            for (std::size_t i = b * block; i < std::min(from.size(), (b + 1) * block); ++i) f(b, from[i]);
        });
    };
    for_each_block([&](std::size_t b, const Keyed& keyed) { ++next[b][digit(keyed)]; });
    std::uint32_t total = 0;
    for (std::size_t value = 0; value < digit_values; ++value)
        for (auto& counts : next) total += std::exchange(counts[value], total);
    for_each_block([&](std::size_t b, const Keyed& keyed) { to[next[b][digit(keyed)]++] = keyed; });
}

}  // namespace

UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh, ScratchMemory* scratch) {
    const std::size_t count = mesh.triangles().size();
    const CentroidCode code(mesh);
    UninitializedVector<Keyed> memory(2 * count, scratch);  // in one piece, as large as what is needed next
    std::span<Keyed> sorted = std::span(memory).first(count);
    std::span<Keyed> other = std::span(memory).subspan(count);
    for_each_index(count, [&](std::size_t t) {
        sorted[t] = {code(mesh.triangles()[t]), static_cast<std::uint32_t>(t)};
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
