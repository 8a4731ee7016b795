#include "core/files.hpp"
#include "core/outputs.hpp"
#include "core/refuse.hpp"
#include "io/meshes/mesh_files.hpp"
#include "io/meshes/npy_header.hpp"
#include "io/meshes/point_arrays.hpp"
#include "io/meshes/point_results.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>

namespace clsdf {

namespace {

enum class PointFormat { npy, csv, ply };

PointFormat format_of_points(const std::string& path) {
    const std::string ending = ending_of(path);
    if (ending == ".npy") return PointFormat::npy;
    if (ending == ".csv") return PointFormat::csv;
    if (ending == ".ply") return PointFormat::ply;
    refuse_unsupported("'{}' does not end like a file of points; the endings are .npy, .csv and .ply", path);
}

FileContent text_of_points(const std::string& path) {
    FileContent content(path);
    refuse_other_content(content);
    return content;
}

/// Whether a field of a table stands for no value: as pandas writes and reads it, R, databases and spreadsheets.
bool is_missing(std::string_view field) {
    if (field.empty()) return true;
    if (std::string_view("+-.0123456789").find(field.front()) != std::string_view::npos) return false;
    constexpr std::array<std::string_view, 12> marks{"na",  "n/a",  "null",  "none",    "#n/a",    "#n/a n/a",
                                                     "#na", "<na>", "#num!", "#div/0!", "#value!", "\\n"};
    return std::ranges::any_of(marks, [&](std::string_view mark) { return equals_ignoring_case(field, mark); });
}

/// The rows of a table with commas between its fields; lines end with LF, CR LF, LF CR or CR.
class CsvRows {
public:
    explicit CsvRows(const FileContent& file) : path_(file.path()), rest_(file.text()) {
        constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
        if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
    }

    /// The fields of the next line that is not empty; false at the end.
    bool next(std::vector<std::string_view>& fields) {
        std::string_view line;
        do {
            if (rest_.empty()) return false;
            const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
            line = rest_.substr(0, end);
            const std::string_view ending = rest_.substr(end);
            const bool is_pair =
                ending.starts_with("\r\n") || (ending.starts_with("\n\r") && !ending.starts_with("\n\r\n"));
            rest_.remove_prefix(std::min(end + (is_pair ? 2U : 1U), rest_.size()));
            ++line_;
        } while (line.find_first_not_of(" \t") == std::string_view::npos);
        fields.clear();
        // A field is in quotes if it begins with one; two in a row within it are a character.
        bool is_quoted = false, in_quotes = false;
        std::size_t begin = 0;
        for (std::size_t at = 0; at <= line.size(); ++at) {
            if (at < line.size() && line[at] == '"') {
                if (line.find_first_not_of(" \t", begin) == at) is_quoted = true;
                in_quotes = is_quoted && !in_quotes;
            }
            if (at < line.size() && (line[at] != ',' || in_quotes)) continue;
            fields.push_back(trimmed(line.substr(begin, at - begin)));
            begin = at + 1;
            is_quoted = false;
        }
        if (in_quotes) fail("a quotation mark has no partner on its line");
        return true;
    }

    /// NaN if the field is empty or a mark of a value that is missing.
    double number(std::string_view field) const {
        if (is_missing(field)) return std::numeric_limits<double>::quiet_NaN();
        TextScanner scanner(field, path_, {}, line_);
        scanner.next_line();
        const double value = scanner.real("a number");
        if (!scanner.at_end_of_line()) scanner.fail_word("a number", field);
        return value;
    }

    [[noreturn]] void fail(const std::string& reason) const {
        throw Error(ErrorCode::unreadable_input, fmt::format("{}: line {}: {}", path_, line_, reason));
    }

private:
    static std::string_view trimmed(std::string_view field) {
        const std::size_t begin = std::min(field.find_first_not_of(" \t\""), field.size());
        const std::size_t end = field.find_last_not_of(" \t\"");
        return end == std::string_view::npos ? std::string_view() : field.substr(begin, end - begin + 1);
    }

