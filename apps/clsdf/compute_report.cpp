#include "compute.hpp"

#include "core/files.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <system_error>

namespace {

namespace fs = std::filesystem;

/// Bytes of all outputs of a sample.
std::uint64_t sample_bytes(const ComputeLayout& layout) {
    std::uint64_t all = info_of(clsdf::Output::distance).sample_bytes();
    for (const clsdf::OutputInfo& info : extra_outputs())
        if (layout.outputs.contains(info.output)) all += info.sample_bytes();
    return all;
}

std::uint64_t field_bytes(const ComputeLayout& layout) {
    return layout.grid.sample_count() * sample_bytes(layout);
}

/// Bytes of the field that are in memory at once.
struct SlabMemory {
    std::size_t slabs;
    std::uint64_t bytes;
};

SlabMemory slab_memory(const ComputeLayout& layout) {
    const std::vector<clsdf::Grid> slabs = clsdf::DistanceTransform::slabs_of(layout.grid);
    std::uint64_t largest = 0;
    for (const clsdf::Grid& slab : slabs) largest = std::max<std::uint64_t>(largest, slab.sample_count());
    return {slabs.size(), largest * sample_bytes(layout) * std::min<std::size_t>(slabs.size(), 2)};
}

// An estimate of a computation's memory beside the field: polyhedra, for slices also their pieces, lists, and the
// compiler.
std::uint64_t working_bytes(const ComputeLayout& layout) {
    const std::uint64_t bytes_per_triangle = layout.scan == clsdf::Scan::slices ? 2048 : 1024;
    return bytes_per_triangle * layout.mesh.triangles().size() + std::uint64_t{256} * 1024 * 1024;
}

std::uint64_t physical_memory() {
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long page = ::sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : 0;
}

std::string human_box(const clsdf::Box& box) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})", box.lower[0], box.lower[1], box.lower[2],
                       box.upper[0], box.upper[1], box.upper[2]);
}

clsdf::Box box_of(const clsdf::Grid& grid) {
    return {grid.position(0, 0, 0), grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1)};
}

Json facts_of(const clsdf::Topology& topology) {
    return {{"closed", topology.closed},
            {"balanced", topology.balanced},
            {"inside_out", topology.inside_out},
            {"open_edges", topology.open_edges},
            {"unbalanced_edges", topology.unbalanced_edges},
            {"non_manifold_edges", topology.non_manifold_edges},
            {"coincident_vertices", topology.coincident_vertices},
            {"unused_vertices", topology.unused_vertices},
            {"repeated_vertex_faces", topology.repeated_vertex_faces},
            {"boundary_edges", topology.boundary_edges},
            {"joined_vertices", topology.joined_vertices},
            {"duplicate_faces", topology.duplicate_faces},
            {"uncounted_faces", topology.uncounted_faces},
            {"reoriented_faces", topology.reoriented_faces},
            {"inner_wall_faces", topology.inner_wall_faces},
            {"parts", topology.parts},
            {"inward_parts", topology.inward_parts},
            {"nested_parts", topology.nested_parts},
            {"tested_points", topology.tested_points},
            {"doubtful_points", topology.doubtful_points},
            {"inside_points", topology.inside_points},
            {"unclear_parts", topology.unclear_parts},
            {"double_sided_faces", topology.double_sided_faces},
            {"doubled_cavity_faces", topology.doubled_cavity_faces},
            {"sheet_faces", topology.sheet_faces},
            {"enclosing_faces", topology.enclosing_faces},
            {"overlapping_parts", topology.overlapping_parts},
            {"downward_faces", topology.downward_faces},
            {"rim_loops", topology.rim_loops},
            {"overlapping_rim_edges", topology.overlapping_rim_edges},
            {"detail_parts", topology.detail_parts},
            {"detail_faces", topology.detail_faces}};
}

const char* meaning_of(clsdf::SignRule rule) {
    switch (rule) {
        case clsdf::SignRule::nonzero:
            return "nonzero: negative if the winding number is not zero";
        case clsdf::SignRule::parity:
            return "parity: negative if a ray crosses the surface an odd number of times";
        case clsdf::SignRule::solid_angle:
            return "solid-angle: negative if the winding number is one half or more, or minus one half or less";
        case clsdf::SignRule::below:
            return "below: negative below the terrain and above its floor";
        default:
            return "none: no sign";
    }
}

