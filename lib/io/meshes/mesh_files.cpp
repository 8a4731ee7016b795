#include "io/meshes/mesh_files.hpp"

#include "core/files.hpp"
#include "core/refuse.hpp"
#include "io/meshes/face_groups.hpp"
#include "io/meshes/placement.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <fcntl.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <limits>
#include <new>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

namespace clsdf {

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorCode::unreadable_input, fmt::format("cannot read '{}': {}", path, reason));
}

[[noreturn]] void fail(const std::string& path, int error) {
    fail(path, std::generic_category().message(error));
}

}  // namespace

FileContent::FileContent(std::string path, std::size_t most_bytes) : path_(std::move(path)) {
    // Not blocking: opening a pipe would wait for its writer.
    const Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number() < 0) fail(path_, errno);
    struct stat status {};
    if (::fstat(file.number(), &status) != 0) fail(path_, errno);
    if (S_ISDIR(status.st_mode)) fail(path_, EISDIR);
    if (!S_ISREG(status.st_mode)) fail(path_, "it is a device or a pipe, not a file");

    // The file is read, not mapped: a mapped file that another process truncates ends the program with a signal. All
    // cores read, into memory on huge pages, because fresh memory and copying take most of the time.
    bytes_.resize(std::min(static_cast<std::size_t>(status.st_size), most_bytes));
    const ReadResult result =
        read_in_parallel(file, 0, std::as_writable_bytes(std::span(bytes_.data(), bytes_.size())));
    if (result.error != 0) fail(path_, result.error);
    if (result.bytes != bytes_.size())
        fail(path_, fmt::format("it became shorter, {} instead of {} bytes", result.bytes, bytes_.size()));
}

const char* ending_of(MeshFormat format) {
    switch (format) {
        case MeshFormat::off:
            return ".off";
        case MeshFormat::obj:
            return ".obj";
        case MeshFormat::stl:
            return ".stl";
        case MeshFormat::ply:
            break;
    }
    return ".ply";
}

namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 6> packing_programs{
    {{".gz", "gunzip"}, {".bz2", "bunzip2"}, {".xz", "unxz"}, {".zst", "unzstd"}, {".zip", "unzip"}, {".7z", "7z x"}}};

}  // namespace

MeshFormat format_of_ending(const std::string& path) {
    const std::string ending = ending_of(path);
    if (ending == ".off") return MeshFormat::off;
    if (ending == ".obj") return MeshFormat::obj;
    if (ending == ".stl") return MeshFormat::stl;
    if (ending == ".ply") return MeshFormat::ply;
    for (const auto& [packed, program] : packing_programs)
        if (ending == packed)
            refuse_unsupported(
                "'{0}' is compressed, by its ending; unpack it first, with '{1} {0}', and give the "
                "file .off, .obj, .stl or .ply that comes out",
                path, program);
    refuse_unsupported("'{}' does not end like a mesh file; the endings are .off, .obj, .stl and .ply", path);
}

namespace {

MeshArrays read_arrays(const FileContent& file, MeshFormat format, ReadingNotes& notes) {
    refuse_other_content(file, format);
    if (!notes.group_by.empty() && format != MeshFormat::ply)
        refuse("{}: groups by the property {} are of .ply files alone; leave it out", file.path(),
               clsdf::quoted(notes.group_by));
    switch (format) {
        case MeshFormat::off:
            return read_off(file, notes);
        case MeshFormat::obj:
            return read_obj(file, notes);
        case MeshFormat::stl:
            return read_stl(file, notes);
        case MeshFormat::ply:
            break;
    }
    return read_ply(file, notes);
}

/// Also names the option that leaves out a face of a vertex that is not finite.
Mesh mesh_of(MeshArrays arrays, const std::string& path) {
    try {
        return Mesh(std::move(arrays.vertices), std::move(arrays.triangles), path);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::invalid_mesh) throw;
        throw Error(error.code(), std::string(error.what()) + bad_facets_remedy);
    }
}