    const std::string& path_;
    std::string_view rest_;
    std::size_t line_ = 0;
};

/// Whether a column has the coordinates along an axis. ParaView names them "Points:0" or "Points_0".
bool is_axis(std::string_view name, std::size_t axis) {
    constexpr std::array<std::string_view, 3> letters{"x", "y", "z"};
    if (equals_ignoring_case(name, letters[axis])) return true;
    return name.size() == 8 && name.starts_with("Points") && (name[6] == ':' || name[6] == '_') &&
           name[7] == "012"[axis];
}

/// Rows of the columns with these names.
template <std::size_t count, typename HasName>
std::vector<std::array<double, count>> read_csv_rows(const FileContent& file,
                                                     const std::array<const char*, count>& names,
                                                     const HasName& has_name_of) {
    CsvRows rows(file);
    std::vector<std::string_view> fields;
    if (!rows.next(fields))
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: the file has no text; it begins with a row of names, {} among them", file.path(),
                                fmt::join(names, ",")));
    const std::string first_row = fmt::format("{}", fmt::join(fields, ","));
    // NumPy writes the names as a comment.
    if (fields.front().starts_with('#'))
        fields.front().remove_prefix(std::min(fields.front().find_first_not_of("# \t"), fields.front().size()));
    std::array<std::size_t, count> columns{};
    for (std::size_t axis = 0; axis < count; ++axis) {
        const auto has_name = [&](std::string_view name) { return has_name_of(name, axis); };
        const auto found = std::find_if(fields.begin(), fields.end(), has_name);
        if (found == fields.end())
            rows.fail(
                fmt::format("the first row, {}, has no column '{}'; write the names of the columns there, with "
                            "commas between them, as in {}",
                            quoted(first_row, 80), names[axis], fmt::join(names, ",")));
        if (const auto second = std::find_if(found + 1, fields.end(), has_name); second != fields.end())
            rows.fail(fmt::format("columns {} and {} both have the coordinate '{}' ({} and {}); leave one of them",
                                  found - fields.begin() + 1, second - fields.begin() + 1, names[axis], quoted(*found),
                                  quoted(*second)));
        columns[axis] = static_cast<std::size_t>(found - fields.begin());
    }
    const std::size_t width = fields.size();
    std::vector<std::array<double, count>> points;
    while (rows.next(fields)) {
        if (fields.size() != width)
            rows.fail(fmt::format("the row has {} fields, and the first one names {} columns", fields.size(), width));
        std::array<double, count> point{};
        for (std::size_t axis = 0; axis < count; ++axis) point[axis] = rows.number(fields[columns[axis]]);
        points.push_back(point);
    }
    return points;
}

/// The outputs that there are, and their values by point.
struct Columns {
    std::vector<OutputInfo> infos;
    std::vector<std::span<const std::byte>> values;
    std::vector<std::uint32_t> group_numbers;

    Columns(std::size_t points, const FieldSlab& results, OutputSet wanted, std::span<const float> winding,
            const FaceGroups* groups) {
        infos.push_back(info_of(Output::distance));
        for (const OutputInfo& info : extra_outputs())
            if (wanted.contains(info.output) || !results.bytes(info.output).empty()) infos.push_back(info);
        for (const OutputInfo& info : infos) {
            values.push_back(results.bytes(info.output));
            if (values.back().size() != points * info.sample_bytes())
                refuse("there are {} points, and the array of the output {} holds {} values of {}", points, info.name,
                       values.back().size() / bytes_of(info.type), points * info.components);
        }
        if (groups != nullptr) add_groups(points, results.triangle(), *groups);
        add_own(points, winding, {.name = "winding", .description = "winding number"});
    }

    /// A column of an array that is no output's, unless it is empty.
    template <typename Value>
    void add_own(std::size_t points, std::span<const Value> own, const OutputInfo& info) {
        if (own.empty()) return;
        if (own.size() != points)
            refuse("there are {} points, and the array of the column {} holds {} values; give as many", points,
                   info.name, own.size());
        infos.push_back(info);
        values.push_back(std::as_bytes(own));
    }

