#include "papers/scans.hpp"

#include "core/parallel.hpp"
#include "lattice/layout_of.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "kernel_sources.hpp"

namespace clsdf::papers {

namespace {

using engine::CommandChain;

// Memory of the minima of slices that are computed together, two numbers each; a layer of bricks may exceed it.
constexpr std::size_t chunk_bytes = std::size_t{64} << 20;
// A launch ends within a fifth of a second, if a core takes at most 6 nanoseconds a distance.
constexpr double distances_per_core_and_launch = 3e7;
constexpr double distances_per_launch = 1e9;  // a small GPU computes ten times as many in a second
constexpr std::size_t brick_samples = CLSDF_BRICK * CLSDF_BRICK * CLSDF_BRICK;

std::size_t rows_of_item(KernelBody body) {
    return body == KernelBody::by_vector ? CLSDF_BRICK * CLSDF_BRICK : 1;
}

device::ProgramSource finish_source(const engine::ProgramSources& programs, const engine::BrickVariant& variant) {
    return slices_source(programs, {variant, false});
}

cl::Program program_of(device::Context& context, const device::ProgramSource& source,
                       const device::BuildWatch& watch = {}) {
    return context.program(source, watch);
}

/// Layers of bricks by z that are computed together, then all their samples, some triangles at a time.
class BruteForceScan final : public engine::FieldScan {
public:
    explicit BruteForceScan(const engine::ScanInputs& inputs)
        : layout_(inputs.layout),
          variant_(inputs.variant),
          record_count_(inputs.mesh.record_count),
          rows_of_item_(rows_of_item(inputs.tools.programs.body)),
          kernel_(inputs.tools.context.kernels(),
                  program_of(inputs.tools.context, brute_force_source(inputs.tools.programs, variant_)), "brute_force"),
          finish_kernel_(inputs.tools.context.kernels(),
                         program_of(inputs.tools.context, finish_source(inputs.tools.programs, variant_)),
                         "slices_finish") {
        divide(inputs.tools.context, inputs.tools.programs);
        const std::size_t samples = static_cast<std::size_t>(chunk_layers_) * CLSDF_BRICK * samples_of_slice(layout_);
        squares_ = inputs.tools.pool->lease(samples * sizeof(cl_uint), "least distances");
        if (variant_.nearest) triangles_ = inputs.tools.pool->lease(samples * sizeof(cl_uint), "nearest triangles");
        const cl::Buffer& triangles = variant_.nearest ? *triangles_ : *squares_;
        kernel_.setArg(brute_layout, layout_);
        kernel_.setArg(brute_polyhedra, *inputs.mesh.polyhedra);
        kernel_.setArg(brute_squares, *squares_);
        kernel_.setArg(brute_triangles, triangles);
        finish_kernel_.setArg(finish_layout, layout_);
        finish_kernel_.setArg(finish_squares, *squares_);
        finish_kernel_.setArg(finish_triangles, triangles);
        finish_kernel_.setArg(finish_pass, cl_int{0});
        finish_kernel_.setArg(finish_sign_bits, inputs.sign_bits);
        if (variant_.count)
            band_samples_ =
                inputs.tools.pool->lease(static_cast<std::size_t>(layout_.size[2]) * sizeof(cl_uint), "counters");
    }

    std::size_t launch_count() const override { return slice_chunk_count() * launches_of_chunk(); }
    double fraction_before(std::size_t launch) const override {
        return static_cast<double>(launch) / static_cast<double>(launch_count());
    }

    void enqueue_begin(CommandChain& chain, const engine::OutputBuffers& outputs) override {
        cl_uint argument = finish_outputs;
        finish_kernel_.setArg(argument++, outputs[Output::distance]);
        if (variant_.nearest) finish_kernel_.setArg(argument++, outputs[Output::triangle]);
        if (variant_.count) finish_kernel_.setArg(argument++, *band_samples_);
        chain.then_fill(*band_samples_, band_samples_.bytes());
    }

