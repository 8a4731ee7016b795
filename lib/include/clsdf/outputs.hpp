#pragma once

#include <clsdf/output_table.h>
#include <clsdf/arrays.hpp>
#include <clsdf/export.hpp>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

namespace clsdf {

/// The values of a triangle and of a site beyond the band.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;
inline constexpr std::uint8_t no_site = 255;

/// A row of the table of outputs.
struct OutputInfo {
    Output output = Output::distance;
    const char* name = "";         ///< "distance": that of the enumerator, in files, and in the names of files
    const char* description = "";  ///< in words
    ElementType type = ElementType::float32;  ///< of a value, in fields and files
    std::size_t components = 1;               ///< values of a sample, which lie side by side

    constexpr std::size_t sample_bytes() const { return bytes_of(type) * components; }
};

/// All outputs, in the order of their numbers. A number may have no output: info_of() finds one by its number.
CLSDF_EXPORT std::span<const OutputInfo> output_table();

/// Throws Error(invalid_argument) for a number that is no output's.
CLSDF_EXPORT const OutputInfo& info_of(Output output);

namespace detail {
/// Throws Error(invalid_argument) unless this is the type of the output's values in fields.
CLSDF_EXPORT void check_type(Output output, ElementType type);
}  // namespace detail

/// A set of outputs, e.g. Output::triangle | Output::gradient.
class OutputSet {
public:
    constexpr OutputSet() = default;
    // NOLINTNEXTLINE(google-explicit-constructor): an output is a set of one
    constexpr OutputSet(Output output) { insert(output); }
    constexpr OutputSet(std::initializer_list<Output> outputs) {
        for (const Output output : outputs) insert(output);
    }
    /// Bit n stands for the output with the number n.
    static constexpr OutputSet from_bits(std::uint32_t bits) {
        OutputSet set;
        set.bits_ = bits;
        return set;
    }

    constexpr std::uint32_t bits() const { return bits_; }
    constexpr bool empty() const { return bits_ == 0; }
    constexpr bool contains(Output output) const { return (bits_ & bit(output)) != 0; }
    constexpr void insert(Output output) { bits_ |= bit(output); }
    constexpr void erase(Output output) { bits_ &= ~bit(output); }

    friend constexpr OutputSet operator|(OutputSet a, OutputSet b) { return from_bits(a.bits_ | b.bits_); }
    friend constexpr bool operator==(OutputSet, OutputSet) = default;

private:
    static constexpr std::uint32_t bit(Output output) { return std::uint32_t{1} << static_cast<std::uint32_t>(output); }

    std::uint32_t bits_ = 0;
};

constexpr OutputSet operator|(Output a, Output b) {
    return OutputSet(a) | OutputSet(b);
}

/// An output and the array that it is written to.
struct OutputTarget {
    Output output = Output::distance;
    OutputArray array;
};

namespace detail {
/// Throws Error(invalid_argument) if an output has two targets.
CLSDF_EXPORT void check_targets(std::span<const OutputTarget> targets);
}  // namespace detail

/// The arrays to which a call writes: one for the distance, and one for each other output that is wanted.
///
///     transform.compute(grid, band, distances);
///     transform.compute(grid, band, {{Output::distance, distances}, {Output::gradient, gradients}});
///
/// Types: those of output_table(). The triangle may also be int32: -1 beyond the band. Distances, gradients,
/// barycentric coordinates and offsets may also be doubles; they are evaluated in double at the nearest triangle. Other
/// types are Error(unsupported): the closest point, a position, has no floats; ask for the offset.
///
/// No two values of a call may lie on the same bytes: arrays that overlap are Error(invalid_argument). Boxes and
/// components of one large array are told exactly, and so are arrays of which none begins inside another. For arrays
/// with other strides that lie between each other the search is limited: a call with thousands of them may miss an
/// overlap.
///
/// Strides, and memory of the device whose offset is no multiple of what buffers are aligned to
/// (CL_DEVICE_MEM_BASE_ADDR_ALIGN / 8) cost a copy of the field.
class OutputTargets {
public:
    OutputTargets() = default;
    /// Throws Error(invalid_argument) if an output has two targets.
    OutputTargets(std::initializer_list<OutputTarget> targets) : targets_(targets) { detail::check_targets(targets_); }
    /// The distance alone.
    // NOLINTNEXTLINE(google-explicit-constructor): an array is the distance's
    OutputTargets(const OutputArray& distance) : targets_{{Output::distance, distance}} {}
    /// The same of an array, of a buffer of the device, or of packed distances from an address on, whose number is not
    /// checked.
    template <typename Memory>
    requires(!std::is_same_v<std::remove_cvref_t<Memory>, OutputArray> && std::is_constructible_v<OutputArray, Memory>)
        // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): memory is the distance's
        OutputTargets(Memory&& memory)
        : OutputTargets(OutputArray(std::forward<Memory>(memory))) {}

    /// The output's array; one that is not given yet is added.
    OutputArray& operator[](Output output) {
        for (OutputTarget& target : targets_)
            if (target.output == output) return target.array;
        return targets_.emplace_back(OutputTarget{output, {}}).array;
    }
    /// Null if the output has none.
    const OutputArray* find(Output output) const {
        for (const OutputTarget& target : targets_)
            if (target.output == output && target.array.is_given()) return &target.array;
        return nullptr;
    }

    /// The outputs that have memory.
    OutputSet outputs() const {
        OutputSet set;
        for (const OutputTarget& target : targets_)
            if (target.array.is_given()) set.insert(target.output);
        return set;
    }
    std::span<const OutputTarget> all() const { return targets_; }

private:
    std::vector<OutputTarget> targets_;
};

}  // namespace clsdf
