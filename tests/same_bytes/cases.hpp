#pragma once

#include "same_bytes/subject.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The calls of a DistanceTransform, each of which prints a line.
namespace clsdf::test {

/// The cases of one transform, whose names begin with that of the mesh and how it was made.
class Cases {
public:
    Cases(const Subject& subject, const DistanceTransform& transform, std::string name)
        : s_(subject), t_(transform), name_(std::move(name)) {}

    /// What is asked of every transform, and after every move.
    void short_list() const {
        run("field", [&](Line& line) {
            const Field field = t_.compute(s_.grid, s_.band, all_outputs());
            for (const OutputInfo& info : output_table()) line.add(info.name, field.bytes(info.output));
        });
        compute("distance", Output::distance, Band::symmetric(2.5 * s_.grid.voxel()), {});
        sparse("sparse", all_outputs());
        query("points", some_points, infinity, all_outputs(), {});
        query("a few points", few_points, 0.1 * s_.side, all_outputs(), {});
        classify();
        winding("winding", some_points, {});
    }

    void long_list() const {
        topology();
        short_list();

        compute("every sample", Output::distance, Band::full(), {});
        compute("two half widths", Output::distance | Output::triangle, {0, 0.1 * s_.side}, {});
        compute("inside alone", Output::distance | Output::site, {infinity, 0}, {});
        compute("signs", Output::distance, Band::signs_only(), {});
        compute("doubles", all_outputs(), s_.band, in_doubles);
        compute("strides", all_outputs(), s_.band, strided);
        compute("planes", all_outputs(), s_.band, planes);
        compute("device", all_outputs(), s_.band, on_device);
        compute("device, doubles", all_outputs(), s_.band, on_device_in_doubles);
        compute("device, strides", Output::distance | Output::gradient, s_.band, on_device_strided);
        for (const Output output :
             {Output::triangle, Output::site, Output::closest, Output::gradient, Output::barycentric, Output::offset})
            compute(std::string("one output ") + info_of(output).name, output, s_.band, {});

        for (const Layout& layout : {Layout{}, in_doubles, strided, on_device, on_device_strided}) requests(layout);
        for (const Layout& layout : {Layout{}, in_doubles, on_device}) blocks(layout);
        slabs();
        sparse_to_arrays();
        sparse_to_sink();
        sparse_requests();

        query("many points", many_points, 0.1 * s_.side, all_outputs(), {});
        query("many points, distance", many_points, infinity, Output::distance, {});
        query("points, doubles", some_points, infinity, all_outputs(), in_doubles);
        query("points, strides", some_points, infinity, all_outputs(), strided);
        query("points, device", some_points, 0.1 * s_.side, all_outputs(), on_device);
        query("many points, device", many_points, infinity, Output::distance | Output::gradient, on_device_strided);
        winding("winding, doubles", few_points, in_doubles);
        winding("winding, device", some_points, on_device);
        restricted();
    }

private:
    template <class Run>
    void run(const std::string& name, const Run& run) const {
        print_case(name_ + ", " + name, run);
    }

    void topology() const {
        run("topology", [&](Line& line) {
            const Topology& t = t_.topology();
            const std::vector<std::size_t> counts{t.closed,
                                                  t.balanced,
                                                  t.inside_out,
                                                  t.open_edges,
                                                  t.unbalanced_edges,
                                                  t.non_manifold_edges,
                                                  t.repeated_vertex_faces,
                                                  t.coincident_vertices,
                                                  t.unused_vertices,
                                                  t.boundary_edges,
                                                  t.joined_vertices,
                                                  t.duplicate_faces,
                                                  t.uncounted_faces,
                                                  t.reoriented_faces,
                                                  t.inner_wall_faces,
                                                  t.first_inner_wall_face,
                                                  t.parts,
                                                  t.inward_parts,
                                                  t.first_inward_face,
                                                  t.nested_parts,
                                                  t.first_nested_face,
                                                  t.tested_points,
                                                  t.doubtful_points,
                                                  t.inside_points,
                                                  t.unclear_parts,
                                                  t.first_unclear_face,
                                                  t.double_sided_faces,
                                                  t.doubled_cavity_faces,
                                                  t.first_doubled_cavity_face,
                                                  t.sheet_faces,
                                                  t.first_sheet_face,
                                                  t.enclosing_faces,
                                                  t.first_enclosing_face,
                                                  t.overlapping_parts,
                                                  t.first_overlapping_face};
            for (const std::size_t count : counts) line.add("count", count);
            line.add("open", t.first_open_edges);
            line.add("unbalanced", t.first_unbalanced_edges);
            line.add(name_of(t_.sign()), 1);
            const Box box = t_.box();
            line.add("box", std::vector<Vec3>{box.lower, box.upper});
        });
    }