    void enqueue_launch(CommandChain& chain, std::size_t number) override {
        const std::size_t chunk = number / launches_of_chunk(), of_chunk = number % launches_of_chunk();
        const std::int32_t first_layer = static_cast<std::int32_t>(chunk) * chunk_layers_;
        const std::int32_t end_layer = std::min(first_layer + chunk_layers_, layout_.bricks[2]);
        const std::int32_t first_slice =
            std::max(layout_.first[2], (layout_.brick_first[2] + first_layer) * CLSDF_BRICK);
        const std::int32_t end_slice =
            std::min(layout_.first[2] + layout_.size[2], (layout_.brick_first[2] + end_layer) * CLSDF_BRICK);
        if (of_chunk == 0) fill(chain, static_cast<std::size_t>(end_slice - first_slice) * samples_of_slice(layout_));
        const std::size_t first_brick =
            static_cast<std::size_t>(first_layer) * bricks_of_layer() + of_chunk % brick_parts_ * bricks_at_once_;
        const std::size_t end_brick =
            std::min(first_brick + bricks_at_once_, static_cast<std::size_t>(end_layer) * bricks_of_layer());
        const std::size_t first_record = of_chunk / brick_parts_ * records_at_once_;
        if (first_brick < end_brick) {
            kernel_.setArg(brute_first_slice, first_slice);
            kernel_.setArg(brute_first_brick, static_cast<cl_uint>(first_brick));
            kernel_.setArg(brute_end_brick, static_cast<cl_uint>(end_brick));
            kernel_.setArg(brute_first_record, static_cast<cl_uint>(first_record));
            kernel_.setArg(brute_end_record,
                           static_cast<cl_uint>(std::min(first_record + records_at_once_, record_count_)));
            const std::size_t items = (end_brick - first_brick) * (CLSDF_BRICK * CLSDF_BRICK / rows_of_item_);
            const std::size_t group = rows_of_item_ == 1 ? engine::common_group : 1;
            chain.then_launch(kernel_, {items, group});
        }
        if (of_chunk + 1 == launches_of_chunk()) finish(chain, first_slice, end_slice);
    }

    void enqueue_end(CommandChain&) override {}

    void describe(CallStatistics& statistics) const override {
        for (const device::BufferPool::Lease* lease : {&squares_, &triangles_, &band_samples_})
            statistics.device_bytes += lease->bytes();
    }

    void read_counters(const device::Context& context, CallStatistics& statistics) const override {
        if (!variant_.count) return;
        statistics.lanes_evaluated = statistics.samples_covered =
            bricks_of_layer() * static_cast<std::size_t>(layout_.bricks[2]) * brick_samples * record_count_;
        statistics.band_samples = sum_of(context, band_samples_, static_cast<std::size_t>(layout_.size[2]));
    }

private:
    enum BruteForceArgument : cl_uint {
        brute_layout,
        brute_first_slice,
        brute_first_brick,
        brute_end_brick,
        brute_first_record,
        brute_end_record,
        brute_polyhedra,
        brute_squares,
        brute_triangles
    };
    enum FinishArgument : cl_uint {
        finish_layout,
        finish_first_slice,
        finish_end_slice,
        finish_squares,
        finish_triangles,
        finish_pass,
        finish_sign_bits,
        finish_outputs
    };

    std::size_t bricks_of_layer() const {
        return static_cast<std::size_t>(layout_.bricks[0]) * static_cast<std::size_t>(layout_.bricks[1]);
    }
    std::size_t slice_chunk_count() const {
        return chunk_count(static_cast<std::size_t>(layout_.bricks[2]), chunk_layers());
    }
    std::size_t chunk_layers() const { return static_cast<std::size_t>(chunk_layers_); }
    std::size_t launches_of_chunk() const { return brick_parts_ * record_parts_; }

