#include "calls/scenes/scene_state.hpp"
#include "calls/transform/transform_access.hpp"
#include "calls/transform/transform_state.hpp"
#include "core/common_part.hpp"
#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/vertices.hpp"
#include "plan/joined_meshes.hpp"
#include "scenes/separate_groups.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace clsdf {

namespace {

using detail::TransformAccess;

/// A body with more faces is worth launches of its own.
constexpr std::size_t most_faces_of_body = 4096;
/// Of fewer bodies each is computed by its own transform, which keeps its plan.
constexpr std::size_t fewest_bodies = 16;
/// Of bodies that are joined: faces, which bounds the memory of their records.
constexpr std::size_t most_faces_joined = std::size_t{1} << 20;
/// Of the arrays of a block, in which bodies that are joined write their parts alone.
constexpr std::size_t most_block_bytes = std::size_t{1} << 27;

/// The samples of a part, counted on the lattice; their limits belong to them.
Box samples_of(const Grid& part) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = static_cast<double>(part.first[axis]);
        box.upper[axis] = static_cast<double>(part.first[axis] + part.size[axis] - 1);
    }
    return box;
}

/// Parts of the grid, layer after layer, which end at coarse bricks.
std::vector<Grid> blocks_of(const Grid& grid, OutputSet outputs) {
    std::size_t sample = 0;
    for (const OutputInfo& info : output_table())
        if (outputs.contains(info.output)) sample += info.sample_bytes();
    const auto slice = static_cast<std::size_t>(grid.size[0] * grid.size[1]) * std::max<std::size_t>(sample, 1);
    const auto layers = static_cast<std::int64_t>(std::max<std::size_t>(most_block_bytes / slice / CLSDF_COARSE, 1));
    constexpr std::int64_t coarse = CLSDF_COARSE;
    std::vector<Grid> blocks;
    for (std::int64_t z = grid.first[2], end = z + grid.size[2]; z < end;) {
        const std::int64_t first_brick = z - (z % coarse + coarse) % coarse;
        const std::int64_t next = std::min(end, first_brick + layers * coarse);
        blocks.push_back(grid.part({0, 0, z - grid.first[2]}, {grid.size[0], grid.size[1], next - z}));
        z = next;
    }
    return blocks;
}

}  // namespace

std::optional<Scene::State::KindOfBody> Scene::State::kind_if_joined(const Shape& shape, bool has_normals) {
    auto& state = TransformAccess::state(shape.transform);
    const std::scoped_lock lock(state.mutex);
    engine::KeptMesh& mesh = *state.kept_mesh;
    const bool is_closed = state.sign == SignRule::none || state.topology.balanced;
    if (!mesh.ways().selections_by_kernels || !mesh.ways().arrays_are_shared || !is_closed ||
        !mesh.sign_surface().is_mesh() || mesh.face_count() > most_faces_of_body)
        return std::nullopt;
    return KindOfBody{state.sign, has_normals && state.sign != SignRule::none && mesh.encloses_negative_volume()};
}