    void compute(const std::string& name, OutputSet outputs, const Band& band, const Layout& layout) const {
        run(name, [&](Line& line) {
            const Results results(outputs, s_.grid.size, layout);
            t_.compute(s_.grid, band, results.targets());
            results.report(line);
        });
    }

    static std::string described(const Layout& layout) {
        return std::string(layout.on_device ? ", device" : "") + (layout.doubles ? ", doubles" : "") +
               (layout.order == Layout::strided ? ", strides" : "");
    }

    void requests(const Layout& layout) const {
        run("requests" + described(layout), [&](Line& line) {
            const Boxes boxes(s_, layout, 40);
            t_.compute(boxes.requests);
            boxes.report(line);
        });
    }

    void blocks(const Layout& layout) const {
        run("blocks" + described(layout), [&](Line& line) {
            const std::vector<Index3> first = first_of_blocks(s_.grid);
            const Results results(Output::distance | Output::gradient, size_of_blocks(first), layout);
            t_.compute(BlockSet{s_.grid, s_.band, {4, 4, 4}, first, results.targets()});
            results.report(line);
        });
    }

    /// All slabs together have the bytes of the whole, however they are divided.
    void slabs() const {
        run("slabs", [&](Line& line) {
            static const Device small_device = the_device().limited({.memory = std::size_t{8} << 20U});
            const DistanceTransform small(small_device, s_.mesh);
            const Grid fine = s_.grid.refined(2);
            std::array<Hash, 2> hashes;
            small.compute(fine, s_.band, Output::closest,
                          [&](const Grid&, const FieldSlab& values) {
                              hashes[0].add(values.bytes(Output::distance));
                              hashes[1].add(values.bytes(Output::closest));
                          },
                          {.sink_has_own_thread = true});
            line.add("distance", hashes[0]);
            line.add("closest", hashes[1]);
        });
    }

    static void report(Line& line, const SparseField& field) {
        line.add("bricks", field.bricks);
        line.add("inside", field.inside);
        for (const OutputInfo& info : output_table()) line.add(info.name, field.bytes(info.output));
    }

    void sparse(const std::string& name, OutputSet outputs) const {
        run(name, [&](Line& line) { report(line, t_.compute_sparse(s_.grid, s_.band, outputs)); });
    }

    void sparse_to_arrays() const {
        run("sparse to arrays", [&](Line& line) {
            SparseCounts counts = t_.count_sparse(s_.grid, s_.band);
            line.add("bricks", counts.bricks);
            line.add("runs", counts.runs);
            counts.bricks += 3;
            counts.runs += 2;
            std::vector<Index3> bricks(counts.bricks);
            std::vector<BrickRun> inside(counts.runs);
            const Results values(Output::site, counts.bricks * brick_samples);
            t_.compute_sparse(s_.grid, s_.band, {bricks, inside, values.targets()}, counts);
            line.add("bricks", bricks);
            line.add("inside", inside);
            values.report(line);
        });
    }

