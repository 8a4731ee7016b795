#include "frusta/kernel_frusta.hpp"
#include "launch/commands.hpp"

#include "core/parallel.hpp"
#include "device/in_flight.hpp"
#include "device/read_back.hpp"
#include "frusta/gaps.hpp"
#include "frusta/host_part.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

// An upper estimate for one core; it limits the work of a launch.
constexpr double seconds_per_fan = 1e-6;
constexpr double seconds_per_gap = 1e-5;

/// Room for the point sites of most meshes, in_groups(): one of 240 faces needs one on a noisy scan, one of 1600 on a
/// smooth one.
std::size_t spare_records(std::size_t faces) {
    return 64 + faces / 96;
}

/// The shortest side that is not taken for a sliver's, in units; the same for all lattices, up to their unit.
double least_length(const Box& box, const LatticeView& lattice) {
    return 1e-30 * box.longest_side() / lattice.unit;
}

/// The launches of the kernels, and their results.
class KernelFrusta {
public:
    KernelFrusta(const DeviceSetUp& set_up, const std::shared_ptr<const NamedFaces>& names, const Box& box,
                 const LatticeView* lattice)
        : set_up_(set_up),
          box_(box),
          count_(names->face_count),
          records_of_(lattice),
          view_(lattice != nullptr ? *lattice : view_of(box)),
          least_length_(least_length(box, view_)) {
        faces_.names = names;
        signs_ = set_up.tools.pool->lease(3 * count_ * sizeof(float), "signs of the edges");
        face_answers_ = set_up.tools.pool->lease(count_, "answers about faces");
        if (lattice != nullptr)
            records_ = set_up.tools.pool->lease((in_record_groups(count_) + spare_records(count_)) * sizeof(Polyhedron),
                                                "polyhedra");
    }

    MadeFrusta make(const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh) {
        const MeshTopology& topology = *faces_.names->topology;
        frusta_->positions = ordered_positions(topology, mesh.vertices());
        frusta_->slopes.resize(count_);
        faces_.positions =
            std::make_shared<const device::BufferPool::Lease>(set_up_.shared(frusta_, frusta_->positions));
        faces_.slopes = set_up_.shared(frusta_, frusta_->slopes, CL_MEM_READ_WRITE);
        lease_vertex_answers(sources->of_kernels->fan_items.size() * CLSDF_FAN_ITEM);
        enqueue_slopes(*sources->opposite);
        if (!sources->of_kernels->fan_items.empty()) enqueue_fans(*sources);
        complete(topology, [&](const Answers& answers) {
            return sources->of_kernels->left_to_host(topology, answers.of_faces, answers.of_vertices);
        });
        return finish({topology, *frusta_});
    }

    MadeFrusta make(HomedTopology& homed, std::shared_ptr<const device::BufferPool::Lease> positions) {
        const DeviceTopology& topology = *homed.on_device();
        faces_.positions = std::move(positions);
        faces_.slopes = lease_slopes();
        lease_vertex_answers(topology.vertex_count());
        enqueue_slopes(*topology.opposite);
        enqueue_ring_fans(topology);
        std::optional<HostPart> part =
            host_part(set_up_, topology, {*face_answers_, *vertex_answers_, **faces_.positions});
        if (!part) {
            const MeshTopology& whole = *homed.on_host();
            frusta_->positions = UninitializedVector<Vec3>(topology.vertex_count());
            frusta_->slopes.resize(count_);
            device::read_values(set_up_.tools.context, **faces_.positions, frusta_->positions);
            complete(whole, [&](const Answers& answers) {
                return left_by_answers(whole, answers.of_faces, answers.of_vertices);
            });
            return finish({whole, *frusta_});
        }
        complete(*part, homed.if_on_host() ? homed.if_on_host()->joined : std::vector<JoinedPart>());
        faces_.part = std::make_shared<const HostPart>(std::move(*part));
        return finish({faces_.part->topology, faces_.part->frusta, faces_.part->faces});
    }

private:
    struct Answers {
        std::vector<std::uint8_t> of_faces, of_vertices;
    };