std::vector<Scene::State::FieldStep> Scene::State::steps_of(const std::vector<FieldPart>& parts,
                                                            const Request& request) {
    const Grid& grid = request.grid;
    const Band& band = request.band;
    const OutputSet outputs = targets::outputs_of(request.targets);
    std::vector<FieldStep> steps, alone;
    const auto add_alone = [&](const FieldPart& part) { alone.push_back({.block = part.grid, .parts = {part}}); };
    std::map<KindOfBody, std::vector<FieldPart>> kinds;
    for (const FieldPart& part : parts) {
        std::optional<KindOfBody> kind;
        if (!band.has_exact_signs) kind = kind_if_joined(*bodies[part.body].shape, engine::takes_normals(outputs));
        if (kind)
            kinds[*kind].push_back(part);
        else
            add_alone(part);
    }
    const std::vector<Grid> blocks = blocks_of(grid, outputs);
    for (const auto& [kind, all] : kinds) {
        if (!are_joined(all, kind, grid, band)) {
            std::ranges::for_each(all, add_alone);
            continue;
        }
        for (std::span<const FieldPart> rest = all; !rest.empty();) {
            auto members = std::make_shared<FieldStep::Members>();
            members->is_inside_out = kind.is_inside_out;
            std::vector<Box> near;
            for (std::size_t faces = 0; near.size() < rest.size() && faces < most_faces_joined;) {
                const FieldPart& part = rest[near.size()];
                faces += TransformAccess::state(bodies[part.body].shape->transform).kept_mesh->face_count();
                near.push_back(samples_of(part.near));
                members->bodies.push_back(part.body);
            }
            const auto groups = scenes::separate_groups(near);
            for (const Grid& block : blocks)
                for (const std::vector<std::uint32_t>& group : groups) {
                    FieldStep step{.block = block, .members = members};
                    for (const std::uint32_t place : group)
                        if (const auto part = common_part(rest[place].grid, block)) {
                            step.parts.push_back({rest[place].body, *part, *part});
                            step.selected.push_back(place);
                        }
                    if (!step.parts.empty()) steps.push_back(std::move(step));
                }
            rest = rest.subspan(near.size());
        }
    }
    steps.insert(steps.end(), alone.begin(), alone.end());
    return steps;
}

bool Scene::State::are_joined(std::span<const FieldPart> parts, const KindOfBody& kind, const Grid& grid,
                              const Band& band) const {
    Box all = empty_box;
    std::size_t faces = 0;
    for (const FieldPart& part : parts) {
        const Shape& shape = *bodies[part.body].shape;
        clsdf::add(all, bodies[part.body].frame.to_scene(shape.box));
        faces += TransformAccess::state(shape.transform).kept_mesh->face_count();
    }
    // Records that are not kept would be made for each step.
    const std::size_t record_bytes = 2 * sizeof(Polyhedron) * std::min(faces, most_faces_joined);
    return parts.size() >= fewest_bodies && options.kept_bytes.value_or(record_bytes) >= record_bytes &&
           engine::can_be_joined(all, grid, band, kind.sign);
}

const DistanceTransform& Scene::State::joined_at(const FieldStep& step) {
    const std::vector<std::uint32_t>& members = step.members->bodies;
    std::vector<scenes::Frame> frames;
    for (const std::uint32_t body : members) frames.push_back(bodies[body].frame);
    const bool is_there = joined && joined->bodies == members && joined->is_inside_out == step.members->is_inside_out;
    if (!is_there || joined->frames != frames) {
        std::vector<engine::MeshToJoin> meshes;
        std::vector<std::size_t> begins{0};
        for (const std::uint32_t body : members) {
            auto& state = TransformAccess::state(bodies[body].shape->transform);
            const std::scoped_lock lock(state.mutex);
            meshes.push_back({&state.kept_mesh->mesh(), state.kept_mesh->shared_topology()});
            begins.push_back(begins.back() + meshes.back().mesh->vertices().size());
        }
        std::vector<Vec3> positions(begins.back());
        constexpr std::size_t grain = 4;
        for_each_index(
            members.size(),
            [&](std::size_t i) {
                const std::vector<Vec3>& own = meshes[i].mesh->vertices();
                const auto to = positions.begin() + static_cast<std::ptrdiff_t>(begins[i]);
                if (is_moved(frames[i]))
                    std::ranges::copy(engine::Vertices::moved(own, frames[i].rotation, frames[i].translation), to);
                else
                    std::ranges::copy(own, to);
            },
            grain);
        if (is_there) {
            joined->frames.clear();
            TransformAccess::state(joined->transform).move_joined(std::move(positions));
        } else {
            joined.reset();
            auto& first = TransformAccess::state(bodies[members.front()].shape->transform);
            joined.emplace(
                JoinedBodies{members,
                             step.members->is_inside_out,
                             {},
                             TransformAccess::of(first.joined(engine::join_meshes(meshes, std::move(positions)),
                                                              step.members->is_inside_out))});
        }
        joined->frames = std::move(frames);
    }
    TransformAccess::state(joined->transform).select_meshes(step.selected);
    return joined->transform;
}

}  // namespace clsdf
