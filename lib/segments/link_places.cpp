#include "segments/link_places.hpp"

#include "core/parallel.hpp"

#include <cstring>

namespace clsdf::segments {

namespace {

/// Numbers of several segments, by an extension of compilers that becomes the widest vectors that there are.
using Lanes [[gnu::vector_size(LinkPlaces::most * sizeof(double))]] = double;

#define CLSDF_INLINED [[gnu::always_inline]] inline

// The operations of kernels/common/expansions.h and segment_crossings.h, one by one.
struct TwoLanes {
    Lanes high, low;
};
struct Vectors {
    std::array<TwoLanes, 3> of;
};

CLSDF_INLINED void load(const LinkPlaces::Numbers& numbers, Lanes& lanes) {
    std::memcpy(&lanes, &numbers, sizeof lanes);
}
CLSDF_INLINED void set_size(const Lanes& x, Lanes& size) {
    size = x < 0 ? -x : x;
}
CLSDF_INLINED void set_sum(const Lanes& a, const Lanes& b, TwoLanes& sum) {
    const Lanes high = a + b, of_b = high - a, of_a = high - of_b;
    sum.low = (a - of_a) + (b - of_b);
    sum.high = high;
}
CLSDF_INLINED void set_product(const Lanes& a, const Lanes& b, TwoLanes& product) {
    const double splitter = 134217729.0;
    const Lanes large_a = splitter * a, high_a = large_a - (large_a - a), low_a = a - high_a;
    const Lanes large_b = splitter * b, high_b = large_b - (large_b - b), low_b = b - high_b;
    product.high = a * b;
    const Lanes rest = ((product.high - high_a * high_b) - low_a * high_b) - high_a * low_b;
    product.low = low_a * low_b - rest;
}
CLSDF_INLINED void set_sum(const TwoLanes& a, const TwoLanes& b, TwoLanes& sum) {
    TwoLanes high, low, middle;
    set_sum(a.high, b.high, high);
    set_sum(a.low, b.low, low);
    set_sum(high.high, high.low + low.high, middle);
    set_sum(middle.high, middle.low + low.low, sum);
}
CLSDF_INLINED void set_product(const TwoLanes& a, const TwoLanes& b, TwoLanes& result) {
    TwoLanes product;
    set_product(a.high, b.high, product);
    set_sum(product.high, product.low + (a.high * b.low + a.low * b.high), result);
}
CLSDF_INLINED void set_difference(const std::array<LinkPlaces::Numbers, 3>& a,
                                  const std::array<LinkPlaces::Numbers, 3>& b, Vectors& difference) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Lanes of_a, of_b;
        load(a[axis], of_a);
        load(b[axis], of_b);
        set_sum(of_a, -of_b, difference.of[axis]);
    }
}
/// a.i b.j - a.j b.i, and the size of its terms.
CLSDF_INLINED void set_cross(const Vectors& a, const Vectors& b, std::size_t i, std::size_t j, TwoLanes& cross,
                             Lanes& size) {
    TwoLanes first, second;
    set_product(a.of[i], b.of[j], first);
    set_product(a.of[j], b.of[i], second);
    second.high = -second.high;
    second.low = -second.low;
    set_sum(first, second, cross);
    Lanes of_first, of_second;
    set_size(a.of[i].high * b.of[j].high, of_first);
    set_size(a.of[j].high * b.of[i].high, of_second);
    size = of_first + of_second;
}
struct Normal {
    std::array<TwoLanes, 3> of;
    std::array<Lanes, 3> sizes;
};
/// is_certain: 1, or 0 where exact arithmetic is needed.
CLSDF_INLINED void set_determinant(const Normal& normal, const Vectors& w, TwoLanes& determinant, Lanes& is_certain) {
    std::array<TwoLanes, 3> terms;
    Lanes size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        set_product(normal.of[axis], w.of[axis], terms[axis]);
        Lanes of_w;
        set_size(w.of[axis].high, of_w);
        size += normal.sizes[axis] * of_w;
    }
    TwoLanes sum;
    set_sum(terms[0], terms[1], sum);
    set_sum(sum, terms[2], determinant);
    Lanes of_all;
    set_size(determinant.high, of_all);
    is_certain = of_all >= 0x1p-40 * size ? Lanes{} + 1.0 : Lanes{};
}

/// Sets the places of the segments, and which of them are certain.
CLSDF_SEVERAL_TARGETS void compute_by_vectors(const std::array<std::array<LinkPlaces::Numbers, 3>, 3>& corners,
                                              const std::array<std::array<LinkPlaces::Numbers, 3>, 2>& ends,
                                              LinkPlaces::Numbers& places, LinkPlaces::Numbers& are_certain) {
    Vectors ab, ac, from_begin, along;
    set_difference(corners[1], corners[0], ab);
    set_difference(corners[2], corners[0], ac);
    set_difference(corners[0], ends[0], from_begin);
    set_difference(ends[1], ends[0], along);
    Normal normal;
    for (std::size_t axis = 0; axis < 3; ++axis)
        set_cross(ab, ac, (axis + 1) % 3, (axis + 2) % 3, normal.of[axis], normal.sizes[axis]);
    TwoLanes n, d, product, rest;
    Lanes of_n, of_d;
    set_determinant(normal, from_begin, n, of_n);
    set_determinant(normal, along, d, of_d);
    const Lanes first = n.high / d.high;
    set_product(d, TwoLanes{first, Lanes{}}, product);
    product.high = -product.high;
    product.low = -product.low;
    set_sum(n, product, rest);
    const Lanes place = first + (rest.high + rest.low) / d.high;
    const Lanes is_certain = n.high == 0 ? Lanes{} : of_n * of_d;
    std::memcpy(places.of.data(), &place, sizeof place);
    std::memcpy(are_certain.of.data(), &is_certain, sizeof is_certain);
}

}  // namespace

void LinkPlaces::compute() {
    Numbers are_certain{};
    compute_by_vectors(corners, ends, places, are_certain);
    for (std::size_t n = 0; n < most; ++n) {
        if (are_certain.of[n] != 0) continue;
        const auto point = [n](const std::array<Numbers, 3>& p) { return Vec3{p[0].of[n], p[1].of[n], p[2].of[n]}; };
        const crossing::Corners face{point(corners[0]), point(corners[1]), point(corners[2])};
        const Vec3 from = point(ends[0]), to = point(ends[1]);
        places.of[n] = from == to ? 0 : crossing::place_of(face, crossing::segment(from, to));
    }
}

}  // namespace clsdf::segments