    std::size_t slope_bytes() const { return count_ * sizeof(FaceSlopes); }
    device::BufferPool::Lease lease_slopes() const {
        return set_up_.tools.pool->lease(slope_bytes(), "slopes of the polyhedra");
    }

    void lease_vertex_answers(std::size_t count) {
        vertex_answer_count_ = count;
        vertex_answers_ = set_up_.tools.pool->lease(count, "answers about vertices");
    }

    void enqueue_slopes(const cl::Buffer& opposite) const {
        device::LentKernel kernel = set_up_.tools.kernel(set_up_.tools.programs.face_records, "face_slopes");
        const std::size_t all = in_record_groups(count_);
        const std::size_t unit = CLSDF_FAN_ITEM;  // a multiple of the faces of a work-item
        ShortLaunches(set_up_.tools.context, {})
            .over(chunk_count(all, unit), seconds_per_face * unit, [&](std::size_t begin, std::size_t end) {
                const std::size_t last = std::min(end * unit, all);
                launch(set_up_.tools.context.queue(), kernel, set_up_.items_of(last - begin * unit),
                       face_lattice(view_), cl_double{least_length_}, static_cast<cl_uint>(begin * unit),
                       static_cast<cl_uint>(last), static_cast<cl_uint>(count_),
                       static_cast<cl_uint>(set_up_.ways.item_faces), *faces_.names->triangles, opposite,
                       **faces_.positions, *faces_.names->names, *faces_.slopes, *signs_, *face_answers_, *records_);
            });
    }

    void enqueue_fans(const FrustaSources& sources) const {
        device::LentKernel kernel = set_up_.tools.kernel(set_up_.tools.programs.face_records, "vertex_fans");
        ShortLaunches(set_up_.tools.context, {})
            .over(sources.of_kernels->fan_items.size(), CLSDF_FAN_ITEM * seconds_per_fan,
                  [&](std::size_t begin, std::size_t end) {
                      launch(set_up_.tools.context.queue(), kernel, set_up_.items_of((end - begin) * CLSDF_FAN_ITEM),
                             static_cast<cl_uint>(begin), cl_double{1 / view_.unit}, *sources.fan_items,
                             *sources.fan_words, *faces_.names->triangles, **faces_.positions, *signs_,
                             *vertex_answers_);
                  });
    }

    /// The fans of vertices, and the host's test of those that are left open.
    void enqueue_ring_fans(const DeviceTopology& topology) const {
        const cl::CommandQueue& queue = set_up_.tools.context.queue();
        const auto words = set_up_.tools.pool->lease(3 * count_ * sizeof(cl_uint), "faces around vertices");
        const ShortLaunches launches(set_up_.tools.context, {});
        device::LentKernel fans = set_up_.tools.kernel(set_up_.tools.programs.face_records, "ring_fans");
        launches.over(topology.vertex_count(), seconds_per_fan, [&](std::size_t begin, std::size_t end) {
            launch(queue, fans, {end - begin}, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                   cl_double{1 / view_.unit}, *topology.starts, *topology.corners, *topology.edges, *topology.edges,
                   *faces_.names->triangles, **faces_.positions, *signs_, *words, *vertex_answers_);
        });
        const LatticeView lattice = view_of(box_);
        if (lattice.unit < std::numeric_limits<double>::min()) return;
        device::LentKernel gaps = set_up_.tools.kernel(set_up_.tools.programs.face_records, "vertex_gaps");
        launches.over(topology.vertex_count(), seconds_per_gap, [&](std::size_t begin, std::size_t end) {
            launch(queue, gaps, {end - begin}, face_lattice(lattice), cl_double{least_length(box_, lattice)},
                   cl_double{gap_scale(lattice)}, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                   *topology.starts, *words, *faces_.names->triangles, *topology.opposite, **faces_.positions,
                   *vertex_answers_);
        });
    }