Json describe_layout(const ComputeLayout& layout) {
    Json result = {{"mesh",
                    {{"file", paths_of(layout.mesh_files)},
                     {"name", names_of(layout.mesh_files)},
                     {"vertices", layout.mesh.vertices().size()},
                     {"triangles", layout.mesh.triangles().size()},
                     {"lower", layout.mesh.box().lower},
                     {"upper", layout.mesh.box().upper}}},
                   {"topology", facts_of(layout.topology)},
                   {"grid", describe(layout.grid)},
                   {"band", describe(layout.band)},
                   {"sign", name_of(layout.sign)},
                   {"positive_inside", layout.positive_inside},
                   {"sparse", layout.is_sparse},
                   {"polyhedra", name_of(layout.polyhedra)},
                   {"scan", name_of(layout.scan)}};
    if (layout.floor) result["floor"] = *layout.floor;
    if (layout.surface != clsdf::Surface::given) result["surface"] = name_of(layout.surface);
    if (layout.groups) result["groups"] = layout.groups->names;
    return result;
}

std::string human_slabs(std::size_t count) {
    return count == 1 ? "the whole field" : fmt::format("two of {} slabs", count);
}

Json ratio(std::size_t part, std::size_t whole) {
    return whole == 0 ? Json() : Json(static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace

std::size_t count_band_samples(const clsdf::FieldDescription& field, const clsdf::FieldSlab& slab) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const auto outside = static_cast<float>(field.band.outside);
    const auto inside = field.sign == clsdf::SignRule::none ? -infinity : -static_cast<float>(field.band.inside);
    std::size_t count = 0;
    for (std::span<const float> rest = slab.distance(); !rest.empty();) {
        // Without branches, with counters as wide as the distances, and in blocks that do not overflow them, so that
        // compilers vectorise the loop.
        const auto some = rest.first(std::min(rest.size(), std::size_t{1} << 20));
        std::uint32_t of_some = 0;
        for (const float distance : some)
            of_some += static_cast<std::uint32_t>(distance < outside) & static_cast<std::uint32_t>(distance > inside);
        count += of_some;
        rest = rest.subspan(some.size());
    }
    return count;
}

std::size_t count_band_samples(const clsdf::FieldDescription& field, const clsdf::SparseSlab& slab) {
    std::size_t count = count_band_samples(field, slab.values);
    const clsdf::Grid& grid = field.grid;
    for (std::size_t b = 0; b < slab.bricks.size(); ++b) {
        clsdf::Index3 begin{}, end{};  // of the grid's samples
        bool is_whole = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t first = grid.first[axis] - slab.bricks[b][axis];
            begin[axis] = std::max<std::int64_t>(first, 0);
            end[axis] = std::min(first + grid.size[axis], clsdf::brick_side);
            is_whole = is_whole && begin[axis] == 0 && end[axis] == clsdf::brick_side;
        }
        if (is_whole) continue;
        clsdf::FieldSlab row;
        const std::span<const float> values =
            slab.values.distance().subspan(b * clsdf::brick_samples, clsdf::brick_samples);
        row.set(clsdf::Output::distance, values);
        count -= count_band_samples(field, row);
        for (std::int64_t z = begin[2]; z < end[2]; ++z)
            for (std::int64_t y = begin[1]; y < end[1]; ++y) {
                row.set(
                    clsdf::Output::distance,
                    values.subspan(static_cast<std::size_t>((z * clsdf::brick_side + y) * clsdf::brick_side + begin[0]),
                                   static_cast<std::size_t>(end[0] - begin[0])));
                count += count_band_samples(field, row);
            }
    }
    return count;
}

std::string warning_of_polyhedra(const ComputeLayout& layout) {
    if (layout.polyhedra != clsdf::Polyhedra::peikert_sigg) return {};
    return fmt::format("the {} polyhedra are not exact: some samples of the band get too large a distance, or none",
                       name_of(layout.polyhedra));
}

std::string warning_of_narrow_band(const clsdf::Grid& grid, const clsdf::Band& band, clsdf::SignRule sign) {
    const double voxel = grid.voxel();
    const bool has_inside = sign != clsdf::SignRule::none;
    double narrow = std::numeric_limits<double>::infinity();
    for (const double width : {band.outside, has_inside ? band.inside : 0.0})
        if (width > 0) narrow = std::min(narrow, width);  // 0: that side is not wanted
    if (!(narrow < voxel)) return {};
    return fmt::format(
        "the band is {:.3g} voxels wide on a side; choose --band 2v or more; a surface that is made from the field may "
        "be off by a good part of a voxel, because samples beside it have the band's limit",
        narrow / voxel);
}

void require_memory(double bytes, const std::string& what) {
    const std::uint64_t memory = physical_memory();
    if (memory > 0 && bytes > static_cast<double>(memory))
        throw clsdf::Error(clsdf::ErrorCode::out_of_memory,
                           fmt::format("{} take {} of memory, and this machine has {}", what, human_bytes(bytes),
                                       human_bytes(static_cast<double>(memory))));
}

