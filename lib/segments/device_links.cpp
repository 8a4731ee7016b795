#include "segments/device_links.hpp"

#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"
#include "link_lattice.h"
#include "segments/device_samples.hpp"
#include "segments/link_raster.hpp"
#include "segments/links.hpp"
#include "sign/row_records.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

namespace clsdf::segments {

namespace {

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_word = 1e-6;  // of 32 samples, in all directions
constexpr double seconds_per_link = 1e-5;
constexpr double seconds_per_side = 1e-7;

constexpr const char* purpose = "links";

/// Finds the links of one grid.
class DeviceFinder {
public:
    DeviceFinder(const DeviceLinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions)
        : inputs_(inputs),
          tools_(inputs.tools),
          launches_(tools_.context, {}),
          box_(grid, margin_of(directions), inputs.mesh.per_unit),
          steps_(directions.begin(), directions.end()) {}

    /// Finds the sides and counts the links; false if the host has to.
    bool count() {
        constexpr std::size_t most = std::numeric_limits<cl_uint>::max();
        const std::size_t words = (static_cast<std::size_t>(box_.size[0]) + 31) / 32;
        words_ = words * static_cast<std::size_t>(box_.size[1] - 2 * box_.margin[1]) *
                 static_cast<std::size_t>(box_.size[2] - 2 * box_.margin[2]);
        if (box_.size[0] > CLSDF_MOST_EXACT_SAMPLES || box_.row_count() * words >= most) return false;
        // Samples have a byte each at the end, and places on lines are integers of 32 bits.
        if (sample_count() >= most || longest_step() * *std::ranges::max_element(box_.size) >= 1 << 30) return false;
        samples_.emplace(tools_, box_, words);
        sides_ = engine::find_exact_sides(tools_, launches_, inputs_.mesh, inputs_.rule, samples_->rows, *samples_->at);
        if (!sides_) return false;
        report(0.3);
        describe();
        const auto counts = tools_.pool->lease(words_ * sizeof(cl_uint), purpose);
        starts_ = tools_.pool->lease((words_ + 1) * sizeof(cl_uint), purpose);
        launch_over("count_links", words_, seconds_per_word, lattice_, *links_of_steps_, *sides_->bits, *counts);
        engine::PrefixSums sums(tools_, *counts, *starts_, words_, purpose);
        made_.count = sums.total();
        report(0.5);
        return true;
    }
    std::size_t size() const { return made_.count; }

    /// Finds the rows; false if the host has to.
    bool find() {
        if (made_.count == 0) return true;
        const auto lease = [&](std::size_t bytes_of_link) {
            return tools_.pool->lease_for_list(made_.count * bytes_of_link, purpose);
        };
        made_.samples = lease(3 * sizeof(cl_int));
        made_.directions = lease(1);
        launch_over("fill_links", words_, seconds_per_word, lattice_, *links_of_steps_, *sides_->bits, *starts_,
                    *made_.samples, *made_.directions);
        const engine::RowKeys faces = find_faces();
        report(0.7);
        made_.q = lease(sizeof(cl_double));
        made_.q_floats = lease(sizeof(cl_float));
        made_.triangles = lease(sizeof(cl_uint));
        made_.counts = lease(sizeof(cl_uint));
        made_.flags = lease(1);
        const auto results =
            device::copied(tools_.context, tools_.pool,
                           std::vector{LinkResults{0, 0, std::numeric_limits<cl_uint>::max(), 0}}, purpose);
        const engine::CrossedMesh& mesh = inputs_.mesh;
        launch_over("solve_links", made_.count, seconds_per_link, lattice_, *steps_by_number_, *mesh.faces->triangles,
                    **mesh.positions, *mesh.faces->names, *samples_->at, *sides_->crossings.starts,
                    *sides_->crossings.keys, *faces.starts, *faces.keys, *made_.samples, *made_.directions, *made_.q,
                    *made_.q_floats, *made_.triangles, *made_.counts, *made_.flags, *results);
        const auto found = device::read_value<LinkResults>(tools_.context, *results);
        if (found.open > 0) return false;
        if (found.wrong > 0) {
            const auto first = std::size_t{found.first_wrong};
            refuse_link(device::read_value<std::array<std::int32_t, 3>>(tools_.context, *made_.samples,
                                                                        first * 3 * sizeof(std::int32_t)),
                        device::read_value<std::uint8_t>(tools_.context, *made_.directions, first));
        }
        report(0.9);
        return true;
    }

    /// With the side of each sample in a byte.
    DeviceLinks on_device() {
        made_.inside = sides_of_grid(false);
        return std::move(made_);
    }
    Links on_host() {
        Links links;
        links.samples.resize(made_.count);
        links.directions.resize(made_.count);
        links.q.resize(made_.count);
        links.triangles.resize(made_.count);
        links.counts.resize(made_.count);
        links.flags.resize(made_.count);
        if (made_.count > 0) {
            device::read_values(tools_.context, *made_.samples, links.samples);
            device::read_values(tools_.context, *made_.directions, links.directions);
            device::read_values(tools_.context, *made_.q, links.q);
            device::read_values(tools_.context, *made_.triangles, links.triangles);
            device::read_values(tools_.context, *made_.counts, links.counts);
            device::read_values(tools_.context, *made_.flags, links.flags);
        }
        const auto sides = sides_of_grid(true);
        for (std::size_t axis = 0; axis < 3; ++axis) links.inside.size[axis] = box_.size[axis] - 2 * box_.margin[axis];
        links.inside.bits.resize((sample_count() + 7) / 8);
        device::read_values(tools_.context, *sides, links.inside.bits);
        return links;
    }

private:
    void report(double fraction) const {
        if (inputs_.between) inputs_.between(fraction);
    }

