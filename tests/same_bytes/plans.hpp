#pragma once

#include "same_bytes/subject.hpp"

#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::test {

/// Plans of all kinds, which are made once, updated after each move of their transform, and run twice each time.
class Plans {
public:
    explicit Plans(const Subject& subject)
        : s_(subject),
          points_(buffer_of(subject.points)),
          points_as_floats_(buffer_of(subject.points_as_floats)),
          first_(first_of_blocks(subject.grid)),
          boxes_(subject, on_device, 12),
          strided_boxes_(subject, on_device_strided, 12),
          other_boxes_(subject, on_device, 12),
          blocks_(Output::distance | Output::triangle, size_of_blocks(first_), on_device_in_doubles) {}

    void prepare(const DistanceTransform& transform) {
        if (grid_) {
            grid_->update(transform);
            requests_->update(transform);
            strided_->update(transform);
            block_set_->update(transform);
            sparse_->update(transform);
            at_points_->update(transform);
            return;
        }
        const SparseCounts counts = transform.count_sparse(s_.grid, s_.band);
        room_ = {2 * counts.bricks + 8, 2 * counts.runs + 8};  // moves need more
        grid_ = transform.plan(s_.grid, s_.band, all_outputs());
        requests_ = transform.plan(boxes_.requests);
        strided_ = transform.plan(strided_boxes_.requests);
        block_set_ = transform.plan(BlockSet{s_.grid, s_.band, {4, 4, 4}, first_, blocks_.targets()});
        sparse_ = transform.plan_sparse({s_.grid, s_.band, sparse_outputs}, room_);
        at_points_ = transform.plan_points(many_points, 0.1 * s_.side, all_outputs());
    }

    void run(const std::string& name) {
        print_case(name + ", plan", [&](Line& line) {
            const Results first(all_outputs(), s_.grid.size, on_device), second(all_outputs(), s_.grid.size, on_device);
            await([&](cl_event* done) { grid_->enqueue(nullptr, first.targets(), {}, done); });
            await([&](cl_event* done) { grid_->enqueue(nullptr, second.targets(), {}, done); });
            first.report(line);
            second.report(line);
        });
        print_case(name + ", plan of requests", [&](Line& line) {
            await([&](cl_event* done) { requests_->enqueue(nullptr, {}, done); });
            boxes_.report(line);
            std::vector<OutputTargets> others;
            for (const Request& request : other_boxes_.requests) others.push_back(request.targets);
            await([&](cl_event* done) { requests_->enqueue(nullptr, others, {}, done); });
            other_boxes_.report(line);
        });
        print_case(name + ", plan of requests, strides", [&](Line& line) {
            await([&](cl_event* done) { strided_->enqueue(nullptr, {}, done); });
            strided_boxes_.report(line);
        });
        print_case(name + ", plan of blocks", [&](Line& line) {
            for (int times = 0; times < 2; ++times) {
                await([&](cl_event* done) { block_set_->enqueue(nullptr, {}, done); });
                blocks_.report(line);
            }
        });
        print_case(name + ", sparse plan", [&](Line& line) {
            for (int times = 0; times < 2; ++times) run_sparse(line);
        });
        print_case(name + ", plan of points", [&](Line& line) {
            run_points(line, InputArray(points_.memory(), ElementType::float64, some_points), on_device);
            run_points(line, InputArray(points_as_floats_.memory(), ElementType::float32, many_points),
                       on_device_strided);
        });
    }

private:
    template <class Enqueue>
    static void await(const Enqueue& enqueue) {
        cl_event done = nullptr;
        enqueue(&done);
        require(::clWaitForEvents(1, &done), "clWaitForEvents");
        ::clReleaseEvent(done);
    }

    template <typename Value>
    static void add(Line& line, const std::string& name, const Buffer& buffer, std::size_t count) {
        const std::vector<std::byte> bytes = buffer.read();
        line.add(name, std::span(bytes).first(count * sizeof(Value)));
    }

    void run_sparse(Line& line) {
        const Buffer counts = buffer_of(std::vector<DeviceSparseCounts>(1)),
                     bricks = buffer_of(std::vector<Index3>(room_.bricks)),
                     inside = buffer_of(std::vector<BrickRun>(room_.runs));
        const Results values(sparse_outputs, room_.bricks * brick_samples, on_device);
        await([&](cl_event* done) {
            sparse_->enqueue(nullptr, {{counts.memory()}, {bricks.memory()}, {inside.memory()}, values.targets()}, {},
                             done);
        });
        DeviceSparseCounts found;
        std::memcpy(&found, counts.read().data(), sizeof(found));
        add<DeviceSparseCounts>(line, "counts", counts, 1);
        if (found.is_complete == 0) return;
        add<Index3>(line, "bricks", bricks, found.bricks);
        add<BrickRun>(line, "inside", inside, found.runs);
        values.report(line, found.bricks * brick_samples);
    }

    void run_points(Line& line, const InputArray& points, const Layout& layout) {
        const Results results(all_outputs(), points.count, layout);
        const Buffer status = buffer_of(std::vector<std::byte>(points.count, std::byte{0xA5}));
        await([&](cl_event* done) {
            at_points_->enqueue(nullptr, points, results.targets(), {}, done,
                                OutputArray(status.memory(), ElementType::uint8));
        });
        results.report(line);
        line.add("status", status.read());
    }

    const OutputSet sparse_outputs = Output::triangle | Output::gradient;
    const Subject& s_;
    const Buffer points_, points_as_floats_;
    const std::vector<Index3> first_;
    const Boxes boxes_, strided_boxes_, other_boxes_;
    const Results blocks_;
    SparseCounts room_;
    std::optional<Plan> grid_, requests_, strided_, block_set_;
    std::optional<SparsePlan> sparse_;
    std::optional<PointPlan> at_points_;
};

}  // namespace clsdf::test
