#include "io/fields/sparse_files.hpp"

#include "core/brick_order.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>

namespace clsdf {
namespace {

/// Bricks, or runs of bricks, are in the order z, y, x, and lie in the part.
class BrickOrder {
public:
    BrickOrder(const Grid& part, const char* what) : part_(part), what_(what) {}

    std::string fault(const Index3& first, std::int64_t count) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t most = part_.size[axis] / brick_side;  // products below do not overflow
            const std::int64_t bricks = axis == 0 ? count : 1;
            if (bricks < 1 || bricks > most || first[axis] % brick_side != 0 || first[axis] < part_.first[axis] ||
                first[axis] - part_.first[axis] > (most - bricks) * brick_side)
                return fmt::format("{} at ({}) is not in the bricks of its part", what_, fmt::join(first, ", "));
        }
        const std::array order{first[2], first[1], first[0]};
        if (is_begun_ && order < end_)
            return fmt::format("{} at ({}) is not in the order z, y, x", what_, fmt::join(first, ", "));
        is_begun_ = true;
        end_ = {first[2], first[1], first[0] + count * brick_side};
        return {};
    }

private:
    const Grid& part_;
    const char* what_;
    bool is_begun_ = false;
    Index3 end_{};
};

}  // namespace

Field to_dense(const SparseField& field) {
    const Grid& grid = field.grid;
    Field dense(field, field.outputs() | Output::distance);
    const float sign = field.positive_inside ? -1.0F : 1.0F;
    const float inside = sign * static_cast<float>(field.band.inside_value());
    const float outside = sign * static_cast<float>(field.band.outside);
    const auto rows = static_cast<std::size_t>(grid.size[1] * grid.size[2]);
    const auto length = static_cast<std::size_t>(grid.size[0]);
    const FieldSlab values = field.values();
    constexpr std::size_t grain = 8;
    for_each_index(
        rows,
        [&](std::size_t row) {
            for (const OutputInfo& info : extra_outputs())
                if (const std::size_t bytes = length * info.sample_bytes(); !dense.bytes(info.output).empty())
                    std::memset(dense.bytes(info.output).data() + row * bytes, 0xFF, bytes);
            const auto number = static_cast<std::int64_t>(row);
            const std::int64_t y = grid.first[1] + number % grid.size[1], z = grid.first[2] + number / grid.size[1];
            const std::int64_t begin = grid.first[0], end = begin + grid.size[0];
            const Index3 start{begin, y & ~(brick_side - 1), z & ~(brick_side - 1)};
            const std::span<float> distance = dense.distance().subspan(row * length, length);
            std::ranges::fill(distance, outside);
            // Runs and bricks of the row of bricks, which are sorted along x.
            const auto is_of_row = [&](const Index3& brick) { return brick[1] == start[1] && brick[2] == start[2]; };
            const Index3 row_begin{std::numeric_limits<std::int64_t>::min(), start[1], start[2]};
            for (auto run = std::ranges::lower_bound(field.inside, row_begin, is_before, &BrickRun::first);
                 run != field.inside.end() && is_of_row(run->first); ++run) {
                const std::int64_t from = std::max(run->first[0], begin);
                const std::int64_t to = std::min(run->first[0] + run->count * brick_side, end);
                if (from < to) std::fill(distance.begin() + (from - begin), distance.begin() + (to - begin), inside);
            }
            for (auto brick = std::ranges::lower_bound(field.bricks, row_begin, is_before);
                 brick != field.bricks.end() && is_of_row(*brick); ++brick) {
                const std::int64_t from = std::max((*brick)[0], begin), to = std::min((*brick)[0] + brick_side, end);
                if (from >= to) continue;
                const auto first = static_cast<std::size_t>(
                    ((brick - field.bricks.begin()) * brick_side + z - start[2]) * brick_side * brick_side +
                    (y - start[1]) * brick_side + from - (*brick)[0]);
                for (const OutputInfo& info : output_table()) {
                    const std::size_t width = info.sample_bytes();
                    if (values.bytes(info.output).empty()) continue;
                    std::memcpy(dense.bytes(info.output).data() +
                                    (row * length + static_cast<std::size_t>(from - begin)) * width,
                                values.bytes(info.output).data() + first * width,
                                static_cast<std::size_t>(to - from) * width);
                }
            }
        },
        grain);
    return dense;
}

std::string fault_in(const SparseSlab& slab) {
    BrickOrder bricks(slab.part, "a brick"), runs(slab.part, "a run of bricks inside");
    for (const Index3& brick : slab.bricks)
        if (std::string fault = bricks.fault(brick, 1); !fault.empty()) return fault;
    for (const BrickRun& run : slab.inside)
        if (std::string fault = runs.fault(run.first, run.count); !fault.empty()) return fault;
    return {};
}

void check_sparse(const InputFile& file, const SparseField& field) {
    field.grid.validate();
    const double widest = field.sign == SignRule::none ? field.band.outside : field.band.widest();
    if (!std::isfinite(widest)) file.fail("its band has no end, and that of a sparse field has one");
    const Grid whole = in_whole_bricks(field.grid);
    whole.validate();
    if (const std::string fault = fault_in(field.slab()); !fault.empty()) file.fail(fault);
}

SpillFile::SpillFile(const std::string& path)
    : path_(path), file_(path), descriptor_(::open(file_.temporary().c_str(), O_RDWR | O_CLOEXEC)) {
    if (descriptor_.number() < 0) fail(errno);
}

void SpillFile::append(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor_.number(), bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) fail(count < 0 ? errno : ENOSPC);
        bytes = bytes.subspan(static_cast<std::size_t>(count));
        size_ += static_cast<std::uint64_t>(count);
    }
}

void SpillFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
    const ReadResult result = read_in_parallel(descriptor_, offset, bytes);
    if (result.bytes != bytes.size()) fail(result.error != 0 ? result.error : EIO);
}

void SpillFile::fail(int error) const {
    throw Error(ErrorCode::output_failure,
                fmt::format("cannot write '{}': {}", path_, std::generic_category().message(error)));
}

}  // namespace clsdf
