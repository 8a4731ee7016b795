#include "plan/region_part.hpp"

#include "core/archive.hpp"
#include "core/archive_head.hpp"
#include "core/word_hash.hpp"
#include "mesh/mesh_arrays.hpp"
#include "plan/stored_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

namespace clsdf::engine {

namespace {

constexpr ArchiveHead own_head{.name{'c', 'l', 's', 'd', 'f', 'p', 'r', 't'}, .layout = 2};

constexpr std::uint32_t unknown_volume = 2;

[[noreturn]] void refuse(const std::string& reason) {
    throw Error(ErrorCode::invalid_argument, fmt::format("these bytes are no part of a transform that this program can "
                                                         "read: {}; pass all bytes that part_bytes() gave",
                                                         reason));
}

/// The members of a part in the order of its bytes.
struct Content {
    std::int32_t sign = 0;
    std::uint32_t has_floor = 0, is_negative = 0, has_boundary = 0, boundary_has_floor = 0;
    double floor = 0, boundary_floor = 0;
    Topology topology;
    std::vector<Region> regions;
    std::uint64_t record_count = 0;
    std::vector<std::uint32_t> numbers;
    SurfaceSample sample;
    std::vector<char> name;
    Box box;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> surface_vertices;
    std::vector<SignSurface::Use> surface_faces;
    UninitializedVector<std::uint32_t> order;
    std::vector<std::uint32_t> non_manifold;
    std::vector<StoredSite> sites;
    std::vector<std::uint32_t> slivers;
    std::uint64_t saddle_vertices = 0, boxes = 0;
    UninitializedVector<FaceSlopes> slopes;
    std::vector<Vec3> corners;
    std::vector<std::size_t> begins;
    // Of a part that moves; else empty.
    double margin = 0;
    std::uint32_t has_volume = 0, first_is_negative = 0, loops_have_floor = 0;
    double loops_floor = 0;
    std::vector<Vec3> first;
    std::vector<Triangle> faces_about;
    UninitializedVector<std::uint32_t> order_about;
    std::vector<std::uint32_t> vertex_numbers, own_vertices, own_faces, places;
    std::vector<Triangle> sample_triangles;
    std::vector<std::uint32_t> loop_vertices;
    std::vector<std::size_t> loop_begins;