Mesh read_file(const std::string& path, const ReadOptions& options) {
    const MeshFormat format = format_of_ending(path);
    ReadingNotes notes;
    notes.skip_bad_facets = options.skip_bad_facets;
    notes.group_by = options.group_by;
    MeshArrays arrays = read_arrays(FileContent(path), format, notes);
    const std::vector<std::string> texts = notes.texts();
    if (arrays.triangles.empty()) {
        std::string reason = fmt::format("{}", fmt::join(texts, "; "));
        if (texts.empty() && !arrays.vertices.empty()) reason = cloud_of(arrays.vertices.size());
        throw Error(ErrorCode::invalid_mesh,
                    fmt::format("{}: there is no triangle{}{}", path, reason.empty() ? "" : "; ", reason));
    }
    const std::vector<GroupRun> runs = std::move(arrays.runs);
    Mesh mesh = mesh_of(std::move(arrays), path);
    if (format == MeshFormat::stl) mesh = weld(mesh);
    mesh.set_groups(groups_of(runs, mesh.triangles().size()));
    if (options.log)
        for (const std::string& text : texts) options.log(fmt::format("{}: {}", path, text));
    return mesh;
}

template <typename Read>
auto with_memory_for(const std::string& what, const Read& read) try {
    return read();
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read {}", what));
}

}  // namespace

void ReadingNotes::skip_face(const std::string& place, std::int64_t missing_vertex) {
    bad_faces.add([&] { return fmt::format("{} (there is no vertex {})", place, missing_vertex); });
}

void ReadingNotes::skip_face(const std::string& place, const Vec3& vertex) {
    bad_faces.add([&] { return fmt::format("{} (a vertex is ({}))", place, fmt::join(vertex, ", ")); });
}

std::string cloud_of(std::size_t points) {
    return fmt::format(
        "its {} {} a cloud of points, not a mesh; reconstruct a surface from them first, or, if they are the points of "
        "a "
        "query, give them as POINTS of clsdf query (read_points())",
        points, points == 1 ? "vertex is" : "vertices are");
}

namespace {

/// What is said of one StlIrregularity, and of several.
struct StlWords {
    const char* one;
    const char* several;
};
constexpr std::array<StlWords, stl_irregularities> stl_words{{
    {"1 name is joined to its 'solid' or 'endsolid'", "{} names are joined to their 'solid' or 'endsolid'"},
    {"the text ends without 'endsolid' and may be cut off", ""},
    {"1 solid begins before the one before it ends", "{} solids begin before the ones before them end"},
    {"1 'endsolid' ends no solid", "{} 'endsolid' end no solid"},
    {"1 facet begins on the line of its solid's name", "{} facets begin on the lines of their solids' names"},
    {"1 facet has no normal", "{} facets have no normal"},
    {"1 loop is in no facet", "{} loops are in no facet"},
    {"1 facet has no 'endfacet'", "{} facets have no 'endfacet'"},
    {"1 colour is skipped", "{} colours are skipped"},
    {"1 comment is skipped", "{} comments are skipped"},
}};

}  // namespace

