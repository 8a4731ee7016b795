#include "transform/kernel_frusta.hpp"

#include "core/keep.hpp"
#include "core/parallel.hpp"
#include "transform/programs.hpp"
#include "transform/short_launches.hpp"

#include <algorithm>
#include <utility>

namespace clsdf::transform {

namespace {

// Of a core, rounded up.
constexpr double seconds_per_face = 1e-6;
constexpr double seconds_per_fan_item = CLSDF_FAN_ITEM * 1e-6;

/// A buffer in an array of the host.
template <class Values>
device::BufferPool::Lease shared(const device::Context& context, Values& values, cl_mem_flags access) {
    using Value = std::remove_const_t<std::remove_reference_t<decltype(values[0])>>;
    const std::size_t bytes = values.size() * sizeof(Value);
    if (bytes == 0) return {};
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): the device only reads what is constant
    auto* const host = const_cast<Value*>(values.data());
    return {nullptr, cl::Buffer(context.context(), access | CL_MEM_USE_HOST_PTR, bytes, host), bytes};
}

/// Waits until the host may read what the device has written to its array.
void hand_over(const DeviceSetUp& job, const device::BufferPool::Lease& buffer) {
    if (buffer.bytes() == 0) return;
    const cl::CommandQueue& queue = job.context.queue();
    void* const mapped = queue.enqueueMapBuffer(*buffer, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, buffer.bytes());
    queue.enqueueUnmapMemObject(*buffer, mapped);
}

std::size_t in_whole_record_groups(std::size_t count) {
    return in_whole_groups(count, polyhedra::record_group);
}

/// Room for the point sites of most meshes: one of 240 faces needs one on a noisy scan, one of 1600 on a smooth one.
std::size_t spare_records(std::size_t faces) {
    return 64 + faces / 128;
}

/// The shortest side that is not taken for a sliver's, in units; the same for all lattices, up to their unit.
double least_length(const Mesh& mesh, const polyhedra::LatticeView& lattice) {
    return 1e-30 * mesh.box().longest_side() / lattice.unit;
}

class KernelFrusta {
public:
    KernelFrusta(const DeviceSetUp& job, std::shared_ptr<const FrustaSources> sources, FrustaMemory& memory,
                 const Mesh& mesh, const polyhedra::LatticeView* lattice)
        : job_(job), sources_(std::move(sources)), memory_(memory), count_(sources_->topology->order.size()) {
        const UninitializedVector<std::uint32_t>& vertices = sources_->topology->faces.vertices;
        frusta_.positions.resize(vertices.size());
        for_each_index(vertices.size(), [&](std::size_t i) { frusta_.positions[i] = mesh.vertices()[vertices[i]]; });
        view_ = lattice != nullptr ? *lattice : polyhedra::view_of(frusta_.positions);
        frusta_.slopes.resize(count_);
        memory.signs.resize(3 * count_);
        memory.face_answers.resize(count_);
        memory.vertex_answers.resize(sources_->of_kernels.fan_items.size() * CLSDF_FAN_ITEM);
        const device::Context& context = job.context;
        positions_ = shared(context, frusta_.positions, CL_MEM_READ_ONLY);
        slopes_ = shared(context, frusta_.slopes, CL_MEM_READ_WRITE);
        signs_ = shared(context, memory.signs, CL_MEM_READ_WRITE);
        face_answers_ = shared(context, memory.face_answers, CL_MEM_READ_WRITE);
        vertex_answers_ = shared(context, memory.vertex_answers, CL_MEM_READ_WRITE);
        least_length_ = least_length(mesh, view_);
    }

    KernelFrusta(const KernelFrusta&) = delete;
    KernelFrusta& operator=(const KernelFrusta&) = delete;
    ~KernelFrusta() {
        // After an error: what is under way uses these arrays.
        if (!is_under_way_ || job_.context.drain()) return;
        keep_for_good(sources_);
        keep_for_good(memory_);
        keep_for_good(frusta_);
    }

    /// `records`: null, or room for those of the faces in whole groups.
    void find(const cl::Buffer* records) {
        is_under_way_ = true;
        enqueue_slopes(records);
        if (!sources_->of_kernels.fan_items.empty()) enqueue_fans();
        for (const auto* written : {&slopes_, &signs_, &face_answers_, &vertex_answers_}) hand_over(job_, *written);
        is_under_way_ = false;
    }

    bool complete(const polyhedra::FirstRecords* first) {
        return complete_frusta(*sources_->topology, sources_->of_kernels,
                               {memory_.signs, memory_.face_answers, memory_.vertex_answers}, first, memory_.completion,
                               frusta_);
    }

    polyhedra::Frusta& frusta() { return frusta_; }

private:
    void enqueue_slopes(const cl::Buffer* records) const {
        cl::Kernel kernel(job_.program, "face_slopes");
        enum Argument : cl_uint {
            in_lattice,
            shortest,
            begins,
            ends,
            face_count,
            faces_of_item,
            triangles,
            opposite,
            positions,
            names,
            slopes,
            signs,
            answers,
            out
        };
        kernel.setArg(in_lattice, face_lattice(view_));
        kernel.setArg(shortest, least_length_);
        kernel.setArg(face_count, static_cast<cl_uint>(count_));
        kernel.setArg(faces_of_item, static_cast<cl_uint>(job_.item_faces()));
        kernel.setArg(triangles, *sources_->triangles);
        kernel.setArg(opposite, *sources_->opposite);
        kernel.setArg(positions, *positions_);
        kernel.setArg(names, *sources_->names);
        kernel.setArg(slopes, *slopes_);
        kernel.setArg(signs, *signs_);
        kernel.setArg(answers, *face_answers_);
        kernel.setArg(out, records != nullptr ? *records : cl::Buffer());
        const std::size_t all = in_whole_record_groups(count_);
        const std::size_t unit = CLSDF_FAN_ITEM;  // a multiple of the faces of a work-item
        ShortLaunches(job_.context, {})
            .over(stretch_count(all, unit), seconds_per_face * unit, [&](std::size_t begin, std::size_t end) {
                const std::size_t last = std::min(end * unit, all);
                kernel.setArg(begins, static_cast<cl_uint>(begin * unit));
                kernel.setArg(ends, static_cast<cl_uint>(last));
                job_.enqueue(kernel, last - begin * unit);
            });
    }

