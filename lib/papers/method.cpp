#include <clsdf/error.hpp>
#include <clsdf/papers.hpp>

#include "calls/transform/transform_access.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "lattice/layout_of.hpp"
#include "papers/pieces.hpp"
#include "papers/scans.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf {

namespace {

using namespace papers;
using engine::PreparedMesh;

/// No sample is farther from the mesh than from its box's farthest point.
double farthest_distance(const Mesh& mesh, const Grid& grid, double unit) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = grid.origin[axis] + static_cast<double>(grid.first[axis]) * grid.spacing[axis];
        const double high = low + static_cast<double>(grid.size[axis] - 1) * grid.spacing[axis];
        const double side = std::max(mesh.box().upper[axis] - low, high - mesh.box().lower[axis]) / unit;
        squared += side * side;
    }
    return std::sqrt(squared);
}

/// The half width, in units, that the polyhedra are made for. A slice has no bounds of its own for the distance as
/// bricks have, so that an infinite band ends where the grid does.
double half_width_for_slices(const Mesh& mesh, const Grid& grid, const Layout& layout) {
    constexpr double most = 1e6;
    if (std::isfinite(layout.outside_squared) && std::isfinite(layout.inside_squared))
        return std::min(static_cast<double>(layout.half_width), most);
    return farthest_distance(mesh, grid, static_cast<double>(layout.unit));
}

/// Polyhedra of any kind, slice by slice.
class SliceMethod final : public FieldMethod {
public:
    explicit SliceMethod(const PapersOptions& options) : options_(options) {}

    void check_outputs(OutputSet outputs) const override { check_distance_and_triangle(outputs, "by slices"); }

    std::shared_ptr<const PreparedMesh> prepare(engine::KeptMesh& kept_mesh, const engine::Job& job) const override {
        const Mesh& mesh = kept_mesh.mesh();
        const Layout& layout = job.layout;
        const engine::LatticeView& lattice = job.lattice;
        const double half_width = half_width_for_slices(mesh, job.grid, layout);
        auto prepared = std::make_shared<PreparedPieces>();
        prepared->triangle_count = mesh.triangles().size();
        const auto upload_records = [&](std::span<const Polyhedron> records) {
            prepared->record_count = prepared->polyhedron_count = records.size();
            prepared->polyhedra = upload(kept_mesh, records.data(), records.size_bytes(), "polyhedra");
        };
        std::size_t closed_gaps = 0;
        if (options_.polyhedra == Polyhedra::peikert_sigg) {
            const PeikertSiggPieces paper = peikert_sigg_pieces(mesh, lattice, half_width, options_.close_gaps, layout);
            upload_records(paper.polyhedra);
            upload_pieces(kept_mesh, paper.pieces, *prepared);
            closed_gaps = paper.closed_gaps;
        } else if (options_.polyhedra == Polyhedra::mauch) {
            const MauchPieces mauch = mauch_pieces(mesh, lattice, half_width, layout);
            upload_records(mauch.polyhedra);
            upload_pieces(kept_mesh, mauch.pieces, *prepared);
            prepared->polyhedron_count = mauch.count();  // more than records
            prepared->boxes = mauch.boxes;
        } else {
            const UninitializedVector<Polyhedron> records = leaned_records(kept_mesh, lattice);
            upload_records(records);
            upload_pieces(
                kept_mesh,
                leaned_pieces(records, half_width, engine::base_slack + engine::slack_rate * half_width, layout),
                *prepared);
            const engine::Frusta& frusta = kept_mesh.frusta();
            prepared->saddle_vertices = frusta.saddle_vertices;
            prepared->point_sites = frusta.sites.size();
            prepared->boxes = frusta.boxes;
        }
        prepared->method_counts.push_back({"closed_gaps", closed_gaps, true});
        return prepared;
    }

    std::unique_ptr<engine::FieldScan> make_scan(const engine::ScanInputs& inputs) const override {
        return make_slice_scan(inputs, options_.slice_minimum);
    }

