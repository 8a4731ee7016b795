#include "prepare/kernel_frusta.hpp"
#include "launch/commands.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "device/in_flight.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::scan {

namespace {

// An upper estimate for one core; it limits the work of a launch.
constexpr double seconds_per_fan_item = CLSDF_FAN_ITEM * 1e-6;

/// What commands of the device use in the host's memory.
struct InTheMaking {
    MadeFrusta made;
    std::shared_ptr<const FrustaSources> sources;
    UninitializedVector<std::uint8_t> face_answers, vertex_answers;
};

class KernelFrusta {
public:
    KernelFrusta(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                 const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh)
        : job_(job),
          topology_(*names->topology),
          mesh_(mesh),
          view_(polyhedra::view_of(mesh.box())),
          count_(names->face_count()),
          vertex_answer_count_(sources->of_kernels.fan_items.size() * CLSDF_FAN_ITEM),
          signs_(job.pool->lease(3 * count_ * sizeof(float), "signs of the edges")),
          face_answers_(job.pool->lease(count_, "answers about faces")),
          vertex_answers_(job.pool->lease(vertex_answer_count_, "answers about vertices")),
          host_(job.context, InTheMaking{{},
                                         sources,
                                         UninitializedVector<std::uint8_t>(count_),
                                         UninitializedVector<std::uint8_t>(vertex_answer_count_)}) {
        auto& [frusta, faces] = host_->made;
        frusta.positions = ordered_positions(topology_, mesh.vertices());
        frusta.slopes.resize(count_);
        faces.names = names;
        faces.positions = job.input(frusta.positions, "vertices");
        faces.slopes = job.shares_memory() ? job.shared(frusta.slopes, CL_MEM_READ_WRITE)
                                           : job.pool->lease(slope_bytes(), "slopes of the polyhedra");
    }

    MadeFrusta make() {
        host_.begin();
        enqueue_slopes();
        enqueue_fans();
        complete();
        host_.end();
        return std::move(host_->made);
    }

private:
    std::size_t slope_bytes() const { return count_ * sizeof(polyhedra::FaceSlopes); }

    void enqueue_slopes() const {
        const DeviceFaces& faces = host_->made.faces;
        cl::Kernel kernel(job_.program, "face_slopes");
        // The shortest side that is not taken for a sliver's, in units.
        const double least_length = 1e-30 * mesh_.box().longest_side() / view_.unit;
        const std::size_t unit = CLSDF_FAN_ITEM;  // a multiple of the faces of a work-item
        ShortLaunches(job_.context, {})
            .over(chunk_count(count_, unit), seconds_per_face * unit, [&](std::size_t begin, std::size_t end) {
                const std::size_t last = std::min(end * unit, count_);
                launch(job_.context.queue(), kernel, job_.items_of(last - begin * unit), polyhedra::face_lattice(view_),
                       cl_double{least_length}, static_cast<cl_uint>(begin * unit), static_cast<cl_uint>(last),
                       static_cast<cl_uint>(job_.item_faces()), *faces.names->triangles, *host_->sources->opposite,
                       *faces.positions, *faces.slopes, *signs_, *face_answers_);
            });
    }

    void enqueue_fans() const {
        const DeviceFaces& faces = host_->made.faces;
        const FrustaSources& sources = *host_->sources;
        cl::Kernel kernel(job_.program, "vertex_fans");
        ShortLaunches(job_.context, {})
            .over(sources.of_kernels.fan_items.size(), seconds_per_fan_item, [&](std::size_t begin, std::size_t end) {
                launch(job_.context.queue(), kernel, job_.items_of((end - begin) * CLSDF_FAN_ITEM),
                       static_cast<cl_uint>(begin), static_cast<cl_uint>(end), cl_double{1 / view_.unit},
                       *sources.fan_items, *sources.fan_words, *faces.names->triangles, *faces.positions, *signs_,
                       *vertex_answers_);
            });
    }

    /// Waits for the kernels. Then the slopes are complete, here and on the device.
    void complete() {
        const cl::CommandQueue& queue = job_.context.queue();
        auto& [frusta, faces] = host_->made;
        void* in_place = nullptr;
        if (job_.shares_memory())
            in_place = queue.enqueueMapBuffer(*faces.slopes, CL_FALSE, CL_MAP_READ | CL_MAP_WRITE, 0, slope_bytes());
        else
            queue.enqueueReadBuffer(*faces.slopes, CL_FALSE, 0, slope_bytes(), frusta.slopes.data());
        if (vertex_answer_count_ > 0)
            queue.enqueueReadBuffer(*vertex_answers_, CL_FALSE, 0, vertex_answer_count_, host_->vertex_answers.data());
        queue.enqueueReadBuffer(*face_answers_, CL_TRUE, 0, count_, host_->face_answers.data());
        const polyhedra::LeftToHost left =
            host_->sources->of_kernels.left_to_host(topology_, host_->face_answers, host_->vertex_answers);
        complete_frusta(topology_, mesh_.box(), left, frusta);
        if (in_place != nullptr) {
            queue.enqueueUnmapMemObject(*faces.slopes, in_place);
            return;
        }
        std::vector<polyhedra::FaceSlopes> written;
        for (const std::uint32_t face : left.faces) written.push_back(frusta.slopes[face]);
        place_items(job_, written, left.faces, *faces.slopes);
    }

    const DeviceSetUp& job_;
    const polyhedra::MeshTopology& topology_;
    const Mesh& mesh_;
    polyhedra::LatticeView view_;
    std::size_t count_;
    std::size_t vertex_answer_count_;
    device::BufferPool::Lease signs_, face_answers_, vertex_answers_;
    device::InFlight<InTheMaking> host_;
};

}  // namespace

FrustaSources::FrustaSources(const DeviceSetUp& job, const polyhedra::MeshTopology& topology) : of_kernels(topology) {
    opposite = job.input(of_kernels.opposite, "opposite vertices");
    fan_words = job.input(of_kernels.fan_words, "faces around vertices");
    fan_items = job.input(of_kernels.fan_items, "items of vertices");
}

bool suits_kernels(const polyhedra::MeshTopology& topology) {
    constexpr std::size_t most = std::size_t{1} << 28;  // numbers of words have 32 bits
    return !topology.order.empty() && topology.order.size() <= most;
}

MadeFrusta frusta_by_kernels(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh) {
    return device::guarded([&] { return KernelFrusta(job, names, sources, mesh).make(); });
}

}  // namespace clsdf::scan