    /// Waits for the kernels. Then the slopes are complete, here and on the device.
    template <class LeftBy>
    void complete(const MeshTopology& topology, const LeftBy& left_by) {
        const cl::CommandQueue& queue = set_up_.tools.context.queue();
        struct Read {
            std::shared_ptr<Frusta> frusta;
            Answers answers;
        };
        device::InFlight<Read> read(
            set_up_.tools.context,
            {frusta_, {std::vector<std::uint8_t>(count_), std::vector<std::uint8_t>(vertex_answer_count_)}});
        read.begin();
        // After an error, too: a driver keeps a buffer that is mapped.
        const auto unmap = [&](void* memory) {
            clEnqueueUnmapMemObject(queue(), (*faces_.slopes)(), memory, 0, nullptr, nullptr);
        };
        std::unique_ptr<void, decltype(unmap)> in_place(nullptr, unmap);
        if (set_up_.ways.arrays_are_shared)
            in_place.reset(
                queue.enqueueMapBuffer(*faces_.slopes, CL_FALSE, CL_MAP_READ | CL_MAP_WRITE, 0, slope_bytes()));
        struct Copy {
            const cl::Buffer& from;
            void* to;
            std::size_t bytes;
        };
        std::vector<std::uint8_t>& of_vertices = read->answers.of_vertices;
        const std::array<Copy, 3> copies{{{*faces_.slopes, frusta_->slopes.data(), in_place ? 0 : slope_bytes()},
                                          {*vertex_answers_, of_vertices.data(), of_vertices.size()},
                                          {*face_answers_, read->answers.of_faces.data(), count_}}};
        const auto is_pinned = [&](const Copy& copy) {
            return set_up_.tools.context.capabilities().has_own_memory &&
                   copy.bytes > device::PinnedCopies::least_bytes;
        };
        cl::Event last;
        const std::size_t launched = set_up_.tools.context.kernels().launched().count();
        for (const Copy& copy : copies)
            if (copy.bytes > 0 && !is_pinned(copy))
                queue.enqueueReadBuffer(copy.from, CL_FALSE, 0, copy.bytes, copy.to, nullptr, &last);
        if (last() != nullptr) set_up_.tools.context.wait(last, launched);
        for (const Copy& copy : copies)
            if (is_pinned(copy))
                set_up_.tools.context.read(queue, copy.from, 0, copy.bytes, static_cast<std::byte*>(copy.to));
        read.end();
        left_ = left_by(read->answers);
        complete_frusta(topology, box_, left_, *frusta_);
        frusta_->sites = in_groups(frusta_->sites, site_blocks(frusta_->sites, topology.joined));
        if (!in_place) place_slopes(*frusta_, left_.faces);
    }

    /// Completes the frusta of the part, and the whole's by them.
    void complete(HostPart& part, std::span<const JoinedPart> joined) {
        complete_frusta(part.topology, box_, part.left, part.frusta);
        std::vector<SiteFrustum> in_whole_mesh = part.frusta.sites;
        for (SiteFrustum& site : in_whole_mesh) site.vertex = part.vertices[site.vertex];
        part.frusta.sites = in_groups(part.frusta.sites, site_blocks(in_whole_mesh, joined));
        const auto in_whole = [](std::span<const std::uint32_t> numbers, const std::vector<std::uint32_t>& of_whole) {
            std::vector<std::uint32_t> result;
            for (const std::uint32_t number : numbers) result.push_back(of_whole[number]);
            return result;
        };
        left_ = {in_whole(part.left.faces, part.faces), in_whole(part.left.vertices, part.vertices),
                 part.left.saddles_elsewhere, in_whole(part.left.gaps, part.vertices)};
        frusta_->slivers = in_whole(part.frusta.slivers, part.faces);
        frusta_->sites = part.frusta.sites;
        for (SiteFrustum& site : frusta_->sites) {
            site.vertex = part.vertices[site.vertex];
            site.face = part.faces[site.face];
        }
        frusta_->saddle_vertices = part.frusta.saddle_vertices;
        frusta_->boxes = part.frusta.boxes;
        place_slopes(part.frusta, part.left.faces);
    }