    std::shared_ptr<const FieldMethod> tested_as(const device::Context& context, const Layout& layout,
                                                 const engine::BrickVariant& variant) const override {
        const bool key_64 = takes_64_bits(context, layout, variant.nearest, options_.slice_minimum);
        return std::make_shared<SliceMethod>(PapersOptions{
            .scan = Scan::slices, .slice_minimum = key_64 ? SliceMinimum::one_pass : SliceMinimum::two_passes});
    }

    std::string name() const override { return has_one_pass() ? "slices KEY_64" : "slices"; }

    std::vector<cl::Program> build(device::Context& context, const engine::Programs& programs,
                                   const engine::BrickVariant& variant,
                                   const device::BuildWatch& watch) const override {
        return {slices_program(context, programs, {variant, has_one_pass()}, watch)};
    }

    std::size_t step_count() const override { return 1; }

private:
    bool has_one_pass() const { return options_.slice_minimum == SliceMinimum::one_pass; }

    static UninitializedVector<Polyhedron> leaned_records(engine::KeptMesh& kept_mesh,
                                                          const engine::LatticeView& lattice) {
        const engine::Frusta& frusta = kept_mesh.frusta();
        UninitializedVector<Polyhedron> records = face_records(kept_mesh, lattice);
        const std::size_t faces = records.size();
        records.resize(faces + frusta.sites.size());
        write_site_records(kept_mesh.topology(), frusta, lattice, 0, std::span(records).subspan(faces));
        return records;
    }

    static void upload_pieces(const engine::KeptMesh& kept_mesh, const ConvexPieces& pieces, PreparedPieces& prepared) {
        prepared.pieces = upload(kept_mesh, pieces.pieces.data(), pieces.pieces.size() * sizeof(Piece), "pieces");
        prepared.planes =
            upload(kept_mesh, pieces.planes.data(), pieces.planes.size() * sizeof(PiecePlane), "planes of the pieces");
        prepared.slices.reserve(pieces.pieces.size());
        for (std::size_t i = 0; i < pieces.pieces.size(); ++i)
            prepared.slices.push_back({pieces.pieces[i].slice_begin, pieces.pieces[i].slice_end, pieces.costs[i]});
    }

    PapersOptions options_;
};

}  // namespace

device::BufferPool::Lease papers::upload(const engine::KeptMesh& kept_mesh, const void* values, std::size_t bytes,
                                         const char* purpose) {
    auto lease = kept_mesh.tools().pool->lease(bytes, purpose);
    if (bytes > 0)
        device::guarded([&] {
            device::write_values(kept_mesh.context(), std::span(static_cast<const std::byte*>(values), bytes), *lease);
        });
    return lease;
}

UninitializedVector<Polyhedron> papers::face_records(engine::KeptMesh& kept_mesh, const engine::LatticeView& lattice) {
    const engine::MeshTopology& topology = kept_mesh.topology();
    const engine::Frusta& frusta = kept_mesh.frusta();
    UninitializedVector<Polyhedron> records(topology.order.size());
    for_each_index(records.size(),
                   [&](std::size_t face) { write_face_record(topology, frusta, lattice, face, records[face]); });
    return records;
}

void papers::check_distance_and_triangle(OutputSet outputs, const char* scan) {
    for (const OutputInfo& info : extra_outputs())
        if (outputs.contains(info.output) && info.output != Output::triangle)
            throw Error(ErrorCode::unsupported,
                        fmt::format("the scan {} does not know the output {}; use the scan by bricks, or do without",
                                    scan, info.name));
}

std::shared_ptr<const FieldMethod> papers::method_of(const PapersOptions& options) {
    switch (resolve_scan(options.polyhedra, options.scan)) {
        case Scan::bricks:
            return nullptr;
        case Scan::brute_force:
            return make_brute_force();
        default:
            return std::make_shared<SliceMethod>(options);
    }
}

DistanceTransform make_transform(Device device, const Mesh& mesh, const PapersOptions& method,
                                 const TransformOptions& options, const CallOptions& call) {
    return detail::TransformAccess::make(std::move(device), mesh, papers::method_of(method), options, call);
}

}  // namespace clsdf
