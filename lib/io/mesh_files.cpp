#include "io/mesh_files.hpp"

#include "core/files.hpp"
#include "core/real_numbers.hpp"
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
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <new>
#include <span>
#include <system_error>
#include <utility>

namespace clsdf {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

bool is_line_end(char c) {
    return c == '\n' || c == '\r';
}

/// read_real() does not set a value that is out of range. Here numbers that are too small round to zero, and numbers
/// that are too large to infinity.
double out_of_range_value(std::string_view word) {
    const bool negative = word.front() == '-';
    if (negative) word.remove_prefix(1);
    const std::string_view mantissa = word.substr(0, word.find_first_of("eE"));
    std::string_view exponent = word.substr(std::min(mantissa.size() + 1, word.size()));
    if (exponent.starts_with('+')) exponent.remove_prefix(1);
    std::int64_t power = 0;
    if (std::from_chars(exponent.data(), exponent.data() + exponent.size(), power).ec == std::errc::result_out_of_range)
        power = exponent.front() == '-' ? std::numeric_limits<std::int64_t>::min() / 2
                                        : std::numeric_limits<std::int64_t>::max() / 2;
    // The power of ten of the first digit that is not zero.
    power += static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size())) -
             static_cast<std::int64_t>(mantissa.find_first_of("123456789"));
    const double magnitude = power < 0 ? 0.0 : std::numeric_limits<double>::infinity();
    return negative ? -magnitude : magnitude;
}

/// "0,000000e+00": as programs write numbers in the language of a country that has a comma there.
bool is_decimal_comma(std::string_view word) {
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos || comma + 1 == word.size()) return false;
    std::string text(word);
    text[comma] = '.';
    const std::string_view digits = std::string_view(text).substr(text[0] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, error] = read_real(digits.data(), digits.data() + digits.size(), value);
    return error != std::errc::invalid_argument && end == digits.data() + digits.size();
}

}  // namespace

TextScanner::TextScanner(std::string_view text, const std::string& path, Syntax syntax, std::size_t first_line)
    : position_(text.data()), end_(text.data() + text.size()), path_(&path), syntax_(syntax), line_(first_line) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (text.starts_with(byte_order_mark)) position_ += byte_order_mark.size();
}

std::size_t TextScanner::line_end_length() const {
    if (position_ == end_ || !is_line_end(*position_)) return 0;
    const auto next_is = [&](std::ptrdiff_t ahead, char c) {
        return end_ - position_ > ahead && position_[ahead] == c;
    };
    if (*position_ == '\r') return next_is(1, '\n') ? 2 : 1;
    // LF CR, unless that CR begins a CR LF.
    return next_is(1, '\r') && !next_is(2, '\n') ? 2 : 1;
}

void TextScanner::skip_line_end() {
    position_ += line_end_length();
    ++line_;
}

void TextScanner::skip_blanks() {
    while (position_ != end_) {
        if (is_blank(*position_)) {
            ++position_;
        } else if (*position_ == '\\' && syntax_.line_continuation) {
            ++position_;
            if (line_end_length() == 0) {
                --position_;
                return;
            }
            skip_line_end();
        } else if (*position_ == '#' && syntax_.hash_comments) {
            while (position_ != end_ && !is_line_end(*position_)) ++position_;
            return;
        } else {
            return;
        }
    }
}

bool TextScanner::at_end_of_line() {
    skip_blanks();
    return position_ == end_ || is_line_end(*position_);
}

bool TextScanner::next_line() {
    if (!before_first_line_)
        while (!at_end_of_line()) word();
    before_first_line_ = false;
    while (at_end_of_line()) {
        if (position_ == end_) return false;
        skip_line_end();
    }
    return true;
}

bool TextScanner::end_line() {
    if (!at_end_of_line() || position_ == end_) return false;
    skip_line_end();
    return true;
}