    /// Enqueues the way of slopes that the host has found to the device. `faces`: the numbers of left_.faces among
    /// these frusta.
    void place_slopes(const Frusta& frusta, std::span<const std::uint32_t> faces) const {
        std::vector<FaceSlopes> written;
        for (const std::uint32_t face : faces) written.push_back(frusta.slopes[face]);
        place_items(set_up_, written, left_.faces, *faces_.slopes);
    }

    MadeFrusta finish(const WrittenFaces& from) {
        faces_.found = frusta_;
        std::optional<PreparedMesh> records;
        if (records_of_ != nullptr) records = finish_records(from);
        return {faces_.part ? nullptr : std::move(frusta_), std::move(faces_), std::move(records), std::move(left_)};
    }

    /// Completes the records: those of faces that the host has measured and of point sites are written after the
    /// kernel's.
    PreparedMesh finish_records(const WrittenFaces& from) {
        const Frusta& frusta = *frusta_;
        const RecordRange faces{0, count_}, sites{0, frusta.sites.size()};
        const std::size_t first_site = in_record_groups(count_), end = first_site + sites.end;
        const bool has_room = end * sizeof(Polyhedron) <= records_.bytes();
        if (!has_room || left_.faces.size() > count_ / 64)  // else the kernel makes them again, of all slopes
            return records_on_device(set_up_, faces_, from, *records_of_, {&faces, 1}, {&sites, 1});
        WrittenRecords written(from, *records_of_, left_.faces);
        written.add_faces(faces, 0);
        written.add_sites(sites, first_site);
        written.place(set_up_, *records_);
        PreparedMesh prepared;
        set_counts(count_, frusta, prepared);
        prepared.record_count = end;
        prepared.polyhedra = std::move(records_);
        return prepared;
    }

    const DeviceSetUp& set_up_;
    Box box_;
    std::size_t count_;
    const LatticeView* records_of_;
    LatticeView view_;
    double least_length_;
    std::shared_ptr<Frusta> frusta_ = std::make_shared<Frusta>();
    DeviceFaces faces_;
    std::size_t vertex_answer_count_ = 0;
    LeftToHost left_;  // by numbers of the whole mesh
    device::BufferPool::Lease signs_, face_answers_, vertex_answers_, records_;
};

}  // namespace

FrustaSources::FrustaSources(const DeviceSetUp& set_up, const MeshTopology& topology)
    : of_kernels(std::make_shared<const KernelTopology>(topology)) {
    opposite = set_up.input(of_kernels, of_kernels->opposite, "opposite vertices");
    fan_words = set_up.input(of_kernels, of_kernels->fan_words, "faces around vertices");
    fan_items = set_up.input(of_kernels, of_kernels->fan_items, "items of vertices");
}

MadeFrusta frusta_by_kernels(const DeviceSetUp& set_up, const std::shared_ptr<const NamedFaces>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh,
                             const LatticeView* lattice) {
    return device::guarded([&] { return KernelFrusta(set_up, names, mesh.box(), lattice).make(sources, mesh); });
}

MadeFrusta frusta_by_kernels(const DeviceSetUp& set_up, HomedTopology& topology,
                             std::shared_ptr<const device::BufferPool::Lease> positions, const Box& box,
                             const LatticeView* lattice) {
    return device::guarded([&] {
        return KernelFrusta(set_up, topology.on_device()->names, box, lattice).make(topology, std::move(positions));
    });
}

}  // namespace clsdf::engine
