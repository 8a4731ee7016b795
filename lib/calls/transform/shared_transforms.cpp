#include "calls/transform/transform_state.hpp"
#include "core/archive.hpp"
#include "core/archive_head.hpp"
#include "core/parallel.hpp"
#include "core/word_hash.hpp"
#include "plan/stored_mesh.hpp"
#include "points/stored_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Prepared meshes in memory that processes share: a head, then the values of engine::StoredMesh and those of
/// points::StoredPoints as this machine has them.
namespace clsdf {

namespace {

constexpr ArchiveHead own_head{.name{'c', 'l', 's', 'd', 'f', 's', 'h', 'r'}, .layout = 2};
/// The values begin at a line.
constexpr std::size_t head_bytes = at_line(sizeof(ArchiveHead));

[[noreturn]] void refuse(const std::string& reason) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("this memory has no transform that this program can read: {}; pass the memory that share() "
                            "has filled, all of it, when share() has returned",
                            reason));
}

void check_alignment(const void* memory) {
    if (reinterpret_cast<std::uintptr_t>(memory) % line_bytes != 0)
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("memory for a shared transform begins at a multiple of {} bytes, and this begins at {}; "
                        "leave the first bytes out",
                        line_bytes, memory));
}

/// Of all bytes behind the head, its padding and `size` bytes of values. On all cores.
std::uint64_t hash_of_all(std::span<const std::byte> memory, std::size_t size) {
    constexpr std::size_t piece = std::size_t{1} << 20;
    const auto bytes = memory.subspan(sizeof(ArchiveHead), head_bytes - sizeof(ArchiveHead) + size);
    std::vector<std::uint64_t> hashes(chunk_count(bytes.size(), piece));
    for_each_index(
        hashes.size(),
        [&](std::size_t i) {
            hashes[i] = hash_of(bytes.subspan(i * piece, std::min(piece, bytes.size() - i * piece)));
        },
        1);
    return hash_of(std::as_bytes(std::span<const std::uint64_t>(hashes)));
}

/// What is written behind the head.
struct Content {
    engine::StoredMesh mesh;
    points::StoredPoints points;

    template <typename Archive>
    void visit(Archive& archive) {
        mesh.visit(archive);
        points.visit(archive);
    }
};

/// Throws Error(unsupported).
Content content_of(const engine::Workshop& workshop, engine::KeptMesh& kept_mesh, points::KeptPoints& kept_points,
                   const engine::SignOfWhole& sign, bool is_outer) {
    if (kept_mesh.restriction() != nullptr)
        throw Error(ErrorCode::unsupported,
                    "the transform is restricted, and whole ones alone can be shared; send its part_bytes()");
    if (is_outer)
        throw Error(ErrorCode::unsupported,
                    "a transform whose surface is outer cannot be shared; make the transform of the mesh of outer()");
    if (workshop.method)
        throw Error(ErrorCode::unsupported,
                    "a transform with polyhedra or a scan of clsdf::papers cannot be shared; use leaned frusta");
    if (kept_mesh.has_moved())
        throw Error(ErrorCode::unsupported,
                    "the vertices of the transform have moved, and it cannot be shared any more; make a transform of "
                    "the mesh at these positions");
    return kept_mesh.prepare([&] { return Content{{kept_mesh, sign}, {kept_points, sign.sign}}; });
}

}  // namespace

std::size_t DistanceTransform::State::prepared_bytes() {
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    context().begin_call();
    return calls::with_remedies(nullptr, {forgetting()}, [&] {
        Content content = content_of(*this, *kept_mesh, *kept_points, {sign, floor, topology}, given != nullptr);
        return head_bytes + archived_size(content);
    });
}

void DistanceTransform::State::share(std::span<std::byte> memory) {
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    context().begin_call();
    check_alignment(memory.data());
    calls::with_remedies(nullptr, {forgetting()}, [&] {
        Content content = content_of(*this, *kept_mesh, *kept_points, {sign, floor, topology}, given != nullptr);
        ArchiveHead head = own_head;
        head.size = archived_size(content);
        if (memory.size() < head_bytes || memory.size() - head_bytes < head.size)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the prepared mesh takes {} bytes, and the memory has {}; give as many as "
                                    "prepared_bytes() says",
                                    head_bytes + head.size, memory.size()));
        const std::span<std::byte> values = memory.subspan(head_bytes, static_cast<std::size_t>(head.size));
        std::memset(memory.data(), 0, head_bytes);
        WritingArchive archive(values);
        content.visit(archive);
        head.hash = hash_of_all(memory, values.size());
        std::atomic_thread_fence(std::memory_order_release);
        std::memcpy(memory.data(), &head, sizeof(head));
    });
}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::of_shared(Device device,
                                                                              std::span<const std::byte> memory,
                                                                              const TransformOptions& options) {
    check_alignment(memory.data());
    ArchiveHead head;
    if (memory.size() < head_bytes) refuse(fmt::format("it has {} bytes, fewer than the head", memory.size()));
    std::memcpy(&head, memory.data(), sizeof(head));
    if (head.name == std::array<char, 8>{}) refuse("nothing has been written yet, or not all");
    if (const std::optional<std::string> obstacle = obstacle_to_reading(head, own_head)) refuse(*obstacle);
    const std::span<const std::byte> behind = memory.subspan(head_bytes);
    if (head.size > behind.size())
        refuse(fmt::format("{} bytes follow the head, which states {}", behind.size(), head.size));
    const std::span<const std::byte> values = behind.first(static_cast<std::size_t>(head.size));
    if (head.hash != hash_of_all(memory, values.size())) refuse("it was changed since it was written");
    Content content;
    try {
        ReadingArchive archive(values);
        content.visit(archive);
        if (!archive.is_at_end()) refuse("it has more values than a transform");
    } catch (const ReadingArchive::Ended&) {
        refuse("it ends too early");
    }
    if (!content.mesh.fits() || !content.points.fits(content.mesh.face_count(), content.mesh.vertex_count()))
        refuse("the lengths of its arrays do not go together");

    std::unique_ptr<State> state(new State(std::move(device), options, {}, nullptr));
    engine::SignOfWhole sign = content.mesh.sign();
    state->sign = sign.sign;
    state->floor = sign.floor;
    state->topology = std::move(sign.topology);
    state->kept_mesh = content.mesh.make(state->context(), state->pool, state->kept_options(options));
    state->kept_points = std::make_unique<points::KeptPoints>(*state->kept_mesh);
    content.points.set(*state->kept_mesh, *state->kept_points);
    return state;
}

}  // namespace clsdf