    template <typename Archive>
    void visit(Archive& archive) {
        archive(sign);
        for (std::uint32_t* flag : {&has_floor, &is_negative, &has_boundary, &boundary_has_floor}) archive(*flag);
        archive(floor);
        archive(boundary_floor);
        visit_topology(topology, archive);
        archive(regions);
        archive(record_count);
        archive(numbers);
        archive(sample);
        archive(name);
        archive(box);
        archive(vertices);
        archive(triangles);
        archive(surface_vertices);
        archive(surface_faces);
        archive(order);
        archive(non_manifold);
        archive(sites);
        archive(slivers);
        archive(saddle_vertices);
        archive(boxes);
        archive(slopes);
        archive(corners);
        archive(begins);
        visit_movable(archive);
    }

private:
    template <typename Archive>
    void visit_movable(Archive& archive) {
        archive(margin);
        for (std::uint32_t* flag : {&has_volume, &first_is_negative, &loops_have_floor}) archive(*flag);
        archive(loops_floor);
        archive(first);
        archive(faces_about);
        archive(order_about);
        for (std::vector<std::uint32_t>* list : {&vertex_numbers, &own_vertices, &own_faces, &places}) archive(*list);
        archive(sample_triangles);
        archive(loop_vertices);
        archive(loop_begins);
    }
};

bool are_below(std::span<const std::uint32_t> values, std::size_t limit) {
    return std::ranges::all_of(values, [&](std::uint32_t value) { return value < limit; });
}

template <typename Number>
bool is_ascending(const std::vector<Number>& values) {
    return std::ranges::adjacent_find(values, std::greater_equal<>()) == values.end();
}

bool is_permutation(std::span<const std::uint32_t> order) {
    std::vector<bool> is_there(order.size());
    for (const std::uint32_t place : order) {
        if (place >= order.size() || is_there[place]) return false;
        is_there[place] = true;
    }
    return true;
}

/// As restrict_to() takes it.
bool is_usable(const Region& region) {
    const auto& [box, half_width, spacing] = region;
    bool is_usable = half_width > 0 && std::isfinite(half_width) && spacing >= 0 && std::isfinite(spacing) &&
                     is_finite(box.lower) && is_finite(box.upper);
    for (std::size_t axis = 0; axis < 3; ++axis) is_usable = is_usable && box.lower[axis] <= box.upper[axis];
    return is_usable;
}

/// Whether every index lies within the list that it is of. The hash tells damage; this keeps bytes that were made by
/// something else from reading beyond.
bool fits(const Content& c) {
    const std::size_t faces = c.triangles.size(), vertices = c.vertices.size();
    bool fits = faces > 0 && c.order.size() == faces && c.slopes.size() == faces && c.numbers.size() == faces &&
                is_permutation(c.order) && are_below(c.non_manifold, 3 * faces) && are_below(c.slivers, faces) &&
                (c.surface_vertices.empty() ||
                 (c.surface_vertices.size() == vertices && are_below(c.surface_vertices, vertices))) &&
                (c.surface_faces.empty() || c.surface_faces.size() == faces) && !c.regions.empty() &&
                c.sign > static_cast<std::int32_t>(SignRule::automatic) &&
                c.sign <= static_cast<std::int32_t>(SignRule::below) && !c.begins.empty() && c.begins.front() == 0 &&
                c.begins.back() == c.corners.size() && is_ascending(c.begins);
    for (const Region& region : c.regions) fits = fits && is_usable(region);
    for (const Triangle& triangle : c.triangles) fits = fits && are_below(triangle, vertices);
    for (const StoredSite& site : c.sites) fits = fits && site.vertex < vertices && site.face < faces;
    for (const SignSurface::Use use : c.surface_faces) fits = fits && use != 0 && use >= -2 && use <= 2;
    return fits;
}

bool are_below(std::span<const Triangle> triangles, std::size_t limit) {
    return std::ranges::all_of(triangles, [&](const Triangle& triangle) { return are_below(triangle, limit); });
}

/// The same of what a part that moves has beside.
bool fits_to_move(const Content& c) {
    if (c.margin == 0) return true;
    const std::size_t vertices = c.first.size(), faces = c.faces_about.size();
    return c.margin > 0 && std::isfinite(c.margin) && faces > 0 && c.order_about.size() == faces &&
           is_permutation(c.order_about) && c.vertex_numbers.size() == vertices && c.places.size() == vertices &&
           is_ascending(c.vertex_numbers) && c.own_vertices.size() == c.vertices.size() &&
           is_ascending(c.own_vertices) && are_below(c.own_vertices, vertices) &&
           c.own_faces.size() == c.triangles.size() && is_ascending(c.own_faces) && are_below(c.own_faces, faces) &&
           are_below(c.faces_about, vertices) && are_below(c.sample_triangles, vertices) &&
           c.sample_triangles.size() == c.sample.size() && are_below(c.loop_vertices, vertices) &&
           !c.loop_begins.empty() && c.loop_begins.front() == 0 && c.loop_begins.back() == c.loop_vertices.size() &&
           is_ascending(c.loop_begins);
}

void set_movable(const MovablePart& movable, Content& content) {
    content.margin = movable.margin;
    content.has_volume = movable.encloses_negative_volume ? 1 : 0;
    content.first_is_negative = movable.encloses_negative_volume.value_or(false) ? 1 : 0;
    content.first = movable.mesh.vertices();
    content.faces_about = movable.mesh.triangles();
    content.order_about = movable.order;
    content.vertex_numbers = movable.numbers;
    content.own_vertices = movable.vertices;
    content.own_faces = movable.faces;
    content.places = movable.places;
    content.sample_triangles = movable.sample;
    content.loop_vertices = movable.loops.vertices;
    content.loop_begins = movable.loops.begins;
    content.loops_have_floor = movable.loops.floor ? 1 : 0;
    content.loops_floor = movable.loops.floor.value_or(0);
}

std::shared_ptr<const MovablePart> movable_of(Content& content, const std::string& name) {
    if (content.margin == 0) return nullptr;
    MovablePart movable{.margin = content.margin,
                        .mesh = Mesh(std::move(content.first), std::move(content.faces_about), name),
                        .order = std::move(content.order_about),
                        .numbers = std::move(content.vertex_numbers),
                        .vertices = std::move(content.own_vertices),
                        .faces = std::move(content.own_faces),
                        .places = std::move(content.places),
                        .sample = std::move(content.sample_triangles)};
    movable.loops.vertices = std::move(content.loop_vertices);
    movable.loops.begins = std::move(content.loop_begins);
    if (content.loops_have_floor != 0) movable.loops.floor = content.loops_floor;
    if (content.has_volume != 0) movable.encloses_negative_volume = content.first_is_negative != 0;
    return std::make_shared<const MovablePart>(std::move(movable));
}

}  // namespace

std::vector<std::byte> bytes_of(const RegionPart& part, const SignOfWhole& sign) {
    Content content;
    content.sign = static_cast<std::int32_t>(sign.sign);
    content.has_floor = sign.floor ? 1 : 0;
    content.floor = sign.floor.value_or(0);
    content.topology = sign.topology;
    content.is_negative = !part.encloses_negative_volume ? unknown_volume : *part.encloses_negative_volume ? 1 : 0;
    content.regions = part.restriction.regions;
    content.record_count = part.restriction.record_count;
    content.numbers = part.restriction.numbers;
    content.sample = part.restriction.sample;
    const Mesh& mesh = part.mesh.mesh;
    content.name.assign(mesh.name().begin(), mesh.name().end());
    content.box = mesh.box();
    content.vertices = mesh.vertices();
    content.triangles = mesh.triangles();
    content.surface_vertices = part.mesh.surface.vertices;
    content.surface_faces = part.mesh.surface.faces;
    const KeptArray<std::uint32_t>& order = part.mesh.topology->order;
    content.order.assign(order.begin(), order.end());
    content.non_manifold = non_manifold_edges(*part.mesh.topology);
    const Frusta& frusta = part.mesh.frusta;
    content.sites = stored_sites(frusta.sites);
    content.slivers = frusta.slivers;
    content.saddle_vertices = frusta.saddle_vertices;
    content.boxes = frusta.boxes;
    content.slopes.assign(frusta.slopes.begin(), frusta.slopes.end());
    content.begins = {0};
    if (part.boundary) {
        content.has_boundary = 1;
        content.corners = part.boundary->corners;
        content.begins = part.boundary->begins;
        content.boundary_has_floor = part.boundary->floor ? 1 : 0;
        content.boundary_floor = part.boundary->floor.value_or(0);
    }
    if (part.movable) set_movable(*part.movable, content);
    ArchiveHead head = own_head;
    head.size = archived_size(content);
    std::vector<std::byte> bytes(sizeof(head) + static_cast<std::size_t>(head.size));
    const std::span<std::byte> values = std::span(bytes).subspan(sizeof(head));
    WritingArchive archive(values);
    content.visit(archive);
    head.hash = hash_of(values);
    std::memcpy(bytes.data(), &head, sizeof(head));
    return bytes;
}

StoredPart part_of_bytes(std::span<const std::byte> bytes) {
    ArchiveHead head;
    if (bytes.size() < sizeof(head)) refuse(fmt::format("there are {}, fewer than its head has", bytes.size()));
    std::memcpy(&head, bytes.data(), sizeof(head));
    bytes = bytes.subspan(sizeof(head));
    if (const std::optional<std::string> obstacle = obstacle_to_reading(head, own_head)) refuse(*obstacle);
    if (head.size != bytes.size()) refuse(fmt::format("{} follow the head, which states {}", bytes.size(), head.size));
    if (head.hash != hash_of(bytes)) refuse("they were changed since they were written");
    Content content;
    try {
        ReadingArchive archive(bytes);
        content.visit(archive);
        if (!archive.is_at_end()) refuse("more follow than a part has");
    } catch (const ReadingArchive::Ended&) {
        refuse("they end too early");
    }
    if (!fits(content) || !fits_to_move(content)) refuse("an index or a count is out of range");

    SignSurface surface;
    surface.vertices = std::move(content.surface_vertices);
    surface.faces = std::move(content.surface_faces);
    Mesh mesh(std::move(content.vertices), std::move(content.triangles),
              std::string(content.name.begin(), content.name.end()));
    Restriction restriction(std::move(content.regions));
    restriction.record_count = static_cast<std::size_t>(content.record_count);
    restriction.numbers = content.numbers;
    restriction.sample = std::move(content.sample);
    StoredPart stored{
        {make_part(std::move(mesh), content.box, std::move(surface), std::move(content.numbers),
                   std::move(content.order), content.non_manifold),
         std::move(restriction),
         content.is_negative == unknown_volume ? std::nullopt : std::optional(content.is_negative != 0)},
        {static_cast<SignRule>(content.sign), content.has_floor != 0 ? std::optional(content.floor) : std::nullopt,
         std::move(content.topology)}};
    Frusta& frusta = stored.part.mesh.frusta;
    frusta.sites = sites_of(content.sites);
    if (!std::ranges::all_of(frusta.sites, [&](const auto& site) { return site.vertex < frusta.positions.size(); }))
        refuse("an index or a count is out of range");
    frusta.slivers = std::move(content.slivers);
    frusta.saddle_vertices = static_cast<std::size_t>(content.saddle_vertices);
    frusta.boxes = static_cast<std::size_t>(content.boxes);
    frusta.slopes = std::move(content.slopes);
    if (content.has_boundary != 0) {
        auto boundary = std::make_shared<OpenBoundary>();
        boundary->corners = std::move(content.corners);
        boundary->begins = std::move(content.begins);
        if (content.boundary_has_floor != 0) boundary->floor = content.boundary_floor;
        stored.part.boundary = std::move(boundary);
    }
    stored.part.movable = movable_of(content, stored.part.mesh.mesh.name());
    return stored;
}

}  // namespace clsdf::engine