    void divide(const device::Context& context, const engine::Programs& programs) {
        const device::Context::Capabilities& device = context.capabilities();
        const std::size_t bytes = std::min(chunk_bytes, device.largest_allocation);
        const std::size_t layer_bytes = 2 * sizeof(cl_uint) * CLSDF_BRICK * samples_of_slice(layout_);
        chunk_layers_ = static_cast<std::int32_t>(
            std::clamp<std::size_t>(bytes / layer_bytes, 1, static_cast<std::size_t>(layout_.bricks[2])));
        const double limit = programs.body == KernelBody::by_vector
                                 ? distances_per_core_and_launch * device.compute_units
                                 : distances_per_launch;
        const std::size_t bricks = chunk_layers() * bricks_of_layer();
        const auto at_once = static_cast<std::size_t>(limit / brick_samples);  // (brick, record)
        // With fewer records, loading and storing minima would cost more than the distances.
        constexpr std::size_t fewest_records = 256;
        bricks_at_once_ = std::clamp<std::size_t>(at_once / std::min(fewest_records, record_count_), 1, bricks);
        records_at_once_ = std::clamp<std::size_t>(at_once / bricks_at_once_, 1, record_count_);
        brick_parts_ = chunk_count(bricks, bricks_at_once_);
        record_parts_ = chunk_count(record_count_, records_at_once_);
    }

    void fill(CommandChain& chain, std::size_t samples) {
        const auto fill_with_none = [&](const device::BufferPool::Lease& buffer) {
            chain.then([&](auto& queue, auto* wait, auto* event) {
                queue.enqueueFillBuffer(*buffer, no_key, 0, samples * sizeof(cl_uint), wait, event);
            });
        };
        fill_with_none(squares_);
        if (variant_.nearest) fill_with_none(triangles_);
    }

    void finish(CommandChain& chain, std::int32_t first_slice, std::int32_t end_slice) {
        finish_kernel_.setArg(finish_first_slice, first_slice);
        finish_kernel_.setArg(finish_end_slice, end_slice);
        enqueue_finish(chain, finish_kernel_, layout_, static_cast<std::size_t>(end_slice - first_slice));
    }

    Layout layout_;
    engine::BrickVariant variant_;
    std::size_t record_count_;
    std::size_t rows_of_item_;
    std::int32_t chunk_layers_ = 1;  ///< of bricks, whose minima are in memory together
    std::size_t bricks_at_once_ = 1, records_at_once_ = 1;
    std::size_t brick_parts_ = 1, record_parts_ = 1;
    device::LentKernel kernel_;
    device::LentKernel finish_kernel_;
    device::BufferPool::Lease squares_;
    device::BufferPool::Lease triangles_;
    device::BufferPool::Lease band_samples_;
};

class BruteForce final : public FieldMethod {
public:
    void check_outputs(OutputSet outputs) const override { check_distance_and_triangle(outputs, "by brute force"); }

    std::shared_ptr<const engine::PreparedMesh> prepare(engine::KeptMesh& kept_mesh,
                                                        const engine::Job& job) const override {
        auto prepared = std::make_shared<engine::PreparedMesh>();
        const UninitializedVector<Polyhedron> records = face_records(kept_mesh, job.lattice);
        prepared->triangle_count = kept_mesh.mesh().triangles().size();
        prepared->record_count = prepared->polyhedron_count = records.size();
        prepared->polyhedra =
            upload(kept_mesh, records.data(), records.size() * sizeof(Polyhedron), "triangles in their frames");
        return prepared;
    }

    std::unique_ptr<engine::FieldScan> make_scan(const engine::ScanInputs& inputs) const override {
        return std::make_unique<BruteForceScan>(inputs);
    }

    std::shared_ptr<const FieldMethod> tested_as(const device::Context&, const Layout&,
                                                 const engine::BrickVariant&) const override {
        return make_brute_force();
    }

    std::string name() const override { return "brute force"; }

    std::vector<cl::Program> build(device::Context& context, const engine::Programs& programs,
                                   const engine::BrickVariant& variant,
                                   const device::BuildWatch& watch) const override {
        return {program_of(context, brute_force_source(programs, variant), watch),
                program_of(context, finish_source(programs, variant), watch)};
    }

    std::size_t step_count() const override { return 2; }
};

}  // namespace

device::ProgramSource brute_force_source(const engine::ProgramSources& programs, const engine::BrickVariant& variant) {
    const std::size_t lanes = std::min<std::size_t>(programs.lanes, CLSDF_BRICK);
    return {"brute_force.cl",
            fmt::format("{} -DITEM_ROWS={}{}", programs.common_options(lanes), rows_of_item(programs.body),
                        engine::options_of(variant)),
            kernels::files};
}

std::shared_ptr<const FieldMethod> make_brute_force() {
    return std::make_shared<BruteForce>();
}

}  // namespace clsdf::papers
