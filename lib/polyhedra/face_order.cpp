#include "polyhedra/face_order.hpp"

#include "core/parallel.hpp"
#include "polyhedra/frames.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// Prefetches memory, if the compiler has a built-in for it.
inline void prefetch([[maybe_unused]] const void* memory) {
#ifdef __GNUC__
    __builtin_prefetch(memory);
#endif
}

}  // namespace

namespace {

/// Bits of a coordinate: a code has 30.
constexpr unsigned most_bits = 10;

/// A vector of numbers, as wide as the processor's vectors.
constexpr std::size_t lanes = 8;

struct LaneVectors {
    std::array<double, lanes> x, y, z;
};

struct Keyed {
    std::uint32_t code;
    std::uint32_t triangle;
};

inline std::uint32_t cell(double place, double last) {
    const double positive = place > 0 ? place : 0;
    return spread_bits(static_cast<std::uint32_t>(static_cast<std::int32_t>(positive < last ? positive : last)));
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
            const Vector sum = (at(a) + at(b)) + at(c);
            sums.x[i] = sum.x();
            sums.y[i] = sum.y();
            sums.z[i] = sum.z();
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

/// Sorts triangles by codes of three digits; equal codes keep their order. The first digit is sorted in parallel
/// blocks, each of which knows where its triangles of each digit go. Then each core sorts triangles of one first digit
/// by the other digits. (If every digit were sorted in blocks, cores would write to the same cache lines.) If all
/// triangles have one first digit, one core sorts.
class CodeSort {
public:
    CodeSort(std::size_t count, unsigned digit_bits)
        : count_(count),
          digit_bits_(digit_bits),
          digit_values_(std::size_t{1} << digit_bits),
          block_(chunk_for_all_cores(count, std::size_t{1} << 13)),
          places_(chunk_count(count, block_)) {}

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
        for_each_chunk(digit_values_, digit_values_ / 64, [&](std::size_t, std::size_t begin, std::size_t end) {
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
        for_each_chunk(count_, block_,
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

std::size_t checked_face_count(std::size_t count) {
    if (count > most_faces)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("{} triangles are more than the {} that can be prepared; split the mesh", count, most_faces));
    return count;
}

namespace {

/// Numbers vertices as faces first name them, by parts of the faces. Each part lists the vertices that it names and no
/// earlier part has named so far; for the time being the vertex at place i of the list has the number
/// 3 * (first face) + i, so that earlier parts give lower ones. Parts run side by side, so several may list the same
/// vertex; it belongs to the first of them, however far the others were.
class Numbering {
public:
    Numbering(const Mesh& mesh, std::span<const std::uint32_t> order, OrderedFaces& faces)
        : mesh_(mesh), order_(order), faces_(faces), numbers_(mesh.vertices().size()) {
        const std::size_t size = chunk_for_all_cores(order.size(), OrderedFaces::chunk);
        for (std::size_t begin = 0; begin < order.size(); begin += size)
            parts_.push_back({begin, std::min(order.size(), begin + size)});
    }

    void run() {
        for_each_index(numbers_.size(), [&](std::size_t vertex) { numbers_[vertex] = none; });
        faces_.triangles = UninitializedVector<Triangle>(order_.size());
        faces_.first_vertices.resize(chunk_count(order_.size(), OrderedFaces::chunk) + 1);
        // With room for what is stored and not counted.
        faces_.vertices = UninitializedVector<std::uint32_t>(numbers_.size() + 1);
        std::uint32_t count = 0;
        if (parts_.size() == 1) {
            list(parts_[0], faces_.vertices);
            count = parts_[0].list_end;
        } else if (parts_.size() > 1) {
            UninitializedVector<std::uint32_t> listed(3 * order_.size());
            for_each_part([&](Part& part) { list(part, listed); });
            find_shared(listed);
            for (Part& part : parts_) part.first = std::exchange(count, count + part.own_before(part.list_end));
            renumber(listed);
        }
        faces_.first_vertices.back() = count;
        faces_.vertices.resize(count);
    }

private:
    static constexpr std::uint32_t none = UINT32_MAX;

    /// An entry of a list, and the first one of the same vertex.
    struct Shared {
        std::uint32_t number;
        std::uint32_t first;
    };

    struct Part {
        std::size_t begin;
        std::size_t end;
        std::uint32_t list_end = 0;
        std::vector<Shared> shared{};  ///< entries that are not the first of their vertex
        std::uint32_t first = 0;       ///< of its own vertices

        std::uint32_t list_begin() const { return static_cast<std::uint32_t>(3 * begin); }

        /// Own vertices on the list before a number.
        std::uint32_t own_before(std::uint32_t number) const {
            const auto place = std::lower_bound(shared.begin(), shared.end(), number,
                                                [](const Shared& entry, std::uint32_t n) { return entry.number < n; });
            return number - list_begin() - static_cast<std::uint32_t>(place - shared.begin());
        }
    };

    template <typename Function>
    void for_each_part(const Function& f) {
        for_each_chunk(parts_.size(), 1, [&](std::size_t part, std::size_t, std::size_t) { f(parts_[part]); });
    }

    void list(Part& part, std::span<std::uint32_t> listed) {
        // A batch at a time: other cores have written to the lines of the vertices' numbers, or these are far.
        constexpr std::size_t batch = 256;
        static_assert(OrderedFaces::chunk % batch == 0);
        std::uint32_t next = part.list_begin();
        for (std::size_t begin = part.begin; begin < part.end; begin += batch) {
            const std::size_t end = std::min(part.end, begin + batch);
            for (std::size_t face = begin; face < end; ++face) {
                const Triangle& triangle = mesh_.triangles()[order_[face]];
                for (const std::uint32_t vertex : triangle) prefetch(&numbers_[vertex]);
                faces_.triangles[face] = triangle;
            }
            if (begin % OrderedFaces::chunk == 0) faces_.first_vertices[begin / OrderedFaces::chunk] = next;
            for (std::size_t face = begin; face < end; ++face)
                for (std::uint32_t& vertex : faces_.triangles[face]) {
                    const std::atomic_ref number(numbers_[vertex]);
                    const std::uint32_t known = number.load(std::memory_order_relaxed);
                    const bool is_new = known >= next;  // not a branch: that could not be predicted
                    listed[next] = vertex;
                    vertex = is_new ? next : known;
                    number.store(vertex, std::memory_order_relaxed);
                    next += is_new ? 1U : 0U;
                }
        }
        part.list_end = next;
    }

    void find_shared(std::span<const std::uint32_t> listed) {
        // If parts met a vertex at the same time, any of their numbers may have been stored last.
        for_each_part([&](const Part& part) {
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                const std::atomic_ref first(numbers_[listed[number]]);
                std::uint32_t known = first.load(std::memory_order_relaxed);
                while (known > number && !first.compare_exchange_weak(known, number, std::memory_order_relaxed)) {
                }
            }
        });
        for_each_part([&](Part& part) {
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                const std::uint32_t first = numbers_[listed[number]];
                if (first != number) part.shared.push_back({number, first});
            }
        });
    }

    /// Puts the final numbers into the lists, and from there into the triangles.
    void renumber(std::span<std::uint32_t> listed) {
        for_each_part([&](const Part& part) {
            std::uint32_t next = part.first;
            auto shared = part.shared.begin();
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                if (shared != part.shared.end() && shared->number == number) {
                    ++shared;
                } else {
                    faces_.vertices[next] = listed[number];
                    listed[number] = next++;
                }
            }
            for (std::size_t face = part.begin; face < part.end; face += OrderedFaces::chunk) {
                std::uint32_t& first = faces_.first_vertices[face / OrderedFaces::chunk];
                first = part.first + part.own_before(first);
            }
        });
        for_each_part([&](const Part& part) {
            for (const Shared& entry : part.shared) listed[entry.number] = listed[entry.first];
        });
        for_each_index(order_.size(), [&](std::size_t face) {
            for (std::uint32_t& vertex : faces_.triangles[face]) vertex = listed[vertex];
        });
    }

    const Mesh& mesh_;
    std::span<const std::uint32_t> order_;
    OrderedFaces& faces_;
    std::vector<Part> parts_;
    UninitializedVector<std::uint32_t> numbers_;  // of the mesh's vertices
};

}  // namespace

OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order) {
    checked_face_count(order.size());
    OrderedFaces faces;
    Numbering(mesh, order, faces).run();
    return faces;
}

}  // namespace clsdf::polyhedra
