#pragma once

#include "benchmarks/cost.hpp"
#include "benchmarks/workload.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace clsdf::bench {

/// A way to compute a workload's field. Whatever it does in compute() is timed; what it keeps between calls it says in
/// its note.
class Method {
public:
    Method() = default;
    Method(const Method&) = delete;
    Method& operator=(const Method&) = delete;
    virtual ~Method() = default;

    virtual std::string name() const = 0;
    /// What it is given, and what is not in its time.
    virtual std::string note() const = 0;

    /// True: it computes the samples of the workload's list, and leaves the others alone. False: the whole grid.
    virtual bool takes_list() const { return false; }

    /// True: it is called as often as was asked for, however long that takes (MeasureOptions::seconds_per_method).
    virtual bool gets_every_call() const { return false; }

    /// What a program does once in its life, such as compiling kernels. Not timed.
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
    std::string remedy;              ///< how to get it; empty where it is there
    std::unique_ptr<Method> method;  ///< null where it is not there

    Entry(std::string name_in, std::string version_in, std::string remedy_in, std::unique_ptr<Method> method_in)
        : name(std::move(name_in)),
          version(std::move(version_in)),
          remedy(std::move(remedy_in)),
          method(std::move(method_in)) {}
};

/// Ours on a device, the transform kept between calls as a simulation code keeps it, and everything anew for each call.
std::unique_ptr<Method> make_kept_transform(const Device& device);
std::unique_ptr<Method> make_transform_anew(const Device& device);

// The peers, each in a file of its own.
Entry embree_entry();
Entry openvdb_entry();
Entry cgal_entry();

/// Ours, then every peer, those that are not there too.
std::vector<Entry> all_methods(const Device& device);

}  // namespace clsdf::bench
