#include "transform/plan_state.hpp"

#include "core/stopwatch.hpp"
#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/sign_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf {

namespace {

constexpr double seconds_per_filled_sample = 1e-9;  // of a core, rounded up

}  // namespace

Plan::State::State(Device device_in, std::shared_ptr<device::BufferPool> pool_in, const transform::Programs& programs,
                   std::shared_ptr<const transform::PreparedMesh> prepared_in, const Mesh& mesh, const Grid& grid_in,
                   const Band& band_in, SignRule sign_in, const Outputs& outputs_in, bool count,
                   const std::function<void()>& between_launches)
    : device(std::move(device_in)),
      pool(std::move(pool_in)),
      prepared(std::move(prepared_in)),
      grid(grid_in),
      band(band_in),
      sign(sign_in),
      outputs(outputs_in),
      layout_(transform::layout_of(grid, band, sign)) {
    const Stopwatch watch;
    device::Context& context = device.internal();
    const transform::ShortLaunches launches(context, between_launches);
    lists_ = transform::make_coarse_lists(context, programs, pool, layout_, *prepared->polyhedra,
                                          prepared->polyhedron_count, launches);
    sign_bits_ =
        transform::sweep_signs(context, programs, pool, layout_, grid, mesh, sign, *prepared->triangles, launches);

    computed_ = pool->lease(transform::brick_count(layout_), "marks of the computed bricks");
    device::guarded([&] {
        const transform::BrickInputs inputs{layout_, *prepared, lists_, *sign_bits_, *computed_};
        const auto make =
            programs.body == KernelBody::by_group ? transform::make_bricks_by_group : transform::make_bricks_by_vector;
        bricks_ = make(context, programs, pool, inputs, {outputs.triangle, count, transform::has_long_bricks(grid)});
        fill_kernel_ = cl::Kernel(programs.fill, "fill_empty_bricks");
        fill_kernel_.setArg(0, layout_);
        fill_kernel_.setArg(1, *computed_);
        fill_kernel_.setArg(2, *sign_bits_);
        const double slice = static_cast<double>(grid.size[0]) * static_cast<double>(grid.size[1]);
        slices_per_fill_ = launches.most(seconds_per_filled_sample * slice);
        context.queue().finish();  // computations may run on another queue
    });

    statistics.triangles = mesh.triangles().size();
    statistics.box_polyhedra = prepared->boxes;
    statistics.saddle_vertices = prepared->saddle_vertices;
    statistics.point_sites = prepared->point_sites;
    statistics.coarse_pairs = lists_.pairs;
    statistics.coarse_bricks = lists_.order.size();
    statistics.polyhedra_seconds = prepared->seconds;
    statistics.lists_seconds = watch.seconds();
    statistics.device_bytes = bricks_->device_bytes();
    for (const device::BufferPool::Lease* lease : std::initializer_list<const device::BufferPool::Lease*>{
             &prepared->polyhedra, &prepared->triangles, &lists_.caps, &lists_.starts, &lists_.entries, &sign_bits_,
             &computed_})
        statistics.device_bytes += lease->bytes();
}

Plan::State::~State() {
    if (last_() != nullptr) clWaitForEvents(1, &last_());
}

cl::Event Plan::State::enqueue(const cl::CommandQueue& queue, const cl::Buffer& distance, const cl::Buffer& triangle,
                               const std::vector<cl::Event>& wait_list,
                               const std::function<void(double)>& between_launches) {
    transform::CommandChain chain(queue, wait_list);
    chain.then_fill(*computed_, transform::brick_count(layout_));
    bricks_->enqueue_reset(chain, distance, triangle);
    for (std::size_t launch = 0; launch < bricks_->launch_count(); ++launch) {
        if (between_launches) {
            chain.wait();
            between_launches(bricks_->fraction_before(launch));
        }
        bricks_->enqueue_launch(chain, launch);
    }
    fill_kernel_.setArg(3, distance);
    fill_kernel_.setArg(4, outputs.triangle ? triangle : distance);
    fill_kernel_.setArg(5, cl_int{outputs.triangle ? 1 : 0});
    const auto rows = static_cast<std::size_t>(layout_.size[1]), slices = static_cast<std::size_t>(layout_.size[2]);
    for (std::size_t slice = 0; slice < slices; slice += slices_per_fill_) {
        fill_kernel_.setArg(6, static_cast<cl_int>(slice));
        const cl::NDRange range(rows, std::min(slices_per_fill_, slices - slice));
        chain.then([&](auto& target, auto* wait, auto* event) {
            target.enqueueNDRangeKernel(fill_kernel_, cl::NullRange, range, cl::NullRange, wait, event);
        });
    }
    last_ = chain.last();
    queue.flush();
    return last_;
}

