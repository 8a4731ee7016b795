#include "transform/plan_state.hpp"

#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/sign_sweep.hpp"
#include "transform/stopwatch.hpp"

#include <algorithm>

namespace clsdf {

namespace {

// A launch ends within a fifth of a second, so that a desktop stays alive and a computation can be stopped. Measured on
// one core: a (polyhedron, coarse brick) pair costs about a microsecond; ten times that where all of its bricks are
// touched.
constexpr double pairs_per_core_and_launch = 40000;

enum BrickArgument : cl_uint {
    arg_layout,
    arg_launch,
    arg_end,
    arg_turns,
    arg_order,
    arg_starts,
    arg_parts,
    arg_entries,
    arg_caps,
    arg_polyhedra,
    arg_sign_bits,
    arg_computed,
    arg_masks,
    arg_list,
    arg_list_length,
    arg_distance,
    arg_first_optional
};

}  // namespace

Plan::State::State(Device device_in, std::shared_ptr<device::BufferPool> pool_in, const transform::Programs& programs,
                   std::shared_ptr<const transform::PreparedMesh> prepared_in, const Mesh& mesh, const Grid& grid_in,
                   const Band& band_in, SignRule sign_in, const Outputs& outputs_in, bool count)
    : device(std::move(device_in)),
      pool(std::move(pool_in)),
      prepared(std::move(prepared_in)),
      grid(grid_in),
      band(band_in),
      sign(sign_in),
      outputs(outputs_in),
      layout_(transform::layout_of(grid, band, sign)) {
    const transform::Stopwatch watch;
    device::Context& context = device.internal();
    lists_ = transform::make_coarse_lists(context, programs, pool, layout_, *prepared->polyhedra,
                                          prepared->polyhedron_count);
    sign_bits_ = transform::sweep_signs(context, programs, pool, layout_, grid, mesh, sign, *prepared->triangles);

    longest_list_ = lists_.lengths.empty() ? 0 : lists_.lengths.front();
    work_items_ = context.capabilities().compute_units;
    size_launches();
    const std::size_t launch_count = launches_.size();
    computed_ = pool->lease(transform::brick_count(layout_), "marks of the computed bricks");
    order_ = pool->lease(lists_.order.size() * sizeof(cl_uint), "order of the coarse bricks");
    first_turns_ = pool->lease(launch_count * sizeof(cl_uint), "queues of the launches");
    turns_ = pool->lease(launch_count * sizeof(cl_uint), "queues of the launches");
    masks_ = pool->lease(work_items_ * longest_list_ * sizeof(cl_ulong), "scratch masks");
    list_ = pool->lease(work_items_ * longest_list_ * sizeof(cl_uint), "scratch lists");
    if (count) counters_ = pool->lease(work_items_ * CLSDF_COUNTERS * sizeof(cl_ulong), "counters");
    device::guarded([&] {
        bricks_kernel_ = cl::Kernel(programs.bricks(context, outputs.triangle, count), "bricks");
        fill_kernel_ = cl::Kernel(programs.fill, "fill_empty_bricks");
        std::vector<cl_uint> first_turns;
        for (const Launch& launch : launches_) first_turns.push_back(launch.begin);
        const cl::CommandQueue& queue = context.queue();
        if (!launches_.empty()) {
            queue.enqueueWriteBuffer(*order_, CL_TRUE, 0, lists_.order.size() * sizeof(cl_uint), lists_.order.data());
            queue.enqueueWriteBuffer(*first_turns_, CL_TRUE, 0, launch_count * sizeof(cl_uint), first_turns.data());
        }
        set_arguments();
        warm_up();
    });

    statistics.triangles = mesh.triangles().size();
    statistics.box_polyhedra = prepared->boxes;
    statistics.saddle_vertices = prepared->saddle_vertices;
    statistics.point_sites = prepared->point_sites;
    statistics.coarse_pairs = lists_.pairs;
    statistics.coarse_bricks = lists_.order.size();
    statistics.polyhedra_seconds = prepared->seconds;
    statistics.lists_seconds = watch.seconds();
    const std::initializer_list<const device::BufferPool::Lease*> leases{&prepared->polyhedra,
                                                                         &prepared->triangles,
                                                                         &lists_.caps,
                                                                         &lists_.starts,
                                                                         &lists_.entries,
                                                                         &sign_bits_,
                                                                         &computed_,
                                                                         &order_,
                                                                         &first_turns_,
                                                                         &turns_,
                                                                         &masks_,
                                                                         &list_,
                                                                         &counters_};
    for (const device::BufferPool::Lease* lease : leases) statistics.device_bytes += lease->bytes();
}

void Plan::State::size_launches() {
    const double limit = pairs_per_core_and_launch * static_cast<double>(work_items_);
    double before = 0;
    double pairs = 0;
    cl_uint begin = 0;
    const auto count = static_cast<cl_uint>(lists_.order.size());
    for (cl_uint i = 0; i < count; ++i) {
        pairs += lists_.lengths[i];
        if (pairs < limit && i + 1 < count) continue;
        launches_.push_back({begin, i + 1, before / static_cast<double>(std::max<std::size_t>(lists_.pairs, 1))});
        before += pairs;
        pairs = 0;
        begin = i + 1;
    }
}

void Plan::State::set_arguments() {
    bricks_kernel_.setArg(arg_layout, layout_);
    bricks_kernel_.setArg(arg_turns, *turns_);
    bricks_kernel_.setArg(arg_order, *order_);
    bricks_kernel_.setArg(arg_starts, *lists_.starts);
    bricks_kernel_.setArg(arg_parts, static_cast<cl_uint>(lists_.parts));
    bricks_kernel_.setArg(arg_entries, *lists_.entries);
    bricks_kernel_.setArg(arg_caps, *lists_.caps);
    bricks_kernel_.setArg(arg_polyhedra, *prepared->polyhedra);
    bricks_kernel_.setArg(arg_sign_bits, *sign_bits_);
    bricks_kernel_.setArg(arg_computed, *computed_);
    bricks_kernel_.setArg(arg_masks, *masks_);
    bricks_kernel_.setArg(arg_list, *list_);
    bricks_kernel_.setArg(arg_list_length, static_cast<cl_uint>(longest_list_));
    if (counters_.bytes() > 0)
        bricks_kernel_.setArg(outputs.triangle ? arg_first_optional + 1 : arg_first_optional, *counters_);
    fill_kernel_.setArg(0, layout_);
    fill_kernel_.setArg(1, *computed_);
    fill_kernel_.setArg(2, *sign_bits_);
}

void Plan::State::warm_up() {
    const cl::CommandQueue& queue = device.internal().queue();
    bricks_kernel_.setArg(arg_launch, cl_uint{0});
    bricks_kernel_.setArg(arg_end, cl_uint{0});
    bricks_kernel_.setArg(arg_distance, *computed_);  // not written to
    if (outputs.triangle) bricks_kernel_.setArg(arg_first_optional, *computed_);
    queue.enqueueFillBuffer(*turns_, cl_uint{0}, 0, sizeof(cl_uint));
    queue.enqueueNDRangeKernel(bricks_kernel_, cl::NullRange, cl::NDRange(work_items_), cl::NDRange(1));
    queue.finish();
}

cl::Event Plan::State::enqueue(const cl::CommandQueue& queue, const cl::Buffer& distance, const cl::Buffer& triangle,
                               const std::vector<cl::Event>& wait_list,
                               const std::function<void(double)>& between_launches) {
    // The caller's queue may be out of order: each command waits for the one before.
    std::vector<cl::Event> previous = wait_list;
    const auto then = [&](auto&& enqueue_command) {
        cl::Event event;
        enqueue_command(previous.empty() ? nullptr : &previous, &event);
        previous.assign(1, event);
    };
    then([&](auto* wait, auto* event) {
        queue.enqueueFillBuffer(*computed_, cl_uchar{0}, 0, transform::brick_count(layout_), wait, event);
    });
    if (counters_.bytes() > 0)
        then([&](auto* wait, auto* event) {
            queue.enqueueFillBuffer(*counters_, cl_ulong{0}, 0, work_items_ * CLSDF_COUNTERS * sizeof(cl_ulong), wait,
                                    event);
        });
    if (!launches_.empty())
        then([&](auto* wait, auto* event) {
            queue.enqueueCopyBuffer(*first_turns_, *turns_, 0, 0, launches_.size() * sizeof(cl_uint), wait, event);
        });
    bricks_kernel_.setArg(arg_distance, distance);
    if (outputs.triangle) bricks_kernel_.setArg(arg_first_optional, triangle);
    for (std::size_t i = 0; i < launches_.size(); ++i) {
        if (between_launches) {
            cl::Event::waitForEvents(previous);
            between_launches(launches_[i].fraction_before);
        }
        bricks_kernel_.setArg(arg_launch, static_cast<cl_uint>(i));
        bricks_kernel_.setArg(arg_end, launches_[i].end);
        then([&](auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(bricks_kernel_, cl::NullRange, cl::NDRange(work_items_), cl::NDRange(1), wait,
                                       event);
        });
    }
    fill_kernel_.setArg(3, distance);
    fill_kernel_.setArg(4, outputs.triangle ? triangle : distance);
    fill_kernel_.setArg(5, cl_int{outputs.triangle ? 1 : 0});
    const cl::NDRange rows(static_cast<std::size_t>(layout_.size[1]), static_cast<std::size_t>(layout_.size[2]));
    then([&](auto* wait, auto* event) {
        queue.enqueueNDRangeKernel(fill_kernel_, cl::NullRange, rows, cl::NullRange, wait, event);
    });
    queue.flush();
    return previous.front();
}

void Plan::State::read_counters() {
    if (counters_.bytes() == 0) return;
    std::vector<cl_ulong> counters(work_items_ * CLSDF_COUNTERS);
    device.internal().queue().enqueueReadBuffer(*counters_, CL_TRUE, 0, counters.size() * sizeof(cl_ulong),
                                                counters.data());
    const auto sum = [&](std::size_t counter) {
        std::size_t total = 0;
        for (std::size_t item = 0; item < work_items_; ++item) total += counters[item * CLSDF_COUNTERS + counter];
        return total;
    };
    statistics.brick_pairs = sum(CLSDF_COUNT_BRICK_PAIRS);
    statistics.lanes_evaluated = sum(CLSDF_COUNT_LANES);
    statistics.samples_covered = sum(CLSDF_COUNT_COVERED);
    statistics.band_samples = sum(CLSDF_COUNT_BAND);
}

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
    return device::guarded([&] {
        std::vector<cl::Event> events;
        for (cl_event event : wait_list) events.emplace_back(event, true);
        const cl::CommandQueue target =
            queue != nullptr ? cl::CommandQueue(queue, true) : state_->device.internal().queue();
        const cl::Buffer distance(outputs.distance, true);
        const cl::Buffer triangle = outputs.triangle != nullptr ? cl::Buffer(outputs.triangle, true) : cl::Buffer();
        const cl::Event last = state_->enqueue(target, distance, triangle, events, {});
        clRetainEvent(last());
        return last();
    });
}

}  // namespace clsdf
