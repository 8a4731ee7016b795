#include <clsdf/distance_transform.hpp>

#include "core/stopwatch.hpp"
#include "transform/layout_of.hpp"
#include "transform/plan_state.hpp"
#include "transform/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace clsdf {

struct DistanceTransform::State {
    Device device;
    Mesh mesh;
    TransformOptions options;
    Topology topology;
    SignRule sign = SignRule::none;
    Scan scan = Scan::bricks;
    transform::Programs programs;
    std::shared_ptr<device::BufferPool> pool;
    TransformStatistics statistics;

    State(Device device_in, Mesh mesh_in, TransformOptions options_in)
        : device(std::move(device_in)),
          mesh(std::move(mesh_in)),
          options(std::move(options_in)),
          topology(describe_topology(mesh)),
          scan(resolve_scan(options.polyhedra, options.scan)),
          programs(device::guarded([&] { return transform::Programs(device.internal(), options.body); })),
          pool(std::make_shared<device::BufferPool>(device.shared())) {
        // Edges between vertices that are equal but not one would be open ones: exact, but slow.
        if (topology.coincident_vertices > 0) mesh = weld(mesh);
        const ResolvedSignRule resolved = resolve_sign_rule(options.sign, topology);
        sign = resolved.rule;
        if (!resolved.warning.empty() && options.log) options.log(resolved.warning);
    }

    std::shared_ptr<const transform::PreparedMesh> prepare(const Grid& grid, const Band& band) {
        return std::make_shared<const transform::PreparedMesh>(transform::prepare_mesh(
            device.internal(), pool, mesh, grid, transform::layout_of(grid, band, sign), options, scan));
    }

    std::unique_ptr<Plan::State> make_plan(std::shared_ptr<const transform::PreparedMesh> prepared, const Grid& grid,
                                           const Band& band, const Outputs& outputs) {
        auto plan = std::make_unique<Plan::State>(device, pool, programs, std::move(prepared), mesh, grid, band, sign,
                                                  outputs, options);
        pool->trim();
        return plan;
    }

    void throw_if_stopped() const {
        if (options.stop.stop_requested()) throw Error(ErrorCode::cancelled, "the computation was cancelled");
    }

    /// One slab, into the caller's host memory. Its progress runs from `begin` to `end`.
    void compute(Plan::State& plan, const HostOutputs& host, double begin, double end);
};

namespace {

/// Slabs of whole coarse bricks, so that nothing is computed twice; `limit` bytes of one output at most.
std::vector<Grid> slabs_of(const Grid& grid, std::size_t limit) {
    const std::size_t slice_bytes =
        static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]) * sizeof(float);
    // Sign bits and their counts take whole bricks; of a grid that is thin along x they outweigh the field.
    constexpr std::size_t sign_limit = std::size_t{96} << 20;
    const std::size_t sign_bytes = transform::sign_bytes_of_slice(grid);
    const auto most = static_cast<std::int64_t>(
        std::min(limit / slice_bytes, std::max<std::size_t>(sign_limit / sign_bytes, CLSDF_BRICK)));
    if (most >= grid.size[2]) return {grid};
    std::vector<Grid> slabs;
    for (std::int64_t begin = 0; begin < grid.size[2];) {
        std::int64_t end = std::min(grid.size[2], begin + std::max<std::int64_t>(most, 1));
        // The last multiple of a coarse brick's side on the lattice; of a brick's; or as many slices as fit.
        for (const std::int64_t side : {std::int64_t{CLSDF_COARSE}, std::int64_t{CLSDF_BRICK}}) {
            const std::int64_t over = ((grid.first[2] + end) % side + side) % side;
            if (end < grid.size[2] && end - over > begin) {
                end -= over;
                break;
            }
        }
        slabs.push_back(grid.part({0, 0, begin}, {grid.size[0], grid.size[1], end - begin}));
        begin = end;
    }
    return slabs;
}

/// Device memory for a host array: the array itself on a processor, whose memory it is.
class OutputBuffer {
public:
    OutputBuffer(const device::Context& context, device::BufferPool& pool, void* host, std::size_t bytes)
        : host_(host), bytes_(bytes), in_place_(context.capabilities().is_processor) {
        if (in_place_)
            buffer_ = cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, host);
        else
            lease_ = pool.lease(bytes, "samples of the field");
    }

    const cl::Buffer& operator*() const { return in_place_ ? buffer_ : *lease_; }

    /// Blocks until the host array holds the result.
    void fetch(const cl::CommandQueue& queue) const {
        if (in_place_) {
            void* mapped = queue.enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ, 0, bytes_);
            queue.enqueueUnmapMemObject(buffer_, mapped);
            queue.finish();
        } else {
            queue.enqueueReadBuffer(*lease_, CL_TRUE, 0, bytes_, host_);
        }
    }

private:
    void* host_;
    std::size_t bytes_;
    bool in_place_;
    cl::Buffer buffer_;
    device::BufferPool::Lease lease_;
};

