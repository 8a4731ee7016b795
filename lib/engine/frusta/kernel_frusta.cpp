#include "frusta/kernel_frusta.hpp"
#include "launch/commands.hpp"

#include "core/parallel.hpp"
#include "device/in_flight.hpp"
#include "frusta/gaps.hpp"
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
constexpr double seconds_per_fan_item = CLSDF_FAN_ITEM * 1e-6;
constexpr double seconds_per_gap_item = CLSDF_FAN_ITEM * 1e-5;

/// Room for the point sites of most meshes: one of 240 faces needs one on a noisy scan, one of 1600 on a smooth one.
std::size_t spare_records(std::size_t faces) {
    return 64 + faces / 128;
}

/// The shortest side that is not taken for a sliver's, in units; the same for all lattices, up to their unit.
double least_length(const Box& box, const LatticeView& lattice) {
    return 1e-30 * box.longest_side() / lattice.unit;
}

class KernelFrusta {
public:
    KernelFrusta(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                 std::shared_ptr<const FrustaSources> sources, const Mesh& mesh, const LatticeView* lattice)
        : job_(job),
          sources_(std::move(sources)),
          topology_(*names->topology),
          box_(mesh.box()),
          count_(names->face_count()),
          records_of_(lattice) {
        frusta_->positions = ordered_positions(topology_, mesh.vertices());
        frusta_->slopes.resize(count_);
        view_ = lattice != nullptr ? *lattice : view_of(mesh.box());
        least_length_ = least_length(box_, view_);
        faces_.names = names;
        faces_.positions = job.input(frusta_, frusta_->positions, "vertices");
        faces_.slopes = job.shares_memory() ? job.shared(frusta_, frusta_->slopes, CL_MEM_READ_WRITE)
                                            : job.tools.pool->lease(slope_bytes(), "slopes of the polyhedra");
        signs_ = job.tools.pool->lease(3 * count_ * sizeof(float), "signs of the edges");
        face_answers_ = job.tools.pool->lease(count_, "answers about faces");
        vertex_answers_ = job.tools.pool->lease(vertex_answer_bytes(), "answers about vertices");
        if (lattice != nullptr)
            records_ = job.tools.pool->lease((in_record_groups(count_) + spare_records(count_)) * sizeof(Polyhedron),
                                             "polyhedra");
    }

    MadeFrusta make() {
        enqueue_slopes();
        if (!sources_->of_kernels->fan_items.empty()) {
            enqueue_fans();
            enqueue_gaps();
        }
        complete();
        std::optional<PreparedMesh> records;
        if (records_of_ != nullptr) records = finish_records();
        return {std::move(frusta_), std::move(faces_), std::move(records), std::move(left_)};
    }

private:
    std::size_t slope_bytes() const { return count_ * sizeof(FaceSlopes); }
    std::size_t vertex_answer_bytes() const { return sources_->of_kernels->fan_items.size() * CLSDF_FAN_ITEM; }

    void enqueue_slopes() const {
        cl::Kernel kernel(job_.tools.programs.mesh_records, "face_slopes");
        const std::size_t all = in_record_groups(count_);
        const std::size_t unit = CLSDF_FAN_ITEM;  // a multiple of the faces of a work-item
        ShortLaunches(job_.tools.context, {})
            .over(chunk_count(all, unit), seconds_per_face * unit, [&](std::size_t begin, std::size_t end) {
                const std::size_t last = std::min(end * unit, all);
                launch(job_.tools.context.queue(), kernel, job_.items_of(last - begin * unit), face_lattice(view_),
                       cl_double{least_length_}, static_cast<cl_uint>(begin * unit), static_cast<cl_uint>(last),
                       static_cast<cl_uint>(count_), static_cast<cl_uint>(job_.item_faces()), *faces_.names->triangles,
                       *sources_->opposite, *faces_.positions, *faces_.names->names, *faces_.slopes, *signs_,
                       *face_answers_, *records_);
            });
    }

    void enqueue_fans() const {
        cl::Kernel kernel(job_.tools.programs.mesh_records, "vertex_fans");
        ShortLaunches(job_.tools.context, {})
            .over(sources_->of_kernels->fan_items.size(), seconds_per_fan_item,
                  [&](std::size_t begin, std::size_t end) {
                      launch(job_.tools.context.queue(), kernel, job_.items_of((end - begin) * CLSDF_FAN_ITEM),
                             static_cast<cl_uint>(begin), static_cast<cl_uint>(end), cl_double{1 / view_.unit},
                             *sources_->fan_items, *sources_->fan_words, *faces_.names->triangles, *faces_.positions,
                             *signs_, *vertex_answers_);
                  });
    }

    /// The host's test of the vertices that are left open so far. A processor's host is as fast.
    void enqueue_gaps() const {
        const LatticeView lattice = view_of(box_);
        if (job_.tools.programs.mesh_lanes() != 1 || lattice.unit < std::numeric_limits<double>::min()) return;
        cl::Kernel kernel(job_.tools.programs.mesh_records, "vertex_gaps");
        ShortLaunches(job_.tools.context, {})
            .over(sources_->of_kernels->fan_items.size(), seconds_per_gap_item,
                  [&](std::size_t begin, std::size_t end) {
                      launch(job_.tools.context.queue(), kernel, job_.items_of((end - begin) * CLSDF_FAN_ITEM),
                             face_lattice(lattice), cl_double{least_length(box_, lattice)},
                             cl_double{gap_scale(lattice)}, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                             *sources_->fan_items, *sources_->fan_words, *faces_.names->triangles, *sources_->opposite,
                             *faces_.positions, *vertex_answers_);
                  });
    }