    void add_groups(std::size_t points, std::span<const std::uint32_t> triangles, const FaceGroups& groups) {
        if (triangles.size() != points)
            refuse(
                "the groups of {} points follow from the output triangle, which has {} values; ask "
                "for it, too",
                points, triangles.size());
        for (const std::uint32_t triangle : triangles) group_numbers.push_back(groups.of(triangle));
        infos.push_back({.name = "group", .description = "group of the nearest triangle", .type = ElementType::uint32});
        values.push_back(std::as_bytes(std::span(group_numbers)));
    }

    /// "closest_x" for a component, "distance" for a single value.
    static std::string name(const OutputInfo& info, std::size_t component) {
        if (info.components == 1) return info.name;
        return fmt::format("{}_{}", info.name,
                           info.components == 3 ? std::string(1, "xyz"[component]) : fmt::format("{}", component + 1));
    }

    /// visit(info, component, address of the value) for each value of a point.
    template <typename Visit>
    void for_each_value(std::size_t point, const Visit& visit) const {
        for (std::size_t k = 0; k < infos.size(); ++k) {
            const std::byte* at = values[k].data() + point * infos[k].sample_bytes();
            for (std::size_t c = 0; c < infos[k].components; ++c, at += bytes_of(infos[k].type)) visit(infos[k], c, at);
        }
    }
};

/// The name of a type in .ply files.
const char* ply_name_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return "double";
        case ElementType::uint32:
            return "uint";
        case ElementType::uint8:
            return "uchar";
        default:
            return "float";
    }
}

/// Rows of bytes, written in large pieces.
class RowWriter {
public:
    explicit RowWriter(AtomicFile& file) : file_(file) {}

    template <typename Number>
    void add(Number number) {
        std::array<std::byte, sizeof(Number)> bytes{};
        store_little_endian(bytes.data(), number);
        buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
        if (buffer_.size() > piece_bytes) flush();
    }
    void add(ElementType type, const std::byte* value) {
        with_number(type, value, std::endian::native, [&](auto number) { add(number); });
    }
    void flush() {
        file_.write(buffer_);
        buffer_.clear();
    }

private:
    static constexpr std::size_t piece_bytes = std::size_t{1} << 16U;
    AtomicFile& file_;
    std::vector<std::byte> buffer_;
};

void write_npy_points(std::size_t points, const Columns& columns, AtomicFile& file) {
    std::string members;
    for (const OutputInfo& info : columns.infos)
        members += info.components == 1
                       ? fmt::format("('{}', '{}'), ", info.name, npy_name_of(info.type))
                       : fmt::format("('{}', '{}', ({},)), ", info.name, npy_name_of(info.type), info.components);
    members.resize(members.size() - 2);
    file.write(npy_header(fmt::format("[{}]", members), {static_cast<std::int64_t>(points)}));
    RowWriter rows(file);
    for (std::size_t i = 0; i < points; ++i)
        columns.for_each_value(
            i, [&](const OutputInfo& info, std::size_t, const std::byte* value) { rows.add(info.type, value); });
    rows.flush();
}

void write_ply_points(std::span<const Vec3> points, const Columns& columns, AtomicFile& file) {
    std::string header = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment written by clsdf\nelement vertex {}\n"
        "property double x\nproperty double y\nproperty double z\n",
        points.size());
    for (const OutputInfo& info : columns.infos)
        for (std::size_t c = 0; c < info.components; ++c)
            header += fmt::format("property {} {}\n", ply_name_of(info.type), Columns::name(info, c));
    file.write(header + "end_header\n");
    RowWriter rows(file);
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (const double x : points[i]) rows.add(x);
        columns.for_each_value(
            i, [&](const OutputInfo& info, std::size_t, const std::byte* value) { rows.add(info.type, value); });
    }
    rows.flush();
}