std::string warning_of_memory(const ComputeLayout& layout) {
    const std::uint64_t memory = physical_memory();
    const std::uint64_t needed = slab_memory(layout).bytes + working_bytes(layout);
    if (memory == 0 || needed <= memory) return {};
    return fmt::format("about {} of memory are needed, and this machine has {}; choose a lower --resolution",
                       human_bytes(static_cast<double>(needed)), human_bytes(static_cast<double>(memory)));
}

std::string warning_of_size(const clsdf::Grid& grid, const clsdf::Box& mesh) {
    const double side = mesh.longest_side() / grid.voxel();
    if (side >= 1) return {};
    return fmt::format("the longest side of the mesh is {:.3g} voxels; is it in the grid's unit? (--scale)", side);
}

std::string warning_between_samples(const clsdf::Grid& grid, const clsdf::Box& mesh, clsdf::SignRule sign) {
    if (sign == clsdf::SignRule::none) return {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto cells = [&](double x) { return (x - grid.origin[axis]) / grid.spacing[axis]; };
        const double from = cells(mesh.lower[axis]), to = cells(mesh.upper[axis]);
        const auto first = static_cast<double>(grid.first[axis]);
        const double last = first + static_cast<double>(grid.size[axis] - 1);
        if (from < first || to > last || from == to || std::ceil(from) <= to) continue;
        return fmt::format(
            "the mesh is {:.3g} spacings wide along {} and lies between two samples, so none is inside; choose a finer "
            "grid, or another origin",
            to - from, "xyz"[axis]);
    }
    return {};
}

std::string warning_of_nothing(const std::string& nothing, const clsdf::Grid& grid, const clsdf::Box& mesh) {
    return fmt::format("{}: the grid reaches from {}, the mesh from {}", nothing, human_box(box_of(grid)),
                       human_box(mesh));
}

std::string warning_of_empty_band(const clsdf::FieldDescription& field, const clsdf::Box& mesh,
                                  std::size_t band_samples) {
    const bool has_inside = field.sign != clsdf::SignRule::none && field.band.inside > 0;
    if (band_samples > 0 || (field.band.outside == 0 && !has_inside)) return {};
    return warning_of_nothing("no sample lies within the band's limits", field.grid, mesh);
}

std::string warning_of_format(const ComputeLayout& layout, const std::string& output) {
    if (clsdf::ending_of(output) != ".sdf") return {};
    if (layout.positive_inside)
        return fmt::format(
            "{} does not state that it is positive inside: \"clsdf check\", \"slice\" and \"render\" need "
            "--positive-inside",
            output);
    if (std::isinf(layout.band.widest())) return {};
    return fmt::format(
        "{} does not state its band: programs that read it take the band's limit for the distance of samples beyond "
        "it; use --band full, or another format",
        output);
}

std::string warning_of_stale_outputs(const ComputeLayout& layout, const Computation& computation) {
    const fs::path output(computation.output);
    std::string warning;
    // The other formats have all outputs in one file.
    if (const std::string ending = clsdf::ending_of(computation.output); ending != ".nrrd" && ending != ".npy")
        return warning;
    for (const clsdf::OutputInfo& info : extra_outputs()) {
        const fs::path file =
            output.parent_path() / (output.stem().string() + "_" + info.name + output.extension().string());
        std::error_code ignored;
        if (layout.outputs.contains(info.output) || !fs::exists(file, ignored)) continue;
        warning += fmt::format("{}{} may be left from an earlier field; this field does not use it",
                               warning.empty() ? "" : "; ", file.string());
    }
    return warning;
}

void print_layout(const ComputeLayout& layout) {
    print_text("mesh    {}: {} vertices, {} triangles\n", paths_of(layout.mesh_files), layout.mesh.vertices().size(),
               layout.mesh.triangles().size());
    if (layout.groups) print_text("groups  {}\n", human(*layout.groups));
    print_text("grid    {}\n", human(layout.grid));
    print_text("band    {}\n", human(layout.band, layout.grid.voxel()));
    print_text("sign    {}{}{}\n", meaning_of(layout.sign), layout.positive_inside ? "; positive inside" : "",
               layout.band.has_exact_signs ? "; exact on the surface" : "");
    if (layout.surface != clsdf::Surface::given) print_text("surface {}\n", name_of(layout.surface));
    print_text("method  {} polyhedra, scanned by {}\n", name_of(layout.polyhedra), name_of(layout.scan));
}

