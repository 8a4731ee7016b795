#include "polyhedra/morton_order.hpp"

#include "core/parallel.hpp"
#include "core/several_targets.hpp"
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

/// Bits of a coordinate: a code has 30.
constexpr unsigned most_bits = 10;

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

inline std::uint32_t cell(double place, double last) {
    const double positive = place > 0 ? place : 0;
    return spread(static_cast<std::uint32_t>(static_cast<std::int32_t>(positive < last ? positive : last)));
}

/// The codes of triangles, as many at a time as a processor's vectors hold.
class CentroidCodes {
public:
    using Codes = std::array<std::uint32_t, lanes>;

    /// bits: of each coordinate, at most most_bits.
    CentroidCodes(const Mesh& mesh, unsigned bits)
        : mesh_(mesh), to_cells_{3 * to_vector(mesh.box().lower), 0, static_cast<double>(1u << bits)} {
        const double longest = mesh.box().longest_side();
        if (longest > 0) to_cells_.scale = to_cells_.count / (3 * longest);
    }

    /// Starts to bring their vertices near the processor.
    void fetch_ahead(std::size_t first) const {
        for (std::size_t i = first; i < std::min(first + lanes, mesh_.triangles().size()); ++i)
            for (const std::uint32_t vertex : mesh_.triangles()[i]) prefetch(&mesh_.vertices()[vertex]);
    }

    /// The codes of the triangles from `first` on; the last one fills the rest.
    Codes of(std::size_t first) const {
        LaneVectors sums{};
        for (std::size_t i = 0; i < lanes; ++i) {
            const auto& [a, b, c] = mesh_.triangles()[std::min(first + i, mesh_.triangles().size() - 1)];
            sums.set(i, (at(a) + at(b)) + at(c));
        }
        Codes codes;
        encode(sums, to_cells_, codes);
        return codes;
    }

private:
    /// From the sum of a triangle's vertices.
    struct ToCells {
        Vector lower;  ///< the box's corner, three times
        double scale;
        double count;  ///< along the box's longest side
    };

    Vector at(std::uint32_t vertex) const { return to_vector(mesh_.vertices()[vertex]); }

    static void encode(const LaneVectors& sums, const ToCells& to_cells, Codes& codes);

    const Mesh& mesh_;
    ToCells to_cells_;
};

CLSDF_SEVERAL_TARGETS void CentroidCodes::encode(const LaneVectors& sums, const ToCells& to_cells, Codes& codes) {
    const auto& [lower, scale, count] = to_cells;
    for (std::size_t i = 0; i < lanes; ++i)
        codes[i] = cell((sums.x[i] - lower.x()) * scale, count - 1) |
                   cell((sums.y[i] - lower.y()) * scale, count - 1) << 1 |
                   cell((sums.z[i] - lower.z()) * scale, count - 1) << 2;
}

/// Sorts triangles by codes of three digits, equal ones as they come: by the first digit in blocks, each of which knows
/// where its triangles of each digit go, then what has one first digit by the others. (Measured on two cores: pass by
/// pass in blocks, from the last digit on, a mesh of 32,768 triangles takes half as long again: of a block few have one
/// digit, and cores write to the same lines of memory. What all have one first digit, as beside a vertex far away, one
/// core sorts.)
class CodeSort {
public:
    CodeSort(std::size_t count, unsigned digit_bits)
        : count_(count),
          digit_bits_(digit_bits),
          digit_values_(std::size_t{1} << digit_bits),
          block_(stretch_for_all_cores(count, std::size_t{1} << 13)),
          places_(stretch_count(count, block_)) {}

    /// fill(begin, end) sets keyed[begin, end). Writes the triangles in the order of their codes; `other` has as much
    /// room as `keyed`.
    template <typename Fill>
    void run(const Fill& fill, std::span<Keyed> keyed, std::span<Keyed> other, std::span<std::uint32_t> order) {
        for_each_block([&](Places& places, std::size_t begin, std::size_t end) {
            fill(begin, end);
            count_digits(keyed.subspan(begin, end - begin), 2, places);
        });
        std::vector<std::uint32_t> first(digit_values_ + 1);
        std::uint32_t place = 0;
        for (std::size_t value = 0; value < digit_values_; ++value) {
            first[value] = place;
            for (Places& places : places_) place += std::exchange(places[value], place);
        }
        first.back() = place;
        for_each_block([&](Places& places, std::size_t begin, std::size_t end) {
            for (const Keyed& one : keyed.subspan(begin, end - begin)) other[places[digit(one, 2)]++] = one;
        });
        for_each_stretch(digit_values_, digit_values_ / 64, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t value = begin; value < end; ++value) {
                const std::uint32_t some = first[value + 1] - first[value];
                if (some > 0)
                    sort_by_last_digits(other.subspan(first[value], some), keyed.subspan(first[value], some),
                                        order.subspan(first[value], some));
            }
        });
    }

private:
    using Places = std::array<std::uint32_t, std::size_t{1} << most_bits>;  ///< by a digit's value

    std::size_t digit(const Keyed& keyed, unsigned number) const {
        return keyed.code >> number * digit_bits_ & (digit_values_ - 1);
    }

    template <typename Function>
    void for_each_block(const Function& f) {
        for_each_stretch(count_, block_,
                         [&](std::size_t block, std::size_t begin, std::size_t end) { f(places_[block], begin, end); });
    }

    void count_digits(std::span<const Keyed> keyed, unsigned number, Places& counts) const {
        std::fill_n(counts.begin(), digit_values_, 0U);
        for (const Keyed& one : keyed) ++counts[digit(one, number)];
    }

    void sort_by_last_digits(std::span<const Keyed> keyed, std::span<Keyed> other,
                             std::span<std::uint32_t> order) const {
        Places places;
        const auto to_places = [&] {
            std::exclusive_scan(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(digit_values_),
                                places.begin(), 0U);
        };
        count_digits(keyed, 0, places);
        to_places();
        for (const Keyed& one : keyed) other[places[digit(one, 0)]++] = one;
        count_digits(other, 1, places);
        to_places();
        for (const Keyed& one : other) order[places[digit(one, 1)]++] = one.triangle;
    }

    std::size_t count_;
    unsigned digit_bits_;
    std::size_t digit_values_;
    std::size_t block_;
    std::vector<Places> places_;  ///< of each block
};

}  // namespace

UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh) {
    const std::size_t count = mesh.triangles().size();
    // Bits of a coordinate and of a digit. Fewer bits suffice for few triangles, and are sorted faster.
    const unsigned bits = count <= std::size_t{1} << 17 ? 8 : most_bits;
    const CentroidCodes centroids(mesh, bits);
    UninitializedVector<Keyed> memory(2 * count);  // in one piece, as large as what is needed next
    const std::span<Keyed> keyed = std::span(memory).first(count);
    UninitializedVector<std::uint32_t> order(count);
    const auto encode = [&](std::size_t begin, std::size_t end) {
        for (std::size_t first = begin; first < end; first += lanes) {
            centroids.fetch_ahead(first + 8 * lanes);
            const CentroidCodes::Codes codes = centroids.of(first);
            for (std::size_t t = first; t < std::min(end, first + lanes); ++t)
                keyed[t] = {codes[t - first], static_cast<std::uint32_t>(t)};
        }
    };
    CodeSort(count, bits).run(encode, keyed, std::span(memory).subspan(count), order);
    return order;
}

}  // namespace clsdf::polyhedra