/// "{}" writes the shortest digits that are read back as the same number. It writes the sign of a NaN, too, which has
/// no meaning.
void write_csv_points(std::span<const Vec3> points, const Columns& columns, AtomicFile& file) {
    fmt::memory_buffer text;
    const auto add = [&](auto value) { fmt::format_to(std::back_inserter(text), "{}", value); };
    add("x,y,z");
    for (const OutputInfo& info : columns.infos)
        for (std::size_t c = 0; c < info.components; ++c) add(fmt::format(",{}", Columns::name(info, c)));
    for (std::size_t i = 0; i < points.size(); ++i) {
        add('\n');
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (axis > 0) add(',');
            add(points[i][axis]);
        }
        columns.for_each_value(i, [&](const OutputInfo& info, std::size_t, const std::byte* value) {
            add(',');
            with_number(info.type, value, std::endian::native, [&](auto number) {
                if constexpr (std::is_floating_point_v<decltype(number)>)
                    add(std::isnan(number) ? std::abs(number) : number);
                else
                    add(+number);  // not as a letter
            });
        });
        if (text.size() < (std::size_t{1} << 16U)) continue;
        file.write(std::string_view(text.data(), text.size()));
        text.clear();
    }
    add('\n');
    file.write(std::string_view(text.data(), text.size()));
}

bool is_npy_of_results(const std::string& path) {
    const std::string ending = ending_of(path);
    if (ending == ".npy") return true;
    if (ending == ".csv") return false;
    refuse_unsupported("'{}' does not end like a file of results at points; the endings are .npy and .csv", path);
}

void check_rays_ending(const std::string& path) {
    const std::string ending = ending_of(path);
    if (ending != ".npy" && ending != ".csv")
        refuse_unsupported("'{}' does not end like a file of rays; the endings are .npy and .csv", path);
}

void write_npy_rays(std::size_t rays, const RayHits& hits, const FaceGroups* groups, AtomicFile& file) {
    const std::string shape = hits.most == 1 ? "" : fmt::format(", ({},)", hits.most);
    const std::string group = groups == nullptr ? "" : fmt::format(", ('group', '<u4'{})", shape);
    file.write(npy_header(fmt::format("[('t', '<f8'{0}), ('triangle', '<u4'{0}){1}{2}]", shape, group,
                                      hits.counts.empty() ? "" : ", ('count', '<u4')"),
                          {static_cast<std::int64_t>(rays)}));
    RowWriter rows(file);
    for (std::size_t i = 0; i < rays; ++i) {
        for (std::size_t k = 0; k < hits.most; ++k) rows.add(hits.t[i * hits.most + k]);
        const auto triangles = hits.triangles.subspan(i * hits.most, hits.most);
        for (const std::uint32_t triangle : triangles) rows.add(triangle);
        if (groups != nullptr)
            for (const std::uint32_t triangle : triangles) rows.add(groups->of(triangle));
        if (!hits.counts.empty()) rows.add(hits.counts[i]);
    }
    rows.flush();
}

void write_csv_rays(const RayRows& rays, const RayHits& hits, const FaceGroups* groups, AtomicFile& file) {
    fmt::memory_buffer text;
    const auto add = [&](auto value) { fmt::format_to(std::back_inserter(text), "{}", value); };
    add("x,y,z,dx,dy,dz");
    for (std::size_t k = 0; k < hits.most; ++k) {
        const std::string number = hits.most == 1 ? "" : fmt::format("_{}", k + 1);
        add(fmt::format(",t{0},triangle{0}", number));
        if (groups != nullptr) add(",group" + number);
    }
    if (!hits.counts.empty()) add(",count");
    for (std::size_t i = 0; i < rays.origins.size(); ++i) {
        const Vec3 &o = rays.origins[i], &d = rays.directions[i];
        add(fmt::format("\n{},{},{},{},{},{}", o[0], o[1], o[2], d[0], d[1], d[2]));
        for (std::size_t k = 0; k < hits.most; ++k) {
            const double t = hits.t[i * hits.most + k];
            const std::uint32_t triangle = hits.triangles[i * hits.most + k];
            add(fmt::format(",{},{}", std::isnan(t) ? std::abs(t) : t, triangle));
            if (groups != nullptr) add(fmt::format(",{}", groups->of(triangle)));
        }
        if (!hits.counts.empty()) add(fmt::format(",{}", hits.counts[i]));
        if (text.size() < (std::size_t{1} << 16U)) continue;
        file.write(std::string_view(text.data(), text.size()));
        text.clear();
    }
    add('\n');
    file.write(std::string_view(text.data(), text.size()));
}

}  // namespace

