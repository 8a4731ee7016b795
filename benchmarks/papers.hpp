#pragma once

#include "benchmarks/method.hpp"

#include <clsdf/papers.hpp>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The counts of a method on a workload.
struct Work {
    std::size_t polyhedra = 0;
    std::size_t distances = 0;  ///< of samples in polyhedra; lanes outside do not count
};

/// A method of the papers, or clsdf's polyhedra by one of their scans.
class PapersMethod : public Method {
public:
    /// Not timed.
    virtual Work work(const Workload& workload) = 0;
};

/// Scan conversion of Mauch's polyhedra in software (software_scan() of clsdf/papers.hpp). `threads` 0: all.
std::unique_ptr<PapersMethod> make_software_mauch(std::size_t threads);

/// Polyhedra of a kind by a scan, on the device. The transform is kept between calls, its polyhedra are not.
std::unique_ptr<PapersMethod> make_scanned(const Device& device, const std::string& name, Polyhedra polyhedra,
                                           Scan scan);

/// The methods of the papers, and clsdf: Mauch's polyhedra in software on one thread and on all, and on the device;
/// Peikert & Sigg's on the device; clsdf's on the device by slices and by bricks; and, if the workload is small, every
/// triangle at every sample.
std::vector<std::unique_ptr<PapersMethod>> papers_methods(const Device& device, const Workload& workload);

/// A mesh on a grid for which the papers state a figure, or one of a series.
struct PapersCase {
    std::string mesh;
    std::int64_t resolution = 0;
    int percent = 0;     ///< half width of the band, of the longest side
    std::string remark;  ///< the paper's finding; may be empty

    /// By the name of its resolution and width.
    Layout layout() const;
};
std::vector<PapersCase> papers_cases();

/// Every sample of a grid, computed by clsdf; and by clsdf in bands of 2, 5 and 10% of the longest side, which
/// OpenVDB's fast sweeping continues.
std::vector<Entry> far_field_methods(const Device& device);
/// The meshes on which these are compared.
const std::vector<std::string>& far_field_meshes();

/// A mesh on a grid on which the surface has a given number of triangles per voxel, which is the inverse of a
/// triangle's mean area in faces of a voxel.
struct UnderSampledCase {
    std::string series;  ///< the mesh of papers_cases() with which the case runs
    Mesh mesh;
    double triangles_per_voxel = 0;

    /// The grid of the same kind and band that comes nearest to the number.
    Layout layout(const Length& half_width) const;
};

/// From 0.1 to 1,000 triangles per voxel, on spheres for the mesh sphere6, on the split mesh for any other. Quick: of a
/// 64th of the triangles at most, on smaller grids.
std::vector<UnderSampledCase> under_sampled_cases(const std::string& series, const Mesh& mesh, bool is_quick);

/// The samples by polyhedra and bricks, and by the tree of query(), each from the mesh's arrays and on a kept
/// transform; and by Embree, which is given the samples of the band.
std::vector<Entry> under_sampled_methods(const Device& device);

/// Times of two methods for one value of a parameter.
struct TimesOfTwo {
    double value = 0;
    double first = 0, second = 0;
};

/// The values, in the order of `times`, at which the faster of the two changes, by interpolation on logarithmic scales.
std::vector<double> crossovers(std::span<const TimesOfTwo> times);

}  // namespace clsdf::bench
