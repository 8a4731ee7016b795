#pragma once

#include "true_samples.hpp"

namespace clsdf::reference {

/// A report in the making: what a number of samples add up to.
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
    struct Case;
    double tolerance(double distance) const;
    float fill(bool inside) const;
    void judge_sign(const Case& sample, Tally& tally) const;
    void judge_distance(const Case& sample, Tally& tally) const;
    void judge_triangle(const Case& sample, Tally& tally) const;

    const TrueSamples& truth_;
    const Field& field_;
    const CheckOptions& options_;
    double voxel_;
};

}  // namespace clsdf::reference
