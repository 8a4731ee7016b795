#pragma once

/// Files of parts that travel (DistanceTransform::part_bytes()), in the target clsdf::io.
#include <clsdf/export.hpp>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

class PartFile;

/// Writes parts, one after the other, into one HDF5 file: the datasets part_0, part_1 and so on are the bytes of one
/// part each, uint8, contiguous, so that other programs read them, too (docs/formats.md). The parts need not be in
/// memory at once: until finish() they are in an unfinished file beside the final one. Without finish() no file stays.
/// One thread at a time.
class CLSDF_EXPORT PartWriter {
public:
    /// Throws Error(unsupported) if the path does not end in .h5, Error(output_failure).
    explicit PartWriter(const std::string& path);
    PartWriter(PartWriter&&) noexcept;
    PartWriter& operator=(PartWriter&&) noexcept;
    ~PartWriter();

    /// The next part. Throws Error(invalid_argument) if there are no bytes, Error(output_failure).
    void append(std::span<const std::byte> bytes);

    /// Gives the file its name. Throws Error(invalid_argument) without a part, Error(output_failure).
    void finish();

private:
    std::unique_ptr<PartFile> file_;  // null after the end
};

/// The number of parts in a file. Throws Error(unreadable_input) that names the file.
CLSDF_EXPORT std::size_t count_parts(const std::string& path);

/// The bytes of a part, from 0, for DistanceTransform::from_part(), which checks them. Processes may read at the same
/// time. Throws Error(unreadable_input) that names the file, Error(invalid_argument) if the file has fewer parts,
/// Error(out_of_memory).
CLSDF_EXPORT std::vector<std::byte> read_part(const std::string& path, std::size_t part);

}  // namespace clsdf