    /// Waits for the kernels. Then the slopes are complete, here and on the device.
    void complete() {
        const cl::CommandQueue& queue = job_.tools.context.queue();
        struct Read {
            std::shared_ptr<Frusta> frusta;
            std::vector<std::uint8_t> face_answers, vertex_answers;
        };
        device::InFlight<Read> read(job_.tools.context, {frusta_, std::vector<std::uint8_t>(count_),
                                                         std::vector<std::uint8_t>(vertex_answer_bytes())});
        read.begin();
        // After an error, too: a driver keeps a buffer that is mapped.
        const auto unmap = [&](void* memory) {
            clEnqueueUnmapMemObject(queue(), (*faces_.slopes)(), memory, 0, nullptr, nullptr);
        };
        std::unique_ptr<void, decltype(unmap)> in_place(nullptr, unmap);
        if (job_.shares_memory())
            in_place.reset(
                queue.enqueueMapBuffer(*faces_.slopes, CL_FALSE, CL_MAP_READ | CL_MAP_WRITE, 0, slope_bytes()));
        struct Copy {
            const cl::Buffer& from;
            void* to;
            std::size_t bytes;
        };
        const std::array<Copy, 3> copies{{{*faces_.slopes, frusta_->slopes.data(), in_place ? 0 : slope_bytes()},
                                          {*vertex_answers_, read->vertex_answers.data(), read->vertex_answers.size()},
                                          {*face_answers_, read->face_answers.data(), count_}}};
        const auto is_pinned = [&](const Copy& copy) {
            return job_.tools.context.capabilities().has_own_memory && copy.bytes > device::PinnedCopies::least_bytes;
        };
        cl::Event last;
        for (const Copy& copy : copies)
            if (copy.bytes > 0 && !is_pinned(copy))
                queue.enqueueReadBuffer(copy.from, CL_FALSE, 0, copy.bytes, copy.to, nullptr, &last);
        // Which fails if a kernel has failed, as copies by way of pinned memory do; a blocking read by PoCL does not.
        if (last() != nullptr) last.wait();
        for (const Copy& copy : copies)
            if (is_pinned(copy))
                job_.tools.context.read(queue, copy.from, 0, copy.bytes, static_cast<std::byte*>(copy.to));
        read.end();
        left_ = sources_->of_kernels->left_to_host(topology_, read->face_answers, read->vertex_answers);
        complete_frusta(topology_, box_, left_, *frusta_);
        if (in_place) return;
        std::vector<FaceSlopes> written;
        for (const std::uint32_t face : left_.faces) written.push_back(frusta_->slopes[face]);
        place_items(job_, written, left_.faces, *faces_.slopes);
    }

    /// Completes the records: those of faces that the host has measured and of point sites are written after the
    /// kernel's.
    PreparedMesh finish_records() {
        const Frusta& frusta = *frusta_;
        const RecordRange faces{0, count_}, sites{0, frusta.sites.size()};
        const std::size_t first_site = in_record_groups(count_), end = first_site + sites.end;
        const bool has_room = end * sizeof(Polyhedron) <= records_.bytes();
        if (!has_room || left_.faces.size() > count_ / 64)  // else the kernel makes them again, of all slopes
            return records_on_device(job_, faces_, topology_, frusta, *records_of_, {&faces, 1}, {&sites, 1});
        WrittenRecords written(topology_, frusta, *records_of_, left_.faces);
        written.add_faces(faces, 0);
        written.add_sites(sites, first_site);
        written.place(job_, *records_);
        PreparedMesh prepared;
        set_counts(topology_, frusta, prepared);
        prepared.record_count = end;
        prepared.polyhedra = std::move(records_);
        return prepared;
    }

    const DeviceSetUp& job_;
    std::shared_ptr<const FrustaSources> sources_;
    const MeshTopology& topology_;
    Box box_;
    std::size_t count_;
    const LatticeView* records_of_;
    LatticeView view_;
    double least_length_ = 0;
    std::shared_ptr<Frusta> frusta_ = std::make_shared<Frusta>();
    DeviceFaces faces_;
    LeftToHost left_;
    device::BufferPool::Lease signs_, face_answers_, vertex_answers_, records_;
};

}  // namespace

FrustaSources::FrustaSources(const DeviceSetUp& job, const MeshTopology& topology)
    : of_kernels(std::make_shared<const KernelTopology>(topology)) {
    opposite = job.input(of_kernels, of_kernels->opposite, "opposite vertices");
    fan_words = job.input(of_kernels, of_kernels->fan_words, "faces around vertices");
    fan_items = job.input(of_kernels, of_kernels->fan_items, "items of vertices");
}

bool suits_kernels(const MeshTopology& topology) {
    constexpr std::size_t most = std::size_t{1} << 28;  // numbers of words have 32 bits
    return !topology.order.empty() && topology.order.size() <= most;
}

MadeFrusta frusta_by_kernels(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh,
                             const LatticeView* lattice) {
    return device::guarded([&] { return KernelFrusta(job, names, sources, mesh, lattice).make(); });
}

}  // namespace clsdf::engine