std::vector<Vec3> read_points(const std::string& path, const std::function<void(const std::string&)>& log) try {
    switch (format_of_points(path)) {
        case PointFormat::npy:
            return read_npy_rows<3>(path, "points have the shape (n, 3), n >= 0, x, y and z a row");
        case PointFormat::csv:
            return read_csv_rows<3>(text_of_points(path), {"x", "y", "z"}, is_axis);
        case PointFormat::ply:
            break;
    }
    ReadingNotes notes;
    std::vector<Vec3> points = read_ply_points(text_of_points(path), notes);
    if (log)
        for (const std::string& text : notes.texts()) log(fmt::format("{}: {}", path, text));
    return points;
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read '{}'", path));
}

void write_points(std::span<const Vec3> points, const FieldSlab& results, const std::string& path, OutputSet wanted,
                  std::span<const float> winding, const FaceGroups* groups) {
    const PointFormat format = format_of_points(path);
    const Columns columns(points.size(), results, wanted, winding, groups);
    AtomicFile file(path);
    switch (format) {
        case PointFormat::npy:
            write_npy_points(points.size(), columns, file);
            break;
        case PointFormat::csv:
            write_csv_points(points, columns, file);
            break;
        case PointFormat::ply:
            write_ply_points(points, columns, file);
            break;
    }
    file.commit();
}

RayRows read_rays(const std::string& path) try {
    check_rays_ending(path);
    constexpr std::array<const char*, 6> names{"x", "y", "z", "dx", "dy", "dz"};
    const auto has_name = [&](std::string_view name, std::size_t k) { return equals_ignoring_case(name, names[k]); };
    const std::vector<std::array<double, 6>> rows =
        format_of_points(path) == PointFormat::npy
            ? read_npy_rows<6>(path, "rays have the shape (n, 6), n >= 0, the origin and the direction a row")
            : read_csv_rows<6>(text_of_points(path), names, has_name);
    RayRows rays;
    for (const auto& [x, y, z, dx, dy, dz] : rows) {
        rays.origins.push_back({x, y, z});
        rays.directions.push_back({dx, dy, dz});
    }
    return rays;
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read '{}'", path));
}

std::vector<double> read_point_numbers(const std::string& path, const char* name) try {
    if (is_npy_of_results(path)) return read_npy_numbers(path, name);
    const auto has_name = [&](std::string_view column, std::size_t) { return column == name; };
    std::vector<double> numbers;
    for (const auto& [number] : read_csv_rows<1>(text_of_points(path), {name}, has_name)) numbers.push_back(number);
    return numbers;
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read '{}'", path));
}

std::vector<Vec3> read_point_vectors(const std::string& path, const char* name) try {
    if (is_npy_of_results(path)) return read_npy_rows<3>(path, "vectors at points have the shape (n, 3), n >= 0", name);
    const std::array<std::string, 3> columns{fmt::format("{}_x", name), fmt::format("{}_y", name),
                                             fmt::format("{}_z", name)};
    const auto has_name = [&](std::string_view column, std::size_t axis) { return column == columns[axis]; };
    return read_csv_rows<3>(text_of_points(path), {columns[0].c_str(), columns[1].c_str(), columns[2].c_str()},
                            has_name);
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read '{}'", path));
}

void write_rays(const RayRows& rays, const RayHits& hits, const std::string& path, const FaceGroups* groups) {
    check_rays_ending(path);
    const std::size_t count = rays.origins.size();
    if (rays.directions.size() != count || hits.most == 0 || hits.t.size() != count * hits.most ||
        hits.triangles.size() != count * hits.most || (!hits.counts.empty() && hits.counts.size() != count))
        refuse(
            "there are {} origins, {} directions, {} values of t, {} triangles and {} counts; give "
            "as many, and {} of t and triangles for each ray",
            count, rays.directions.size(), hits.t.size(), hits.triangles.size(), hits.counts.size(), hits.most);
    AtomicFile file(path);
    if (format_of_points(path) == PointFormat::npy)
        write_npy_rays(count, hits, groups, file);
    else
        write_csv_rays(rays, hits, groups, file);
    file.commit();
}

void check_rays_path(const std::string& path) {
    check_rays_ending(path);
    check_writable(path);
}

void check_points_path(const std::string& path) {
    format_of_points(path);
    check_writable(path);
}

}  // namespace clsdf
