#include "plan/grid_plan.hpp"

#include "core/stopwatch.hpp"
#include "device/opencl.hpp"
#include "lattice/layout_of.hpp"
#include "launch/programs.hpp"
#include "plan/field_method.hpp"
#include "sign/sign_sweep.hpp"

namespace clsdf::engine {

GridPlan::GridPlan(const Workshop& workshop, Inputs inputs_in, const Job& job_in,
                   const std::function<void()>& between_launches, bool in_halves)
    : device(workshop.device), inputs(std::move(inputs_in)), job(job_in) {
    const Stopwatch watch;
    device::Context& context = workshop.context();
    const ShortLaunches launches(context, between_launches);
    Stopwatch sign_watch;
    const DeviceTools tools = workshop.tools();
    SignSweep sweep({tools, job.layout, inputs.sweep_mesh.get(), inputs.sweep_selection, workshop.sign, launches,
                     inputs.make_sign_bits});
    inputs.make_sign_bits = {};  // which holds the mesh of points
    statistics.sign_seconds = sign_watch.seconds();
    const PreparedMesh& records = *inputs.records;
    if (inputs.sites) finishing_.emplace(job.grid, job.band, job.layout, inputs.sites, inputs.is_inside_out);
    device::guarded([&] {
        const ScanInputs scan_inputs{.tools = tools,
                                     .layout = job.layout,
                                     .mesh = records,
                                     .launches = launches,
                                     .variant = {job.outputs != OutputSet{}, job.counts, has_long_bricks(job.grid)},
                                     .sign_bits = sweep.bits(),
                                     .selection = inputs.selection,
                                     .points = inputs.points,
                                     .finishing = finishing_ ? &*finishing_ : nullptr,
                                     .wanted = job.wanted,
                                     .in_halves = in_halves,
                                     .shares_short_lists = inputs.shares_short_lists};
        scan_ = workshop.method ? workshop.method->make_scan(scan_inputs) : make_brick_scan(scan_inputs);
        // To wait takes as long as a small kernel: the host waits for the sign and the lists together.
        sign_watch = Stopwatch();
        sign_bits_ = sweep.finish();
        statistics.sign_seconds += sign_watch.seconds();
        context.queue().flush();
    });

    statistics.triangles = records.triangle_count;
    statistics.polyhedra = records.polyhedron_count;
    statistics.box_polyhedra = records.boxes;
    statistics.saddle_vertices = records.saddle_vertices;
    statistics.point_sites = records.point_sites;
    statistics.method_counts = records.method_counts;
    statistics.lists_seconds = watch.seconds();
    statistics.device_bytes = records.device_bytes() + sign_bits_.bytes();
    scan_->describe(statistics);
}

void GridPlan::enqueue(CommandChain& chain, const OutputBuffers& buffers,
                       const std::function<void(double)>& between_launches) {
    lower_half_ = {};
    scan_->enqueue_begin(chain, buffers);
    if (!chain.has_begun())
        chain.then([](const auto& queue, auto* wait, auto* event) { queue.enqueueMarkerWithWaitList(wait, event); });
    before_launches_ = chain.last();
    const FieldScan::LowerHalf lower = scan_->lower_half();
    const auto complete_lower_half = [&] {
        if (lower.slices == 0 || buffers.listed() != nullptr) return;
        scan_->enqueue_lower_end(chain);
        lower_half_ = {job.grid.offset(0, 0, lower.slices), chain.last()};
    };
    if (lower.launches == 0) complete_lower_half();
    for (std::size_t launch = 0; launch < scan_->launch_count(); ++launch) {
        if (between_launches) {
            device::context_of(device).finish();
            between_launches(scan_->fraction_before(launch));
        }
        scan_->enqueue_launch(chain, launch);
        if (launch + 1 == lower.launches) complete_lower_half();
    }
    after_launches_ = chain.last();
    scan_->enqueue_end(chain);
    last_ = chain.last();
}

void GridPlan::read_back(const cl::CommandQueue& queue) {
    if (job.counts) scan_->read_counters(device::context_of(device), statistics);
    if ((queue.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_PROFILING_ENABLE) == 0) return;
    const auto seconds = [](const cl::Event& from, const cl::Event& to) {
        const cl_ulong begin = from.getProfilingInfo<CL_PROFILING_COMMAND_END>();
        return 1e-9 * static_cast<double>(to.getProfilingInfo<CL_PROFILING_COMMAND_END>() - begin);
    };
    statistics.bricks_seconds = seconds(before_launches_, after_launches_);
    statistics.fill_seconds = seconds(after_launches_, last_);
}

}  // namespace clsdf::engine
