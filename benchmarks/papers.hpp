#pragma once

#include "benchmarks/method.hpp"

#include <clsdf/papers.hpp>

#include <memory>
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

}  // namespace clsdf::bench
