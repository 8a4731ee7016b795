#include "plans/requests.hpp"

#include "core/outputs.hpp"
#include "core/refuse.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <tuple>

namespace clsdf::plans {

namespace {

// Nanoseconds on two cores. A call has launches and waits; a sample beyond the band is filled; a sample of the band
// costs its distances.
constexpr double cost_of_call = 5e5;
constexpr double cost_of_sample = 0.7;
constexpr double cost_of_band_sample = 5;

double samples_of(const Grid& grid) {
    return static_cast<double>(grid.size[0]) * static_cast<double>(grid.size[1]) * static_cast<double>(grid.size[2]);
}

/// The smallest block of the lattice that holds all of them.
Grid block_around(std::span<const engine::Job> jobs, std::span<const std::size_t> chosen) {
    Grid block = jobs[chosen.front()].grid;
    for (const std::size_t n : chosen) {
        const Grid& grid = jobs[n].grid;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t begin = std::min(block.first[axis], grid.first[axis]);
            const std::int64_t end = std::max(block.first[axis] + block.size[axis], grid.first[axis] + grid.size[axis]);
            block.first[axis] = begin;
            block.size[axis] = end - begin;
        }
    }
    return block;
}

/// Divides the jobs of requests of one lattice, band and set of outputs.
class Division {
public:
    Division(std::span<const engine::Job> jobs, const Box& box) : jobs_(jobs) {
        const Vec3 sides = box.extent();
        area_ = 2 * (sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0]);
    }

    /// Requests that are computed together.
    struct Part {
        Grid block;  ///< around them
        double cost;
        std::vector<std::size_t> requests{};
    };

    /// The cheaper of one block and the best of two halves, which lie on both sides of the median along the block's
    /// longest axis. Changes their order.
    std::vector<Part> divide(std::span<std::size_t> chosen) const {
        const Grid block = block_around(jobs_, chosen);
        Part whole{block, cost(block, chosen)};
        std::vector<Part> parts;
        if (chosen.size() > 1) {
            const Index3& size = block.size;
            const auto axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
            const auto middle = chosen.begin() + static_cast<std::ptrdiff_t>(chosen.size() / 2);
            std::nth_element(chosen.begin(), middle, chosen.end(),
                             [&](std::size_t a, std::size_t b) { return place(a, axis) < place(b, axis); });
            parts = divide({chosen.begin(), middle});
            std::vector<Part> upper = divide({middle, chosen.end()});
            std::move(upper.begin(), upper.end(), std::back_inserter(parts));
        }
        const double cost_of_parts = std::accumulate(parts.begin(), parts.end(), 0.0,
                                                     [](double sum, const Part& part) { return sum + part.cost; });
        if (!parts.empty() && cost_of_parts < whole.cost) return parts;
        whole.requests.assign(chosen.begin(), chosen.end());
        return {std::move(whole)};
    }

private:
    /// Ties are broken by the index, so that the division depends on the requests alone.
    std::pair<std::int64_t, std::size_t> place(std::size_t n, std::size_t axis) const {
        const Grid& grid = jobs_[n].grid;
        return {2 * grid.first[axis] + grid.size[axis], n};
    }

    double cost(const Grid& block, std::span<const std::size_t> chosen) const {
        const double all = samples_of(block);
        double asked = 0;
        for (const std::size_t n : chosen) asked += samples_of(jobs_[n].grid);
        const Band& band = jobs_[chosen.front()].band;
        const double of_mesh =
            area_ * (band.inside + band.outside) / (block.spacing[0] * block.spacing[1] * block.spacing[2]);
        const double in_vain = std::max(0.0, 1 - asked / all);
        return cost_of_call + cost_of_sample * all + cost_of_band_sample * std::min(all, of_mesh) * in_vain;
    }

    std::span<const engine::Job> jobs_;
    double area_ = 0;
};

std::size_t element_bytes(const OutputInfo& info, const OutputArray& array) {
    return bytes_of(array.type == ElementType::automatic ? info.type : array.type);
}

