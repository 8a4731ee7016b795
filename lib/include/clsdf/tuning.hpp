#pragma once

#include <clsdf/device.hpp>
#include <clsdf/export.hpp>
#include <clsdf/outputs.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// For those who test, measure or extend the method. A program that computes fields does not need this header.
/// TransformOptions::body and CallOptions::count_work are members there because a call takes one set of options.
namespace clsdf {

namespace tuning {

/// Makes this process obey five environment variables, which the library does not read otherwise. For programs of
/// tests and tools: call it first in main(). It cannot be undone. Thread-safe; throws nothing.
///
/// - CLSDF_MAX_ALLOCATION=BYTES: the most bytes of one allocation of a device; read when a device is listed or opened.
/// - CLSDF_MAX_FLOAT_WIDTH=FLOATS: the most floats in a vector of a device; read at the same time.
/// - CLSDF_DRIVER=FOLDER: where the bundled driver is, in place of its own folder; read when devices are listed first.
/// - CLSDF_DEVICE_FILES=FOLDER: where the files of GPUs are, in place of /dev; read when devices are listed.
/// - CLSDF_SELF_TEST=0: the programs of a device are not tested; read when a program is first used.
CLSDF_EXPORT void read_environment() noexcept;

/// Compiles the program that takes longest, that of the bricks of a field with these outputs, and no other one. For a
/// second process beside one that computes: PoCL compiles one program at a time in a process, and keeps programs on
/// disk for all processes. Thread-safe. Throws Error(device_failure).
CLSDF_EXPORT void compile_bricks(const Device& device, OutputSet outputs);

/// Compiles every program that a call on a processor of this device's level of instructions may ask for, whatever its
/// model. After Device::write_programs(), the folder is that of a level in a bundled driver. Programs of
/// TransformOptions::body, clsdf::papers and clsdf::picture are not among them. Thread-safe. Throws
/// Error(device_failure), Error(output_failure).
CLSDF_EXPORT void compile_level(const Device& device);

/// The programs of compile_level() that the bundled driver lacks, of every level that it has a folder for: the level,
/// the kernel file and the options of each. `device` is its device. Thread-safe. Throws Error(device_failure).
CLSDF_EXPORT std::vector<std::string> missing_programs(const Device& device);

}  // namespace tuning

/// Which form of the kernels computes the samples. Both give exact results; a form gives the same bytes on every run.
enum class KernelBody : std::int32_t {
    automatic = 0,  ///< by_vector on processors, by_group elsewhere
    by_vector = 1,  ///< a work-item computes vectors of samples, one after the other: for processors
    by_group = 2,   ///< a work-group computes a brick, a work-item some of its samples: for GPUs
};

/// A count of a method beside the core, by the name that its library gives it.
struct MethodCount {
    std::string name;
    std::size_t value = 0;
    bool of_mesh = false;  ///< of the whole mesh; else of a part of the grid: those of parts add up
};

/// How much work a computation was, and the times of its stages: TransformStatistics::work.
struct WorkCounts {
    std::size_t triangles = 0;
    std::size_t polyhedra = 0;        ///< of the triangles and point sites
    std::size_t box_polyhedra = 0;    ///< faces so degenerate that their polyhedron is a box
    std::size_t saddle_vertices = 0;  ///< with convex and concave edges; about: nearly flat edges may count as both
    std::size_t point_sites = 0;      ///< gaps closed by a polyhedron of the vertex's own
    std::size_t coarse_pairs = 0;     ///< (polyhedron, coarse brick)
    std::size_t coarse_bricks = 0;    ///< coarse bricks that a polyhedron overlaps

    // Counted on the device with CallOptions::count_work.
    std::size_t brick_pairs = 0;      ///< (polyhedron, brick), or (slender polyhedron, coarse brick)
    std::size_t lanes_evaluated = 0;  ///< distances computed, of a triangle or a site
    std::size_t samples_covered = 0;  ///< of these, with the sample inside the polyhedron
    std::size_t band_samples = 0;     ///< samples that carry their distance

    // Seconds of the host, which count as those of TransformStatistics.
    double lists_seconds = 0;  ///< the sign's sweep included
    double sign_seconds = 0;   ///< of these, or of points, the sign
    // The kernels' own share, by the device's clock; 0 unless its queue was made with profiling enabled.
    double bricks_seconds = 0;
    double fill_seconds = 0;

    std::vector<MethodCount> method_counts;
};

}  // namespace clsdf
