#pragma once

#include "mesh_sites.hpp"
#include "true_samples.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::reference {

/// The partial report of some samples.
struct Tally {
    CheckReport report;
    double squared_errors = 0;  ///< voxels^2, over the band samples

    /// Adds the tally of the samples that follow.
    void append(const Tally& next);
    CheckReport finish() const;
};

/// Runs `part(index, tallies)` for all parts on all cores, with a tally for each field, and adds the tallies in the
/// order of the parts, so the result does not depend on the number of threads.
std::vector<CheckReport> tally_parts(std::size_t count, std::size_t fields, const CheckOptions& options,
                                     const std::function<void(std::size_t, std::span<Tally>)>& part);

/// Throws Error(invalid_argument) if an array of the field does not fit its grid.
void require_sizes(const Field& field);

/// Distances of samples beyond this are not needed to judge a field.
double reach_of(const Field& field, bool is_signed, const CheckOptions& options);

/// The band's contract, sample by sample.
class Judge {
public:
    /// All three must outlive this. body: the number of the mesh's body.
    Judge(const TrueSamples& truth, const Field& field, const CheckOptions& options, std::uint32_t body = 0);

    void judge(const Index3& index, const TrueSample& truth, Tally& tally) const;
    double tolerance(double distance) const;

private:
    /// One sample: the truth, the field's value, and the position in the band.
    struct Case {
        enum class Place { in_band, at_limit, beyond };

        Index3 index;
        const TrueSample& truth;
        std::size_t offset;
        float found;
        double expected;  ///< what the field should say
        Place place;
        bool sign_is_certain;
        Tally& tally;

        void report(std::size_t& counter, std::string what, bool of_distance = true) const;
    };
    float fill(bool inside) const;
    void judge_sign(const Case& sample) const;
    void judge_distance(const Case& sample) const;
    void judge_outputs(const Case& sample) const;  // output_contracts.cpp

    const TrueSamples& truth_;
    const Field& field_;
    const CheckOptions& options_;
    std::uint32_t body_;
    double voxel_;
    double joined_margin_;            ///< how far from the surface joined vertices may change the sign
    std::optional<MeshSites> sites_;  ///< if sites or gradients are judged
};

}  // namespace clsdf::reference
