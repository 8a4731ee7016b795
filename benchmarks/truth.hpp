#pragma once

#include "benchmarks/workload.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::bench {

/// The faults of a method's values.
struct Judgement {
    std::size_t samples = 0;       ///< looked at
    std::size_t wrong_signs = 0;   ///< farther than 1e-6 voxel from the surface
    std::size_t missed = 0;        ///< in the band, but not computed or with the value of samples beyond it
    std::size_t leaked = 0;        ///< beyond the band, but with a value within it
    std::size_t wrong_values = 0;  ///< in the band, off by more than 1e-5 voxel and 2 ulp
    double max_error_voxels = 0;   ///< of the magnitudes, over the samples of the band that are not missed
    double mean_error_voxels = 0;  ///< over the same samples

    bool exact() const { return wrong_signs + missed + leaked + wrong_values == 0; }
    /// The worse of both, count by count.
    void take_worse(const Judgement& other);
};

/// The largest stride with which a method may compute the list: the samples that are judged are in every such part.
inline constexpr std::size_t largest_stride = 64;

/// True distances and signs of some samples of a workload, by the reference: half of them of the list's bricks that
/// every method computes, half anywhere in the grid.
class Truth {
public:
    /// `samples` 0: every sample of the grid. The choice is random; `seed` decides it.
    Truth(const Workload& workload, std::size_t samples, std::uint64_t seed);

    /// Compares values with the truth. A method that takes the list is judged by the samples that it had to compute.
    Judgement judge(std::span<const float> distance, bool takes_list, std::size_t stride) const;

private:
    struct Sample {
        std::size_t offset = 0;
        double distance = 0;
        bool inside = false;
        std::size_t brick = not_listed;  ///< of the list
    };
    static constexpr std::size_t not_listed = ~std::size_t{0};

    static std::vector<Sample> choose(const Workload& workload, std::size_t samples, std::uint64_t seed);

    std::vector<Sample> samples_;
    Band band_;
    bool with_sign_;
    double voxel_;
};

}  // namespace clsdf::bench
