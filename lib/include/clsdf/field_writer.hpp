#pragma once

#include <clsdf/field.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace clsdf {

/// The values of some slices of a field, z after z: grid.size[0] * grid.size[1] samples for each, x fastest. An array
/// is empty where the field does not hold that output.
struct FieldSlab {
    std::span<const float> distance{};
    std::span<const std::uint32_t> triangle{};
};

class FormatWriter;

/// Writes a field that is never whole in memory, slab by slab, by the file's ending as Field::write does and with the
/// same bytes however it is cut into slabs. Nothing appears under its final name before finish(); without it, nothing
/// is left behind. A .vdb keeps the samples of the band in memory until finish(), every other format only what the
/// operating system has not yet written.
class FieldWriter {
public:
    /// Throws Error(unsupported) for an unknown ending, or for a grid or outputs that the format has no place for,
    /// Error(invalid_argument) for a grid or a band that makes no sense, or Error(output_failure).
    FieldWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs = {});
    FieldWriter(FieldWriter&&) noexcept;
    FieldWriter& operator=(FieldWriter&&) noexcept;
    ~FieldWriter();

    /// The next slices, in ascending z. Throws Error(output_failure), or Error(invalid_argument) where the arrays are
    /// not whole slices of just the outputs that were announced, or more than there are; nothing can be appended then.
    void append(const FieldSlab& slab);

    /// Gives the files their names, the distances' last. Throws Error(output_failure), or Error(invalid_argument) where
    /// slices are missing.
    void finish();

private:
    FieldDescription field_;
    Outputs outputs_;
    std::int64_t slices_ = 0;
    std::unique_ptr<FormatWriter> format_;  // null after the end or a failure
};

}  // namespace clsdf