/// Bytes from a block's first value to that of the next block.
std::ptrdiff_t block_stride(const OutputInfo& info, const OutputArray& array, std::size_t samples, std::size_t blocks) {
    const bool is_packed = array.strides == ArrayLayout().strides && array.component_stride == 0;
    if (array.block_stride == 0 && !is_packed && blocks > 1)
        refuse("the array of the output {} has strides and no block stride; set it, too", info.name);
    const std::size_t packed = samples * info.components * element_bytes(info, array);
    if (array.block_stride == 0 && is_packed && array.host != nullptr && array.bytes != ArrayLayout::unknown_size &&
        array.bytes != array.offset + blocks * packed)
        refuse("{} blocks of {} samples take {} bytes of the output {}, and its array holds {}", blocks, samples,
               blocks * packed, info.name, array.bytes - array.offset);
    return array.block_stride != 0 ? array.block_stride : static_cast<std::ptrdiff_t>(packed);
}

/// The properties that the requests of a batch share.
auto kind_of(const engine::Job& job, const targets::HostArrays& arrays) {
    std::uint32_t in_double = 0;
    for (const OutputInfo& row : extra_outputs()) in_double |= arrays[row.output].in_double ? bit_of(row) : 0;
    return std::tuple(job.grid.origin, job.grid.spacing, job.band.inside, job.band.outside, job.band.has_exact_signs,
                      job.outputs.bits(), in_double);
}

}  // namespace

std::vector<Request> requests_of(const BlockSet& blocks, std::size_t begin, std::size_t end) {
    Grid block = blocks.lattice;
    block.first = {};
    block.size = blocks.size;
    block.validate();
    const std::size_t samples = block.sample_count(), count = blocks.first.size();
    std::vector<std::ptrdiff_t> strides;
    for (const OutputTarget& target : blocks.targets.all()) {
        const OutputInfo& info = info_of(target.output);
        strides.push_back(block_stride(info, target.array, samples, count));
        if (count > 0 && strides.back() < 0 &&
            static_cast<double>(target.array.offset) <
                -static_cast<double>(strides.back()) * static_cast<double>(count - 1))
            refuse(
                "the block stride of the output {} is {}, which leads before its memory; let the "
                "offset name the first block",
                info.name, strides.back());
    }
    std::vector<Request> requests;
    requests.reserve(end - begin);
    for (std::size_t n = begin; n < end; ++n) {
        Request& request = requests.emplace_back(Request{block, blocks.band, {}});
        request.grid.first = blocks.first[n];
        std::size_t number = 0;
        for (const OutputTarget& target : blocks.targets.all()) {
            OutputArray& array = request.targets[target.output];
            array = target.array;
            array.block_stride = 0;
            array.offset += static_cast<std::size_t>(strides[number++] * static_cast<std::ptrdiff_t>(n));
            // An array with an offset may be larger than what is written to it.
            if (array.offset == 0 && array.strides == ArrayLayout().strides && array.component_stride == 0 &&
                array.bytes != ArrayLayout::unknown_size)
                array.component_stride =
                    static_cast<std::ptrdiff_t>(element_bytes(info_of(target.output), target.array));
        }
    }
    return requests;
}

std::vector<Batch> batches_of(std::span<const engine::Job> jobs, std::span<const targets::HostArrays> arrays,
                              const Box& box) {
    if (jobs.empty()) return {};
    std::map<decltype(kind_of(jobs.front(), arrays.front())), std::vector<std::size_t>> kinds;
    for (std::size_t n = 0; n < jobs.size(); ++n) kinds[kind_of(jobs[n], arrays[n])].push_back(n);
    std::vector<Batch> batches;
    for (auto& [kind, chosen] : kinds)
        for (Division::Part& part : Division(jobs, box).divide(chosen)) {
            const std::size_t first = part.requests.front();
            const bool is_one = part.requests.size() == 1;
            Batch& batch = batches.emplace_back(Batch{is_one ? jobs[first] : jobs[first].with_grid(part.block),
                                                      std::move(part.requests), part.cost, arrays[first]});
            if (!is_one)
                for (const std::size_t n : batch.requests) batch.job.wanted.push_back(jobs[n].grid);
        }
    return batches;
}

std::vector<Slab> slabs_of(std::span<const Batch> batches, const engine::SlabLimits& limits,
                           const engine::SlabLimits& limits_in_place) {
    std::vector<Slab> slabs;
    for (const Batch& batch : batches)
        for (const Grid& part : engine::slabs_of(batch.job.grid, batch.in_place ? limits_in_place : limits,
                                                 targets::widest_of(batch.arrays)))
            slabs.push_back({&batch, part});
    return slabs;
}

}  // namespace clsdf::plans
