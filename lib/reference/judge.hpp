#pragma once

#include "mesh_sites.hpp"
#include "true_samples.hpp"

#include <optional>
#include <string>

namespace clsdf::reference {

/// The partial report of some samples.
struct Tally {
    CheckReport report;
    double squared_errors = 0;  ///< voxels^2, over the band samples

    /// Adds the tally of the samples that follow.
    void append(const Tally& next);
    CheckReport finish() const;
};

/// The band's contract, sample by sample.
class Judge {
public:
    /// All three must outlive this.
    Judge(const TrueSamples& truth, const Field& field, const CheckOptions& options);

    void judge(const Index3& index, const TrueSample& truth, Tally& tally) const;

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
    double tolerance(double distance) const;
    float fill(bool inside) const;
    void judge_sign(const Case& sample) const;
    void judge_distance(const Case& sample) const;
    void judge_outputs(const Case& sample) const;  // output_contracts.cpp

    const TrueSamples& truth_;
    const Field& field_;
    const CheckOptions& options_;
    double voxel_;
    double joined_margin_;            ///< how far from the surface joined vertices may change the sign
    std::optional<MeshSites> sites_;  ///< if sites or gradients are judged
};

}  // namespace clsdf::reference
