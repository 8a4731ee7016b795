#include "field/formats.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field_writer.hpp>

#include <fmt/format.h>

#include <utility>

namespace clsdf {
namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, "field writer: " + what};
}

// The slices of a slab, the same number of each output that was announced and none of the others.
std::int64_t slices_in(const FieldSlab& slab, const Grid& grid, const Outputs& outputs) {
    const auto slice = static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
    const std::size_t samples = slab.distance.size();
    if (samples == 0 || samples % slice != 0)
        throw misuse(fmt::format("{} samples are no whole slices of {} x {}", samples, grid.size[0], grid.size[1]));
    for (const OutputKind& kind : extra_kinds()) {
        const std::size_t bytes = kind.bytes(slab).size();
        const std::size_t expected = kind.wanted(outputs) ? samples * kind.sample_bytes() : 0;
        if (bytes != expected)
            throw misuse(fmt::format("{} has {} bytes in a slab of {} samples, and {} were announced", kind.name, bytes,
                                     samples, expected));
    }
    return static_cast<std::int64_t>(samples / slice);
}

}  // namespace

FieldWriter::FieldWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs)
    : field_(field), outputs_(outputs) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    field.grid.validate();
    field.band.validate();
    check_place_for(outputs, path, format);
    format_ = format.writer(path, field, outputs);
}

FieldWriter::FieldWriter(FieldWriter&&) noexcept = default;
FieldWriter& FieldWriter::operator=(FieldWriter&&) noexcept = default;
FieldWriter::~FieldWriter() = default;

void FieldWriter::append(const FieldSlab& slab) {
    // Gone if anything is thrown: what was half written must not be finished.
    std::unique_ptr<FormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw misuse("nothing can be appended after a failure or after finish()");
    const std::int64_t slices = slices_in(slab, field_.grid, outputs_);
    if (slices > field_.grid.size[2] - slices_)
        throw misuse(
            fmt::format("{} slices after {} are more than the {} of the grid", slices, slices_, field_.grid.size[2]));
    format->append(slab, slices_);
    slices_ += slices;
    format_ = std::move(format);
}

void FieldWriter::finish() {
    const std::unique_ptr<FormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw misuse("nothing is left to finish after a failure or after finish()");
    if (slices_ != field_.grid.size[2])
        throw misuse(fmt::format("{} of {} slices were appended", slices_, field_.grid.size[2]));
    format->finish();
}

}  // namespace clsdf