std::vector<std::string> ReadingNotes::texts() const {
    std::vector<std::string> texts;
    const auto plural = [](std::size_t count) { return count == 1 ? "" : "s"; };
    if (bad_faces.count > 0)
        texts.push_back(
            fmt::format("{} with a vertex that does not exist or is not finite {} left out, the first at {}",
                        bad_faces.count == 1 ? "1 face" : fmt::format("{} faces", bad_faces.count),
                        bad_faces.count == 1 ? "is" : "are", bad_faces.first));
    if (small_faces.count > 0)
        texts.push_back(fmt::format("{} face{} of fewer than three corners {} skipped, the first at {}",
                                    small_faces.count, plural(small_faces.count), small_faces.count == 1 ? "is" : "are",
                                    small_faces.first));
    if (weights.count > 0)
        texts.push_back(
            fmt::format("{} {} a fourth number w other than 1, the first at {}; x, y and z are divided by it",
                        weights.count, weights.count == 1 ? "vertex has" : "vertices have", weights.first));
    if (unknown_lines.count > 0)
        texts.push_back(fmt::format("{} line{} with keywords that OBJ does not have {} skipped, the first at {}",
                                    unknown_lines.count, plural(unknown_lines.count),
                                    unknown_lines.count == 1 ? "is" : "are", unknown_lines.first));
    if (header_lines.count > 0)
        texts.push_back(fmt::format("{} line{} of the header {} no keyword and {} skipped, the first at {}",
                                    header_lines.count, plural(header_lines.count),
                                    header_lines.count == 1 ? "has" : "have", header_lines.count == 1 ? "is" : "are",
                                    header_lines.first));
    for (std::size_t i = 0; i < stl.size(); ++i)
        if (stl[i].count == 1)
            texts.push_back(fmt::format("{}, at {}", stl_words[i].one, stl[i].first));
        else if (stl[i].count > 1)
            texts.push_back(fmt::format("{}, the first at {}",
                                        fmt::format(fmt::runtime(stl_words[i].several), stl[i].count), stl[i].first));
    if (padding > 0)
        texts.push_back(fmt::format("{} byte{} of zeros or Ctrl-Z after the text {} skipped", padding, plural(padding),
                                    padding == 1 ? "is" : "are"));
    if (uncut.count > 0)
        texts.push_back(fmt::format(
            "{}, whose triangles may overlap, because ears were not found within a limit of steps; divide {} into "
            "triangles beforehand ({} that of triangle {}, with {} corners)",
            uncut.count == 1 ? "1 polygon becomes a fan" : fmt::format("{} polygons become fans", uncut.count),
            uncut.count == 1 ? "it" : "them", uncut.count == 1 ? "it is" : "the first is", uncut.first_triangle,
            uncut.corners));
    if (bytes_after > 0)
        texts.push_back(fmt::format("{} byte{} after the last {} {} skipped", bytes_after, plural(bytes_after), last,
                                    bytes_after == 1 ? "is" : "are"));
    return texts;
}

Mesh read_mesh(const std::string& path, const ReadOptions& options) {
    check_placement(options);
    return with_memory_for(fmt::format("'{}'", path), [&] { return placed(read_file(path, options), options); });
}

Mesh read_meshes(std::span<const std::string> paths, const ReadOptions& options) {
    if (paths.empty()) refuse("no file of a mesh is given; name one or more");
    if (paths.size() == 1) return read_mesh(paths[0], options);
    check_placement(options);
    return with_memory_for(fmt::format("the meshes '{}'", fmt::join(paths, "', '")), [&] {
        MeshArrays all;
        NamedGroups groups;
        for (const std::string& path : paths) {
            const Mesh mesh = placed(read_file(path, options), options);
            const std::size_t first = all.vertices.size();
            if (mesh.vertices().size() >= std::numeric_limits<std::uint32_t>::max() - first)
                refuse_unsupported(
                    "'{}' and the files before it have {} vertices, and a mesh has fewer than "
                    "4294967295; leave some out",
                    path, first + mesh.vertices().size());
            all.vertices.insert(all.vertices.end(), mesh.vertices().begin(), mesh.vertices().end());
            for (const Triangle& triangle : mesh.triangles()) {
                const auto shift = static_cast<std::uint32_t>(first);
                all.triangles.push_back({shift + triangle[0], shift + triangle[1], shift + triangle[2]});
            }
            groups.add_file(path, mesh.groups(), mesh.triangles().size());
        }
        Mesh mesh(std::move(all.vertices), std::move(all.triangles), fmt::format("{}", fmt::join(paths, " + ")));
        mesh.set_groups(groups.take());
        return mesh;
    });
}

}  // namespace clsdf