void add(TransformStatistics& total, const TransformStatistics& slab) {
    total.triangles = slab.triangles;
    total.box_polyhedra = slab.box_polyhedra;
    total.saddle_vertices = slab.saddle_vertices;
    total.point_sites = slab.point_sites;
    total.closed_gaps = slab.closed_gaps;
    total.coarse_pairs += slab.coarse_pairs;
    total.coarse_bricks += slab.coarse_bricks;
    total.device_bytes = std::max(total.device_bytes, slab.device_bytes);
    total.brick_pairs += slab.brick_pairs;
    total.active_pieces += slab.active_pieces;
    total.slice_intersections += slab.slice_intersections;
    total.empty_intersections += slab.empty_intersections;
    total.lanes_evaluated += slab.lanes_evaluated;
    total.samples_covered += slab.samples_covered;
    total.band_samples += slab.band_samples;
    total.polyhedra_seconds = slab.polyhedra_seconds;
    total.lists_seconds += slab.lists_seconds;
    total.field_seconds += slab.field_seconds;
}

}  // namespace

void DistanceTransform::State::compute(Plan::State& plan, const HostOutputs& host, double begin, double end) {
    const Stopwatch watch;
    const device::Context& context = device.internal();
    device::guarded([&] {
        const std::size_t bytes = plan.grid.sample_count() * sizeof(float);
        const OutputBuffer distance(context, *pool, host.distance.data(), bytes);
        std::optional<OutputBuffer> triangle;
        if (plan.outputs.triangle) triangle.emplace(context, *pool, host.triangle.data(), bytes);
        std::function<void(double)> between;
        if (options.progress || options.stop.stop_possible())
            between = [&](double fraction) {
                throw_if_stopped();
                if (options.progress) options.progress(begin + (end - begin) * fraction);
            };
        try {
            plan.enqueue(context.queue(), *distance, triangle ? **triangle : cl::Buffer(), {}, between);
            distance.fetch(context.queue());
            if (triangle) triangle->fetch(context.queue());
            plan.read_counters();
        } catch (...) {
            // What is under way still writes to the caller's memory.
            clFinish(context.queue()());
            throw;
        }
    });
    plan.statistics.field_seconds = watch.seconds();
}

DistanceTransform::DistanceTransform(Device device, const Mesh& mesh, TransformOptions options)
    : state_(std::make_unique<State>(std::move(device), mesh, std::move(options))) {}
DistanceTransform::DistanceTransform(Device device, const MeshView& mesh, TransformOptions options)
    : state_(std::make_unique<State>(std::move(device), Mesh(mesh), std::move(options))) {}
DistanceTransform::DistanceTransform(DistanceTransform&&) noexcept = default;
DistanceTransform& DistanceTransform::operator=(DistanceTransform&&) noexcept = default;
DistanceTransform::~DistanceTransform() = default;

const Topology& DistanceTransform::topology() const {
    return state_->topology;
}
SignRule DistanceTransform::sign() const {
    return state_->sign;
}
const TransformStatistics& DistanceTransform::statistics() const {
    return state_->statistics;
}

void DistanceTransform::set_stop(std::stop_token stop) {
    state_->options.stop = std::move(stop);
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, const Outputs& outputs) {
    return Plan(state_->make_plan(state_->prepare(grid, band), grid, band, outputs));
}

void DistanceTransform::compute(const Grid& grid, const Band& band, const HostOutputs& host) {
    State& state = *state_;
    grid.validate();
    const std::size_t samples = grid.sample_count();
    const Outputs outputs{.triangle = !host.triangle.empty()};
    if (host.distance.size() != samples || (outputs.triangle && host.triangle.size() != samples))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the grid has {} samples, and the arrays given hold {} distances and {} triangles",
                                samples, host.distance.size(), host.triangle.size()));
    state.throw_if_stopped();
    const auto prepared = state.prepare(grid, band);
    state.throw_if_stopped();
    state.statistics = {};
    std::size_t done = 0;
    for (const Grid& slab : slabs_of(grid, state.device.internal().capabilities().largest_allocation)) {
        const auto plan = state.make_plan(prepared, slab, band, outputs);
        state.throw_if_stopped();
        const std::size_t count = slab.sample_count();
        const HostOutputs part{host.distance.subspan(done, count),
                               outputs.triangle ? host.triangle.subspan(done, count) : std::span<std::uint32_t>{}};
        const auto fraction = [&](std::size_t n) { return static_cast<double>(n) / static_cast<double>(samples); };
        state.compute(*plan, part, fraction(done), fraction(done + count));
        add(state.statistics, plan->statistics);
        done += count;
    }
    if (state.options.progress) state.options.progress(1.0);
}

Field DistanceTransform::operator()(const Grid& grid, const Band& band, const Outputs& outputs) {
    Field field;
    field.grid = grid;
    field.band = band;
    field.sign = state_->sign;
    field.mesh_name = state_->mesh.name();
    grid.validate();
    try {
        field.distance.resize(grid.sample_count());
        if (outputs.triangle) field.triangle.resize(grid.sample_count());
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("a field of {} x {} x {} samples does not fit the memory; compute parts of the grid",
                                grid.size[0], grid.size[1], grid.size[2]));
    }
    compute(grid, band, {field.distance, field.triangle});
    return field;
}

}  // namespace clsdf
