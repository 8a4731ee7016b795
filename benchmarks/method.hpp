#pragma once

#include "benchmarks/cost.hpp"
#include "benchmarks/workload.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace clsdf::bench {

/// A method that computes a workload's field. All of compute() is timed; the note states what is kept between calls.
class Method {
public:
    Method() = default;
    Method(const Method&) = delete;
    Method& operator=(const Method&) = delete;
    virtual ~Method() = default;

    virtual std::string name() const = 0;
    /// Its input, and the parts that its time does not include.
    virtual std::string note() const = 0;

    /// True: it computes only the samples of the workload's list. False: the whole grid.
    virtual bool takes_list() const { return false; }

    /// True: it gets all repetitions, also if they take longer than MeasureOptions::seconds_per_method.
    virtual bool gets_every_call() const { return false; }

    /// Work that a program does once, such as compiling kernels. Not timed.
    virtual void prepare(const Workload&) {}

    /// The whole job, from the mesh in memory to signed distances in the mesh's units in `distance`, which has
    /// grid.sample_count() values; a method that takes the list computes every `stride`-th of its bricks. Returns the
    /// part of the cost that does not shrink with the stride.
    virtual Cost compute(const Workload& workload, std::span<float> distance, std::size_t stride) = 0;
};

/// A method that the command can be asked for by name.
struct Entry {
    std::string name;
    std::string version;             ///< of the peer; empty for our own
    std::string remedy;              ///< how to get it; empty if it is built in
    std::unique_ptr<Method> method;  ///< null if it is not built in

    Entry(std::string name_in, std::string version_in, std::string remedy_in, std::unique_ptr<Method> method_in)
        : name(std::move(name_in)),
          version(std::move(version_in)),
          remedy(std::move(remedy_in)),
          method(std::move(method_in)) {}
};

/// clsdf on a device: with a transform that is kept between calls, as in a simulation code, and with a new one for each
/// call.
std::unique_ptr<Method> make_kept_transform(const Device& device, const std::string& name = "clsdf, again");
std::unique_ptr<Method> make_transform_anew(const Device& device, const std::string& name = "clsdf");

// The peers, one file each.
Entry embree_entry();
Entry openvdb_entry();
Entry cgal_entry();

/// clsdf's band of a share of the mesh's longest side, continued over the whole grid by OpenVDB's fast sweeping.
Entry openvdb_sweep_entry(const Device& device, double share);

/// Signed distances at points, by a peer that is set up for a mesh. Empty if the peer is not built in.
using PointPeer = std::function<void(std::span<const Vec3> points, std::span<float> distance)>;
PointPeer embree_points(const Mesh& mesh);

/// The first hits of rays, in lengths of their directions, by a peer that is set up for a mesh. Empty if the peer is
/// not built in.
using RayPeer =
    std::function<void(std::span<const Vec3> origins, std::span<const Vec3> directions, std::span<double> t)>;
RayPeer embree_rays(const Mesh& mesh);

/// clsdf, then every peer, also those that are not built in.
std::vector<Entry> all_methods(const Device& device);

}  // namespace clsdf::bench