void Plan::State::read_counters() {
    const std::vector<std::size_t> counters = bricks_->read_counters(device.internal().queue());
    if (counters.empty()) return;
    statistics.brick_pairs = counters[CLSDF_COUNT_BRICK_PAIRS];
    statistics.lanes_evaluated = counters[CLSDF_COUNT_LANES];
    statistics.samples_covered = counters[CLSDF_COUNT_COVERED];
    statistics.band_samples = counters[CLSDF_COUNT_BAND];
}

namespace {

/// Memory of the caller's that is too small, or of another context, would be written past, or fail later and less
/// clearly.
void check_memory(const char* name, cl_mem memory, cl_context context, std::size_t samples) {
    const cl::Memory object(memory, true);
    if (object.getInfo<CL_MEM_CONTEXT>()() != context)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("DeviceOutputs::{} belongs to another OpenCL context than the plan's device", name));
    const std::size_t bytes = object.getInfo<CL_MEM_SIZE>();
    if (bytes / sizeof(float) < samples)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("DeviceOutputs::{} holds {} bytes, and the grid's {} samples need {}", name, bytes,
                                samples, samples * sizeof(float)));
}

}  // namespace

Plan::Plan(std::unique_ptr<State> state) : state_(std::move(state)) {}
Plan::Plan(Plan&&) noexcept = default;
Plan& Plan::operator=(Plan&&) noexcept = default;
Plan::~Plan() = default;

const Grid& Plan::grid() const {
    return state_->grid;
}
const Band& Plan::band() const {
    return state_->band;
}
SignRule Plan::sign() const {
    return state_->sign;
}
const TransformStatistics& Plan::statistics() const {
    return state_->statistics;
}

cl_event Plan::enqueue(cl_command_queue queue, const DeviceOutputs& outputs, std::span<const cl_event> wait_list) {
    if (outputs.distance == nullptr)
        throw Error(ErrorCode::invalid_argument,
                    "Plan::enqueue needs memory for the distance; DeviceOutputs::distance is null");
    if (state_->outputs.triangle && outputs.triangle == nullptr)
        throw Error(ErrorCode::invalid_argument,
                    "the plan was made with Outputs::triangle, and DeviceOutputs::triangle is null; give it memory, or "
                    "plan without");
    if (!state_->outputs.triangle && outputs.triangle != nullptr)
        throw Error(
            ErrorCode::invalid_argument,
            "DeviceOutputs::triangle is given, and the plan was made without; plan with Outputs{.triangle = true}");
    return device::guarded([&] {
        const std::size_t samples = state_->grid.sample_count();
        check_memory("distance", outputs.distance, state_->device.context(), samples);
        if (outputs.triangle != nullptr) check_memory("triangle", outputs.triangle, state_->device.context(), samples);
        std::vector<cl::Event> events;
        for (cl_event event : wait_list) events.emplace_back(event, true);
        const cl::CommandQueue target =
            queue != nullptr ? cl::CommandQueue(queue, true) : state_->device.internal().callers_queue();
        const cl::Buffer distance(outputs.distance, true);
        const cl::Buffer triangle = outputs.triangle != nullptr ? cl::Buffer(outputs.triangle, true) : cl::Buffer();
        const cl::Event last = state_->enqueue(target, distance, triangle, events, {});
        clRetainEvent(last());
        return last();
    });
}

}  // namespace clsdf
