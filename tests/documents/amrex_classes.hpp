#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

/// A stand-in for the classes of AMReX that the code of docs/amrex.md uses.
// NOLINTBEGIN(readability-identifier-naming,google-explicit-constructor): AMReX's own names
namespace amrex {

using Real = double;
using IntVect = std::array<int, 3>;

struct Geometry {
    std::array<Real, 3> lower{};
    Real size = 0;
    Real ProbLo(int axis) const { return lower.at(static_cast<std::size_t>(axis)); }
    Real CellSize(int) const { return size; }
};

struct Box {
    IntVect lower{}, upper{};  // included
    IntVect smallEnd() const { return lower; }
    IntVect length() const { return {upper[0] - lower[0] + 1, upper[1] - lower[1] + 1, upper[2] - lower[2] + 1}; }
    std::size_t numPts() const {
        const IntVect n = length();
        return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
    }
};

inline Box surroundingNodes(Box cells) {
    for (int& n : cells.upper) ++n;
    return cells;
}
inline Box surroundingNodes(Box cells, int direction) {
    ++cells.upper.at(static_cast<std::size_t>(direction));
    return cells;
}

struct FArrayBox {
    FArrayBox() = default;
    FArrayBox(const Box& box, int components)
        : FArrayBox(box, std::vector<Real>(static_cast<std::size_t>(components) * box.numPts())) {}
    FArrayBox(const Box& box, std::vector<Real> values_in) : bounds(box), values(std::move(values_in)) {}
    /// Of the caller's memory, which may be a device's.
    FArrayBox(const Box& box, Real* memory_in) : bounds(box), memory(memory_in) {}
    Box bounds;
    std::vector<Real> values;
    Real* memory = nullptr;
    Box box() const { return bounds; }
    Real* dataPtr(int component) {
        return (memory != nullptr ? memory : values.data()) + static_cast<std::size_t>(component) * bounds.numPts();
    }
};

using MultiFab = std::vector<FArrayBox>;

template <class Item, std::size_t N>
using Array = std::array<Item, N>;

struct Dim3 {
    int x = 0, y = 0, z = 0;
};

template <class Item>
struct Array4 {
    Item* p = nullptr;
    Dim3 begin, end;  // beyond the last
    Item& operator()(int i, int j, int k) const {
        const auto at = [](int n, int first) { return static_cast<std::size_t>(n - first); };
        const std::size_t nx = at(end.x, begin.x), ny = at(end.y, begin.y);
        return p[(at(k, begin.z) * ny + at(j, begin.y)) * nx + at(i, begin.x)];
    }
    operator Array4<const Item>() const { return {p, begin, end}; }
};

template <class Item>
struct BaseFab {
    explicit BaseFab(const Box& box) : bounds(box), values(box.numPts()) {}
    Box bounds;
    std::vector<Item> values;
    const Box& box() const { return bounds; }
    Item* dataPtr() { return values.data(); }
    Array4<Item> array() {
        const auto [x, y, z] = bounds.upper;
        return {values.data(), {bounds.lower[0], bounds.lower[1], bounds.lower[2]}, {x + 1, y + 1, z + 1}};
    }
};

enum class RunOn { Cpu };

namespace EB2 {
using Type_t = int;
namespace Type {
constexpr Type_t regular = 0, covered = 1, irregular = 2;
}
}  // namespace EB2

struct MFIter {
    explicit MFIter(const MultiFab& fabs) : count(fabs.size()) {}
    bool isValid() const { return at < count; }
    MFIter& operator++() {
        ++at;
        return *this;
    }
    operator std::size_t() const { return at; }
    std::size_t at = 0, count;
};

}  // namespace amrex
// NOLINTEND(readability-identifier-naming,google-explicit-constructor)
