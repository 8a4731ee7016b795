#pragma once

#include <clsdf/sparse.hpp>

#include "targets/host_arrays.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>

namespace clsdf::targets {

/// A destination for the layers of a sparse field, one part after the other.
class SparseTarget {
public:
    SparseTarget() = default;
    SparseTarget(const SparseTarget&) = delete;
    SparseTarget& operator=(const SparseTarget&) = delete;
    virtual ~SparseTarget() = default;

    /// How many more bricks there is room for. If the next layers have more, they are only counted.
    virtual std::size_t most() const { return std::numeric_limits<std::size_t>::max(); }
    /// Memory for the values of the next bricks, which are at most most().
    virtual HostArrays room(std::size_t bricks) = 0;
    /// The values are there. slab: without values.
    virtual void take(const SparseSlab& slab) = 0;
    /// The next layers have more bricks than most(). slab: without values and bricks.
    virtual void count(std::size_t /*bricks*/, const SparseSlab& /*slab*/) {}
};

/// Hands the layers to a sink.
class SinkTarget final : public SparseTarget {
public:
    SinkTarget(const HostArrays& wanted, const SparseSink& sink) : wanted_(wanted), sink_(sink) {}

    HostArrays room(std::size_t bricks) override {
        // An eighth more serves later slabs, too: memory that was written before costs the system nothing.
        if (bricks > room_) room_ = bricks + bricks / 8;
        return arrays_ = own_.for_samples(wanted_, room_ * brick_samples);
    }
    void take(const SparseSlab& slab) override {
        SparseSlab whole = slab;
        whole.values = slab_of(arrays_, slab.bricks.size() * brick_samples);
        sink_(whole);
    }

private:
    const HostArrays& wanted_;
    const SparseSink& sink_;
    OwnArrays own_;
    HostArrays arrays_;
    std::size_t room_ = 0;  ///< bricks that there is memory for
};

/// Adds the layers to a field.
class FieldTarget final : public SparseTarget {
public:
    /// expected: a number of bricks that will probably do. Pages that are not written take no memory.
    FieldTarget(const HostArrays& wanted, SparseField& field, std::size_t expected);

    HostArrays room(std::size_t bricks) override;
    void take(const SparseSlab& slab) override;

private:
    void resize(std::size_t bricks);

    const HostArrays& wanted_;
    SparseField& field_;
    std::size_t capacity_;
};

/// The caller's arrays, checked.
struct SparseArrays {
    SparseArrays() = default;  ///< without room: everything is only counted
    /// Throws as DistanceTransform::compute_sparse() does.
    explicit SparseArrays(const SparseTargets& given);

    /// Throws Error(invalid_argument) if a field of so many bricks and runs does not fit.
    void check_room(const SparseCounts& counts) const;

    std::span<Index3> bricks{};
    std::span<BrickRun> inside{};
    HostArrays values{};
};

/// Puts the layers into arrays as long as there is room, and counts them.
class ArraysTarget final : public SparseTarget {
public:
    ArraysTarget(const SparseArrays& arrays, SparseCounts& counts) : arrays_(arrays), counts_(counts) {}

    std::size_t most() const override { return arrays_.bricks.size() - used(); }
    HostArrays room(std::size_t /*bricks*/) override { return arrays_from(used() * brick_samples, arrays_.values); }
    void take(const SparseSlab& slab) override;
    void count(std::size_t bricks, const SparseSlab& slab) override;

private:
    /// The place of the next bricks in the arrays: their end once the room is exceeded.
    std::size_t used() const { return std::min(counts_.bricks, arrays_.bricks.size()); }

    const SparseArrays& arrays_;
    SparseCounts& counts_;
};

/// A box of whole bricks and its field.
struct SparseBox {
    Grid bricks;
    SparseField* field;
};

/// Adds the bricks and runs that a part of the lattice shares with a box to the box's field.
void add_part(const SparseSlab& part, const SparseBox& box);

}  // namespace clsdf::targets
