#pragma once

#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "launch/commands.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>

namespace clsdf::engine {

/// Groups of a launch along y, and as many along z: NVIDIA's GPUs have 65,535 at most.
constexpr std::size_t most_groups = 32768;

/// enqueue(y, z, items) for launches that begin at work-item (0, y, z), have at most `most` work-items along y and z,
/// and together cover `all`.
template <class Enqueue>
void divided(const std::array<std::size_t, 3>& all, const std::array<std::size_t, 2>& most, Enqueue&& enqueue) {
    for (std::size_t z = 0; z < all[2]; z += most[1])
        for (std::size_t y = 0; y < all[1]; y += most[0])
            enqueue(y, z, cl::NDRange(all[0], std::min(most[0], all[1] - y), std::min(most[1], all[2] - z)));
}

/// The cores in estimates of a launch's time: the compute units, but at least eight if the device is no processor.
inline unsigned cores_of(const device::Context::Capabilities& device) {
    return device.is_processor ? device.compute_units : std::max(8U, device.compute_units);
}

/// Divides the work of a stage into launches of about a tenth of a second: no launch may last longer than a fifth, and
/// between two a computation can be stopped.
class ShortLaunches {
public:
    /// `between`, which may be empty, is called before each launch of a stage, when the stage's one before has ended;
    /// what it throws ends the stage.
    ShortLaunches(const device::Context& context, std::function<void()> between)
        : context_(&context),
          between_(std::move(between)),
          core_seconds_(context.capabilities().launch_seconds * cores_of(context.capabilities())) {}

    /// How many items fit a launch, of which each takes a core of a processor so many seconds.
    std::size_t most(double core_seconds) const {
        return std::max<std::size_t>(1, static_cast<std::size_t>(core_seconds_ / core_seconds));
    }

    /// How many launches there must be for work that takes a core of a processor so many seconds.
    std::size_t steps(double core_seconds) const { return static_cast<std::size_t>(core_seconds / core_seconds_) + 1; }

    /// enqueue(number) for as many launches.
    template <class Enqueue>
    void one_by_one(std::size_t count, Enqueue&& enqueue) const {
        for (std::size_t number = 0; number < count; ++number) {
            if (between_) {
                if (number > 0) context_->finish();
                between_();
            }
            enqueue(number);
        }
    }

    /// enqueue(begin, end) for ranges that are [0, items) together.
    template <class Enqueue>
    void over(std::size_t items, double core_seconds, Enqueue&& enqueue) const {
        const std::size_t step = most(core_seconds);
        one_by_one(chunk_count(items, step),
                   [&](std::size_t number) { enqueue(number * step, std::min((number + 1) * step, items)); });
    }

    /// Launches a kernel for [0, items), one item per work-item. set(begin, end) sets its arguments for a range.
    template <class Set>
    void over_items(device::LentKernel& kernel, std::size_t items, double core_seconds, const Set& set) const {
        over(items, core_seconds, [&](std::size_t first, std::size_t end) {
            set(static_cast<cl_uint>(first), static_cast<cl_uint>(end));
            launch(context_->queue(), kernel, {end - first});
        });
    }

private:
    const device::Context* context_;
    std::function<void()> between_;
    double core_seconds_;  ///< time of a launch, on all cores together
};

/// Calls launch(begin, end) for consecutive ranges of [0, items), and waits for each. `core_seconds`, an estimate for
/// one item on one core, gives the size of the first range. The measured time of a range gives the size of the next.
/// All ranges but the last have at least `least` items, because other work on a busy machine makes times longer.
/// `between`, which may be empty, is called before each launch with the fraction done. Its exceptions end the work.
template <class Launch>
void measured_launches(const device::Context& context, std::size_t items, double core_seconds, std::size_t least,
                       const std::function<void(double)>& between, Launch&& launch) {
    const double launch_seconds = context.capabilities().launch_seconds;
    auto size = static_cast<std::size_t>(launch_seconds * cores_of(context.capabilities()) / core_seconds);
    for (std::size_t begin = 0; begin < items;) {
        const std::size_t end = std::min(begin + std::max(size, least), items);
        if (between) between(static_cast<double>(begin) / static_cast<double>(items));
        const Stopwatch watch;
        launch(begin, end);
        context.finish();
        const double ratio = std::clamp(launch_seconds / std::max(watch.seconds(), 1e-6), 0.5, 4.0);
        size = static_cast<std::size_t>(static_cast<double>(end - begin) * ratio);
        begin = end;
    }
}

}  // namespace clsdf::engine