std::string_view TextScanner::word() {
    if (at_end_of_line()) return {};
    const char* begin = position_;
    const auto ends_word = [&](const char* c) {
        if (is_blank(*c) || is_line_end(*c)) return true;
        if (*c == '#') return syntax_.hash_comments;
        return *c == '\\' && syntax_.line_continuation && c + 1 != end_ && is_line_end(c[1]);
    };
    while (position_ != end_ && !ends_word(position_)) ++position_;
    return {begin, static_cast<std::size_t>(position_ - begin)};
}

void TextScanner::skip(std::size_t letters) {
    skip_blanks();
    position_ += letters;
}

std::string_view TextScanner::word_of_text() {
    before_first_line_ = false;
    while (at_end_of_line()) {
        if (position_ == end_) return {};
        skip_line_end();
    }
    return word();
}

double TextScanner::real(const char* what) {
    return real_in(word(), what);
}

double TextScanner::real_in(std::string_view text, const char* what) const {
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = read_real(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) fail_word(what, text);
    return error == std::errc::result_out_of_range ? out_of_range_value(digits) : value;
}

std::int64_t TextScanner::integer(const char* what) {
    const std::string_view text = word();
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) fail_word(what, text);
    return value;
}

void TextScanner::first_line() {
    if (!next_line()) throw Error(ErrorCode::unreadable_input, fmt::format("{}: the file has no text", *path_));
}

void TextScanner::fail(const std::string& reason) const {
    fail(ErrorCode::unreadable_input, reason);
}

void TextScanner::fail(ErrorCode code, const std::string& reason) const {
    throw Error(code, fmt::format("{}: line {}: {}", *path_, line_, reason));
}

void TextScanner::fail_word(const char* what, std::string_view word) const {
    if (!word.empty())
        fail(fmt::format("expected {}, found {}{}", what, quoted(word),
                         is_decimal_comma(word) ? "; numbers have a decimal point, not a comma" : ""));
    if (position_ == end_) fail(fmt::format("expected {}, but the file ends", what));
    fail(fmt::format("expected {}, but the line ends", what));
}

bool equals_ignoring_case(std::string_view word, std::string_view lower) {
    return std::equal(word.begin(), word.end(), lower.begin(), lower.end(), [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
    });
}

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

MeshFormat format_of_ending(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (equals_ignoring_case(ending, ".off")) return MeshFormat::off;
    if (equals_ignoring_case(ending, ".obj")) return MeshFormat::obj;
    if (equals_ignoring_case(ending, ".stl")) return MeshFormat::stl;
    if (equals_ignoring_case(ending, ".ply")) return MeshFormat::ply;
    throw Error(ErrorCode::unsupported,
                fmt::format("'{}' does not end like a mesh file; the endings are .off, .obj, .stl and .ply", path));
}

namespace {

MeshArrays read_arrays(const FileContent& file, MeshFormat format, ReadingNotes& notes) {
    refuse_other_content(file, format);
    switch (format) {
        case MeshFormat::off:
            return read_off(file, notes);
        case MeshFormat::obj:
            return read_obj(file, notes);
        case MeshFormat::stl:
            return read_stl(file);
        case MeshFormat::ply:
            break;
    }
    return read_ply(file, notes);
}

Mesh read_file(const std::string& path, const ReadOptions& options) {
    const MeshFormat format = format_of_ending(path);
    ReadingNotes notes;
    MeshArrays arrays = read_arrays(FileContent(path), format, notes);
    const std::vector<std::string> texts = notes.texts();
    if (arrays.triangles.empty() && !texts.empty())
        throw Error(ErrorCode::invalid_mesh, fmt::format("{}: there is no triangle; {}", path, fmt::join(texts, "; ")));
    Mesh mesh(std::move(arrays.vertices), std::move(arrays.triangles), path);
    if (format == MeshFormat::stl) mesh = weld(mesh);
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

std::vector<std::string> ReadingNotes::texts() const {
    std::vector<std::string> texts;
    const auto plural = [](std::size_t count) { return count == 1 ? "" : "s"; };
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
    if (bytes_after > 0)
        texts.push_back(fmt::format("{} byte{} after the last row {} skipped", bytes_after, plural(bytes_after),
                                    bytes_after == 1 ? "is" : "are"));
    return texts;
}

namespace {

void check_placement(const ReadOptions& options) {
    if (!(options.scale > 0) || !std::isfinite(options.scale))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("scale: {} is no factor for lengths; give a finite number above 0", options.scale));
    for (const double step : options.translate)
        if (!std::isfinite(step))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("translate: {} is no length; give three finite numbers", step));
}

/// The mesh of a file in the unit and at the place of the options.
Mesh read_and_place(const std::string& path, const ReadOptions& options) {
    Mesh mesh = read_file(path, options);
    if (options.scale == 1 && options.translate == Vec3{}) return mesh;
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& position : positions)
        for (std::size_t axis = 0; axis < 3; ++axis)
            position[axis] = position[axis] * options.scale + options.translate[axis];
    try {
        mesh.set_positions(std::move(positions));
    } catch (const Error& error) {
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}, after the scale {} and the translation ({}); choose smaller ones", error.what(),
                                options.scale, fmt::join(options.translate, ", ")));
    }
    return mesh;
}

}  // namespace