    std::size_t sample_count() const {
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            count *= static_cast<std::size_t>(box_.size[axis] - 2 * box_.margin[axis]);
        return count;
    }

    /// The largest component of a direction, at least 1.
    std::int64_t longest_step() const {
        std::int64_t longest = 1;
        for (const Place& step : steps_)
            for (const auto component : step) longest = std::max<std::int64_t>(longest, std::abs(component));
        return longest;
    }

    /// Launches a kernel whose last arguments are a range of [0, items), behind these.
    template <class... Arguments>
    void launch_over(const char* name, std::size_t items, double core_seconds, const Arguments&... arguments) const {
        device::LentKernel kernel = tools_.kernel(tools_.programs.links, name);
        const cl_uint range = engine::set_arguments(kernel, 0, arguments...);
        launches_.over_items(kernel, items, core_seconds,
                             [&](cl_uint begin, cl_uint end) { engine::set_arguments(kernel, range, begin, end); });
    }

    /// What the kernels read of lattice and directions.
    void describe() {
        const PairedDirections pairs = paired(steps_);
        std::vector<LinkLine> lines;
        LinkRaster(box_, pairs.steps).describe(pairs, lattice_, lines);
        lattice_.samples = samples_->rows;
        std::vector<LinkStep> links;
        std::vector<cl_int4> by_number;
        for (std::size_t n = 0; n < steps_.size(); ++n) {
            const Place& step = steps_[n];
            by_number.push_back({{step[0], step[1], step[2], 0}});
            if (step != Place{}) links.push_back({{step[0], step[1], step[2]}, static_cast<clsdf_int32>(n)});
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lattice_.first[axis] = box_.grid.first[axis];
            lattice_.margin[axis] = box_.margin[axis];
        }
        lattice_.directions = static_cast<clsdf_int32>(links.size());
        lattice_.lines = static_cast<clsdf_int32>(lines.size());
        lattice_.is_parity = inputs_.rule == SignRule::parity ? 1 : 0;
        if (links.empty()) links.emplace_back();
        if (lines.empty()) lines.emplace_back();
        const auto copied = [&](const auto& values) {
            return device::copied(tools_.context, tools_.pool, values, "directions of links");
        };
        links_of_steps_ = copied(links);
        lines_ = copied(lines);
        steps_by_number_ = copied(by_number);
    }

    /// The faces that each link crosses.
    engine::RowKeys find_faces() const {
        const cl::Program program = tools_.programs.links;
        const engine::CrossedMesh& mesh = inputs_.mesh;
        device::LentKernel kernel = tools_.kernel(program, "link_crossings");
        const cl_uint arguments =
            engine::set_arguments(kernel, 0, lattice_, *lines_, *mesh.faces->triangles, **mesh.positions, *samples_->at,
                                  *sides_->bits, *starts_, *made_.samples, *made_.directions);
        engine::RowRecords records({.tools = tools_,
                                    .launches = launches_,
                                    .program = program,
                                    .kernel = std::move(kernel),
                                    .arguments = arguments,
                                    .rows = made_.count,
                                    .triangles = mesh.faces->face_count,
                                    .first_room = made_.count + made_.count / 8,
                                    .purpose = "faces that links cross",
                                    .listed = "crossings of links and the surface",
                                    .seconds_per_row = 1e-6,
                                    .seconds_per_triangle = 2e-5});
        records.begin();
        return records.finish();
    }

    DeviceLinks::Lease sides_of_grid(bool are_packed) const {
        const std::size_t count = sample_count(), items = are_packed ? (count + 31) / 32 : count;
        auto sides = tools_.pool->lease(items * (are_packed ? sizeof(cl_uint) : 1), "sides of samples");
        launch_over("store_sides", items, seconds_per_side * (are_packed ? 32 : 1), lattice_, *sides_->bits,
                    static_cast<cl_ulong>(count), cl_int{are_packed ? 1 : 0}, *sides);
        return sides;
    }

    const DeviceLinkInputs& inputs_;
    const engine::DeviceTools& tools_;
    engine::ShortLaunches launches_;
    SampleBox box_;
    std::vector<Place> steps_;
    std::size_t words_ = 0;  ///< of all rows of the grid
    std::optional<DeviceSamples> samples_;
    std::optional<engine::ExactSides> sides_;
    LinkLattice lattice_{};
    device::BufferPool::Lease links_of_steps_, lines_, steps_by_number_;
    device::BufferPool::Lease starts_;  ///< of the links of each word
    DeviceLinks made_;
};

}  // namespace

std::optional<DeviceLinks> links_on_device(const DeviceLinkInputs& inputs, const Grid& grid,
                                           std::span<const LinkDirection> directions, std::size_t most) {
    return device::guarded([&]() -> std::optional<DeviceLinks> {
        DeviceFinder finder(inputs, grid, directions);
        if (!finder.count() || (finder.size() <= most && !finder.find())) return std::nullopt;
        return finder.on_device();
    });
}

std::optional<Links> links_by_kernels(const DeviceLinkInputs& inputs, const Grid& grid,
                                      std::span<const LinkDirection> directions) {
    return device::guarded([&]() -> std::optional<Links> {
        DeviceFinder finder(inputs, grid, directions);
        if (!finder.count() || !finder.find()) return std::nullopt;
        return finder.on_host();
    });
}

std::optional<std::size_t> count_links_by_kernels(const DeviceLinkInputs& inputs, const Grid& grid,
                                                  std::span<const LinkDirection> directions) {
    return device::guarded([&]() -> std::optional<std::size_t> {
        DeviceFinder finder(inputs, grid, directions);
        if (!finder.count()) return std::nullopt;
        return finder.size();
    });
}

}  // namespace clsdf::segments
