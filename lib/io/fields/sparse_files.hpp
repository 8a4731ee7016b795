#pragma once

#include "core/files.hpp"
#include "io/fields/field_files.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/sparse.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

// Sparse fields as arrays, in .npy and .h5 files: the values of each output, (bricks, 8, 8, 8), the bricks' indices,
// (bricks, 3), and the runs of bricks that are inside, (runs, 4): the first brick's index and the number of bricks.

namespace clsdf {

// The names of the arrays of indices, which is also what a description calls their files.
inline constexpr const char* bricks_name = "bricks";
inline constexpr const char* runs_name = "inside_runs";

/// z, y and x of a brick, and the components of a sample if there are several.
inline std::vector<std::int64_t> sparse_shape(std::size_t bricks, const OutputInfo& info) {
    std::vector<std::int64_t> shape{static_cast<std::int64_t>(bricks), brick_side, brick_side, brick_side};
    if (info.components > 1) shape.push_back(static_cast<std::int64_t>(info.components));
    return shape;
}

static_assert(sizeof(Index3) == 3 * sizeof(std::int64_t) && sizeof(BrickRun) == 4 * sizeof(std::int64_t));

/// The fault of the bricks and runs of a part: their order, or their place. Empty if there is none.
std::string fault_in(const SparseSlab& slab);

/// Throws Error(unreadable_input) that names the file if the field that was read makes no sense.
void check_sparse(const InputFile& file, const SparseField& field);

/// Bytes that are kept in an unfinished file beside the final one, which never gets a name.
class SpillFile {
public:
    /// `path`: the final file.
    explicit SpillFile(const std::string& path);

    void append(std::span<const std::byte> bytes);
    std::uint64_t size() const { return size_; }
    /// May be called by many threads.
    void read(std::uint64_t offset, std::span<std::byte> bytes) const;

private:
    [[noreturn]] void fail(int error) const;

    std::string path_;
    AtomicFile file_;
    Descriptor descriptor_;
    std::uint64_t size_ = 0;
};

}  // namespace clsdf