    void enqueue_fans() const {
        cl::Kernel kernel(job_.program, "vertex_fans");
        enum Argument : cl_uint { begins, ends, per_unit, items, words, positions, signs, answers };
        kernel.setArg(per_unit, 1 / view_.unit);
        kernel.setArg(items, *sources_->fan_items);
        kernel.setArg(words, *sources_->fan_words);
        kernel.setArg(positions, *positions_);
        kernel.setArg(signs, *signs_);
        kernel.setArg(answers, *vertex_answers_);
        ShortLaunches(job_.context, {})
            .over(sources_->of_kernels.fan_items.size(), seconds_per_fan_item, [&](std::size_t begin, std::size_t end) {
                kernel.setArg(begins, static_cast<cl_uint>(begin));
                kernel.setArg(ends, static_cast<cl_uint>(end));
                job_.enqueue(kernel, (end - begin) * CLSDF_FAN_ITEM);
            });
    }

    const DeviceSetUp& job_;
    std::shared_ptr<const FrustaSources> sources_;
    FrustaMemory& memory_;
    std::size_t count_;
    polyhedra::Frusta frusta_;
    polyhedra::LatticeView view_;
    double least_length_ = 0;
    bool is_under_way_ = false;
    device::BufferPool::Lease positions_, slopes_, signs_, face_answers_, vertex_answers_;
};

}  // namespace

FrustaSources::FrustaSources(device::Context& context, std::shared_ptr<const polyhedra::MeshTopology> topology_in)
    : topology(std::move(topology_in)), of_kernels(*topology) {
    device::guarded([&] {
        triangles = shared(context, topology->faces.triangles, CL_MEM_READ_ONLY);
        opposite = shared(context, of_kernels.opposite, CL_MEM_READ_ONLY);
        names = shared(context, of_kernels.names, CL_MEM_READ_ONLY);
        fan_words = shared(context, of_kernels.fan_words, CL_MEM_READ_ONLY);
        fan_items = shared(context, of_kernels.fan_items, CL_MEM_READ_ONLY);
    });
}

bool suits_kernels(const polyhedra::MeshTopology& topology, std::size_t least_faces) {
    constexpr std::size_t most = std::size_t{1} << 28;  // numbers of words have 32 bits
    const std::size_t faces = topology.order.size();
    return faces >= std::max<std::size_t>(least_faces, 1) && faces <= most &&
           polyhedra::are_few(topology.edges.non_manifold_corners, faces);
}

std::optional<polyhedra::Frusta> frusta_by_kernels(const DeviceSetUp& job,
                                                   const std::shared_ptr<const FrustaSources>& sources,
                                                   FrustaMemory& memory, const Mesh& mesh,
                                                   const polyhedra::LatticeView* lattice, PreparedMesh* prepared) {
    if (!polyhedra::are_few(sources->of_kernels.awkward_faces.size(), sources->topology->order.size()))
        return std::nullopt;
    return device::guarded([&]() -> std::optional<polyhedra::Frusta> {
        KernelFrusta kernels(job, sources, memory, mesh, lattice);
        if (lattice == nullptr) {
            kernels.find(nullptr);
            if (!kernels.complete(nullptr)) return std::nullopt;
            return std::move(kernels.frusta());
        }
        const polyhedra::MeshTopology& topology = *sources->topology;
        const std::size_t count = topology.order.size(), first_site = in_whole_record_groups(count);
        const std::size_t room = first_site + spare_records(count);
        const auto lease = [&](std::size_t records) {
            return job.pool->lease(records * sizeof(Polyhedron), "polyhedra");
        };
        const cl::CommandQueue& queue = job.context.queue();
        device::BufferPool::Lease records = lease(room);
        kernels.find(&*records);
        const auto map = [&](std::size_t size) {
            return std::span(static_cast<Polyhedron*>(queue.enqueueMapBuffer(
                                 *records, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, size * sizeof(Polyhedron))),
                             size);
        };
        std::span<Polyhedron> mapped = map(room);
        const polyhedra::FirstRecords first{*lattice, mapped.first(count)};
        const bool is_complete = kernels.complete(&first);
        if (is_complete) std::fill_n(mapped.subspan(count).begin(), first_site - count, Polyhedron(mapped[count - 1]));
        polyhedra::Frusta& frusta = kernels.frusta();
        const std::size_t end = first_site + frusta.sites.size();
        if (is_complete && end > room) {
            device::BufferPool::Lease larger = lease(end);
            queue.enqueueUnmapMemObject(*records, mapped.data());
            queue.enqueueCopyBuffer(*records, *larger, 0, 0, first_site * sizeof(Polyhedron));
            records = std::move(larger);
            mapped = map(end);
        }
        if (is_complete)
            write_site_records(topology, frusta, *lattice, 0, mapped.subspan(first_site, frusta.sites.size()));
        queue.enqueueUnmapMemObject(*records, mapped.data());
        if (!is_complete) return std::nullopt;
        set_counts(topology, frusta, *prepared);
        prepared->record_count = end;
        prepared->polyhedra = std::move(records);
        return std::move(frusta);
    });
}

}  // namespace clsdf::transform
