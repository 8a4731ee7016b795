#include "papers/scans.hpp"

#include <algorithm>

namespace clsdf::papers {

namespace {

/// The sum over all pieces of a slice.
struct SliceLoad {
    std::size_t active = 0;
    double cost = 0;
};

std::vector<SliceLoad> loads_of(std::span<const PieceSlices> pieces, std::int32_t first, std::int32_t count) {
    // Differences from slice to slice; of the cost they leave roundings, which are far below a launch.
    std::vector<std::ptrdiff_t> active(static_cast<std::size_t>(count) + 1);
    std::vector<double> cost(active.size());
    for (const PieceSlices& piece : pieces) {
        const std::int32_t begin = std::max(piece.begin - first, 0), end = std::min(piece.end - first, count);
        if (begin >= end) continue;
        ++active[static_cast<std::size_t>(begin)];
        --active[static_cast<std::size_t>(end)];
        cost[static_cast<std::size_t>(begin)] += cost_of(piece.cost);
        cost[static_cast<std::size_t>(end)] -= cost_of(piece.cost);
    }
    std::vector<SliceLoad> loads(static_cast<std::size_t>(count));
    std::ptrdiff_t active_here = 0;
    double cost_here = 0;
    for (std::size_t slice = 0; slice < loads.size(); ++slice) {
        active_here += active[slice];
        cost_here += cost[slice];
        loads[slice] = {static_cast<std::size_t>(active_here), std::max(cost_here, 0.0)};
    }
    return loads;
}

std::vector<SliceChunk> chunks_of(const std::vector<SliceLoad>& loads, std::int32_t first, const SliceLimits& limits) {
    std::vector<SliceChunk> chunks;
    std::size_t active = 0;
    for (std::size_t slice = 0; slice < loads.size(); ++slice) {
        const auto number = first + static_cast<std::int32_t>(slice);
        const bool fits = !chunks.empty() &&
                          static_cast<std::size_t>(number - chunks.back().begin) < limits.slices_at_once &&
                          active - chunks.back().active_begin + loads[slice].active <= limits.active_at_once;
        if (!fits) chunks.push_back({number, number, active, active});
        active += loads[slice].active;
        chunks.back().end = number + 1;
        chunks.back().active_end = active;
    }
    return chunks;
}

/// Cuts a chunk's active list where the cost of a launch is reached.
class Cutter {
public:
    Cutter(double limit, std::vector<std::size_t>& ends) : limit_(limit), ends_(ends) {}

    /// Entries that are not divided.
    void add(std::size_t entries, double cost) {
        if (cost_ > 0 && cost_ + cost > limit_) cut();
        position_ += entries;
        cost_ += cost;
    }
    void cut() {
        ends_.push_back(position_);
        cost_ = 0;
    }

private:
    double limit_;
    std::vector<std::size_t>& ends_;
    std::size_t position_ = 0;
    double cost_ = 0;
};

/// The ends of the launches of a chunk.
std::vector<std::size_t> launch_ends(const SliceChunk& chunk, std::span<const SliceLoad> loads,
                                     std::span<const PieceSlices> pieces, double limit) {
    std::vector<std::size_t> ends;
    Cutter cutter(limit, ends);
    for (std::int32_t slice = chunk.begin; slice < chunk.end; ++slice) {
        const SliceLoad& load = loads[static_cast<std::size_t>(slice - chunk.begin)];
        if (load.cost <= limit) {
            cutter.add(load.active, load.cost);
            continue;
        }
        for (const PieceSlices& piece : pieces)
            if (piece.begin <= slice && slice < piece.end) cutter.add(1, cost_of(piece.cost));
    }
    cutter.cut();
    return ends;
}

}  // namespace

// The cost on a processor of finding a polygon, and of a row, as a number of distances.
double cost_of(const PieceCost& piece) {
    constexpr double a_polygon = 40;
    constexpr double a_row = 10;
    return a_polygon + a_row * static_cast<double>(piece.rows) + static_cast<double>(piece.samples);
}

SliceSchedule schedule_slices(std::span<const PieceSlices> pieces, std::int32_t first, std::int32_t count,
                              const SliceLimits& limits) {
    const std::vector<SliceLoad> loads = loads_of(pieces, first, count);
    SliceSchedule schedule;
    schedule.chunks = chunks_of(loads, first, limits);
    for (std::size_t c = 0; c < schedule.chunks.size(); ++c) {
        const SliceChunk& chunk = schedule.chunks[c];
        schedule.most_slices = std::max(schedule.most_slices, static_cast<std::size_t>(chunk.end - chunk.begin));
        schedule.most_active = std::max(schedule.most_active, chunk.active_end - chunk.active_begin);
        const auto chunk_loads = std::span(loads).subspan(static_cast<std::size_t>(chunk.begin - first),
                                                          static_cast<std::size_t>(chunk.end - chunk.begin));
        const std::vector<std::size_t> ends = launch_ends(chunk, chunk_loads, pieces, limits.cost_per_launch);
        for (std::int32_t pass = 0; pass < limits.passes; ++pass) {
            std::size_t begin = 0;
            for (const std::size_t end : ends) {
                schedule.launches.push_back({c, pass, begin, end, 0});
                begin = end;
            }
        }
    }
    const auto launches = static_cast<double>(schedule.launches.size());
    for (std::size_t i = 0; i < schedule.launches.size(); ++i)
        schedule.launches[i].fraction_before = static_cast<double>(i) / launches;
    return schedule;
}

}  // namespace clsdf::papers