Mesh read_mesh(const std::string& path, const ReadOptions& options) {
    check_placement(options);
    return with_memory_for(fmt::format("'{}'", path), [&] { return read_and_place(path, options); });
}

Mesh read_meshes(std::span<const std::string> paths, const ReadOptions& options) {
    if (paths.empty()) throw Error(ErrorCode::invalid_argument, "no file of a mesh is given; name one or more");
    if (paths.size() == 1) return read_mesh(paths[0], options);
    check_placement(options);
    return with_memory_for(fmt::format("the meshes '{}'", fmt::join(paths, "', '")), [&] {
        MeshArrays all;
        for (const std::string& path : paths) {
            const Mesh mesh = read_and_place(path, options);
            const std::size_t first = all.vertices.size();
            if (mesh.vertices().size() >= std::numeric_limits<std::uint32_t>::max() - first)
                throw Error(ErrorCode::unsupported,
                            fmt::format("'{}' and the files before it have {} vertices, and a mesh has fewer than "
                                        "4294967295; leave some out",
                                        path, first + mesh.vertices().size()));
            all.vertices.insert(all.vertices.end(), mesh.vertices().begin(), mesh.vertices().end());
            for (const Triangle& triangle : mesh.triangles()) {
                const auto shift = static_cast<std::uint32_t>(first);
                all.triangles.push_back({shift + triangle[0], shift + triangle[1], shift + triangle[2]});
            }
        }
        return Mesh(std::move(all.vertices), std::move(all.triangles), fmt::format("{}", fmt::join(paths, " + ")));
    });
}

namespace {

/// Buffers text and writes it to the file in large pieces.
class TextWriter {
public:
    explicit TextWriter(AtomicFile& file) : file_(file) {}