void print_memory(const ComputeLayout& layout) {
    const SlabMemory memory = slab_memory(layout);
    print_text("memory  {}{} for {}, and about {} to compute\n", layout.is_sparse ? "at most " : "",
               human_bytes(static_cast<double>(memory.bytes)), human_slabs(memory.slabs),
               human_bytes(static_cast<double>(working_bytes(layout))));
    print_text("file    {}{}\n", layout.is_sparse ? "sparse; at most about " : "",
               human_bytes(static_cast<double>(field_bytes(layout))));
}

void print_outcome(const ComputeLayout& layout, const Computation& computation) {
    const auto samples = static_cast<double>(layout.grid.sample_count());
    print_text("device  {} ({})\n", computation.device_name, computation.device_platform);
    const clsdf::TransformStatistics& statistics = computation.statistics;
    if (statistics.first_use)
        print_text(
            "setup   {} the kernels for this device{} in {:.1f} s{}\n",
            computation.device_platform.ends_with("bundled with clsdf") ? "tested" : "compiled",
            computation.keeps_records ? ", once," : "", statistics.compile_seconds,
            computation.keeps_records ? "" : "; without a folder of records that can be written every run does so");
    print_text("done    computed in {:.3f} s: {} samples, {} of them within the band's limits; {} samples a second\n",
               computation.compute_seconds, human_count(samples),
               human_count(static_cast<double>(computation.band_samples)),
               human_count(samples / computation.compute_seconds));
    print_text("memory  {} of buffers on the device, {} on the host for {}\n",
               human_bytes(static_cast<double>(statistics.device_bytes)),
               human_bytes(static_cast<double>(statistics.host_bytes)), human_slabs(statistics.slabs));
    // A sparse or compressed file is smaller than its values. A pipe has no size.
    std::error_code none;
    const bool is_file = fs::is_regular_file(computation.output, none);
    const std::uint64_t written = is_file ? fs::file_size(computation.output, none) : field_bytes(layout);
    print_text("wrote   {} ({})\n", computation.output, human_bytes(static_cast<double>(written)));
}

Json describe_dry_run(const ComputeLayout& layout) {
    Json result = describe_layout(layout);
    const SlabMemory memory = slab_memory(layout);
    result["memory"] = {{"field_bytes", field_bytes(layout)},
                        {"slabs", memory.slabs},
                        {"slab_bytes", memory.bytes},
                        {"working_bytes", working_bytes(layout)}};
    return result;
}

Json describe(const ComputeLayout& layout, const Computation& computation) {
    const clsdf::TransformStatistics& statistics = computation.statistics;
    const clsdf::WorkCounts& work = *statistics.work;
    Json result = describe_layout(layout);
    result["device"] = {{"name", computation.device_name}, {"platform", computation.device_platform}};
    result["seconds"] = {{"read", computation.read_seconds},
                         {"setup", computation.setup_seconds},
                         {"compile", statistics.compile_seconds},
                         {"compute", computation.compute_seconds},
                         {"polyhedra", statistics.polyhedra_seconds},
                         {"lists", statistics.work->lists_seconds},
                         {"field", statistics.field_seconds},
                         {"write", computation.write_seconds},
                         {"compute_and_write", computation.field_seconds}};
    result["first_use"] = statistics.first_use;
    result["samples_per_second"] = static_cast<double>(layout.grid.sample_count()) / computation.compute_seconds;
    result["statistics"] = {{"samples", layout.grid.sample_count()},
                            {"band_samples", computation.band_samples},
                            {"triangles", work.triangles},
                            {"polyhedra", work.polyhedra},
                            {"box_polyhedra", work.box_polyhedra},
                            {"saddle_vertices", work.saddle_vertices},
                            {"point_sites", work.point_sites},
                            {"coarse_pairs", work.coarse_pairs},
                            {"coarse_bricks", work.coarse_bricks},
                            {"slabs", statistics.slabs},
                            {"device_bytes", statistics.device_bytes},
                            {"host_bytes", statistics.host_bytes},
                            {"box_polyhedra_per_triangle", ratio(work.box_polyhedra, work.triangles)}};
    if (work.lanes_evaluated > 0)  // counted
        for (const auto& [name, count] :
             {std::pair("samples_covered", work.samples_covered), std::pair("lanes_evaluated", work.lanes_evaluated)}) {
            result["statistics"][name] = count;
            result["statistics"][fmt::format("{}_per_band_sample", name)] = ratio(count, computation.band_samples);
        }
    for (const char* name : {"closed_gaps", "active_pieces", "slice_intersections", "empty_intersections"}) {
        const auto count = std::ranges::find(work.method_counts, name, &clsdf::MethodCount::name);
        result["statistics"][name] = count != work.method_counts.end() ? count->value : 0;
    }
    result["output"] = computation.output;
    return result;
}