    void sparse_to_sink() const {
        run("sparse to a sink", [&](Line& line) {
            std::array<Hash, 4> hashes;
            t_.compute_sparse(s_.grid.refined(2), s_.band, Output::triangle, [&](const SparseSlab& slab) {
                hashes[0].add(std::as_bytes(slab.bricks));
                hashes[1].add(std::as_bytes(slab.inside));
                hashes[2].add(slab.values.bytes(Output::distance));
                hashes[3].add(slab.values.bytes(Output::triangle));
            });
            constexpr std::array names{"bricks", "inside", "distance", "triangle"};
            for (std::size_t k = 0; k < names.size(); ++k) line.add(names.at(k), hashes.at(k));
        });
    }

    void sparse_requests() const {
        run("sparse requests", [&](Line& line) {
            std::vector<SparseRequest> requests;
            for (const Request& box : Boxes(s_, {}, 40).requests)
                requests.push_back({box.grid.grown(4), s_.band, Output::triangle});
            for (const SparseField& field : t_.compute_sparse(requests)) report(line, field);
        });
    }

    void query(const std::string& name, std::size_t count, double half_width, OutputSet outputs,
               const Layout& layout) const {
        run(name, [&](Line& line) {
            const Results results(outputs, count, layout);
            TransformStatistics statistics;
            if (layout.on_device) {  // floats
                const Buffer points = buffer_of(s_.points_as_floats);
                statistics =
                    t_.query(InputArray(points.memory(), ElementType::float32, count), half_width, results.targets());
            } else {
                statistics = t_.query(std::span(s_.points).first(count), half_width, results.targets());
            }
            line.add("unusable", statistics.unusable_points);
            results.report(line);
        });
    }

    void classify() const {
        run("classify", [&](Line& line) {
            std::vector<Box> boxes;
            for (std::size_t k = 0; k + 1 < some_points; ++k) {
                if (k >= 2 && k <= 5) continue;  // points that are not finite
                const Vec3 &a = s_.points[k], &b = s_.points[k + 1];
                Box box{a, a};
                for (std::size_t axis = 0; axis < 3; ++axis)
                    box.upper[axis] += 0.05 * static_cast<double>(k % 3) * std::abs(b[axis] - a[axis]);
                boxes.push_back(box);
            }
            std::vector<BoxPlace> places(boxes.size());
            t_.classify(boxes, 0.05 * s_.side, places);
            line.add("places", places);
        });
    }

    void winding(const std::string& name, std::size_t count, const Layout& layout) const {
        run(name, [&](Line& line) {
            const Results results(Output::distance, count, layout);
            const Buffer points = buffer_of(s_.points);
            const InputArray on_host = std::span(s_.points).first(count);
            t_.winding(layout.on_device ? InputArray(points.memory(), ElementType::float64, count) : on_host,
                       *results.targets().find(Output::distance));
            results.report(line);
        });
    }

    void restricted() const {
        run("restricted", [&](Line& line) {
            const std::array<Grid, 2> parts{in_whole_bricks(s_.grid.block(s_.grid.first, {16, 16, 8})),
                                            s_.grid.part({20, 10, 2}, {13, 11, 7})};
            const std::array<Region, 2> regions{Region{parts[0].box(), s_.band.widest(), s_.grid.voxel()},
                                                Region{parts[1].box(), s_.band.widest(), s_.grid.voxel()}};
            const DistanceTransform part = t_.restrict_to(regions);
            for (const Grid& grid : parts) {
                const Results results(all_outputs(), grid.size);
                part.compute(grid, s_.band, results.targets());
                results.report(line);

                const std::vector<Vec3> points{grid.position(0, 0, 0), grid.position(3, 4, 5), grid.position(9, 9, 2)};
                const Results at_points(all_outputs(), points.size());
                part.query(points, s_.band.widest(), at_points.targets());
                at_points.report(line);
            }
            report(line, part.compute_sparse(parts[0], s_.band));
            std::vector<BoxPlace> places(2);
            part.classify(std::array{parts[0].box(), parts[1].box()}, s_.band.widest(), places);
            line.add("places", places);
        });
    }

    const Subject& s_;
    const DistanceTransform& t_;
    std::string name_;
};

}  // namespace clsdf::test