    template <typename... Values>
    void write(fmt::format_string<const Values&...> format, const Values&... values) {
        fmt::format_to(std::back_inserter(buffer_), format, values...);
        if (buffer_.size() > piece_bytes) flush();
    }
    void flush() {
        file_.write(std::string_view(buffer_.data(), buffer_.size()));
        buffer_.clear();
    }

private:
    static constexpr std::size_t piece_bytes = std::size_t{1} << 16U;
    AtomicFile& file_;
    fmt::memory_buffer buffer_;
};

/// "{}" writes the shortest digits that are read back as the same number.
void write_off(const Mesh& mesh, AtomicFile& file) {
    TextWriter text(file);
    text.write("OFF\n{} {} 0\n", mesh.vertices().size(), mesh.triangles().size());
    for (const auto& [x, y, z] : mesh.vertices()) text.write("{} {} {}\n", x, y, z);
    for (const auto& [a, b, c] : mesh.triangles()) text.write("3 {} {} {}\n", a, b, c);
    text.flush();
}

void write_obj(const Mesh& mesh, AtomicFile& file) {
    TextWriter text(file);
    for (const auto& [x, y, z] : mesh.vertices()) text.write("v {} {} {}\n", x, y, z);
    for (const auto& [a, b, c] : mesh.triangles())
        text.write("f {} {} {}\n", std::uint64_t{a} + 1, std::uint64_t{b} + 1, std::uint64_t{c} + 1);
    text.flush();
}

float to_float(double coordinate, std::uint32_t vertex) {
    const auto rounded = static_cast<float>(coordinate);
    if (!std::isfinite(rounded))
        throw Error(ErrorCode::unsupported,
                    fmt::format("STL holds 32-bit numbers, which end before the coordinate {} of vertex {}; choose "
                                "another format",
                                coordinate, vertex));
    return rounded;
}

std::array<float, 3> unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Vec3 v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const Vec3 n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(n[0], n[1], n[2]);
    // A zero normal tells readers to compute it from the vertices.
    if (!(length > 0) || !std::isfinite(length)) return {};
    return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
}

void write_stl(const Mesh& mesh, AtomicFile& file) {
    // Not "solid": readers would take the file for text.
    std::array<std::byte, 84> header{};
    constexpr std::string_view comment = "binary STL written by clsdf";
    for (std::size_t i = 0; i < comment.size(); ++i) header[i] = static_cast<std::byte>(comment[i]);
    store_little_endian(&header[80], static_cast<std::uint32_t>(mesh.triangles().size()));
    file.write(header);
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<std::byte, 50> record{};
        std::byte* address = record.data();
        const auto& vertices = mesh.vertices();
        for (const float x : unit_normal(vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]))
            address = store_little_endian(address, x);
        for (const std::uint32_t index : triangle)
            for (const double x : vertices[index]) address = store_little_endian(address, to_float(x, index));
        file.write(record);
    }
}

void write_ply(const Mesh& mesh, AtomicFile& file, std::span<const FaceColour> colours) {
    // Some readers know no unsigned indices.
    const bool fits_int = mesh.vertices().size() <= std::size_t{std::numeric_limits<std::int32_t>::max()};
    file.write(
        fmt::format("ply\nformat binary_little_endian 1.0\ncomment written by clsdf\nelement vertex {}\n"
                    "property double x\nproperty double y\nproperty double z\nelement face {}\n"
                    "property list uchar {} vertex_indices\n{}end_header\n",
                    mesh.vertices().size(), mesh.triangles().size(), fits_int ? "int" : "uint",
                    colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n"));
    for (const Vec3& vertex : mesh.vertices()) {
        std::array<std::byte, 24> record{};
        std::byte* address = record.data();
        for (const double x : vertex) address = store_little_endian(address, x);
        file.write(record);
    }
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face) {
        std::array<std::byte, 16> record{std::byte{3}};
        std::byte* address = record.data() + 1;
        for (const std::uint32_t index : mesh.triangles()[face]) address = store_little_endian(address, index);
        if (!colours.empty())
            for (const std::uint8_t part : colours[face]) address = store_little_endian(address, part);
        file.write(std::span(record.data(), address));
    }
}

}  // namespace

void write_mesh(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours) {
    const MeshFormat format = format_of_ending(path);
    if (!colours.empty() && colours.size() != mesh.triangles().size())
        throw Error(ErrorCode::invalid_argument, fmt::format("{} colours for {} triangles; give one for each, or none",
                                                             colours.size(), mesh.triangles().size()));
    AtomicFile file(path);
    switch (format) {
        case MeshFormat::off:
            write_off(mesh, file);
            break;
        case MeshFormat::obj:
            write_obj(mesh, file);
            break;
        case MeshFormat::stl:
            write_stl(mesh, file);
            break;
        case MeshFormat::ply:
            write_ply(mesh, file, colours);
            break;
    }
    file.commit();
}

}  // namespace clsdf
